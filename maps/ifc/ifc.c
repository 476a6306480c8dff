// ifc.c - a STEP file of a building becomes an IfcModel: meshes of all products, on several threads.
//
// Each product is read by one thread into memory of that thread; what shapes share (representation maps) is made first. Results are put
// together in the order of the file, so that they do not depend on threads.
#include "maps/ifc/ifc.h"

#include <stdio.h>
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "maps/ifc/ifc_file.h"

// Models farther than this from the origin of the file are moved near it, metres.
#define FAR_AWAY 10000.0
// Products with coordinates beyond this are left out, metres: no country has such.
#define FARTHEST 1e8

bool ifc_recognise(Bytes content) {
    const unsigned char *p = content.data, *end = p + content.size;
    if (end - p >= 3 && memcmp(p, "\xEF\xBB\xBF", 3) == 0) p += 3;
    while (p < end && (*p == ' ' || *p == '\n' || *p == '\r' || *p == '\t')) p++;
    return end - p >= 13 && memcmp(p, "ISO-10303-21;", 13) == 0;
}

static const char *const TYPE_NAMES[T_COUNT] = {
#define IFC_TYPE_NAME(name) "IFC" #name,
    IFC_TYPES(IFC_TYPE_NAME)
#undef IFC_TYPE_NAME
};

// The prisms of one product, before they are joined.
typedef struct Found {
    IfcFootprint *footprints;
    IfcRing *rings;
    Vec2 *points;
    int footprint_count, ring_count, point_count;
    int first_footprint, first_ring, first_point;  // in the model
} Found;

// The sums of neighbouring products.
enum { JOINED_AT_ONCE = 4096 };
typedef struct Sum {
    Box box;  // of all but sites
    long long polygons;
} Sum;

typedef struct Work {
    IfcFile *file;
    IfcModel *model;
    const Relations *relations;
    Reader *readers;
    Arena *prisms;  // [threads] for footprints until they are joined
    Found *found;   // [product_count]
    Sum *sums;      // of each JOINED_AT_ONCE products
    int at_once;    // products that a thread takes: neighbours in the file have much in common
} Work;

// ---- representations

static bool is_one_of(const Reader *r, const StepValue *text, const char *const *names, int count) {
    for (int i = 0; i < count; i++)
        if (text->size == strlen(names[i]) &&
            memcmp(r->file->step.text + text->at, names[i], text->size) == 0)
            return true;
    return false;
}

// How well a representation shows the body: 2 the body itself, 1 another form of it, 0 a drawing.
static int body_rank(const Reader *r, const StepValue *identifier, const StepValue *type) {
    static const char *const BODY[] = {"Body"}, *const OTHERS[] = {"Facetation", "Mesh", "Tessellation",
                                                                   "Body-Fallback", "Surface"};
    static const char *const KINDS[] = {"SweptSolid",   "Brep",       "AdvancedBrep",
                                        "CSG",          "Clipping",   "MappedRepresentation",
                                        "SurfaceModel", "SolidModel", "AdvancedSweptSolid",
                                        "Tessellation", "Surface3D",  "SurfaceOrSolidModel"};
    static const char *const DRAWINGS[] = {"Axis", "FootPrint", "Profile",   "Box",      "Annotation",
                                           "Plan", "CoG",       "Clearance", "Lighting", "Reference"};
    enum { OTHER_COUNT = sizeof OTHERS / sizeof *OTHERS, KIND_COUNT = sizeof KINDS / sizeof *KINDS };
    enum { DRAWING_COUNT = sizeof DRAWINGS / sizeof *DRAWINGS };
    if (identifier->kind == STEP_STRING) {
        if (is_one_of(r, identifier, BODY, 1)) return 2;
        if (is_one_of(r, identifier, OTHERS, OTHER_COUNT)) return 1;
        if (is_one_of(r, identifier, DRAWINGS, DRAWING_COUNT)) return 0;
    }
    return type->kind == STEP_STRING && is_one_of(r, type, KINDS, KIND_COUNT);
}

// The items of a product's body, in its own frame.
static void read_body(Reader *r, int record, Body *out) {
    StepValue v[7], list[3], s[4];
    ifc_arguments(r, record, v, 7);
    int shape = ifc_type(r, v[6].record);
    if ((shape != T_PRODUCTDEFINITIONSHAPE && shape != T_PRODUCTREPRESENTATION) ||
        !ifc_arguments(r, v[6].record, list, 3))
        return;
    for (int rank = 2; rank > 0 && out->count == 0; rank--) {
        StepCursor c = ifc_list(r, &list[2]);
        for (StepValue rep = step_next(&c); rep.kind != STEP_END; rep = step_next(&c)) {
            int type = ifc_type(r, rep.record);
            if ((type != T_SHAPEREPRESENTATION && type != T_TOPOLOGYREPRESENTATION) ||
                !ifc_arguments(r, rep.record, s, 4))
                continue;
            // Faces of members for structural analysis stand for bodies.
            int own = type == T_TOPOLOGYREPRESENTATION ? 1 : body_rank(r, &s[1], &s[2]);
            if (own == rank) ifc_representation(r, rep.record, NULL, -1, out);
            // One form of a body that has several is enough.
            if (rank == 1 && out->count > 0) break;
        }
    }
}

static Frame product_frame(const IfcProduct *p) {
    return (Frame){p->axis[0], p->axis[1], p->axis[2], p->place};
}

// ---- maps

static void copy_body(Arena *arena, const Body *from, Body *to) {
    *to = (Body){.items = ARENA_ARRAY(arena, Item, from->count), .count = from->count};
    for (int i = 0; i < from->count; i++) {
        const Item *a = &from->items[i];
        Item *b = &to->items[i];
        *b = *a;
        b->shape.corners = memcpy(ARENA_ARRAY(arena, Vec3, a->shape.corner_count), a->shape.corners,
                                  (size_t)a->shape.corner_count * sizeof(Vec3));
        b->shape.faces = memcpy(ARENA_ARRAY(arena, ShapeFace, a->shape.face_count), a->shape.faces,
                                (size_t)a->shape.face_count * sizeof(ShapeFace));
        if (a->shape.map_count > 0)
            b->shape.maps = memcpy(ARENA_ARRAY(arena, TextureMap, a->shape.map_count), a->shape.maps,
                                   (size_t)a->shape.map_count * sizeof(TextureMap));
        if (a->prism.ring_count == 0) continue;
        int total = 0;
        b->prism.size = memcpy(ARENA_ARRAY(arena, int, a->prism.ring_count), a->prism.size,
                               (size_t)a->prism.ring_count * sizeof(int));
        for (int k = 0; k < a->prism.ring_count; k++) total += a->prism.size[k];
        b->prism.corners =
            memcpy(ARENA_ARRAY(arena, Vec3, total), a->prism.corners, (size_t)total * sizeof(Vec3));
    }
}

typedef struct MapWork {
    Work *work;
    Body *bodies;
    Arena *arenas;  // [threads]
} MapWork;

static void read_map(void *context, int index, int thread) {
    MapWork *maps = context;
    Reader *r = &maps->work->readers[thread];
    StepValue m[2];
    Body body = {0};
    ifc_begin(r, -1);
    ifc_arguments(r, maps->work->file->maps.pair[index].key, m, 2);
    ifc_representation(r, m[1].record, NULL, -1, &body);
    copy_body(&maps->arenas[thread], &body, &maps->bodies[index]);
    arena_reset(&r->scratch);
}

// The representation maps that items use, each once.
static void find_maps(IfcFile *file, const Pairs *used) {
    file->maps = *used;
    int kept = 0;
    for (int i = 0; i < used->count; i++) {
        if (kept > 0 && used->pair[kept - 1].key == used->pair[i].key) continue;
        used->pair[kept] = (Pair){used->pair[i].key, kept};
        kept++;
    }
    file->maps.count = kept;
}

// ---- products

static int look_of(Reader *r, const Relations *rel, int record) {
    int at = ifc_pair(&rel->materials, record);
    int look = at < 0 ? -1 : ifc_material_look(r, rel->materials.pair[at].value, 0);
    if (look >= 0) return look;
    at = ifc_pair(&rel->types, record);
    if (at < 0) return -1;
    at = ifc_pair(&rel->materials, rel->types.pair[at].value);
    return at < 0 ? -1 : ifc_material_look(r, rel->materials.pair[at].value, 0);
}

// The place of a corner in the picture that lies on its face.
static Vec2 place_of(const Shape *s, const ShapeFace *f, Vec3 corner) {
    if (!f->map) return vec2(NAN, NAN);
    const TextureMap *m = &s->maps[f->map - 1];
    return vec2(vec3_dot(m->u, corner) + m->u0, vec3_dot(m->v, corner) + m->v0);
}

static void make_mesh(Arena *arena, const Body *body, const Frame *frame, int look, IfcMesh *out) {
    int corners = 0, faces = 0, maps = 0;
    for (int i = 0; i < body->count; i++) {
        maps += body->items[i].shape.map_count;
        corners += body->items[i].shape.corner_count;
        faces += body->items[i].shape.face_count;
    }
    *out = (IfcMesh){0};
    if (faces == 0) return;
    // One piece of memory for both: an arena aligns each piece.
    size_t size = (size_t)corners * sizeof(Vec3);
    char *memory = arena_alloc(arena, size + (size_t)faces * sizeof(IfcPolygon), 1);
    out->corners = (Vec3 *)memory;
    out->polygons = (IfcPolygon *)(memory + size);
    if (maps > 0) out->places = ARENA_ARRAY(arena, Vec2, corners);
    for (int i = 0; i < body->count; i++) {
        const Shape *s = &body->items[i].shape;
        for (int k = 0; k < s->face_count; k++) {
            const ShapeFace *f = &s->faces[k];
            out->polygons[out->polygon_count++] = (IfcPolygon){out->corner_count, f->count,
                                                               f->material >= 0 ? f->material
                                                               : look >= 0      ? look
                                                                                : 0};
            for (int n = 0; n < f->count; n++) {
                if (out->places) out->places[out->corner_count] = place_of(s, f, s->corners[f->first + n]);
                out->corners[out->corner_count++] = frame_point(frame, s->corners[f->first + n]);
            }
        }
    }
}

// Is a prism upright in the model? Writes its corners there.
static bool is_upright(Reader *r, const Prism *prism, const Frame *frame, int total, Vec3 **corners) {
    Vec3 sweep = frame_turn(frame, prism->sweep);
    if (prism->ring_count == 0 || !(hypot(sweep.x, sweep.y) <= 1e-6 * fabs(sweep.z))) return false;
    *corners = ARENA_ARRAY(&r->scratch, Vec3, total);
    for (int i = 0; i < total; i++) {
        (*corners)[i] = frame_point(frame, prism->corners[i]);
        if (!(fabs((*corners)[i].z - (*corners)[0].z) <= SHAPE_EPSILON)) return false;
    }
    return true;
}

// Keeps the upright prisms of a body.
static void find_footprints(Reader *r, Arena *arena, const Body *body, const Frame *frame, Found *found) {
    int rings = 0, points = 0, total;
    for (int i = 0; i < body->count; i++) {
        rings += body->items[i].prism.ring_count;
        for (int k = 0; k < body->items[i].prism.ring_count; k++) points += body->items[i].prism.size[k];
    }
    if (rings == 0) return;
    // Exactly as much as needed: there may be millions.
    size_t head = (size_t)body->count * sizeof(IfcFootprint), middle = (size_t)rings * sizeof(IfcRing);
    char *memory = arena_alloc(arena, head + middle + (size_t)points * sizeof(Vec2), 1);
    found->footprints = (IfcFootprint *)memory;
    found->points = (Vec2 *)(memory + head);
    found->rings = (IfcRing *)(memory + head + (size_t)points * sizeof(Vec2));
    for (int i = 0; i < body->count; i++) {
        const Prism *prism = &body->items[i].prism;
        Vec3 *corners;
        total = 0;
        for (int k = 0; k < prism->ring_count; k++) total += prism->size[k];
        if (!is_upright(r, prism, frame, total, &corners)) continue;
        double base = corners[0].z, top = base + frame_turn(frame, prism->sweep).z;
        found->footprints[found->footprint_count++] = (IfcFootprint){
            found->ring_count, prism->ring_count, fmin(base, top), fmax(base, top), prism->clipped};
        for (int ring = 0, first = 0; ring < prism->ring_count; first += prism->size[ring], ring++) {
            int count = prism->size[ring];
            double twice = 0;
            for (int k = 0; k < count; k++) {
                Vec3 a = vec3_sub(corners[first + k], corners[first]),
                     b = vec3_sub(corners[first + (k + 1) % count], corners[first]);
                twice += a.x * b.y - a.y * b.x;
            }
            bool turn = (twice > 0) == (ring > 0);
            found->rings[found->ring_count++] = (IfcRing){found->point_count, count};
            for (int k = 0; k < count; k++) {
                Vec3 p = corners[first + (turn ? count - 1 - k : k)];
                found->points[found->point_count++] = vec2(p.x, p.y);
            }
        }
    }
}

// The solids that are cut out of a body.
typedef struct Tools {
    const Shape **items;
    int count, room;
} Tools;

// Adds the openings of a product, in the frame that `back` leads to.
static void add_tools(Reader *r, const Work *work, int product, const Frame *back, Tools *tools) {
    const Relations *rel = work->relations;
    for (int at = ifc_pair(&rel->openings, rel->record[product]);
         at >= 0 && at < rel->openings.count && rel->openings.pair[at].key == rel->record[product]; at++) {
        int index = ifc_pair(&rel->products, rel->openings.pair[at].value);
        if (index < 0) continue;
        const IfcProduct *opening = &work->model->products[rel->products.pair[index].value];
        Body holes = {0};
        read_body(r, rel->openings.pair[at].value, &holes);
        Frame own = product_frame(opening), joined = frame_join(back, &own);
        for (int i = 0; i < holes.count; i++) {
            if (!holes.items[i].shape.solid) continue;
            Shape *kept = ARENA_ARRAY(&r->scratch, Shape, 1);
            *kept = shape_empty(true);
            shape_append_mapped(&r->scratch, kept, &holes.items[i].shape, &joined);
            *ARENA_PUSH(&r->scratch, tools->items, tools->count, tools->room) = kept;
        }
    }
}

// The product that a product is a part of, if openings void it, too; else the next whole of which that is so; -1: none.
static int voided_whole(const Work *work, int product, int *depth) {
    const Relations *rel = work->relations;
    while ((product = work->model->products[product].whole) >= 0 && (*depth)++ < IFC_DEEPEST)
        if (ifc_pair(&rel->openings, rel->record[product]) >= 0) return product;
    return -1;
}

// The items of a body with openings cut out: those of the product and of all that it is a part of, as the layers of a wall.
static void cut_openings(Reader *r, const Work *work, int product, const Body *body, Body *out) {
    const Relations *rel = work->relations;
    Frame frame = product_frame(&work->model->products[product]), back = frame_inverse(&frame);
    Tools tools = {0};
    for (int at = product, depth = 0; at >= 0; at = voided_whole(work, at, &depth))
        add_tools(r, work, at, &back, &tools);
    *out = (Body){.items = ARENA_ARRAY(&r->scratch, Item, body->count), .count = body->count};
    for (int i = 0; i < body->count; i++) {
        out->items[i] = body->items[i];
        if (!shape_boolean(&r->scratch, SHAPE_DIFFERENCE, &body->items[i].shape, tools.items, tools.count,
                           &r->work, &out->items[i].shape))
            ifc_note(r, rel->record[product],
                     "keeps its openings closed: to cut them out takes too long, or it lies too far away");
        // Faces of a cut look as the body does.
        int look = body->items[i].shape.face_count ? body->items[i].shape.faces[0].material : -1;
        Shape *s = &out->items[i].shape;
        for (int k = 0; k < s->face_count; k++)
            if (s->faces[k].material < 0) s->faces[k].material = look;
    }
}

// Are all corners of a mesh at places that can be?
static bool is_near(const IfcMesh *mesh) {
    double farthest = 0;
    for (int i = 0; i < mesh->corner_count; i++) {
        Vec3 c = mesh->corners[i];
        double far = fabs(c.x) + fabs(c.y) + fabs(c.z);
        if (!(far <= farthest)) farthest = far;  // NaN stays
        if (!(farthest <= FARTHEST)) return false;
    }
    return true;
}

// A product's parts stand between it and the one before it, as a rule: their text, and its own, is asked for while that one is read.
static void expect_next(const Work *work, int product) {
    enum { MOST = 16384, LINE = 64, OWN = 2 * LINE };
    const StepFile *step = &work->file->step;
    if (product + 1 >= work->model->product_count) return;
    size_t from = step->at[work->relations->record[product]] + OWN,
           to = step->at[work->relations->record[product + 1]] + OWN;
    if (to > from + MOST) from = to - MOST;
    for (; from < to; from += LINE) __builtin_prefetch(step->text + from);
}

static void read_products(void *context, int index, int thread) {
    Work *work = context;
    int end = (index + 1) * work->at_once;
    for (int i = index * work->at_once; i < end && i < work->model->product_count; i++) {
        expect_next(work, i);
        work->readers[thread].product = i;
        ifc_read_product(&work->readers[thread], work->relations, i, &work->model->products[i]);
    }
}

static void read_shape(Work *work, int index, int thread) {
    Reader *r = &work->readers[thread];
    const Relations *rel = work->relations;
    IfcProduct *p = &work->model->products[index];
    ifc_begin(r, index);
    if (ifc_too_many(r)) return;
    expect_next(work, index);
    Body body = {0}, cut;
    read_body(r, rel->record[index], &body);
    p->item_count = body.count;
    if (body.count > 0) {
        Frame frame = product_frame(p);
        int look = look_of(r, rel, rel->record[index]);
        make_mesh(&r->kept, &body, &frame, look, &p->whole_mesh);
        if (!is_near(&p->whole_mesh)) {
            ifc_note(r, rel->record[index], "lies farther than %g m away", FARTHEST);
            p->whole_mesh = (IfcMesh){0};
            body.count = p->item_count = 0;
        }
        p->mesh = p->whole_mesh;
        for (int i = 0; i < p->whole_mesh.corner_count; i++)
            p->box = box_add(p->box, p->whole_mesh.corners[i]);
        find_footprints(r, &work->prisms[thread], &body, &frame, &work->found[index]);
        int depth = 0;
        bool voided =
            ifc_pair(&rel->openings, rel->record[index]) >= 0 || voided_whole(work, index, &depth) >= 0;
        if (body.count > 0 && p->kind != IFC_OPENING && voided) {
            cut_openings(r, work, index, &body, &cut);
            make_mesh(&r->kept, &cut, &frame, look, &p->mesh);
            if (!is_near(&p->mesh)) p->mesh = p->whole_mesh;
        }
    }
    arena_reset(&r->scratch);
}

static void read_shapes(void *context, int index, int thread) {
    Work *work = context;
    int end = (index + 1) * work->at_once;
    for (int i = index * work->at_once; i < end && i < work->model->product_count; i++)
        read_shape(work, i, thread);
}

// ---- the whole

enum { MOST_AT_ONCE = 64 };  // products

static void join_some(void *context, int index, int thread) {
    (void)thread;
    const Work *work = context;
    IfcModel *model = work->model;
    Sum sum = {.box = box_empty()};
    int end = (index + 1) * JOINED_AT_ONCE;
    for (int i = index * JOINED_AT_ONCE; i < end && i < model->product_count; i++) {
        const Found *f = &work->found[i];
        IfcProduct *p = &model->products[i];
        p->first_footprint = f->first_footprint;
        p->footprint_count = f->footprint_count;
        for (int k = 0; k < f->footprint_count; k++) {
            IfcFootprint *to = &model->footprints[f->first_footprint + k];
            *to = f->footprints[k];
            to->first_ring += f->first_ring;
        }
        for (int k = 0; k < f->ring_count; k++)
            model->rings[f->first_ring + k] =
                (IfcRing){f->rings[k].first_point + f->first_point, f->rings[k].point_count};
        for (int k = 0; k < f->point_count; k++) model->points[f->first_point + k] = f->points[k];
        if (p->kind != IFC_SITE && !box_is_empty(p->box)) sum.box = box_union(sum.box, p->box);
        sum.polygons += p->mesh.polygon_count;
    }
    work->sums[index] = sum;
}

// Puts together what stands in lists of the model, and tells what all products come to.
static Sum join_footprints(Arena *arena, Work *work, int threads, IfcModel *model) {
    for (int i = 0; i < model->product_count; i++) {
        Found *f = &work->found[i];
        f->first_footprint = model->footprint_count;
        f->first_ring = model->ring_count;
        f->first_point = model->point_count;
        model->footprint_count += f->footprint_count;
        model->ring_count += f->ring_count;
        model->point_count += f->point_count;
    }
    model->footprints = ARENA_ARRAY(arena, IfcFootprint, model->footprint_count + 1);
    model->rings = ARENA_ARRAY(arena, IfcRing, model->ring_count + 1);
    model->points = ARENA_ARRAY(arena, Vec2, model->point_count + 1);
    int count = (model->product_count + JOINED_AT_ONCE - 1) / JOINED_AT_ONCE;
    Arena scratch = {0};
    work->sums = ARENA_ARRAY(&scratch, Sum, count + 1);
    parallel_for(threads, count, join_some, work);
    Sum all = {.box = box_empty()};
    for (int i = 0; i < count; i++) {
        all.box = box_union(all.box, work->sums[i].box);
        all.polygons += work->sums[i].polygons;
    }
    arena_free(&scratch);
    return all;
}

static int compare_notes(const void *a, const void *b) {
    const RawNote *p = a, *q = b;
    if (p->product != q->product) return p->product < q->product ? -1 : 1;
    if (p->entity != q->entity) return p->entity < q->entity ? -1 : 1;
    return strcmp(p->text, q->text);
}

static void join_notes(Arena *arena, const Work *work, int threads, IfcModel *model) {
    int count = 0, at = 0;
    for (int t = 0; t < threads; t++) count += work->readers[t].note_count;
    RawNote *all = ARENA_ARRAY(arena, RawNote, count + 1);
    for (int t = 0; t < threads; t++)
        for (int i = 0; i < work->readers[t].note_count; i++) all[at++] = work->readers[t].notes[i];
    if (count > 1) qsort(all, (size_t)count, sizeof *all, compare_notes);
    int shown = count < IFC_MOST_NOTES ? count : IFC_MOST_NOTES;
    model->notes = ARENA_ARRAY(arena, IfcNote, shown + 1);
    for (int i = 0; i < shown; i++) {
        const IfcProduct *p = all[i].product >= 0 ? &model->products[all[i].product] : NULL;
        model->notes[i] =
            (IfcNote){all[i].entity, all[i].product,
                      p ? arena_format(arena, "#%d %s \"%s\": %s", p->entity, p->type, p->name, all[i].text)
                        : all[i].text};
    }
    model->note_count = shown;
    if (count > shown)
        model->notes[model->note_count++] =
            (IfcNote){0, -1, arena_format(arena, "%d more parts of the file cannot be used", count - shown)};
}

// Moves a model that lies far from its origin, so that sums of coordinates keep their digits; `all` is its box.
static void move_near(IfcModel *model, Box all) {
    if (box_is_empty(all)) return;
    Vec3 middle = vec3_scale(vec3_add(all.min, all.max), 0.5);
    if (fabs(middle.x) < FAR_AWAY && fabs(middle.y) < FAR_AWAY && fabs(middle.z) < FAR_AWAY) return;
    Vec3 o = model->origin =
        vec3(round(middle.x), round(middle.y), fabs(middle.z) < FAR_AWAY ? 0 : round(middle.z));
    for (int i = 0; i < model->product_count; i++) {
        IfcProduct *p = &model->products[i];
        for (int k = 0; k < p->whole_mesh.corner_count; k++)
            p->whole_mesh.corners[k] = vec3_sub(p->whole_mesh.corners[k], o);
        if (p->mesh.corners != p->whole_mesh.corners)
            for (int k = 0; k < p->mesh.corner_count; k++)
                p->mesh.corners[k] = vec3_sub(p->mesh.corners[k], o);
        p->place = vec3_sub(p->place, o);
        p->box = (Box){vec3_sub(p->box.min, o), vec3_sub(p->box.max, o)};
    }
    for (int i = 0; i < model->point_count; i++)
        model->points[i] = vec2_sub(model->points[i], vec2(o.x, o.y));
    for (int i = 0; i < model->footprint_count; i++) {
        model->footprints[i].base -= o.z;
        model->footprints[i].top -= o.z;
    }
    for (int i = 0; i < model->storey_count; i++) model->storeys[i].elevation -= o.z;
}

static bool tell_damage(const IfcFile *file, const Reader *readers, int threads, Error *error) {
    size_t bad = SIZE_MAX;
    for (int t = 0; t < threads; t++)
        if (readers[t].bad < bad) bad = readers[t].bad;
    if (bad == SIZE_MAX) return true;
    int shown = step_shown(&file->step, bad, 24);
    return error_set(error,
                     "%s:%lld: an argument is `%.*s` (allowed: a number, 'text', .NAME., #number, $, *, a "
                     "list or NAME(value))",
                     file->step.path, step_line(&file->step, bad), shown, file->step.text + bad);
}

static bool finish(const IfcFile *file, Work *work, int threads, Arena *arena, Error *error) {
    IfcModel *model = work->model;
    if (ifc_too_many(&work->readers[0]))
        return error_set(error, "%s: makes more than %lld polygons (the limit for %zu bytes)",
                         file->step.path, file->most_polygons, file->step.size);
    model->schema = arena_string(arena, file->step.schema);
    model->unit = file->length;
    model->material_count = file->material_count;
    model->materials = memcpy(ARENA_ARRAY(arena, IfcMaterial, file->material_count + 1), file->materials,
                              (size_t)file->material_count * sizeof(IfcMaterial));
    for (int i = 0; i < model->material_count; i++)
        model->materials[i].name = arena_string(arena, model->materials[i].name);
    model->texture_count = file->texture_count;
    if (file->texture_count > 0)
        model->textures = memcpy(ARENA_ARRAY(arena, IfcTexture, file->texture_count), file->textures,
                                 (size_t)file->texture_count * sizeof(IfcTexture));
    Sum all = join_footprints(arena, work, threads, model);
    join_notes(arena, work, threads, model);
    move_near(model, all.box);
    model->polygon_count = all.polygons;
    return true;
}

// `index` holds the places of entities.
static bool read_all(IfcFile *file, Work *work, int threads, Arena *arena, Arena *shared, Arena *index,
                     Error *error) {
    Reader *r = &work->readers[0];
    IfcModel *model = work->model;
    Relations relations = {0};
    ifc_read_units(r, file);
    ifc_read_styles(r, file, shared);
    ifc_read_relations(work->readers, threads, shared, &relations);
    find_maps(file, &relations.maps);
    work->relations = &relations;
    model->product_count = relations.products.count;
    model->products = ARENA_ARRAY(arena, IfcProduct, model->product_count + 1);
    // A hundred turns for each thread, so that all are done at about the same time.
    work->at_once = model->product_count / threads / 100;
    work->at_once = work->at_once < 1 ? 1 : work->at_once > MOST_AT_ONCE ? MOST_AT_ONCE : work->at_once;
    int turns = (model->product_count + work->at_once - 1) / work->at_once;
    parallel_for(threads, turns, read_products, work);
    for (int t = 0; t < threads; t++) work->readers[t].product = -1;
    ifc_relate_products(r, threads, arena, &relations, model);
    arena_reset(&r->scratch);
    work->found = ARENA_ARRAY(shared, Found, model->product_count + 1);
    MapWork maps = {work, ARENA_ARRAY(shared, Body, file->maps.count + 1),
                    ARENA_ARRAY(shared, Arena, threads)};
    parallel_for(threads, file->maps.count, read_map, &maps);
    file->map_bodies = maps.bodies;
    work->prisms = ARENA_ARRAY(shared, Arena, threads);
    for (int t = 0; t < threads; t++) work->prisms[t].dense = true;
    parallel_for(threads, turns, read_shapes, work);
    bool good = tell_damage(file, work->readers, threads, error);
    // No entity is asked for any more: the memory serves what is put together now.
    arena_free(index);
    good = good && finish(file, work, threads, arena, error);
    for (int t = 0; t < threads; t++) arena_free(&work->prisms[t]);
    for (int t = 0; t < threads; t++) arena_free(&maps.arenas[t]);
    return good;
}

bool ifc_read(const char *path, Bytes content, const IfcOptions *options, Arena *arena, IfcModel *out,
              Error *error) {
    *out = (IfcModel){0};
    int threads = parallel_threads(options->threads);
    Arena shared = {.dense = true}, index = {.dense = true};
    long long polygons = 0;
    IfcFile file = {.options = *options, .polygons = &polygons};
    StepTypes types = {TYPE_NAMES, T_COUNT};
    // A small file may make 300,000 faces by mapping, a large one as many as its text may tell.
    file.most_polygons = 300000 + (long long)content.size / 8;
    if (file.most_polygons > IFC_MOST_FACES) file.most_polygons = IFC_MOST_FACES;
    bool good = step_read(path, content, &types, threads, &index, &file.step, error);
    if (good) {
        Work work = {.file = &file, .model = out, .readers = ARENA_ARRAY(&shared, Reader, threads)};
        for (int t = 0; t < threads; t++) {
            Reader *r = &work.readers[t];
            *r = (Reader){.file = &file,
                          .bad = SIZE_MAX,
                          .product = -1,
                          .strings = {.arena = &r->kept},
                          .kept = {.dense = true}};
        }
        good = read_all(&file, &work, threads, arena, &shared, &index, error);
        for (int t = 0; t < threads; t++) {
            arena_free(&work.readers[t].scratch);
            arena_join(arena, &work.readers[t].kept);
        }
    }
    arena_free(&index);
    arena_free(&shared);
    return good;
}
