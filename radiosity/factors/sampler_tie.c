// sampler_tie.c - which of two faces is seen along a direction where floats do not tell their distances apart: along the line
// where they meet, and where they lie in one plane.
//
// Behind a wall without thickness the ceiling of the next room ends on the wall. A direction within a rounding of that line
// is held by both, at one distance, and must never see the ceiling, or light leaks through the wall. The ceiling is the farther
// one as soon as one looks at where both really are: inside their edges. So the direction is moved a hair's breadth inwards
// from the edges that pass it by, of either face, and there the distances are compared, in doubles.
#include "radiosity/factors/sampler_part.h"

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
// A face as near as this, metres, or nearer, is asked nothing finer: else all would be tied.
static const float NEAREST = 1e-3f;

float sampler_tie_within(const Form *near) {
    return ROUNDING * fminf(near->abs_x + near->abs_y + near->abs_z, 1 / NEAREST);
}

static const ViewFace *view_face(const SamplerView *of, int face) {
    return &of->view->faces[of->sampler->view_index[face]];
}

// Among faces in one place the one that turns its front to the eye is seen, then the lower.
static bool is_first(const ViewFace *a, const ViewFace *b) {
    return form_factor_rank(a) < form_factor_rank(b);
}

int sampler_tie_of_planes(const SamplerView *of, int face, int other) {
    const ViewFace *a = view_face(of, face), *b = view_face(of, other);
    for (int i = 0; i < b->vertex_count; i++)
        if (fabs(vec3_dot(a->n, of->view->vertices[b->first_vertex + i]) - a->d) > ONE_PLANE) return 0;
    return is_first(a, b) ? 1 : -1;
}

// A vertex of an edge, from the eye, in the view's axes.
static Vec3 vertex_of(const SamplerView *of, const ViewFace *face, int name) {
    const View *view = of->view;
    if (name >= 0) return view->vertices[face->first_vertex + name];
    Vec3 off = vec3_sub(of->sampler->mesh->vertices[~name], view->eye);
    return vec3(vec3_dot(view->x, off), vec3_dot(view->y, off), vec3_dot(view->z, off));
}

// The sum of the normals, inwards, of those edges of a face that pass by w, all in the view's axes.
static Vec3 inwards_from_edges(const SamplerView *of, const ViewFace *face, Vec3 w) {
    const FaceLines *o = &of->sampler->outlines;
    double side = face->d > 0 ? 1 : -1;
    Vec3 sum = {0, 0, 0};
    for (int i = o->first_edge[face->face]; i < o->first_edge[face->face + 1]; i++) {
        Vec3 p = vertex_of(of, face, o->edges[i].from), q = vertex_of(of, face, o->edges[i].to);
        Vec3 n = vec3_normalize(vec3_cross(p, q));
        if (side * vec3_dot(n, w) < AT_EDGE) sum = vec3_add(sum, vec3_scale(n, side));
    }
    return sum;
}

bool sampler_tie_along(const SamplerView *of, int face, int other, Vec3 w) {
    const ViewFace *a = view_face(of, face), *b = view_face(of, other);
    const Sampler *s = of->sampler;
    Vec3 at = vec3(w.x * s->cosine - w.y * s->sine, w.x * s->sine + w.y * s->cosine, w.z);
    Vec3 inwards = vec3_add(inwards_from_edges(of, a, at), inwards_from_edges(of, b, at));
    at = vec3_add(at, vec3_scale(inwards, INWARDS));
    double nearer = vec3_dot(a->n, at) / a->d - vec3_dot(b->n, at) / b->d;
    return nearer != 0 ? nearer > 0 : is_first(a, b);
}
