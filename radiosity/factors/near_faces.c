// near_faces.c - faces close by, whose shares are known in closed form (Lambert 1760; analytic.h), as control variates of
// a sampled row.
//
// The edges of a wall a centimetre from the eye are all but diameters of the hemisphere's base. How many of the samples lie
// to one side of a diameter errs most where it runs along rows of them, by up to half a row: 8e-4 of all light at a
// resolution of 200, whatever the lattice, for every lattice has rows some way round. Of a face that nothing hides the
// share needs no samples: its elements are scaled to it, and all others alike to the rest.
#include "radiosity/factors/near_faces.h"

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/analytic.h"

// A face is near when each of its corners is so many times as far as its plane; of others no edge is so straight and so long.
static const double NEAR = 8;
// And it reaches to the foot of the perpendicular to its plane, or to so many times the plane's distance from there.
static const double BESIDE = 4;
// And has so much of the light at least: others err little.
static const double LEAST_SHARE = 0.1;
// A point less than this inside the face's cone, as an angle's tangent, or before its plane, as a share of the distance, touches
// it: far above the rounding of doubles, far below a visible distance.
static const double TOUCH = 1e-6;
enum { MOST_NEAR = 6 };  // as faces of a box; more are left as they are

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
        // How far the foot of the perpendicular is inside the edge, times the edge's length.
        Vec3 edge = vec3_sub(v[i + 1 < n ? i + 1 : 0], v[i]);
        double inside = vec3_dot(face->n, vec3_cross(v[i], edge));
        if (inside < 0 && inside * inside > BESIDE * BESIDE * d2 * vec3_dot(edge, edge)) return false;
    }
    return true;
}

// The planes of the space before a face and above the horizon, a little shrunk. Returns how many planes there are.
static int space_before(const View *view, const ViewFace *face, Plane *out) {
    const Vec3 *v = view->vertices + face->first_vertex;
    int count = 0, n = face->vertex_count;
    Vec3 shrink = vec3_scale(face->n, TOUCH);  // against the face's directions
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

// Has the polygon any part in the space? Exactly so: of what is hidden itself the answer must be that of what hides it.
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

static bool is_free(const View *view, const ViewFace *face) {
    Plane space[ANALYTIC_CORNERS];
    int planes = space_before(view, face, space);
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

static int find_near(const RowSum *sum, const View *view, NearFace *out) {
    int count = 0;
    for (int i = 0; i < view->face_count && count < MOST_NEAR; i++) {
        const ViewFace *face = &view->faces[i];
        if (!is_near(view, face)) continue;
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
    // Where all samples see them, or none should see anything else, there is no rest to share.
    if (!(exact < 1 && sampled < total)) return;
    for (int i = 0; i < count; i++) {
        const Face *face = &sum->mesh->faces[near[i].face->face];
        // row_finish divides by the new total, which makes the others' shares (1 - exact) of it.
        double scale = near[i].exact / near[i].sampled * (total - sampled) / (1 - exact);
        for (int e = face->first_element; e < face->first_element + face->element_count; e++)
            sum->share[e] *= scale;
    }
}
