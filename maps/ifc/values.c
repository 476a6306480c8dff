// values.c - arguments of records as numbers, points, directions and placements (ISO 16739, IfcGeometryResource).
#include <stdio.h>
#include <stdlib.h>

#include "maps/ifc/ifc_file.h"

bool ifc_arguments(Reader *r, int record, StepValue *out, int count) {
    int read = 0;
    if (record >= 0) {
        StepCursor c = step_arguments(&r->file->step, record, &r->bad);
        read = step_values(&c, out, count);
    }
    for (; read < count; read++) out[read] = (StepValue){.kind = STEP_NONE, .record = -1};
    return record >= 0;
}

int ifc_type(const Reader *r, int record) { return record < 0 ? -1 : r->file->step.type[record]; }

// The elements of a list; anything else has none.
StepCursor ifc_list(Reader *r, const StepValue *list) {
    StepCursor c = {&r->file->step, r->file->step.size, &r->bad};
    if (list->kind == STEP_LIST || list->kind == STEP_TYPED) c.at = list->at + 1;
    return c;
}

double ifc_number(Reader *r, const StepValue *value, double otherwise) {
    if (value->kind == STEP_NUMBER) return value->number;
    if (value->kind != STEP_TYPED) return otherwise;
    StepCursor c = ifc_list(r, value);
    StepValue inner = step_next(&c);
    return inner.kind == STEP_NUMBER ? inner.number : otherwise;
}

double ifc_length(Reader *r, const StepValue *value, double otherwise) {
    double number = ifc_number(r, value, NAN);
    return isnan(number) ? otherwise : number * r->file->length;
}

bool ifc_is(const Reader *r, const StepValue *value, const char *enumerator) {
    return step_is(&r->file->step, value, enumerator);
}

static int compare_pairs(const void *a, const void *b) {
    const Pair *p = a, *q = b;
    if (p->key != q->key) return p->key < q->key ? -1 : 1;
    return p->value < q->value ? -1 : p->value > q->value;
}

void ifc_sort(Pairs *pairs) {
    // As a rule files tell their relations in the order of what they relate.
    int in_order = 1;
    while (in_order < pairs->count && compare_pairs(&pairs->pair[in_order - 1], &pairs->pair[in_order]) <= 0)
        in_order++;
    if (in_order < pairs->count) qsort(pairs->pair, (size_t)pairs->count, sizeof(Pair), compare_pairs);
}

int ifc_pair(const Pairs *pairs, int key) {
    const Pair *pair = pairs->pair;
    int count = pairs->count;
    if (count == 0 || key < pair[0].key || key > pair[count - 1].key) return -1;
    // Keys are about evenly spaced, as a rule: the search begins near where the key would stand then, and widens.
    int low = 0, high = count - 1, step = 4;
    double span = (double)pair[high].key - pair[0].key;
    int guess = span > 0 ? (int)(((double)key - pair[0].key) / span * high) : 0;
    if (pair[guess].key < key) {
        for (low = guess; high - low > step && pair[low + step].key < key; step *= 2) low += step;
        if (high - low > step) high = low + step;
    } else {
        for (high = guess; high > step && pair[high - step].key >= key; step *= 2) high -= step;
        if (high > step) low = high - step;
    }
    // The first pair of the key lies at `low` or behind it, and not behind `high`.
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (pair[middle].key < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return pair[low].key == key ? low : -1;
}

void ifc_note(Reader *r, int record, const char *format, ...) {
    // One product's notes are few: the same fault in each of its faces is told once.
    int same = 0;
    for (int i = r->note_count - 1; i >= 0 && r->notes[i].product == r->product; i--) same++;
    if (same >= 4) return;
    va_list args;
    va_start(args, format);
    const char *text = arena_format_list(&r->kept, format, args);
    va_end(args);
    for (int i = 0; i < same; i++)
        if (strcmp(r->notes[r->note_count - 1 - i].text, text) == 0) return;
    int entity = record < 0 ? 0 : r->file->step.entity[record];
    if (record >= 0)
        text = arena_format(&r->kept, "#%d %s %s", entity, step_type_name(&r->file->step, record, &r->kept),
                            text);
    *ARENA_PUSH(&r->kept, r->notes, r->note_count, r->note_room) = (RawNote){entity, r->product, text};
}

// ---- bounds and looks

void ifc_count_polygons(Reader *r, int count) {
    __atomic_fetch_add(r->file->polygons, count + 1ll, __ATOMIC_RELAXED);
}

void ifc_count_points(Reader *r, int count) { ifc_count_polygons(r, count / IFC_POINTS); }

bool ifc_too_many(const Reader *r) {
    return __atomic_load_n(r->file->polygons, __ATOMIC_RELAXED) > r->file->most_polygons;
}

bool ifc_enter(Reader *r, int record) {
    if (r->depth >= IFC_DEEPEST) {
        ifc_note(r, record, "stands in more than %d others, or in itself", IFC_DEEPEST);
        return false;
    }
    // Whatever a product is made of stands in the file a few times at most, unless it multiplies.
    if (r->visits > 100000 + 4ll * r->file->step.record_count) {
        ifc_note(r, record, "and others stand within each other too often");
        return false;
    }
    r->depth++;
    r->visits++;
    return true;
}

void ifc_leave(Reader *r) { r->depth--; }

void ifc_begin(Reader *r, int product) {
    long long polygons = r->visits / IFC_VISITS + r->work / IFC_WORK;
    if (polygons > 0) __atomic_fetch_add(r->file->polygons, polygons, __ATOMIC_RELAXED);
    r->visits = r->work = 0;
    r->product = product;
}

int ifc_style_of(const Reader *r, int record) {
    int at = ifc_pair(&r->file->styles, record);
    return at < 0 ? -1 : r->file->styles.pair[at].value;
}

// ---- points and directions

static Vec3 triple(Reader *r, int record, int *count) {
    double v[3] = {0};
    *count = 0;
    if (record < 0) return vec3(0, 0, 0);
    StepCursor c = step_arguments(&r->file->step, record, &r->bad), list = step_enter(&c);
    *count = step_next_numbers(&list, v, 3);
    return vec3(v[0], v[1], v[2]);
}

Vec3 ifc_point(Reader *r, int record) {
    int count;
    if (ifc_type(r, record) != T_CARTESIANPOINT) return vec3(0, 0, 0);
    return vec3_scale(triple(r, record, &count), r->file->length);
}

Vec3 ifc_direction(Reader *r, int record, Vec3 otherwise) {
    int count;
    if (ifc_type(r, record) != T_DIRECTION) return otherwise;
    Vec3 d = vec3_normalize(triple(r, record, &count));
    return vec3_length(d) > 0 ? d : otherwise;
}

// A frame of z and an approximate x (IfcBuildAxes).
static Frame build_axes(Vec3 o, Vec3 z, Vec3 x) {
    x = vec3_sub(x, vec3_scale(z, vec3_dot(x, z)));
    if (vec3_length(x) < 1e-9) {
        x = fabs(z.x) < 0.9 ? vec3(1, 0, 0) : vec3(0, 0, 1);
        x = vec3_sub(x, vec3_scale(z, vec3_dot(x, z)));
    }
    x = vec3_normalize(x);
    return (Frame){x, vec3_cross(z, x), z, o};
}

Frame ifc_axes(Reader *r, int record) {
    StepValue a[3];
    int type = ifc_type(r, record);
    if (type == T_AXIS2PLACEMENT3D && ifc_arguments(r, record, a, 3)) {
        return build_axes(ifc_point(r, a[0].record), ifc_direction(r, a[1].record, vec3(0, 0, 1)),
                          ifc_direction(r, a[2].record, vec3(1, 0, 0)));
    }
    if (type == T_AXIS2PLACEMENT2D && ifc_arguments(r, record, a, 2)) {
        Vec3 x = ifc_direction(r, a[1].record, vec3(1, 0, 0));
        x.z = 0;
        return build_axes(ifc_point(r, a[0].record), vec3(0, 0, 1), x);
    }
    if (type == T_AXIS1PLACEMENT) return ifc_axis(r, record);
    return frame_identity();
}

Frame ifc_axis(Reader *r, int record) {
    StepValue a[2];
    if (ifc_type(r, record) != T_AXIS1PLACEMENT || !ifc_arguments(r, record, a, 2)) return frame_identity();
    return build_axes(ifc_point(r, a[0].record), ifc_direction(r, a[1].record, vec3(0, 0, 1)), vec3(1, 0, 0));
}

Frame ifc_operator(Reader *r, int record) {
    StepValue a[7];
    Frame f = frame_identity();
    int type = ifc_type(r, record);
    if (!ifc_arguments(r, record, a, 7)) return f;
    bool flat =
        type == T_CARTESIANTRANSFORMATIONOPERATOR2D || type == T_CARTESIANTRANSFORMATIONOPERATOR2DNONUNIFORM;
    if (!flat && type != T_CARTESIANTRANSFORMATIONOPERATOR3D &&
        type != T_CARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM)
        return f;
    double s = ifc_number(r, &a[3], 1), s2 = s, s3 = s;
    if (type == T_CARTESIANTRANSFORMATIONOPERATOR2DNONUNIFORM) s2 = ifc_number(r, &a[4], s);
    if (type == T_CARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM) {
        s2 = ifc_number(r, &a[5], s);
        s3 = ifc_number(r, &a[6], s);
    }
    if (flat) {
        Vec3 x = ifc_direction(r, a[0].record, vec3(1, 0, 0)), y = vec3(-x.y, x.x, 0);
        Vec3 told = ifc_direction(r, a[1].record, y);
        if (vec3_dot(told, y) < 0) y = vec3_scale(y, -1);
        return (Frame){vec3_scale(x, s), vec3_scale(y, s2), vec3(0, 0, 1), ifc_point(r, a[2].record)};
    }
    // IfcBaseAxis: z as told, x made square to it, y square to both, on the side that is told.
    Vec3 z = ifc_direction(r, a[4].record, vec3(0, 0, 1));
    Frame axes = build_axes(vec3(0, 0, 0), z, ifc_direction(r, a[0].record, vec3(1, 0, 0)));
    Vec3 y = ifc_direction(r, a[1].record, axes.y);
    if (vec3_dot(y, axes.y) < 0) axes.y = vec3_scale(axes.y, -1);
    // Without a third axis the second one may turn a mirrored frame about; with axes told as x and y alone z follows them.
    if (a[4].record < 0 && a[0].record >= 0 && a[1].record >= 0) {
        Vec3 x = ifc_direction(r, a[0].record, vec3(1, 0, 0));
        if (fabs(x.z) > 1e-9 || fabs(y.z) > 1e-9) {
            Vec3 normal = vec3_normalize(vec3_cross(x, y));
            if (vec3_length(normal) > 0) axes = build_axes(vec3(0, 0, 0), normal, x);
        }
    }
    return (Frame){vec3_scale(axes.x, s), vec3_scale(axes.y, s2), vec3_scale(axes.z, s3),
                   ifc_point(r, a[2].record)};
}

Frame ifc_placement(Reader *r, int record) {
    // The placements from this one outwards, up to one that is remembered or to the world.
    int chain[IFC_DEEPEST], count = 0, depth = 0, at = record;
    bool whole = true;
    Frame out = frame_identity();
    while (at >= 0 && depth <= IFC_DEEPEST) {
        const Placed *placed = &r->placed[at % IFC_PLACED];
        if (placed->depth > 0 && placed->record == at) {
            out = placed->frame;
            depth += placed->depth;
            break;
        }
        StepValue parent, v[3];
        // A place along an alignment may be told as axes too, as the third argument.
        whole = ifc_type(r, at) == T_LOCALPLACEMENT ||
                (ifc_type(r, at) == T_LINEARPLACEMENT && ifc_arguments(r, at, v, 3) && v[2].record >= 0);
        if (!whole) {
            ifc_note(r, at,
                     "is no placement that is read (allowed: IFCLOCALPLACEMENT, and IFCLINEARPLACEMENT with "
                     "axes)");
            break;
        }
        if (++depth > IFC_DEEPEST) break;
        chain[count++] = at;
        ifc_arguments(r, at, &parent, 1);
        at = parent.record;
    }
    // Told of the first one, whichever of the others were remembered.
    if (depth > IFC_DEEPEST) {
        ifc_note(r, record, "is placed relative to more than %d others, or to itself", IFC_DEEPEST);
        return frame_identity();
    }
    depth -= count;
    while (count > 0) {
        StepValue a[3];
        at = chain[--count];
        ifc_arguments(r, at, a, 3);
        Frame own = ifc_axes(r, a[ifc_type(r, at) == T_LINEARPLACEMENT ? 2 : 1].record);
        out = frame_join(&out, &own);
        // A chain that could not be read is noted for each product anew.
        if (whole) r->placed[at % IFC_PLACED] = (Placed){at, ++depth, out};
    }
    return out;
}

int ifc_point_list(Reader *r, int record, Vec3 **out) {
    StepValue list;
    *out = NULL;
    int type = ifc_type(r, record), count = 0, room = 0;
    if ((type != T_CARTESIANPOINTLIST3D && type != T_CARTESIANPOINTLIST2D) ||
        !ifc_arguments(r, record, &list, 1))
        return 0;
    StepCursor c = ifc_list(r, &list);
    for (StepValue v = step_next(&c); v.kind != STEP_END; v = step_next(&c)) {
        double p[3] = {0};
        step_numbers(&c, &v, p, 3);
        *ARENA_PUSH(&r->scratch, *out, count, room) = vec3_scale(vec3(p[0], p[1], p[2]), r->file->length);
    }
    ifc_count_points(r, count);
    return count;
}

void ifc_curve_push(Reader *r, Curve *curve, Vec3 point) {
    if (curve->count > 0 && vec3_length(vec3_sub(curve->points[curve->count - 1], point)) < IFC_SAME_POINT)
        return;
    *ARENA_PUSH(&r->scratch, curve->points, curve->count, curve->room) = point;
    curve->last = vec3(0, 0, 0);
}
