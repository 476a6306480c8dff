// joined.c - each part lists its own faces in the order that they have in the mesh of the whole. Their splits make that mesh; then their
// light is laid out on it.
#include "radiosity/show/joined.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "radiosity/mesh/nodes.h"
#include "radiosity/show/shown.h"

// A part begins with this. Then come, for each face, a FaceRecord, the bits of the splits of both meshes, and doubles: three for each
// element of radiosity, of direct light and of daylight, and for each patch of unshot light. Where light is shown there follow the number
// of the face's nodes, for each its light and the rest of that, and for each element of the mesh that shows it the number of its corners
// and the node of each. In the mesh of another part an element may have more corners, or fewer, on its edges: then nodes have places, too.
typedef struct PartHead {
    int face_count, splits_even, shown_even;
    bool splits, shown, nodes;
    bool places;  // each node begins with its place
    double emitted[3], absorbed[3], escaped[3], outdoors[3];
    Daylight day;
    long long shots;
} PartHead;

typedef struct FaceRecord {
    FaceTitle title;
    int bits, shown_bits, double_count;
} FaceRecord;

static size_t bit_bytes(int bits) { return ((size_t)bits + 63) / 64 * 8; }

// ---- packing

typedef struct Packed {
    char *data;
    int size, capacity;
} Packed;

static void append(Arena *arena, Packed *out, const void *data, size_t size) {
    out->data = arena_room(arena, out->data, 1, out->size, out->size + (int)size, &out->capacity);
    if (size > 0) memcpy(out->data + out->size, data, size);
    out->size += (int)size;
}

typedef struct Doubles {
    double *at;
    int count, capacity;
} Doubles;

static void add_double(Arena *arena, Doubles *d, double value) {
    *ARENA_PUSH(arena, d->at, d->count, d->capacity) = value;
}

static void push_light(Arena *arena, Doubles *d, double (*value)[3], int first, int count) {
    for (int i = first; i < first + count; i++)
        for (int c = 0; c < 3; c++) add_double(arena, d, value[i][c]);
}

// A part that is being packed.
typedef struct Packing {
    const Mesh *mesh;
    Mesh shown;
    const RadSolution *solution;
    Nodes nodes;  // of `shown`
    FaceTitle *titles;
    int *bit, *shown_bit;  // as mesh_face_bits gives them, or NULL
    int *in_face;          // [nodes.count] the node's number in the face that is packed last
    PartHead head;         // but for the number of faces
    Arena scratch;
} Packing;

static void push_node(Arena *arena, Doubles *d, const Packing *p, int node) {
    Vec3 at = p->shown.vertices[p->nodes.vertex[node]];
    if (p->head.places) push_light(arena, d, (double[1][3]){{at.x, at.y, at.z}}, 0, 1);
    push_light(arena, d, p->solution->node, node, 1);
    push_light(arena, d, p->solution->rest, node, 1);
}

// Each node of the face once: without that the letters of a large building are its largest part.
static void push_corners(Arena *arena, Doubles *d, const Packing *p, int face) {
    const Mesh *shown = &p->shown;
    const Face *f = &shown->faces[face];
    int count = 0, at = d->count;
    Doubles corners = {0};
    add_double(arena, d, 0);
    for (int e = f->first_element; e < f->first_element + f->element_count; e++)
        for (int c = shown->elements[e].first_corner;
             c < shown->elements[e].first_corner + shown->elements[e].corner_count; c++)
            p->in_face[p->nodes.of_corner[c]] = -1;
    for (int e = f->first_element; e < f->first_element + f->element_count; e++) {
        const Element *element = &shown->elements[e];
        add_double(arena, &corners, element->corner_count);
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            int node = p->nodes.of_corner[c], *number = &p->in_face[node];
            if (*number < 0) {
                *number = count++;
                push_node(arena, d, p, node);
            }
            add_double(arena, &corners, *number);
        }
    }
    d->at[at] = count;
    for (int i = 0; i < corners.count; i++) add_double(arena, d, corners.at[i]);
}

static void pack_bits(Arena *arena, Packed *out, const MeshSplits *splits, int first, int count,
                      Arena *scratch) {
    unsigned char *bits = arena_alloc(scratch, bit_bytes(count) + 1, 1);
    if (count > 0) border_copy_bits(splits->bits, first, bits, 0, count);
    append(arena, out, bits, bit_bytes(count));
}

static bool packing_begin(Packing *p, const Mesh *mesh, const RadSolution *solution, const float *door_open,
                          Error *error) {
    const MeshSplits *splits = mesh->options.splits, *finer = solution->shown;
    *p = (Packing){.mesh = mesh, .shown = *mesh, .solution = solution};
    if (finer && !shown_build(mesh, finer, door_open, &p->scratch, &p->shown, error)) {
        arena_free(&p->scratch);
        return false;
    }
    p->nodes = nodes_of(&p->shown, &p->scratch);
    p->in_face = ARENA_ARRAY(&p->scratch, int, p->nodes.count + 1);
    p->titles = border_titles(mesh, &p->scratch);
    p->bit = splits ? mesh_face_bits(mesh, splits, &p->scratch) : NULL;
    p->shown_bit = finer ? mesh_face_bits(mesh, finer, &p->scratch) : NULL;
    p->head = (PartHead){.splits_even = splits ? splits->even : 0,
                         .shown_even = finer ? finer->even : 0,
                         .splits = splits != NULL,
                         .shown = finer != NULL,
                         .nodes = solution->node && solution->rest,
                         .day = solution->day,
                         .shots = solution->shots};
    memcpy(p->head.emitted, solution->emitted, sizeof p->head.emitted);
    memcpy(p->head.absorbed, solution->absorbed, sizeof p->head.absorbed);
    memcpy(p->head.escaped, solution->escaped, sizeof p->head.escaped);
    memcpy(p->head.outdoors, solution->outdoors, sizeof p->head.outdoors);
    return true;
}

static void pack_face(const Packing *p, int f, Arena *arena, Packed *out) {
    const Face *face = &p->mesh->faces[f];
    const RadSolution *s = p->solution;
    const int *bit = p->bit, *shown_bit = p->shown_bit;
    Arena own = {0};
    Doubles d = {0};
    push_light(&own, &d, s->radiosity, face->first_element, face->element_count);
    push_light(&own, &d, s->direct, face->first_element, face->element_count);
    push_light(&own, &d, s->daylight, face->first_element, face->element_count);
    push_light(&own, &d, s->unshot, face->first_patch, face->patch_count);
    if (p->head.nodes) push_corners(&own, &d, p, f);
    FaceRecord record = {p->titles[f], bit ? bit[f + 1] - bit[f] : 0,
                         shown_bit ? shown_bit[f + 1] - shown_bit[f] : 0, d.count};
    append(arena, out, &record, sizeof record);
    if (bit) pack_bits(arena, out, p->mesh->options.splits, bit[f], record.bits, &own);
    if (shown_bit) pack_bits(arena, out, s->shown, shown_bit[f], record.shown_bits, &own);
    append(arena, out, d.at, (size_t)d.count * sizeof *d.at);
    arena_free(&own);
}

static TeamBytes pack_faces(const Packing *p, const int *faces, int count, Arena *arena) {
    Packed all = {0};
    PartHead head = p->head;
    head.face_count = count;
    append(arena, &all, &head, sizeof head);
    for (int i = 0; i < count; i++) pack_face(p, faces[i], arena, &all);
    return (TeamBytes){all.data, (size_t)all.size};
}

// The faces that belong to this part, and with `unseen` those that it does not see.
static int *faces_of_part(const Mesh *mesh, bool unseen, int *count, Arena *arena) {
    const MeshPart *part = mesh->options.part;
    int *out = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    *count = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        int object = mesh->faces[f].object;
        if (mesh_owns(mesh, f) || (unseen && !(part->seen[object / 64] >> object % 64 & 1)))
            out[(*count)++] = f;
    }
    return out;
}

bool joined_pack(const Mesh *mesh, const RadSolution *solution, const float *door_open, Arena *arena,
                 TeamBytes *out, Error *error) {
    Packing p;
    int count;
    if (!packing_begin(&p, mesh, solution, door_open, error)) return false;
    const int *faces = faces_of_part(mesh, false, &count, &p.scratch);
    *out = pack_faces(&p, faces, count, arena);
    arena_free(&p.scratch);
    return true;
}

bool joined_pack_each(const Mesh *mesh, const RadSolution *solution, const float *door_open,
                      const Borders *borders, Arena *arena, TeamBytes *out, Error *error) {
    Packing p;
    int count;
    if (!packing_begin(&p, mesh, solution, door_open, error)) return false;
    p.head.places = true;
    for (int part = 0; part < team_count(borders_member(borders)); part++) {
        const int *faces = part == mesh->options.part->own ? faces_of_part(mesh, true, &count, &p.scratch)
                                                           : borders_lent(borders, part, &count);
        out[part] = pack_faces(&p, faces, count, arena);
    }
    arena_free(&p.scratch);
    return true;
}

// ---- joining

// A face of the whole, and where its record lies.
typedef struct Joined {
    FaceRecord record;
    const unsigned char *bits, *shown_bits;
    const char *doubles;
} Joined;

static int by_title(const void *a, const void *b) {
    const Joined *p = a, *q = b;
    return border_compare(&p->record.title, &q->record.title);
}

static Joined *read_parts(const TeamBytes *part, int count, int *faces, Arena *arena) {
    int all = 0, f = 0;
    for (int p = 0; p < count; p++) {
        PartHead head;
        memcpy(&head, part[p].data, sizeof head);
        all += head.face_count;
    }
    Joined *out = ARENA_ARRAY(arena, Joined, all + 1);
    for (int p = 0; p < count; p++) {
        const char *at = (const char *)part[p].data + sizeof(PartHead),
                   *end = (const char *)part[p].data + part[p].size;
        for (; at < end; f++) {
            Joined *j = &out[f];
            memcpy(&j->record, at, sizeof j->record);
            j->bits = (const unsigned char *)at + sizeof j->record;
            j->shown_bits = j->bits + bit_bytes(j->record.bits);
            j->doubles = (const char *)j->shown_bits + bit_bytes(j->record.shown_bits);
            at = j->doubles + (size_t)j->record.double_count * sizeof(double);
        }
    }
    qsort(out, (size_t)all, sizeof *out, by_title);
    *faces = all;
    return out;
}

static MeshSplits *join_splits(const Joined *face, int count, bool shown, int even, Arena *arena) {
    MeshSplits *out = ARENA_ARRAY(arena, MeshSplits, 1);
    out->even = even;
    for (int f = 0; f < count; f++) out->bit_count += shown ? face[f].record.shown_bits : face[f].record.bits;
    out->bits = ARENA_ARRAY(arena, unsigned char, out->bit_count / 8 + 1);
    for (int f = 0, at = 0; f < count; f++) {
        int bits = shown ? face[f].record.shown_bits : face[f].record.bits;
        border_copy_bits(shown ? face[f].shown_bits : face[f].bits, 0, out->bits, at, bits);
        at += bits;
    }
    return out;
}

static const char *take_light(const char *from, double (*value)[3], int first, int count) {
    size_t bytes = (size_t)count * sizeof *value;
    memcpy(value + first, from, bytes);
    return from + bytes;
}

// Nodes of a face, and corners of an element, as they were packed.
typedef struct Corners {
    const char *nodes, *at;
    int count;
    bool places;
} Corners;

static size_t node_size(bool places) { return (places ? 9 : 6) * sizeof(double); }

static int count_at(const char *at) {
    double count;
    memcpy(&count, at, sizeof count);
    return (int)count;
}

static const char *node_of(const Corners *c, int corner) {
    return c->nodes + (size_t)count_at(c->at + (size_t)corner * sizeof(double)) * node_size(c->places);
}

static void corner_light(const Corners *c, int corner, double light[2][3]) {
    memcpy(light, node_of(c, corner) + node_size(c->places) - 6 * sizeof(double), 6 * sizeof(double));
}

static Vec3 corner_place(const Corners *c, int corner) {
    Vec3 out;
    memcpy(&out, node_of(c, corner), sizeof out);
    return out;
}

// The light at a place on the edge of an element whose light is linear between its corners.
static void light_on_edge(const Corners *c, Vec3 at, double light[2][3]) {
    double least = INFINITY, share = 0;
    int edge = 0;
    for (int i = 0; i < c->count; i++) {
        Vec3 from = corner_place(c, i), along = vec3_sub(corner_place(c, (i + 1) % c->count), from);
        double square = vec3_dot(along, along),
               t = square > 0 ? fmin(fmax(vec3_dot(vec3_sub(at, from), along) / square, 0), 1) : 0;
        Vec3 off = vec3_sub(at, vec3_add(from, vec3_scale(along, t)));
        double distance = vec3_dot(off, off);
        if (distance >= least) continue;
        least = distance;
        edge = i;
        share = t;
    }
    double ends[2][2][3];
    corner_light(c, edge, ends[0]);
    corner_light(c, (edge + 1) % c->count, ends[1]);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 3; k++) light[i][k] = (1 - share) * ends[0][i][k] + share * ends[1][i][k];
}

// Nodes have the light of the first face on which they lie.
static bool take_corners(const Joined *joined, bool places, const Mesh *shown, int face, const Nodes *nodes,
                         bool *known, RadSolution *out) {
    const Face *f = &shown->faces[face];
    const FaceTitle *title = &joined->record.title;
    const char *at = joined->doubles +
                     (size_t)(9 * title->element_count + 3 * title->patch_count) * sizeof(double),
               *end = joined->doubles + (size_t)joined->record.double_count * sizeof(double);
    Corners corners = {.nodes = at + sizeof(double), .places = places};
    at = corners.nodes + (size_t)count_at(at) * node_size(places);
    for (int e = f->first_element; e < f->first_element + f->element_count; e++) {
        const Element *element = &shown->elements[e];
        if (at >= end) return false;
        corners.count = count_at(at);
        corners.at = at + sizeof(double);
        bool same = corners.count == element->corner_count;
        if (!same && !places) return false;
        at = corners.at + (size_t)corners.count * sizeof(double);
        for (int i = 0; i < element->corner_count; i++) {
            int corner = element->first_corner + i, node = nodes->of_corner[corner];
            double light[2][3];
            if (known[node]) continue;
            Vec3 place = shown->vertices[shown->corners[corner]];
            if (same && (!places || vec3_equal(corner_place(&corners, i), place)))
                corner_light(&corners, i, light);
            else
                light_on_edge(&corners, place, light);
            known[node] = true;
            memcpy(out->node[node], light[0], sizeof light[0]);
            memcpy(out->rest[node], light[1], sizeof light[1]);
        }
    }
    return at == end;
}

static bool join_nodes(const Joined *face, bool places, const Mesh *mesh, const float *door_open,
                       Arena *arena, RadSolution *out, Error *error) {
    Arena scratch = {0};
    Mesh shown = *mesh;
    bool good = !out->shown || shown_build(mesh, out->shown, door_open, &scratch, &shown, error);
    // A finer mesh that is too large for the whole is none: light is that of the elements.
    if (!good) {
        out->shown = NULL;
        arena_free(&scratch);
        return true;
    }
    Nodes nodes = nodes_of(&shown, &scratch);
    bool *known = ARENA_ARRAY(&scratch, bool, nodes.count + 1);
    out->node_count = nodes.count;
    out->node = arena_alloc(arena, (size_t)nodes.count + 1, sizeof *out->node);
    out->rest = arena_alloc(arena, (size_t)nodes.count + 1, sizeof *out->rest);
    int wrong = 0;
    for (int f = 0; f < shown.face_count && good; f++)
        wrong += !take_corners(&face[f], places, &shown, f, &nodes, known, out);
    if (wrong > 0)
        good = error_set(error, "%s: parts do not agree on the corners of %d polygons",
                         mesh->graph->building->source, wrong);
    arena_free(&scratch);
    return good;
}

bool joined_light(const CellGraph *graph, const MeshOptions *options, const float *door_open,
                  const TeamBytes *part, int count, Arena *arena, Mesh *mesh, RadSolution *out,
                  Error *error) {
    Arena scratch = {0};
    PartHead head;
    int faces;
    memcpy(&head, part[0].data, sizeof head);
    Joined *face = read_parts(part, count, &faces, &scratch);
    MeshOptions whole = *options;
    if (head.splits) whole.splits = join_splits(face, faces, false, head.splits_even, arena);
    bool good = mesh_build(graph, door_open, &whole, arena, mesh, error);
    FaceTitle *titles = good ? border_titles(mesh, &scratch) : NULL;
    bool same = good && mesh->face_count == faces;
    for (int f = 0; f < faces && same; f++)
        same = memcmp(&titles[f], &face[f].record.title, sizeof *titles) == 0;
    if (good && !same)
        good =
            error_set(error, "%s: parts do not agree on the elements of the whole", graph->building->source);
    good = good && rad_start_dark(mesh, arena, out, error);
    if (good) {
        memcpy(out->emitted, head.emitted, sizeof head.emitted);
        memcpy(out->absorbed, head.absorbed, sizeof head.absorbed);
        memcpy(out->escaped, head.escaped, sizeof head.escaped);
        memcpy(out->outdoors, head.outdoors, sizeof head.outdoors);
        out->day = head.day;
        out->shots = head.shots;
        out->shown = head.shown ? join_splits(face, faces, true, head.shown_even, arena) : NULL;
        for (int f = 0; f < faces; f++) {
            const Face *own = &mesh->faces[f];
            const char *at =
                take_light(face[f].doubles, out->radiosity, own->first_element, own->element_count);
            at = take_light(at, out->direct, own->first_element, own->element_count);
            at = take_light(at, out->daylight, own->first_element, own->element_count);
            take_light(at, out->unshot, own->first_patch, own->patch_count);
        }
        if (head.nodes) good = join_nodes(face, head.places, mesh, door_open, arena, out, error);
    }
    arena_free(&scratch);
    return good;
}
