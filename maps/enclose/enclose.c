// enclose.c - free space from a drawn plan: regions and openings from walls, rooms, doors and holes in
// floors.
//
// All linework of all storeys is noded together on the 1 mm grid into one planar arrangement; each of its
// faces gets a column of solid and free spans; like spans of neighbouring faces become regions. Regions are
// thus disjoint and share their vertices by construction. The steps are in enclose_*.c, in the order of
// enclose.h.
#include <stdarg.h>
#include <stdio.h>

#include "engine/core/memory.h"
#include "maps/enclose/enclose.h"

// Closing small gaps must enclose at least this much more to be worth it, mm^2.
static const double LEAST_GAIN = 2.5e5;
// The smallest share of all spots that is tried.
static const double LEAST_SHARE = 1.0 / 4096;

static void on_geos_error(const char *message, void *context) {
    Enclosure *e = context;
    if (strcmp(message, "std::bad_alloc") == 0) memory_end_library("GEOS");
    snprintf(e->geos_message, sizeof e->geos_message, "%s", message);
}

static bool run_pass(Enclosure *e, bool with_plugs, Pass *pass) {
    *pass = (Pass){.leaking = false};
    if (!plan_build(e, with_plugs, &pass->plan)) return false;
    long long spots = (long long)e->b->storey_count * pass->plan.face_count;
    if (spots > ENCLOSE_MOST_SPOTS) {
        e->too_many = true;
        return error_set(
            e->error,
            "%d storeys, whose outlines make a common plan of %d pieces, are too much (allowed: %d, "
            "storeys times pieces)",
            e->b->storey_count, pass->plan.face_count, ENCLOSE_MOST_SPOTS);
    }
    cover_label(e, pass, with_plugs);
    indoor_label(e, pass);
    return true;
}

// Labels the plan as drawn. Where something lies open, labels it once more with small gaps closed, and keeps the second
// result if it encloses more.
static bool find_indoors(Enclosure *e) {
    if (!run_pass(e, false, &e->pass)) return false;
    bool any = false;
    if (!e->pass.leaking) return true;
    if (!enclose_plugs(e, &any)) return false;
    Pass closed;
    if (!any) return true;
    if (!run_pass(e, true, &closed)) return false;
    if (closed.enclosed > e->pass.enclosed + LEAST_GAIN) e->pass = closed;
    return true;
}

static void find_world_box(Building *b) {
    b->world = box_empty();
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        for (int k = 0; k < r->ring_count; k++) {
            const Ring *ring = &b->rings[r->first_ring + k];
            for (int n = 0; n < ring->point_count; n++) {
                Vec2 p = b->points[ring->first_point + n];
                b->world = box_add(box_add(b->world, vec3(p.x, p.y, r->z0)), vec3(p.x, p.y, r->z1));
            }
        }
    }
}

static bool enclose(Enclosure *e) {
    if (!enclose_prepare(e)) return false;
    crossings_limit(e);
    if (!enclose_find_world(e) || !enclose_implicit_walls(e)) return false;
    holes_fit(e);
    holes_close_slits(e);
    if (!find_indoors(e) || !memory_within(e->error)) return false;
    if (!e->settled && enclose_settle_low_walls(e)) return !(e->changed = true);
    indoor_report(e);
    leaks_report(e);
    columns_build(e);
    columns_drop_unseen_outdoors(e);
    if (!memory_within(e->error)) return false;
    openings_append(e);
    regions_trace(e);
    if (e->b->region_count == 0) return error_set(e->error, "nothing of the plan is free space");
    openings_join(e);
    find_world_box(e->b);
    enclose_choose_start(e);
    return true;
}

static bool attempt(Enclosure *e) {
    Arena scratch = {0};
    e->scratch = &scratch;
    e->geos = GEOS_init_r();
    GEOSContext_setErrorMessageHandler_r(e->geos, on_geos_error, e);
    bool ok = enclose(e);
    GEOS_finish_r(e->geos);
    arena_free(&scratch);
    memory_return_freed();
    return ok;
}

bool maps_enclose(const Sketch *sketch, Building *b, Arena *arena, Error *error) {
    const Building before = *b;
    bool *low = ARENA_ARRAY(arena, bool, sketch->wall_count);
    double share = 1;
    for (bool settled = false; share >= LEAST_SHARE;) {
        Enclosure e = {.sketch = sketch,
                       .b = b,
                       .arena = arena,
                       .error = error,
                       .share = share,
                       .wall_low = low,
                       .settled = settled};
        // Arrays only grow: restoring the earlier counts takes back the elements appended since. Of polygons and vertices the memory of
        // outgrown arrays is gone.
        Building grown = *b;
        *b = before;
        b->polygons = grown.polygons, b->polygon_capacity = grown.polygon_capacity;
        b->vertices = grown.vertices, b->vertex_capacity = grown.vertex_capacity;
        if (attempt(&e)) return true;
        if (!e.too_many && !e.changed) return false;
        settled = settled || e.changed;
        if (e.too_many) share /= 4;
    }
    return false;
}
