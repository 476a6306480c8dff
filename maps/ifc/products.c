// products.c - products, storeys and what relates them (ISO 16739, IfcKernel and IfcProductExtension).
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "maps/ifc/ifc_file.h"

static const char *const KIND_NAMES[IFC_KINDS] = {
    "product",      "space",   "wall",   "slab",  "door",          "window",     "opening",
    "stair",        "ramp",    "column", "beam",  "covering",      "furnishing", "roof",
    "curtain wall", "railing", "member", "plate", "light fixture", "site",       "unbuilt"};

const char *ifc_kind_name(IfcKind kind) { return KIND_NAMES[kind]; }

static IfcKind product_kind(int type) {
    switch (type) {
    case T_SPACE:
        return IFC_SPACE;
    case T_WALL:
    case T_WALLSTANDARDCASE:
    case T_WALLELEMENTEDCASE:
        return IFC_WALL;
    case T_SLAB:
    case T_SLABSTANDARDCASE:
    case T_SLABELEMENTEDCASE:
        return IFC_SLAB;
    case T_DOOR:
    case T_DOORSTANDARDCASE:
        return IFC_DOOR;
    case T_WINDOW:
    case T_WINDOWSTANDARDCASE:
        return IFC_WINDOW;
    case T_OPENINGELEMENT:
    case T_OPENINGSTANDARDCASE:
        return IFC_OPENING;
    case T_STAIR:
    case T_STAIRFLIGHT:
        return IFC_STAIR;
    case T_RAMP:
    case T_RAMPFLIGHT:
        return IFC_RAMP;
    case T_COLUMN:
    case T_COLUMNSTANDARDCASE:
        return IFC_COLUMN;
    case T_BEAM:
    case T_BEAMSTANDARDCASE:
        return IFC_BEAM;
    case T_COVERING:
        return IFC_COVERING;
    case T_FURNISHINGELEMENT:
    case T_FURNITURE:
    case T_SYSTEMFURNITUREELEMENT:
    case T_SANITARYTERMINAL:
    case T_ELECTRICAPPLIANCE:
    case T_AUDIOVISUALAPPLIANCE:
    case T_MEDICALDEVICE:
        return IFC_FURNISHING;
    case T_ROOF:
        return IFC_ROOF;
    case T_CURTAINWALL:
        return IFC_CURTAIN_WALL;
    case T_RAILING:
        return IFC_RAILING;
    case T_MEMBER:
    case T_MEMBERSTANDARDCASE:
        return IFC_MEMBER;
    case T_PLATE:
    case T_PLATESTANDARDCASE:
        return IFC_PLATE;
    case T_LIGHTFIXTURE:
    case T_LAMP:
        return IFC_LIGHT;
    case T_SITE:
    case T_FACILITY:
    case T_FACILITYPART:
    case T_ROAD:
    case T_ROADPART:
    case T_BRIDGE:
    case T_BRIDGEPART:
    case T_RAILWAY:
    case T_RAILWAYPART:
        return IFC_SITE;
    case T_SPATIALZONE:
    case T_REFERENT:
    case T_STRUCTURALCURVEMEMBER:
    case T_STRUCTURALCURVEMEMBERVARYING:
    case T_STRUCTURALSURFACEMEMBER:
    case T_STRUCTURALSURFACEMEMBERVARYING:
        return IFC_UNBUILT;
    default:
        return IFC_OTHER;
    }
}

static bool is_product(int type) {
    switch (type) {
#define IFC_CASE(name) case T_##name:
        IFC_PRODUCT_TYPES(IFC_CASE)
#undef IFC_CASE
        return type != T_ANNOTATION;
    default:
        return false;
    }
}

// ---- relations

static void push_pair(Arena *arena, Pairs *pairs, int key, int value) {
    if (key >= 0 && value >= 0)
        *ARENA_PUSH(arena, pairs->pair, pairs->count, pairs->room) = (Pair){key, value};
}

// A relation of many records with one: the arguments that name them.
static void push_many(Reader *r, Arena *arena, Pairs *pairs, int record, int many, int one) {
    StepValue v[6];
    ifc_arguments(r, record, v, 6);
    StepCursor c = ifc_list(r, &v[many]);
    for (StepValue m = step_next(&c); m.kind != STEP_END; m = step_next(&c))
        push_pair(arena, pairs, m.record, v[one].record);
}

// A relation of one record with another.
static void push_two(Reader *r, Arena *arena, Pairs *pairs, int record, int key, int value) {
    StepValue v[6];
    ifc_arguments(r, record, v, 6);
    push_pair(arena, pairs, v[key].record, v[value].record);
}

// The lists of relations, all of which are put together in the same way.
enum { LISTS = 9 };
static Pairs *list_of(Relations *rel, int list) {
    Pairs *const all[LISTS] = {&rel->products, &rel->storeys, &rel->materials, &rel->types, &rel->openings,
                               &rel->fills,    &rel->inside,  &rel->parts,     &rel->maps};
    return all[list];
}

// A part of the file, whose lists one thread finds.
enum { READ_AT_ONCE = 65536 };  // records
typedef struct RelationWork {
    Reader *readers;
    Arena *arenas;     // [threads]
    Relations *parts;  // [part_count] with values of products and storeys left open
    int part_count;
    Relations *out;
} RelationWork;

static void read_relation(Reader *r, Arena *arena, int record, Relations *out) {
    StepValue v;
    int type = ifc_type(r, record);
    switch (type) {
    case T_RELAGGREGATES:
    case T_RELNESTS:
        push_many(r, arena, &out->parts, record, 5, 4);
        break;
    case T_RELCONTAINEDINSPATIALSTRUCTURE:
        push_many(r, arena, &out->inside, record, 4, 5);
        break;
    case T_RELVOIDSELEMENT:
        push_two(r, arena, &out->openings, record, 4, 5);
        break;
    case T_RELFILLSELEMENT:
        push_two(r, arena, &out->fills, record, 5, 4);
        break;
    case T_RELDEFINESBYTYPE:
        push_many(r, arena, &out->types, record, 4, 5);
        break;
    case T_RELASSOCIATESMATERIAL:
        push_many(r, arena, &out->materials, record, 4, 5);
        break;
    case T_MAPPEDITEM:
        ifc_arguments(r, record, &v, 1);
        if (ifc_type(r, v.record) == T_REPRESENTATIONMAP) push_pair(arena, &out->maps, v.record, record);
        break;
    case T_BUILDINGSTOREY:
        push_pair(arena, &out->storeys, record, 0);
        break;
    default:
        if (is_product(type)) push_pair(arena, &out->products, record, 0);
        break;
    }
}

static void read_some_relations(void *context, int index, int thread) {
    RelationWork *work = context;
    Reader *r = &work->readers[thread];
    int first = index * READ_AT_ONCE, left = r->file->step.record_count - first;
    for (int i = 0; i < READ_AT_ONCE && i < left; i++)
        read_relation(r, &work->arenas[thread], first + i, &work->parts[index]);
}

// Puts the lists of one kind together, in the order of the file; then they are sorted by their keys.
static void join_lists(void *context, int list, int thread) {
    (void)thread;
    RelationWork *work = context;
    Pairs *out = list_of(work->out, list);
    for (int i = 0; i < work->part_count; i++) {
        const Pairs *from = list_of(&work->parts[i], list);
        if (from->count > 0) memcpy(out->pair + out->count, from->pair, (size_t)from->count * sizeof(Pair));
        out->count += from->count;
    }
    // Those of products and storeys are in order, and their values are their places.
    if (out == &work->out->products || out == &work->out->storeys) {
        for (int i = 0; i < out->count; i++) out->pair[i].value = i;
    } else {
        ifc_sort(out);
    }
}

void ifc_read_relations(Reader *readers, int threads, Arena *arena, Relations *out) {
    Arena scratch = {0};
    int part_count = (readers->file->step.record_count + READ_AT_ONCE - 1) / READ_AT_ONCE;
    RelationWork work = {readers, ARENA_ARRAY(&scratch, Arena, threads),
                         ARENA_ARRAY(&scratch, Relations, part_count + 1), part_count, out};
    parallel_for(threads, part_count, read_some_relations, &work);
    for (int list = 0; list < LISTS; list++) {
        Pairs *to = list_of(out, list);
        for (int i = 0; i < part_count; i++) to->room += list_of(&work.parts[i], list)->count;
        to->pair = ARENA_ARRAY(arena, Pair, to->room + 1);
    }
    parallel_for(threads, LISTS, join_lists, &work);
    out->record = ARENA_ARRAY(arena, int, out->products.count + 1);
    for (int i = 0; i < out->products.count; i++) out->record[i] = out->products.pair[i].key;
    for (int t = 0; t < threads; t++) arena_free(&work.arenas[t]);
    arena_free(&scratch);
}

static int value_of(const Pairs *pairs, int key) {
    int at = key < 0 ? -1 : ifc_pair(pairs, key);
    return at < 0 ? -1 : pairs->pair[at].value;
}

// ---- products

// The text of an enumerator.
static const char *enumerator(Reader *r, const StepValue *v) {
    if (v->kind != STEP_ENUM || v->size == 0) return "";
    char *out = memcpy(step_room(&r->strings, v->size + 1), r->file->step.text + v->at, v->size);
    out[v->size] = 0;
    return out;
}

static const char *operation_of(Reader *r, const Relations *rel, int record, const StepValue *own) {
    StepValue v[11];
    if (own->kind == STEP_ENUM) return enumerator(r, own);
    int type = value_of(&rel->types, record);
    if (!ifc_arguments(r, type, v, 11)) return "";
    if (ifc_type(r, type) == T_DOORSTYLE) return enumerator(r, &v[8]);
    return ifc_type(r, type) == T_DOORTYPE ? enumerator(r, &v[10]) : "";
}

void ifc_read_product(Reader *r, const Relations *rel, int product, IfcProduct *p) {
    StepValue v[12];
    int record = rel->record[product];
    const StepFile *step = &r->file->step;
    int type = step->type[record];
    ifc_arguments(r, record, v, 12);
    *p = (IfcProduct){.entity = step->entity[record],
                      .kind = product_kind(type),
                      .storey = -1,
                      .space = -1,
                      .whole = -1,
                      .host = -1,
                      .box = box_empty()};
    p->type = step_type_name(step, record, &r->kept);
    p->guid = step_string(step, &v[0], &r->strings);
    p->name = step_string(step, &v[2], &r->strings);
    p->object_type = step_string(step, &v[4], &r->strings);
    p->long_name = p->kind == IFC_SPACE || p->kind == IFC_SITE ? step_string(step, &v[7], &r->strings) : "";
    bool leaf = p->kind == IFC_DOOR || p->kind == IFC_WINDOW;
    p->predefined = p->kind == IFC_SITE ? "" : enumerator(r, &v[p->kind == IFC_SPACE ? 9 : leaf ? 10 : 8]);
    p->operation = "";
    if (leaf) {
        p->height = ifc_length(r, &v[8], 0);
        p->width = ifc_length(r, &v[9], 0);
    }
    if (p->kind == IFC_DOOR) p->operation = operation_of(r, rel, record, &v[11]);
    Frame f = ifc_placement(r, v[5].record);
    p->axis[0] = vec3_normalize(f.x);
    p->axis[1] = vec3_normalize(f.y);
    p->axis[2] = vec3_normalize(f.z);
    p->place = f.o;
    // A place that cannot be counts as none; the mesh is left out then.
    if (!(fabs(f.o.x) + fabs(f.o.y) + fabs(f.o.z) <= 1e9)) p->place = vec3(1e9, 1e9, 1e9);
}

// The angle of an IfcCompoundPlaneAngleMeasure: degrees, minutes, seconds, millionths.
static double compound_angle(Reader *r, const StepValue *list, bool *told) {
    double part[4] = {0};
    StepCursor c = {&r->file->step, 0, &r->bad};
    *told = step_numbers(&c, list, part, 4) >= 2;
    return (part[0] + part[1] / 60 + (part[2] + part[3] / 1e6) / 3600) * M_PI / 180;
}

static void read_place(Reader *r, IfcModel *model) {
    const StepFile *step = &r->file->step;
    StepValue v[11];
    for (int i = 0; i < step->record_count; i++) {
        if (step->type[i] == T_SITE && !model->placed && ifc_arguments(r, i, v, 11)) {
            bool north, east;
            model->latitude = compound_angle(r, &v[9], &north);
            model->longitude = compound_angle(r, &v[10], &east);
            model->placed = north && east;
        } else if (step->type[i] == T_GEOMETRICREPRESENTATIONCONTEXT && model->north == 0 &&
                   ifc_arguments(r, i, v, 6) && v[5].record >= 0) {
            Vec3 d = ifc_direction(r, v[5].record, vec3(0, 1, 0));
            model->north = atan2(d.x, d.y);
        }
    }
}

static int compare_storeys(const void *a, const void *b) {
    const IfcStorey *p = a, *q = b;
    if (p->elevation != q->elevation) return p->elevation < q->elevation ? -1 : 1;
    return p->entity < q->entity ? -1 : p->entity > q->entity;
}

static void read_storeys(Reader *r, Arena *arena, Relations *rel, IfcModel *model) {
    const StepFile *step = &r->file->step;
    int count = model->storey_count = rel->storeys.count;
    model->storeys = ARENA_ARRAY(arena, IfcStorey, count + 1);
    for (int i = 0; i < count; i++) {
        StepValue v[10];
        int record = rel->storeys.pair[i].key;
        ifc_arguments(r, record, v, 10);
        double z = v[5].record >= 0 ? ifc_placement(r, v[5].record).o.z : ifc_length(r, &v[9], 0);
        model->storeys[i] = (IfcStorey){step->entity[record], step_string(step, &v[0], &r->strings),
                                        step_string(step, &v[2], &r->strings), isfinite(z) ? z : 0};
        if (!model->storeys[i].name[0]) model->storeys[i].name = step_string(step, &v[7], &r->strings);
    }
    if (count > 1) qsort(model->storeys, (size_t)count, sizeof(IfcStorey), compare_storeys);
    Pairs rank = {ARENA_ARRAY(&r->scratch, Pair, count + 1), count, count};
    for (int i = 0; i < count; i++) rank.pair[i] = (Pair){model->storeys[i].entity, i};
    ifc_sort(&rank);
    for (int i = 0; i < count; i++) {
        int at = ifc_pair(&rank, step->entity[rel->storeys.pair[i].key]);
        rel->storeys.pair[i].value = rank.pair[at].value;
    }
}

// The container of a product tells its storey; a part has that of its whole, an opening that of its host.
static int storey_of(const Relations *rel, IfcModel *model, int product, int depth) {
    IfcProduct *p = &model->products[product];
    if (p->storey >= 0 || depth > IFC_DEEPEST) return p->storey;
    if (p->space >= 0) p->storey = storey_of(rel, model, p->space, depth + 1);
    if (p->storey < 0 && p->whole >= 0) p->storey = storey_of(rel, model, p->whole, depth + 1);
    if (p->storey < 0 && p->host >= 0) p->storey = storey_of(rel, model, p->host, depth + 1);
    return p->storey;
}

enum { RELATED_AT_ONCE = 4096 };  // products
typedef struct Relating {
    const Relations *rel;
    IfcModel *model;
} Relating;

static void relate_product(const Relations *rel, const IfcModel *model, int product) {
    IfcProduct *p = &model->products[product];
    int record = rel->record[product], inside = value_of(&rel->inside, record),
        whole = value_of(&rel->parts, record);
    for (int i = 0; i < 2; i++) {
        int in = i ? whole : inside;
        if (in >= 0 && p->storey < 0) p->storey = value_of(&rel->storeys, in);
    }
    int space = value_of(&rel->products, inside);
    if (space >= 0 && model->products[space].kind == IFC_SPACE) p->space = space;
    p->whole = value_of(&rel->products, whole);
    int fills = value_of(&rel->fills, record);
    if (fills >= 0) p->host = value_of(&rel->products, fills);
}

static void relate_some(void *context, int index, int thread) {
    (void)thread;
    const Relating *work = context;
    int first = index * RELATED_AT_ONCE, left = work->model->product_count - first;
    for (int i = 0; i < RELATED_AT_ONCE && i < left; i++) relate_product(work->rel, work->model, first + i);
}

static bool is_boundary(int type) {
    return type == T_RELSPACEBOUNDARY || type == T_RELSPACEBOUNDARY1STLEVEL ||
           type == T_RELSPACEBOUNDARY2NDLEVEL;
}

static void read_boundaries(Reader *r, Arena *arena, const Relations *rel, IfcModel *model) {
    const StepFile *step = &r->file->step;
    int room = 0;
    for (int i = 0; i < step->record_count; i++) {
        StepValue v[9];
        if (!is_boundary(step->type[i]) || !ifc_arguments(r, i, v, 9)) continue;
        int space = value_of(&rel->products, v[4].record);
        if (space < 0) continue;
        *ARENA_PUSH(arena, model->boundaries, model->boundary_count, room) =
            (IfcBoundary){space, value_of(&rel->products, v[5].record), !ifc_is(r, &v[7], "VIRTUAL"),
                          ifc_is(r, &v[8], "EXTERNAL")};
    }
}

void ifc_relate_products(Reader *r, int threads, Arena *arena, Relations *rel, IfcModel *model) {
    const StepFile *step = &r->file->step;
    read_storeys(r, arena, rel, model);
    for (int i = 0; i < rel->openings.count; i++) {
        int opening = value_of(&rel->products, rel->openings.pair[i].value);
        if (opening >= 0 && model->products[opening].kind == IFC_OPENING)
            model->products[opening].host = value_of(&rel->products, rel->openings.pair[i].key);
    }
    Relating work = {rel, model};
    parallel_for(threads, (model->product_count + RELATED_AT_ONCE - 1) / RELATED_AT_ONCE, relate_some, &work);
    for (int i = 0; i < model->product_count; i++) storey_of(rel, model, i, 0);
    read_boundaries(r, arena, rel, model);
    read_place(r, model);
    model->name = "";
    for (int i = 0; i < step->record_count && !model->name[0]; i++) {
        StepValue v[3];
        if (step->type[i] != T_BUILDING && step->type[i] != T_PROJECT) continue;
        ifc_arguments(r, i, v, 3);
        model->name = step_string(step, &v[2], &r->strings);
    }
}
