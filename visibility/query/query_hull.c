// query_hull.c - polygons in a portal's plane: what holds two of them, and whether one holds another.
#include "visibility/query/query.h"

// A corner's place in the plane, of which one coordinate is left out, and where it came from.
typedef struct Corner {
    double x, y;
    const Vec3 *p;
} Corner;

// So turned that what runs counter-clockwise about n does so here.
static Corner flatten(const Vec3 *p, Vec3 n) {
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    if (z >= x && z >= y) return n.z > 0 ? (Corner){p->x, p->y, p} : (Corner){p->y, p->x, p};
    if (y >= x) return n.y > 0 ? (Corner){p->z, p->x, p} : (Corner){p->x, p->z, p};
    return n.x > 0 ? (Corner){p->y, p->z, p} : (Corner){p->z, p->y, p};
}

static double turn(const Corner *a, const Corner *b, const Corner *c) {
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

// The convex hull, counter-clockwise about n (A. M. Andrew 1979).
int query_hull(const Vec3 *a, int a_count, const Vec3 *b, int b_count, Vec3 n, Vec3 *out) {
    Corner sorted[VIEW_CORNERS + MAX_CORNERS];
    const Corner *chain[2 * (VIEW_CORNERS + MAX_CORNERS)];
    int count = a_count + b_count, kept = 0;
    for (int i = 0; i < count; i++) {
        Corner next = flatten(i < a_count ? &a[i] : &b[i - a_count], n);
        int at = i;
        for (; at > 0; at--) {
            const Corner *last = &sorted[at - 1];
            if (last->x < next.x || (last->x == next.x && last->y <= next.y)) break;
            sorted[at] = *last;
        }
        sorted[at] = next;
    }
    for (int back = 0; back < 2; back++) {
        int least = kept;
        for (int i = 0; i < count; i++) {
            const Corner *next = &sorted[back ? count - 1 - i : i];
            while (kept >= least + 2 && turn(chain[kept - 2], chain[kept - 1], next) <= 0) kept--;
            chain[kept++] = next;
        }
        kept--;  // it begins the way back
    }
    for (int i = 0; i < kept; i++) out[i] = *chain[i]->p;
    return kept;
}

// Is all of `part` in the polygon? Both lie in the portal's plane.
bool query_polygon_holds(const Sloped *view, const ViewPart *part, Vec3 n) {
    for (int i = 0; i < view->count; i++) {
        Vec3 a = view->v[i], edge = vec3_sub(view->v[i + 1 == view->count ? 0 : i + 1], a);
        Vec3 inward = vec3_cross(n, edge);
        double slack = POSITION_SLACK * vec3_length(edge);
        for (int k = 0; k < part->count; k++) {
            if (vec3_dot(inward, vec3_sub(part->polygon[k], a)) < -slack) return false;
        }
    }
    return view->count > 0;
}
