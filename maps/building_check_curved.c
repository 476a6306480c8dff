// building_check_curved.c - faults of curved shapes, of what they consist of, and of materials where rays are traced.
#include "maps/building_check.h"
#include "maps/curved/curved_patch.h"

// Cosine between axes of a frame that counts as square: rounding of a turn, many times over.
static const double SQUARE = 1e-9;
static const double MOST_INDEX = 4;  // of refraction

void check_optics(Check *c) {
    for (int i = 0; i < c->b->material_count; i++) {
        const Material *m = &c->b->materials[i];
        float most = fmaxf(m->reflectance.r, fmaxf(m->reflectance.g, m->reflectance.b));
        if (!(m->mirror >= 0 && m->mirror + most <= 1.00001f))
            check_fault(c, "material %d (%s): mirror %g beside a reflectance of %g (together 0 to 1)", i,
                        text_of(m->name), (double)m->mirror, (double)most);
        if (m->index != 0 && !(m->index >= 1 && (double)m->index <= MOST_INDEX))
            check_fault(c, "material %d (%s): index of refraction %g (0, or 1 to %g)", i, text_of(m->name),
                        (double)m->index, MOST_INDEX);
    }
}

static void check_frame(Check *c, int i) {
    const CurvedFrame *f = &c->b->shapes[i].frame;
    bool sound = good3(f->origin);
    for (int k = 0; k < 3 && sound; k++) {
        Vec3 a = f->axis[k], b = f->axis[(k + 1) % 3];
        double lengths = vec3_length(a) * vec3_length(b);
        sound = good3(a) && lengths > 0 && fabs(vec3_dot(a, b)) <= SQUARE * lengths;
    }
    if (!sound) check_fault(c, "curved shape %d: its axes are not perpendicular, or one has no length", i);
}

static void check_patch(Check *c, int i) {
    const Building *b = c->b;
    const CurvedShape *s = &b->shapes[i];
    if (!run_good(s->first_control, PATCH_CONTROLS, b->control_count) ||
        !run_good(s->first_trim, s->trim_count, b->trim_count)) {
        check_fault(c, "curved shape %d: controls from %d of %d, trims from %d of %d", i, s->first_control,
                    b->control_count, s->first_trim, b->trim_count);
        return;
    }
    for (int k = 0; k < PATCH_CONTROLS; k++) {
        const CurvedControl *control = &b->controls[s->first_control + k];
        if (!good3(control->point) || !(control->weight > 0) || !good(control->weight))
            check_fault(c, "curved shape %d: control %d at (%g, %g, %g), weight %g (finite, above 0)", i, k,
                        control->point.x, control->point.y, control->point.z, control->weight);
    }
    for (int k = 0; k < s->trim_count; k++) {
        const CurvedTrim *t = &b->trims[s->first_trim + k];
        for (int p = 0; p < 4; p++) {
            Vec2 at = t->point[p];
            bool inside = at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1;
            if (!inside || !(t->weight[p] > 0) || !good(t->weight[p]))
                check_fault(c,
                            "curved shape %d: point %d of trim %d is (%g, %g), weight %g (0 to 1, above 0)",
                            i, p, k, at.x, at.y, t->weight[p]);
        }
    }
}

static void check_balls(Check *c, int i) {
    const Building *b = c->b;
    const CurvedShape *s = &b->shapes[i];
    if (s->ball_count < 1 || !run_good(s->first_ball, s->ball_count, b->ball_count) || !(s->threshold > 0)) {
        check_fault(c, "curved shape %d: balls %d to %d of %d (at least 1), threshold %g (above 0)", i,
                    s->first_ball, s->first_ball + s->ball_count - 1, b->ball_count, s->threshold);
        return;
    }
    for (int k = 0; k < s->ball_count; k++) {
        const CurvedBall *ball = &b->balls[s->first_ball + k];
        if (!good3(ball->centre) || !(ball->radius > 0) || !good(ball->radius) || !good(ball->weight))
            check_fault(c, "curved shape %d: ball %d has radius %g, weight %g (finite, a radius above 0)", i,
                        k, ball->radius, ball->weight);
    }
}

void check_curved(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->shape_count; i++) {
        const CurvedShape *s = &b->shapes[i];
        if (s->kind < 0 || s->kind >= CURVED_KINDS) {
            check_fault(c, "curved shape %d: kind %d (allowed 0 to %d)", i, (int)s->kind, CURVED_KINDS - 1);
            continue;
        }
        bool held = index_good(s->object, b->object_count) &&
                    run_good(s->first_polygon, s->polygon_count, b->polygon_count);
        if (held) {
            const Object *o = &b->objects[s->object];
            held = s->first_polygon >= o->first_polygon &&
                   s->first_polygon + s->polygon_count <= o->first_polygon + o->polygon_count;
        }
        if (!held || !index_good(s->material, b->material_count))
            check_fault(c, "curved shape %d: polygons %d to %d, not all of object %d; material %d of %d", i,
                        s->first_polygon, s->first_polygon + s->polygon_count - 1, s->object, s->material,
                        b->material_count);
        if (!(s->tolerance > 0 && good(s->tolerance)) || !(s->top >= 0 && s->top <= 1))
            check_fault(c, "curved shape %d: tolerance %g m (above 0), top %g (0 to 1)", i, s->tolerance,
                        s->top);
        if (s->kind == CURVED_PATCH) {
            check_patch(c, i);
        } else if (s->kind == CURVED_METABALLS) {
            check_balls(c, i);
        } else {
            check_frame(c, i);
        }
    }
}
