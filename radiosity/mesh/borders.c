// borders.c - both sides of a border list its faces in one order, the order of their polygons, so that letters need no names.
#include "radiosity/mesh/borders.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// The faces of one list.
typedef struct FaceSet {
    int *face;  // [count]
    int count, capacity;
} FaceSet;

struct Borders {
    const Mesh *mesh;
    TeamMember *member;
    FaceSet *foreign;  // [parts] in this mesh, of each other part
    FaceSet *lent;     // [parts] of this part, in the mesh of each other
};

TeamMember *borders_member(const Borders *borders) { return borders->member; }

const int *borders_lent(const Borders *borders, int part, int *count) {
    *count = borders->lent[part].count;
    return borders->lent[part].face;
}

FaceTitle *border_titles(const Mesh *mesh, Arena *arena) {
    FaceTitle *out = ARENA_ARRAY(arena, FaceTitle, mesh->face_count + 1);
    int object = -1, place = 0;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        if (face->object != object) place = 0;
        object = face->object;
        out[f] = (FaceTitle){face->object, face->polygon, face->polygon < 0 ? place++ : 0, face->patch_count,
                             face->element_count};
    }
    return out;
}

// Faces are in the order of objects; within one, polygons come before stand-ins.
int border_compare(const FaceTitle *a, const FaceTitle *b) {
    if (a->object != b->object) return a->object - b->object;
    bool first = a->polygon >= 0, second = b->polygon >= 0;
    if (first != second) return first ? -1 : 1;
    return first ? a->polygon - b->polygon : a->place - b->place;
}

// Finds the faces with these titles, which are in order. False where one is not there, or is another.
static bool find_titles(const Mesh *mesh, const FaceTitle *own, TeamBytes titles, FaceSet *out,
                        Arena *arena) {
    const FaceTitle *wanted = titles.data;
    int count = (int)(titles.size / sizeof *wanted), f = 0;
    for (int i = 0; i < count; i++) {
        while (f < mesh->face_count && border_compare(&own[f], &wanted[i]) < 0) f++;
        if (f == mesh->face_count || memcmp(&own[f], &wanted[i], sizeof *wanted) != 0 || !mesh_owns(mesh, f))
            return false;
        *ARENA_PUSH(arena, out->face, out->count, out->capacity) = f;
    }
    return true;
}

Borders *borders_new(const Mesh *mesh, TeamMember *member, Arena *arena, Error *error) {
    Arena scratch = {0};
    int parts = team_count(member);
    Borders *b = ARENA_ARRAY(arena, Borders, 1);
    *b = (Borders){mesh, member, ARENA_ARRAY(arena, FaceSet, parts), ARENA_ARRAY(arena, FaceSet, parts)};
    FaceTitle *titles = border_titles(mesh, &scratch), **of = ARENA_ARRAY(&scratch, FaceTitle *, parts);
    TeamBytes *to = ARENA_ARRAY(&scratch, TeamBytes, parts);
    for (int f = 0; f < mesh->face_count; f++) {
        int object = mesh->faces[f].object;
        if (mesh_owns(mesh, f) || !(mesh->options.part->seen[object / 64] >> object % 64 & 1)) continue;
        FaceSet *set = &b->foreign[mesh->options.part->owner[object]];
        *ARENA_PUSH(arena, set->face, set->count, set->capacity) = f;
    }
    for (int p = 0; p < parts; p++) {
        of[p] = ARENA_ARRAY(&scratch, FaceTitle, b->foreign[p].count + 1);
        for (int i = 0; i < b->foreign[p].count; i++) of[p][i] = titles[b->foreign[p].face[i]];
        to[p] = (TeamBytes){of[p], (size_t)b->foreign[p].count * sizeof **of};
    }
    const TeamBytes *from = team_exchange(member, to, &scratch);
    bool good = true;
    for (int p = 0; p < parts; p++) good = good && find_titles(mesh, titles, from[p], &b->lent[p], arena);
    bool any = team_any(member, !good);
    arena_free(&scratch);
    if (!any) return b;
    error_set(error, "%s: groups of cells do not agree on the elements of a polygon that they share",
              mesh->graph->building->source);
    return NULL;
}

// ---- values

// The values of a face: from `first` on, `count` of them.
static void values_of(const Mesh *mesh, int face, BorderUnit unit, int *first, int *count) {
    const Face *f = &mesh->faces[face];
    *first = unit == BORDER_PATCH ? f->first_patch : f->first_element;
    *count = unit == BORDER_PATCH ? f->patch_count : f->element_count;
}

static size_t count_values(const Mesh *mesh, const FaceSet *set, BorderUnit unit) {
    size_t sum = 0;
    for (int i = 0; i < set->count; i++) {
        int first, count;
        values_of(mesh, set->face[i], unit, &first, &count);
        sum += (size_t)count;
    }
    return sum;
}

// The values of faces, one after the other, go to `at`. Returns where they end.
static char *put_values(const Mesh *mesh, const FaceSet *set, BorderValue value, char *at) {
    for (int i = 0; i < set->count; i++) {
        int first, count;
        values_of(mesh, set->face[i], value.unit, &first, &count);
        memcpy(at, (const char *)value.array + value.size * (size_t)first, value.size * (size_t)count);
        at += value.size * (size_t)count;
    }
    return at;
}

// They come from `at`.
static const char *take_values(const Mesh *mesh, const FaceSet *set, BorderValue value, const char *at) {
    for (int i = 0; i < set->count; i++) {
        int first, count;
        values_of(mesh, set->face[i], value.unit, &first, &count);
        memcpy((char *)value.array + value.size * (size_t)first, at, value.size * (size_t)count);
        at += value.size * (size_t)count;
    }
    return at;
}

void borders_fetch(const Borders *b, const BorderValue *values, int count) {
    Arena scratch = {0};
    int parts = team_count(b->member);
    TeamBytes *to = ARENA_ARRAY(&scratch, TeamBytes, parts);
    for (int p = 0; p < parts; p++) {
        size_t bytes = 0;
        for (int i = 0; i < count; i++)
            bytes += values[i].size * count_values(b->mesh, &b->lent[p], values[i].unit);
        char *out = arena_alloc(&scratch, bytes + 1, 1), *at = out;
        for (int i = 0; i < count; i++) at = put_values(b->mesh, &b->lent[p], values[i], at);
        to[p] = (TeamBytes){out, bytes};
    }
    const TeamBytes *from = team_exchange(b->member, to, &scratch);
    for (int p = 0; p < parts; p++) {
        const char *at = from[p].data;
        for (int i = 0; i < count; i++) at = take_values(b->mesh, &b->foreign[p], values[i], at);
    }
    arena_free(&scratch);
}

// A letter holds, array by array, of those faces alone that have any light, their number in the list and their values; and -1.
static size_t write_light(const Mesh *mesh, const FaceSet *set, BorderValue light, char *out) {
    size_t size = 0;
    int64_t end = -1;
    double(*value)[3] = light.array;
    for (int i = 0; i < set->count; i++) {
        int first, count;
        bool any = false;
        values_of(mesh, set->face[i], light.unit, &first, &count);
        for (int k = first; k < first + count && !any; k++)
            any = value[k][0] != 0 || value[k][1] != 0 || value[k][2] != 0;
        if (!any) continue;
        int64_t number = i;
        size_t bytes = (size_t)count * sizeof *value;
        memcpy(out + size, &number, sizeof number);
        memcpy(out + size + sizeof number, value[first], bytes);
        memset(value[first], 0, bytes);
        size += sizeof number + bytes;
    }
    memcpy(out + size, &end, sizeof end);
    return size + sizeof end;
}

// Returns where the array ends.
static const char *add_vectors(const Mesh *mesh, const FaceSet *set, BorderValue light, const char *at) {
    double(*value)[3] = light.array;
    for (;;) {
        int first, count;
        int64_t number;
        memcpy(&number, at, sizeof number);
        at += sizeof number;
        if (number < 0) return at;
        values_of(mesh, set->face[number], light.unit, &first, &count);
        for (int k = first; k < first + count; k++, at += sizeof *value)
            for (int c = 0; c < 3; c++) value[k][c] += ((const double *)at)[c];
    }
}

void borders_bring(const Borders *b, const BorderValue *light, int count) {
    Arena scratch = {0};
    int parts = team_count(b->member);
    TeamBytes *to = ARENA_ARRAY(&scratch, TeamBytes, parts);
    for (int i = 0; i < count; i++) CORE_ASSERT(light[i].size == sizeof(double[3]));
    for (int p = 0; p < parts; p++) {
        const FaceSet *set = &b->foreign[p];
        size_t most = 0, size = 0;
        for (int i = 0; i < count; i++)
            most += count_values(b->mesh, set, light[i].unit) * light[i].size +
                    (size_t)(set->count + 1) * sizeof(int64_t);
        char *out = arena_alloc(&scratch, most + 1, 1);
        for (int i = 0; i < count; i++) size += write_light(b->mesh, set, light[i], out + size);
        to[p] = (TeamBytes){out, size};
    }
    const TeamBytes *from = team_exchange(b->member, to, &scratch);
    for (int p = 0; p < parts; p++) {
        const char *at = from[p].data;
        for (int i = 0; i < count; i++) at = add_vectors(b->mesh, &b->lent[p], light[i], at);
    }
    arena_free(&scratch);
}

static int greatest_first(const void *a, const void *b) {
    double p = *(const double *)a, q = *(const double *)b;
    return p < q ? 1 : p > q ? -1 : 0;
}

double borders_least(const Borders *borders, double *value, int count, double most) {
    Arena scratch = {0};
    double out = INFINITY;
    if (borders) {
        TeamMember *member = borders->member;
        const TeamBytes *from = team_collect(member, value, (size_t)count * sizeof *value, &scratch);
        size_t all = 0;
        for (int m = 0; m < team_count(member); m++) all += from[m].size;
        value = arena_alloc(&scratch, all + 1, 1);
        count = 0;
        for (int m = 0; m < team_count(member); m++) {
            memcpy(value + count, from[m].data, from[m].size);
            count += (int)(from[m].size / sizeof *value);
        }
    }
    qsort(value, (size_t)count, sizeof *value, greatest_first);
    for (int i = 0; i < most && i < count; i++) out = value[i];
    arena_free(&scratch);
    return out;
}

// ---- splits: of each face the number of its bits, and these

void border_copy_bits(const unsigned char *from, int first, unsigned char *to, int at, int count) {
    for (int i = 0; i < count; i++)
        if (from[(first + i) / 8] >> (first + i) % 8 & 1)
            to[(at + i) / 8] = (unsigned char)(to[(at + i) / 8] | 1 << (at + i) % 8);
}

static TeamBytes write_splits(const FaceSet *set, const MeshSplits *splits, const int *first, Arena *arena) {
    size_t size = 0;
    for (int i = 0; i < set->count; i++)
        size += sizeof(int) + (size_t)(first[set->face[i] + 1] - first[set->face[i]] + 7) / 8;
    unsigned char *out = arena_alloc(arena, size + 1, 1), *at = out;
    for (int i = 0; i < set->count; i++) {
        int from = first[set->face[i]], count = first[set->face[i] + 1] - from;
        memcpy(at, &count, sizeof count);
        border_copy_bits(splits->bits, from, at + sizeof count, 0, count);
        at += sizeof count + (size_t)(count + 7) / 8;
    }
    return (TeamBytes){out, size};
}

MeshSplits *borders_splits(const Borders *b, const MeshSplits *splits, Arena *arena) {
    Arena scratch = {0};
    const Mesh *mesh = b->mesh;
    int parts = team_count(b->member), *first = mesh_face_bits(mesh, splits, &scratch), bits = 0;
    const unsigned char **of = ARENA_ARRAY(&scratch, const unsigned char *, mesh->face_count + 1);
    int *count = ARENA_ARRAY(&scratch, int, mesh->face_count + 1);
    TeamBytes *to = ARENA_ARRAY(&scratch, TeamBytes, parts);
    for (int p = 0; p < parts; p++) to[p] = write_splits(&b->lent[p], splits, first, &scratch);
    const TeamBytes *from = team_exchange(b->member, to, &scratch);
    for (int f = 0; f < mesh->face_count; f++) count[f] = first[f + 1] - first[f];
    for (int p = 0; p < parts; p++) {
        const unsigned char *at = from[p].data;
        for (int i = 0; i < b->foreign[p].count; i++) {
            int f = b->foreign[p].face[i];
            memcpy(&count[f], at, sizeof *count);
            of[f] = at + sizeof *count;
            at += sizeof *count + (size_t)(count[f] + 7) / 8;
        }
    }
    for (int f = 0; f < mesh->face_count; f++) bits += count[f];
    MeshSplits *out = ARENA_ARRAY(arena, MeshSplits, 1);
    *out = (MeshSplits){bits, ARENA_ARRAY(arena, unsigned char, (bits + 7) / 8 + 1), splits->even};
    for (int f = 0, at = 0; f < mesh->face_count; at += count[f++])
        border_copy_bits(of[f] ? of[f] : splits->bits, of[f] ? 0 : first[f], out->bits, at, count[f]);
    arena_free(&scratch);
    return out;
}
