// building_check.c - every fault of a building, named with its place.
#include "maps/building_check.h"

#include <stdarg.h>

#include "engine/core/polygon.h"
#include "engine/core/predicates.h"

void check_fault(Check *c, const char *format, ...) {
    if (c->count++ >= c->max) return;
    va_list args;
    va_start(args, format);
    c->faults[c->count - 1] = arena_format_list(c->arena, format, args);
    va_end(args);
}

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
