// building_check_forms.c - the faults of a building's form: what buildings of its form do not hold, and given portals.
#include "engine/core/polygon.h"
#include "maps/building_check.h"

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

void check_form(Check *c) {
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
