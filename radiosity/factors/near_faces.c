// near_faces.c - faces close by, whose shares are known in closed form (Lambert 1760; analytic.h), as control variates of
// a sampled row.
//
// The edges of a wall a centimetre from the eye are almost diameters of the hemisphere's base. The number of samples on one side of
// a diameter errs most where the diameter runs along rows of samples, by up to half a row: 8e-4 of all light at a resolution of 200.
// No lattice avoids this error, because every lattice has rows in some direction. A face that nothing hides needs no samples for its
// share: its elements are scaled to the exact share, and all other elements alike to the rest.
#include "radiosity/factors/near_faces.h"

#include <math.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/analytic.h"

// A face is near if each of its corners is at least this many times as far from the eye as its plane; other faces have no edges that
// are so nearly diameters.
static const double NEAR = 8;
// A near face must also contain the foot of the perpendicular to its plane, or come within this many times the plane's distance of it.
static const double BESIDE = 4;
// A near face must also have at least this share of the light: the shares of smaller faces err little.
static const double LEAST_SHARE = 0.1;
// A point touches the face if it is less than this inside the face's cone, as an angle's tangent, or less than this in front of the
// face's plane, as a share of the plane's distance: far above the rounding of doubles, far below a visible distance.
static const double TOUCH = 1e-6;
enum { MOST_NEAR = 6 };  // the faces of a box; further faces keep their sampled shares

typedef struct NearFace {
    const ViewFace *face;
    double exact, sampled;
} NearFace;

static bool is_near(const View *view, const ViewFace *face) {
    const Vec3 *v = view->vertices + face->first_vertex;
    double d2 = face->d * face->d;
    int n = face->vertex_count;
    if (face->d > 0 || n + 2 >= ANALYTIC_CORNERS) return false;
    for (int i = 0; i < n; i++)
        if (vec3_dot(v[i], v[i]) < NEAR * NEAR * d2) return false;
    for (int i = 0; i < n; i++) {
        // The distance of the foot of the perpendicular inside the edge, times the edge's length.
        Vec3 edge = vec3_sub(v[i + 1 < n ? i + 1 : 0], v[i]);
        double inside = vec3_dot(face->n, vec3_cross(v[i], edge));
        if (inside < 0 && inside * inside > BESIDE * BESIDE * d2 * vec3_dot(edge, edge)) return false;
    }
    return true;
}

// The planes that bound the space between the eye and a face, above the horizon and a little shrunk. Returns the number of planes.
static int space_before(const View *view, const ViewFace *face, Plane *out) {
    const Vec3 *v = view->vertices + face->first_vertex;
    int count = 0, n = face->vertex_count;
    Vec3 shrink = vec3_scale(face->n, TOUCH);  // face->n points from the face to the eye
    out[count++] = (Plane){face->n, face->d * (1 - TOUCH)};
    out[count++] = (Plane){vec3_add(vec3(0, 0, 1), shrink), 0};
    for (int i = 0; i < n; i++) {
        Vec3 across = vec3_normalize(vec3_cross(v[i + 1 < n ? i + 1 : 0], v[i]));
        out[count++] = (Plane){vec3_add(across, shrink), 0};
    }
    return count;
}

static bool all_outside(const Vec3 *v, int count, Plane plane) {
    for (int i = 0; i < count; i++)
        if (plane_distance(plane, v[i]) > 0) return false;
    return true;
}

// Does any part of the polygon lie in the space? The answer must be exact: culling may have removed a polygon that is hidden by
// another, so the hidden one must not give an answer that the one in front of it does not give.
static bool reaches_into(const Vec3 *v, int count, const Plane *space, int planes) {
    Vec3 part[2][ANALYTIC_CORNERS];
    for (int i = 0; i < planes; i++)
        if (all_outside(v, count, space[i])) return false;
    for (int i = 0; i < planes && count >= 3; i++) {
        if (count + 1 >= ANALYTIC_CORNERS) return true;
        count = polygon_clip(v, count, space[i], 0, part[i % 2]);
        v = part[i % 2];
    }
    return count >= 3;
}

// May any part of a cluster lie in the space?
static bool cluster_reaches_into(const View *view, const ViewCluster *cluster, const Plane *space,
                                 int planes) {
    const float *c = cluster->centre, *half = cluster->half;
    Vec3 centre = {(double)c[0], (double)c[1], (double)c[2]};
    for (int i = 0; i < planes; i++) {
        // The plane's normal along the axes of the building.
        Vec3 n = vec3_add(vec3_scale(view->x, space[i].n.x),
                          vec3_add(vec3_scale(view->y, space[i].n.y), vec3_scale(view->z, space[i].n.z)));
        double size = fabs(n.x) * (double)half[0] + fabs(n.y) * (double)half[1] + fabs(n.z) * (double)half[2];
        if (plane_distance(space[i], centre) < -(size + TOUCH * (1 + vec3_length(centre)))) return false;
    }
    return true;
}

static bool is_free(const View *view, const ViewFace *face) {
    Plane space[ANALYTIC_CORNERS];
    int planes = space_before(view, face, space);
    for (int i = 0; i < view->cluster_count; i++) {
        const ViewCluster *cluster = &view->clusters[i];
        if (cluster->listed != VIEW_ALL && cluster_reaches_into(view, cluster, space, planes))
            view_list(view, i, VIEW_ALL);
    }
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *other = &view->faces[i];
        if (other != face &&
            reaches_into(view->vertices + other->first_vertex, other->vertex_count, space, planes))
            return false;
    }
    return true;
}

static double share_of(const RowSum *sum, const Face *face) {
    double share = 0;
    for (int e = face->first_element; e < face->first_element + face->element_count; e++)
        share += sum->share[e];
    return share;
}

// May a face have LEAST_SHARE of the light? Of all cones, that about the normal has most: the square of its sine.
static bool may_be_large(const ViewFace *face) {
    const float *c = face->centre, least = (float)(0.99 * LEAST_SHARE);
    return !(face->radius * face->radius < least * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]));
}

static int find_near(const RowSum *sum, const View *view, NearFace *out) {
    int count = 0;
    for (int i = 0; i < view->face_count && count < MOST_NEAR; i++) {
        const ViewFace *face = &view->faces[i];
        if (!may_be_large(face) || !is_near(view, face)) continue;
        double exact = analytic_point(view->vertices + face->first_vertex, face->vertex_count);
        if (exact < LEAST_SHARE) continue;
        double sampled = share_of(sum, &sum->mesh->faces[face->face]);
        if (!(sampled > 0) || !is_free(view, face)) continue;
        out[count++] = (NearFace){face, exact, sampled};
    }
    return count;
}

void near_faces_mend(RowSum *sum, const View *view) {
    NearFace near[MOST_NEAR];
    int count = find_near(sum, view, near);
    if (count == 0) return;
    double total = sum->back + sum->escaped, exact = 0, sampled = 0;
    for (int i = 0; i < sum->touched_count; i++) total += sum->share[sum->touched[i]];
    for (int i = 0; i < count; i++) exact += near[i].exact, sampled += near[i].sampled;
    // If all samples see near faces, or the exact shares sum to 1, there is no rest for the other shares.
    if (!(exact < 1 && sampled < total)) return;
    for (int i = 0; i < count; i++) {
        const Face *face = &sum->mesh->faces[near[i].face->face];
        // row_finish divides by the new total; the other shares then sum to 1 - exact.
        double scale = near[i].exact / near[i].sampled * (total - sampled) / (1 - exact);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            sum->share[e] *= scale;
    }
}
