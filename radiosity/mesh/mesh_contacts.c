// mesh_contacts.c - finds where objects stand on a face or close in front of it: the lines along which the face's elements are cut,
// so that lit and covered parts are not one element (Baum, Mann, Smith & Winget 1991: light and shadow leaks).
#include "engine/core/polygon.h"
#include "maps/building/building.h"
#include "radiosity/mesh/mesh_parts.h"

// Lines shorter than this do not cut, metres: fine furniture has thousands, and each covers little.
static const double SHORTEST = 0.04;
// A line nearer than this to the face's own border does not cut, metres: the part cut off would be too small.
static const double AT_BORDER = 1e-3;
// Faces whose normals have a larger cosine than this are neighbours in one surface and cover nothing of each other.
static const double SAME_WAY = 0.99;
// If the normals of two faces have a larger absolute cosine than this, it is not known on which side of its edges the other face covers.
static const double ALONG = 0.9;
// Side of the squares that faces are sorted into, metres.
static const double SIDE = 1;

// The most entries of faces in these squares, summed over all squares: a quarter of a gigabyte.
static const double MOST_ENTRIES = 1 << 26;

typedef struct Contacts {
    MeshBuilder *builder;
    double close;
    Box *boxes;  // [face_count]
    double x0, y0;
    int nx, ny;
    int *first, *list;  // [nx * ny + 1]; the faces whose boxes touch each square
    int *stamp;         // [face_count] the last face that was tested against this one, plus one
} Contacts;

static const Vec3 *points_of(const Contacts *c) { return c->builder->places.points; }

static Box box_of_face(const Contacts *c, const Face *face) {
    const int *outline = c->builder->mesh->outline + face->first_vertex;
    Box box = box_empty();
    for (int i = 0; i < face->vertex_count; i++) box = box_add(box, points_of(c)[outline[i]]);
    return box;
}

static int square_of(double x, double x0, int count) {
    double at = (x - x0) / SIDE;
    return at < 0 ? 0 : at >= count ? count - 1 : (int)at;
}

typedef struct Range {
    int i0, i1, j0, j1;
} Range;

static Range range_of(const Contacts *c, const Box *box) {
    return (Range){square_of(box->min.x, c->x0, c->nx), square_of(box->max.x, c->x0, c->nx),
                   square_of(box->min.y, c->y0, c->ny), square_of(box->max.y, c->y0, c->ny)};
}

// Sorts the faces into squares. False where there would be more than MOST_ENTRIES: too many large faces.
static bool sort_faces(Contacts *c, Arena *scratch) {
    const Mesh *mesh = c->builder->mesh;
    Box all = box_empty();
    for (int f = 0; f < mesh->face_count; f++) {
        c->boxes[f] = box_of_face(c, &mesh->faces[f]);
        all = box_union(all, c->boxes[f]);
    }
    // Lines cut in the order in which faces are found, which must be the same in the meshes of all parts of a building.
    const Vec3 corner = mesh->options.part ? mesh->graph->box.min : all.min;
    c->x0 = corner.x;
    c->y0 = corner.y;
    const double most = 1000;
    c->nx = (int)fmax(fmin(most, (all.max.x - c->x0) / SIDE + 1), 1);
    c->ny = (int)fmax(fmin(most, (all.max.y - c->y0) / SIDE + 1), 1);
    double entries = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        Range r = range_of(c, &c->boxes[f]);
        entries += (double)(r.i1 - r.i0 + 1) * (r.j1 - r.j0 + 1);
    }
    if (entries > MOST_ENTRIES) return false;
    c->first = ARENA_ARRAY(scratch, int, c->nx * c->ny + 2);
    for (int pass = 0; pass < 2; pass++) {
        for (int f = 0; f < mesh->face_count; f++) {
            Range r = range_of(c, &c->boxes[f]);
            for (int j = r.j0; j <= r.j1; j++) {
                for (int i = r.i0; i <= r.i1; i++) {
                    int at = j * c->nx + i;
                    if (pass == 0)
                        c->first[at + 2]++;
                    else
                        c->list[c->first[at + 1]++] = f;
                }
            }
        }
        if (pass == 1) break;
        for (int at = 0; at < c->nx * c->ny; at++) c->first[at + 2] += c->first[at + 1];
        c->list = ARENA_ARRAY(scratch, int, c->first[c->nx * c->ny + 1] + 1);
    }
    return true;
}

// ---- lines on a face

// Adds the part of the line a -> b, which lies in the face's plane, that is inside the face's outline.
static void add_cut(Contacts *c, const Face *face, const Face *other, Vec3 a, Vec3 b) {
    MeshBuilder *builder = c->builder;
    const int *outline = builder->mesh->outline + face->first_vertex;
    double t0 = 0, t1 = 1;
    for (int i = 0; i < face->vertex_count; i++) {
        Vec3 p = points_of(c)[outline[i]], q = points_of(c)[outline[(i + 1) % face->vertex_count]];
        Vec3 inwards = vec3_normalize(vec3_cross(face->plane.n, vec3_sub(q, p)));
        double from = vec3_dot(inwards, vec3_sub(a, p)) - AT_BORDER,
               to = vec3_dot(inwards, vec3_sub(b, p)) - AT_BORDER;
        if (from <= 0 && to <= 0) return;
        if (from < 0) t0 = fmax(t0, from / (from - to));
        if (to < 0) t1 = fmin(t1, from / (from - to));
    }
    if ((t1 - t0) * vec3_length(vec3_sub(b, a)) < SHORTEST) return;
    // Objects are closed, so the space behind the other face is covered.
    double facing = vec3_dot(face->plane.n, other->plane.n);
    Vec3 open = vec3_sub(other->plane.n, vec3_scale(face->plane.n, facing));
    if (fabs(facing) > ALONG) open = vec3(0, 0, 0);
    MeshCut cut = {vec3_sub(vec3_lerp(a, b, t0), face->origin), vec3_sub(vec3_lerp(a, b, t1), face->origin),
                   open};
    *ARENA_PUSH(&builder->cut_arena, builder->cuts, builder->cut_count, builder->cut_capacity) = cut;
}

// Adds the lines where another face stands on this face, comes close to it, or goes through it.
static void note_contact(Contacts *c, const Face *face, const Face *other) {
    const int *outline = c->builder->mesh->outline + other->first_vertex;
    if (vec3_dot(face->plane.n, other->plane.n) > SAME_WAY) return;
    Vec3 crossing[2];
    int crossings = 0;
    for (int i = 0; i < other->vertex_count; i++) {
        Vec3 a = points_of(c)[outline[i]], b = points_of(c)[outline[(i + 1) % other->vertex_count]];
        double above_a = plane_distance(face->plane, a), above_b = plane_distance(face->plane, b);
        bool close_a =
            above_a > -AT_BORDER && above_a<c->close, close_b = above_b> - AT_BORDER && above_b < c->close;
        if (close_a && close_b) {
            add_cut(c, face, other, vec3_sub(a, vec3_scale(face->plane.n, above_a)),
                    vec3_sub(b, vec3_scale(face->plane.n, above_b)));
        } else if ((above_a < -AT_BORDER) != (above_b < -AT_BORDER) && crossings < 2) {
            // Clamped, for edges that lie almost in the plane.
            double t = fmin(fmax(above_a / (above_a - above_b), 0), 1);
            crossing[crossings++] = vec3_lerp(a, b, t);
        }
    }
    if (crossings == 2) add_cut(c, face, other, crossing[0], crossing[1]);
}

static void find_cuts(Contacts *c, int index) {
    const Mesh *mesh = c->builder->mesh;
    const Face *face = &mesh->faces[index];
    const Box around = box_grow(c->boxes[index], c->close);
    Range r = range_of(c, &around);
    for (int j = r.j0; j <= r.j1; j++) {
        for (int i = r.i0; i <= r.i1; i++) {
            int at = j * c->nx + i;
            for (int k = c->first[at]; k < c->first[at + 1]; k++) {
                int other = c->list[k];
                if (other == index || c->stamp[other] == index + 1) continue;
                c->stamp[other] = index + 1;
                if (!box_overlap(around, c->boxes[other])) continue;
                note_contact(c, face, &mesh->faces[other]);
            }
        }
    }
}

bool mesh_find_cuts(MeshBuilder *builder) {
    const Mesh *mesh = builder->mesh;
    builder->first_cut = ARENA_ARRAY(&builder->cut_arena, int, mesh->face_count + 1);
    if (mesh->options.close <= 0) return true;
    Arena scratch = {0};
    Contacts c = {.builder = builder,
                  .close = mesh->options.close,
                  .boxes = ARENA_ARRAY(&scratch, Box, mesh->face_count),
                  .stamp = ARENA_ARRAY(&scratch, int, mesh->face_count)};
    bool good = sort_faces(&c, &scratch);
    for (int f = 0; f < mesh->face_count && good; f++) {
        builder->first_cut[f] = builder->cut_count;
        find_cuts(&c, f);
    }
    builder->first_cut[mesh->face_count] = builder->cut_count;
    arena_free(&scratch);
    return good;
}
