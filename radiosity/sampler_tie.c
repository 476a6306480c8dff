// sampler_tie.c - which of two faces is seen along a direction where floats do not tell their distances apart: along the line
// where they meet, and where they lie in one plane.
//
// Behind a wall without thickness the ceiling of the next room ends on the wall. A direction within a rounding of that line
// is held by both, at one distance, and must never see the ceiling, or light leaks through the wall. The ceiling is the farther
// one as soon as one looks at where both really are: inside their edges. So the direction is moved a hair's breadth inwards
// from the edges that pass it by, of either face, and there the distances are compared, in doubles.
#include "radiosity/sampler_part.h"

// A direction is moved so far, radians, from each edge that passes it by: well above the rounding of an edge's form, 4e-7, which
// may have put it on the wrong side, less than anything one looks at.
static const double INWARDS = 1e-5;
// And these are the edges: all that it could be moved across.
static const double AT_EDGE = 4e-5;
// Faces nearer to each other than this lie in one plane, metres: above the noise of coordinates 1,000 km from the origin, below
// sheets 2e-7 apart (analytic.c).
static const double ONE_PLANE = 1e-8;
// A face's 1 / distance errs by so much of the sum of its coefficients: three products and sums of floats, and their factors'
// own rounding; twice, of the two that are compared.
static const float ROUNDING = 8 * 0x1p-24f;
// Of a face as near as this, metres, or nearer, nothing finer is asked: else all would be tied.
static const float NEAREST = 1e-3f;

float sampler_tie_within(const Form *near) {
    return ROUNDING * fminf(near->abs_x + near->abs_y + near->abs_z, 1 / NEAREST);
}

static const ViewFace *view_face(const SamplerView *of, int face) {
    return &of->view->faces[of->sampler->view_index[face]];
}

// Of faces in one place the one is seen that turns its front to the eye, then the lower.
static bool is_first(const ViewFace *a, const ViewFace *b) {
    return form_factor_rank(a) < form_factor_rank(b);
}

int sampler_tie_of_planes(const SamplerView *of, int face, int other) {
    const ViewFace *a = view_face(of, face), *b = view_face(of, other);
    for (int i = 0; i < b->vertex_count; i++)
        if (fabs(vec3_dot(a->n, of->view->vertices[b->first_vertex + i]) - a->d) > ONE_PLANE) return 0;
    return is_first(a, b) ? 1 : -1;
}

// The sum of the normals, inwards, of those edges of a face that pass by w (building space).
static Vec3 inwards_from_edges(const SamplerView *of, const ViewFace *face, Vec3 w) {
    const FaceLines *o = &of->sampler->outlines;
    double side = face->d > 0 ? 1 : -1;
    Vec3 sum = {0, 0, 0};
    for (int i = o->first_edge[face->face]; i < o->first_edge[face->face + 1]; i++) {
        const FaceEdge *edge = &o->edges[i];
        Vec3 n = vec3_normalize(vec3_cross(vec3_sub(edge->point, of->view->eye), edge->along));
        if (side * vec3_dot(n, w) < AT_EDGE) sum = vec3_add(sum, vec3_scale(n, side));
    }
    return sum;
}

bool sampler_tie_along(const SamplerView *of, int face, int other, Vec3 w) {
    const ViewFace *a = view_face(of, face), *b = view_face(of, other);
    const View *view = of->view;
    Vec3 x, y;
    sampler_axes(of->sampler, view, &x, &y);
    Vec3 at = vec3_add(vec3_scale(x, w.x), vec3_add(vec3_scale(y, w.y), vec3_scale(view->z, w.z)));
    Vec3 inwards = vec3_add(inwards_from_edges(of, a, at), inwards_from_edges(of, b, at));
    at = vec3_add(at, vec3_scale(inwards, INWARDS));
    Vec3 in_view = vec3(vec3_dot(view->x, at), vec3_dot(view->y, at), vec3_dot(view->z, at));
    double nearer = vec3_dot(a->n, in_view) / a->d - vec3_dot(b->n, in_view) / b->d;
    return nearer != 0 ? nearer > 0 : is_first(a, b);
}
