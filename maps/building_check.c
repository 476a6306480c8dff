// building_check.c - every fault of a building, named with its place; those of regions are found in building_check_regions.c.
#include "maps/building_check.h"

#include "engine/core/polygon.h"
#include "maps/curved/curved_patch.h"

// ---- the form: each form of a building lacks some parts, and only one has given portals

// How far a given portal's corners may lie off its plane, metres: compilers print few decimals of their own units.
static const double GIVEN_BEND = 0.004;

static void check_absent(Check *c, const char *form, const char *what, int count) {
    if (count != 0) check_fault(c, "a building of %s has %d %s (allowed 0)", form, count, what);
}

static void check_given_portal(Check *c, int i) {
    const Building *b = c->b;
    const GivenPortal *p = &b->given_portals[i];
    for (int side = 0; side < 2; side++) {
        if (!index_good(p->cell[side], b->given_cell_count))
            check_fault(c, "given portal %d: cell %d (allowed 0 to %d)", i, p->cell[side],
                        b->given_cell_count - 1);
    }
    if (p->cell[0] == p->cell[1])
        check_fault(c, "given portal %d: leads from cell %d to itself", i, p->cell[0]);
    if (p->vertex_count < 3 || !run_good(p->first_vertex, p->vertex_count, b->vertex_count)) {
        check_fault(c, "given portal %d: vertices %d to %d of %d (at least 3, all there)", i, p->first_vertex,
                    p->first_vertex + p->vertex_count - 1, b->vertex_count);
        return;
    }
    const Vec3 *v = &b->vertices[p->first_vertex];
    for (int k = 0; k < p->vertex_count; k++) {
        if (good3(v[k])) continue;
        check_fault(c, "given portal %d: vertex %d at (%g, %g, %g) (finite, within %g m)", i, k, v[k].x,
                    v[k].y, v[k].z, MAPS_LIMIT);
        return;
    }
    double off = polygon_bend(v, p->vertex_count, plane_of_polygon(v, p->vertex_count));
    if (polygon_area(v, p->vertex_count) < MAPS_SMALLEST_AREA) {
        check_fault(c, "given portal %d at (%.3f, %.3f, %.3f): no area", i, v[0].x, v[0].y, v[0].z);
    } else if (off > GIVEN_BEND) {
        check_fault(c, "given portal %d at (%.3f, %.3f, %.3f): bends by %.4f m (limit %g)", i, v[0].x, v[0].y,
                    v[0].z, off, GIVEN_BEND);
    }
}

static void check_no_plan(Check *c, const char *form) {
    const Building *b = c->b;
    check_absent(c, form, "regions", b->region_count);
    check_absent(c, form, "storeys", b->storey_count);
    check_absent(c, form, "inlays", b->inlay_count);
}

static void check_no_cells(Check *c, const char *form) {
    check_absent(c, form, "given cells", c->b->given_cell_count);
    check_absent(c, form, "given portals", c->b->given_portal_count);
}

static void check_form(Check *c) {
    const Building *b = c->b;
    switch (b->form) {
    case FORM_REGIONS:
        check_no_cells(c, "regions");
        return;
    case FORM_SOUP:
        check_no_plan(c, "polygons alone");
        check_no_cells(c, "polygons alone");
        return;
    case FORM_CELLS:
        check_no_plan(c, "given cells");
        check_absent(c, "given cells", "openings", b->opening_count);
        check_absent(c, "given cells", "leaves", b->leaf_count);
        check_absent(c, "given cells", "objects", b->object_count);
        check_absent(c, "given cells", "polygons", b->polygon_count);
        if (b->given_cell_count < 1) check_fault(c, "a building of given cells has none");
        for (int i = 0; i < b->given_portal_count; i++) check_given_portal(c, i);
        return;
    case BUILDING_FORMS:
        break;
    }
    check_fault(c, "form %d (allowed 0 to %d)", (int)b->form, BUILDING_FORMS - 1);
}

// ---- materials, storeys, polygons, objects, openings

static void check_rgb(Check *c, const char *what, int i, Rgb v, float most) {
    float channel[3] = {v.r, v.g, v.b};
    for (int k = 0; k < 3; k++) {
        if (!(channel[k] >= 0 && channel[k] <= most)) {
            check_fault(c, "%s %d: channel %d is %g (allowed 0 to %g)", what, i, k, (double)channel[k],
                        (double)most);
        }
    }
}

static void check_materials_and_storeys(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->material_count; i++) {
        const Material *m = &b->materials[i];
        check_rgb(c, "reflectance of material", i, m->reflectance, MAPS_MAX_REFLECTANCE);
        check_rgb(c, "emission of material", i, m->emission, 1e30f);
        if (!(m->alpha >= 0 && m->alpha <= 1)) {
            check_fault(c, "material %d (%s): alpha %g (allowed 0 to 1)", i, text_of(m->name),
                        (double)m->alpha);
        }
    }
    for (int i = 0; i < b->storey_count; i++) {
        const Storey *s = &b->storeys[i];
        if (!good(s->floor) || !good(s->height) || !good(s->slab) || s->height <= 0 || s->slab < 0) {
            check_fault(
                c,
                "storey %d (%s): floor %g m, height %g m, slab %g m (floor finite, height above 0, slab at "
                "least 0)",
                i, text_of(s->name), s->floor, s->height, s->slab);
        }
    }
}

static void check_polygon(Check *c, int i) {
    const Building *b = c->b;
    const Polygon *p = &b->polygons[i];
    if (p->vertex_count < 3 || !run_good(p->first_vertex, p->vertex_count, b->vertex_count)) {
        check_fault(c, "polygon %d: vertices %d to %d of %d (at least 3, all there)", i, p->first_vertex,
                    p->first_vertex + p->vertex_count - 1, b->vertex_count);
        return;
    }
    const Vec3 *v = &b->vertices[p->first_vertex];
    if (!index_good(p->material, b->material_count)) {
        check_fault(c, "polygon %d: material %d (allowed 0 to %d)", i, p->material, b->material_count - 1);
    }
    for (int k = 0; k < p->vertex_count; k++) {
        if (good3(v[k])) continue;
        check_fault(c, "polygon %d: vertex %d at (%g, %g, %g) (finite, within %g m)", i, k, v[k].x, v[k].y,
                    v[k].z, MAPS_LIMIT);
        return;
    }
    Plane plane = plane_of_polygon(v, p->vertex_count);
    double off = polygon_bend(v, p->vertex_count, plane);
    if (polygon_area(v, p->vertex_count) <= MAPS_SMALLEST_AREA / 2) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): no area", i, v[0].x, v[0].y, v[0].z);
    } else if (off > MAPS_PLANARITY) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): bends by %.4f m (limit %g)", i, v[0].x, v[0].y,
                    v[0].z, off, MAPS_PLANARITY);
    } else if (!polygon_is_convex(v, p->vertex_count, plane.n)) {
        check_fault(c, "polygon %d at (%.3f, %.3f, %.3f): not convex", i, v[0].x, v[0].y, v[0].z);
    }
}

static void check_objects(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->polygon_count; i++) check_polygon(c, i);
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (!run_good(o->first_polygon, o->polygon_count, b->polygon_count)) {
            check_fault(c, "object %d (%s): polygons %d to %d of %d", i, text_of(o->name), o->first_polygon,
                        o->first_polygon + o->polygon_count - 1, b->polygon_count);
        }
        if ((o->plug || o->opening != -1) && !index_good(o->opening, b->opening_count)) {
            check_fault(c, "object %d (%s): opening %d (allowed 0 to %d)", i, text_of(o->name), o->opening,
                        b->opening_count - 1);
        }
        if (o->leaf != -1 && !index_good(o->leaf, b->leaf_count)) {
            check_fault(c, "object %d (%s): leaf %d (allowed 0 to %d)", i, text_of(o->name), o->leaf,
                        b->leaf_count - 1);
        }
        bool proxy = good(o->proxy_z0) && good(o->proxy_z1) && o->proxy_z0 <= o->proxy_z1;
        for (int k = 0; k < 4; k++) proxy = proxy && good(o->proxy[k].x) && good(o->proxy[k].y);
        if (!proxy) {
            check_fault(c, "object %d (%s): its proxy is not finite or reaches from %g up to %g", i,
                        text_of(o->name), o->proxy_z0, o->proxy_z1);
        }
    }
}

static void check_inlays(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->inlay_count; i++) {
        const Inlay *in = &b->inlays[i];
        if (in->point_count < 3 || !run_good(in->first_point, in->point_count, b->point_count)) {
            check_fault(c, "inlay %d: points %d to %d of %d (at least 3, all there)", i, in->first_point,
                        in->first_point + in->point_count - 1, b->point_count);
            continue;
        }
        if (!index_good(in->material, b->material_count) || !good(in->z)) {
            check_fault(c, "inlay %d: material %d of %d, height %g m", i, in->material, b->material_count,
                        in->z);
        }
        const Vec2 *p = &b->points[in->first_point];
        for (int k = 0; k < in->point_count; k++) {
            Vec2 q = p[(k + 1) % in->point_count], r = p[(k + 2) % in->point_count];
            if (orient2d(p[k], q, r) < 0) {
                check_fault(c, "inlay %d at (%.3f, %.3f): not convex or not counter-clockwise", i, q.x, q.y);
                break;
            }
        }
    }
}

static void check_lights_and_views(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->light_count; i++) {
        const Light *l = &b->lights[i];
        if (!good3(l->position) || !(l->radius >= 0) || !good(l->radius)) {
            check_fault(c, "light %d (%s): at (%g, %g, %g), radius %g m (finite, at least 0)", i,
                        text_of(l->name), l->position.x, l->position.y, l->position.z, l->radius);
        }
        check_rgb(c, "flux of light", i, l->flux, 1e30f);
        if (l->object != -1 && !index_good(l->object, b->object_count)) {
            check_fault(c, "light %d (%s): object %d of %d", i, text_of(l->name), l->object, b->object_count);
        }
    }
    for (int i = 0; i < b->viewpoint_count + b->tour_point_count; i++) {
        bool stored = i < b->viewpoint_count;
        const Viewpoint *v = stored ? &b->viewpoints[i] : &b->tour_points[i - b->viewpoint_count];
        if (good3(v->eye) && good(v->yaw) && good(v->pitch) && v->fov > 0 && v->fov < M_PI) continue;
        check_fault(
            c,
            "%s %d (%s): eye (%g, %g, %g), yaw %g, pitch %g, field of view %g (finite; view between 0 and "
            "pi)",
            stored ? "viewpoint" : "tour point", stored ? i : i - b->viewpoint_count, text_of(v->name),
            v->eye.x, v->eye.y, v->eye.z, v->yaw, v->pitch, v->fov);
    }
    for (int i = 0; i < b->tour_count; i++) {
        const Tour *t = &b->tours[i];
        if (!run_good(t->first_viewpoint, t->viewpoint_count, b->tour_point_count)) {
            check_fault(c, "tour %d (%s): viewpoints %d to %d of %d", i, text_of(t->name), t->first_viewpoint,
                        t->first_viewpoint + t->viewpoint_count - 1, b->tour_point_count);
        }
    }
    for (int i = 0; i < b->note_count; i++) {
        const Note *n = &b->notes[i];
        if (!n->text || !run_good(n->first_point, n->point_count, b->point_count)) {
            check_fault(c, "note %d: no text, or its path lies outside the points", i);
        }
    }
}

static void check_openings(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        const char *name = text_of(o->name);
        if (o->kind < 0 || o->kind >= OPENING_KINDS)
            check_fault(c, "opening %d (%s): kind %d", i, name, (int)o->kind);
        if (b->form != FORM_SOUP && !index_good(o->storey, b->storey_count)) {
            check_fault(c, "opening %d (%s): storey %d of %d", i, name, o->storey, b->storey_count);
        }
        if (!good(o->line[0].x) || !good(o->line[0].y) || !good(o->line[1].x) || !good(o->line[1].y)) {
            check_fault(c, "opening %d (%s): its line is not finite", i, name);
        } else if (vec2_equal(o->line[0], o->line[1])) {
            check_fault(c, "opening %d (%s) at (%.3f, %.3f): it has no width", i, name, o->line[0].x,
                        o->line[0].y);
        }
        if (!good(o->sill) || !good(o->head) || o->sill >= o->head) {
            check_fault(c, "opening %d (%s): sill %g m, head %g m (sill below head)", i, name, o->sill,
                        o->head);
        }
        if (!(o->open >= 0 && o->open <= 1))
            check_fault(c, "opening %d (%s): open by %g (allowed 0 to 1)", i, name, o->open);
        if (!run_good(o->first_leaf, o->leaf_count, b->leaf_count)) {
            check_fault(c, "opening %d (%s): leaves %d to %d of %d", i, name, o->first_leaf,
                        o->first_leaf + o->leaf_count - 1, b->leaf_count);
        }
        if (!index_good(o->material, b->material_count)) {
            check_fault(c, "opening %d (%s): material %d of %d", i, name, o->material, b->material_count);
        }
        for (int s = 0; s < 2; s++) {
            if (o->region[s] != -1 && !index_good(o->region[s], b->region_count)) {
                check_fault(c, "opening %d (%s): region %d of %d", i, name, o->region[s], b->region_count);
            }
        }
        if (b->form != FORM_SOUP && (o->region[0] == -1 || o->region[1] == -1) && !o->reason) {
            check_fault(c, "opening %d (%s) at (%.3f, %.3f): leads nowhere without a reason", i, name,
                        o->line[0].x, o->line[0].y);
        }
    }
}

static void check_leaves(Check *c) {
    const Building *b = c->b;
    for (int i = 0; i < b->leaf_count; i++) {
        const Leaf *l = &b->leaves[i];
        double numbers[] = {l->pivot.x,   l->pivot.y,   l->turn,      l->slide.x,   l->slide.y,
                            l->rise,      l->axis[0].x, l->axis[0].y, l->axis[1].x, l->axis[1].y,
                            l->thickness, l->z0,        l->z1};
        bool finite = true;
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) finite = finite && good(numbers[k]);
        if (!finite || l->thickness <= 0 || l->z0 >= l->z1 || vec2_equal(l->axis[0], l->axis[1]))
            check_fault(c, "leaf %d at (%.3f, %.3f): it is not finite or has no size", i, l->pivot.x,
                        l->pivot.y);
        bool corners = l->corner_count == 0 || (l->corner_count >= 3 && l->corner_count <= LEAF_CORNERS &&
                                                run_good(l->first_corner, l->corner_count, b->point_count));
        if (!corners)
            check_fault(c, "leaf %d: corners %d to %d of %d points (none, or 3 to %d)", i, l->first_corner,
                        l->first_corner + l->corner_count - 1, b->point_count, LEAF_CORNERS);
        if (!index_good(l->opening, b->opening_count))
            check_fault(c, "leaf %d: opening %d of %d", i, l->opening, b->opening_count);
    }
}

static void check_world(Check *c) {
    const Building *b = c->b;
    bool sound = good3(b->world.min) && good3(b->world.max);
    for (int i = 0; sound && i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->z0 < b->world.min.z || r->z1 > b->world.max.z) {
            check_fault(c, "region %d (%s): heights %g to %g m leave the world (%g to %g m)", i,
                        text_of(r->name), r->z0, r->z1, b->world.min.z, b->world.max.z);
        }
    }
    if (!sound) check_fault(c, "the world's box is not finite");
    if (!good3(b->start) || !good(b->start_yaw)) {
        check_fault(c, "the start (%g, %g, %g) is not finite", b->start.x, b->start.y, b->start.z);
    }
}

// ---- curved shapes, and materials where rays are traced

// Cosine between axes of a frame that counts as square: rounding of a turn, many times over.
static const double SQUARE = 1e-9;
static const double MOST_INDEX = 4;  // of refraction

static void check_optics(Check *c) {
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

static void check_curved(Check *c) {
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

int building_check(const Building *b, Arena *arena, const char **faults, int max) {
    Check c = {.b = b, .arena = arena, .faults = faults, .max = max};
    check_form(&c);
    check_materials_and_storeys(&c);
    check_optics(&c);
    check_regions(&c);
    check_openings(&c);
    check_leaves(&c);
    check_objects(&c);
    check_curved(&c);
    check_inlays(&c);
    check_lights_and_views(&c);
    check_world(&c);
    return c.count;
}
