// joined.c - each part lists its own faces in the order that they have in the mesh of the whole. Their splits make that mesh; then their
// light is laid out on it.
#include "radiosity/show/joined.h"

#include <stdlib.h>
#include <string.h>

#include "radiosity/mesh/nodes.h"
#include "radiosity/show/shown.h"

// A part begins with this. Then come, for each face, a FaceRecord, the bits of the splits of both meshes, and doubles: three for each
// element of radiosity, of direct light and of daylight, and for each patch of unshot light. Where light is shown there follow, for each
// element of the mesh that shows it, the number of its corners, and for each corner its light and the rest of that.
typedef struct PartHead {
    int face_count, splits_even, shown_even;
    bool splits, shown, nodes;
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

static void push_corners(Arena *arena, Doubles *d, const Mesh *shown, int face, const Nodes *nodes,
                         const RadSolution *s) {
    const Face *f = &shown->faces[face];
    for (int e = f->first_element; e < f->first_element + f->element_count; e++) {
        const Element *element = &shown->elements[e];
        add_double(arena, d, element->corner_count);
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            push_light(arena, d, s->node, nodes->of_corner[c], 1);
            push_light(arena, d, s->rest, nodes->of_corner[c], 1);
        }
    }
}

static void pack_bits(Arena *arena, Packed *out, const MeshSplits *splits, int first, int count,
                      Arena *scratch) {
    unsigned char *bits = arena_alloc(scratch, bit_bytes(count) + 1, 1);
    if (count > 0) border_copy_bits(splits->bits, first, bits, 0, count);
    append(arena, out, bits, bit_bytes(count));
}

bool joined_pack(const Mesh *mesh, const RadSolution *solution, const float *door_open, Arena *arena,
                 TeamBytes *out, Error *error) {
    Arena scratch = {0};
    Packed all = {0};
    const MeshSplits *splits = mesh->options.splits, *finer = solution->shown;
    bool nodes_known = solution->node && solution->rest;
    Mesh shown = *mesh;
    if (finer && !shown_build(mesh, finer, door_open, &scratch, &shown, error)) {
        arena_free(&scratch);
        return false;
    }
    Nodes nodes = nodes_of(&shown, &scratch);
    FaceTitle *titles = border_titles(mesh, &scratch);
    int *bit = splits ? mesh_face_bits(mesh, splits, &scratch) : NULL,
        *shown_bit = finer ? mesh_face_bits(mesh, finer, &scratch) : NULL;
    PartHead head = {.splits_even = splits ? splits->even : 0,
                     .shown_even = finer ? finer->even : 0,
                     .splits = splits != NULL,
                     .shown = finer != NULL,
                     .nodes = nodes_known,
                     .day = solution->day,
                     .shots = solution->shots};
    memcpy(head.emitted, solution->emitted, sizeof head.emitted);
    memcpy(head.absorbed, solution->absorbed, sizeof head.absorbed);
    memcpy(head.escaped, solution->escaped, sizeof head.escaped);
    memcpy(head.outdoors, solution->outdoors, sizeof head.outdoors);
    for (int f = 0; f < mesh->face_count; f++) head.face_count += mesh_owns(mesh, f);
    append(arena, &all, &head, sizeof head);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        Arena own = {0};
        Doubles d = {0};
        if (!mesh_owns(mesh, f)) continue;
        push_light(&own, &d, solution->radiosity, face->first_element, face->element_count);
        push_light(&own, &d, solution->direct, face->first_element, face->element_count);
        push_light(&own, &d, solution->daylight, face->first_element, face->element_count);
        push_light(&own, &d, solution->unshot, face->first_patch, face->patch_count);
        if (nodes_known) push_corners(&own, &d, &shown, f, &nodes, solution);
        FaceRecord record = {titles[f], bit ? bit[f + 1] - bit[f] : 0,
                             shown_bit ? shown_bit[f + 1] - shown_bit[f] : 0, d.count};
        append(arena, &all, &record, sizeof record);
        if (bit) pack_bits(arena, &all, splits, bit[f], record.bits, &own);
        if (shown_bit) pack_bits(arena, &all, finer, shown_bit[f], record.shown_bits, &own);
        append(arena, &all, d.at, (size_t)d.count * sizeof *d.at);
        arena_free(&own);
    }
    *out = (TeamBytes){all.data, (size_t)all.size};
    arena_free(&scratch);
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

// Nodes have the light of the first face on which they lie.
static bool take_corners(const Joined *joined, const Mesh *shown, int face, const Nodes *nodes, bool *known,
                         RadSolution *out) {
    const Face *f = &shown->faces[face];
    const FaceTitle *title = &joined->record.title;
    const char *at = joined->doubles +
                     (size_t)(9 * title->element_count + 3 * title->patch_count) * sizeof(double),
               *end = joined->doubles + (size_t)joined->record.double_count * sizeof(double);
    for (int e = f->first_element; e < f->first_element + f->element_count; e++) {
        const Element *element = &shown->elements[e];
        double count = 0;
        if (at >= end) return false;
        memcpy(&count, at, sizeof count);
        if ((int)count != element->corner_count) return false;
        at += sizeof count;
        for (int c = element->first_corner; c < element->first_corner + element->corner_count; c++) {
            int node = nodes->of_corner[c];
            double light[2][3];
            memcpy(light, at, sizeof light);
            at += sizeof light;
            if (known[node]) continue;
            known[node] = true;
            memcpy(out->node[node], light[0], sizeof light[0]);
            memcpy(out->rest[node], light[1], sizeof light[1]);
        }
    }
    return at == end;
}

static bool join_nodes(const Joined *face, const Mesh *mesh, const float *door_open, Arena *arena,
                       RadSolution *out, Error *error) {
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
        wrong += !take_corners(&face[f], &shown, f, &nodes, known, out);
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
    whole.part = NULL;
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
        if (head.nodes) good = join_nodes(face, mesh, door_open, arena, out, error);
    }
    arena_free(&scratch);
    return good;
}
