// faces.c - bodies and surfaces given by their faces: breps, shells, triangulated and polygonal face sets (ISO 16739,
// IfcTopologyResource and IfcGeometricModelResource).
#include "engine/core/polygon.h"
#include "maps/ifc/ifc_file.h"

// ---- loops

static Vec3 vertex(Reader *r, int record) {
    StepValue v;
    if (ifc_type(r, record) != T_VERTEXPOINT || !ifc_arguments(r, record, &v, 1)) return vec3(0, 0, 0);
    return ifc_point(r, v.record);
}

static bool edge_loop(Reader *r, int record, Curve *out) {
    StepValue list, o[4], e[4];
    ifc_arguments(r, record, &list, 1);
    StepCursor c = ifc_list(r, &list);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        if (ifc_type(r, s.record) != T_ORIENTEDEDGE || !ifc_arguments(r, s.record, o, 4) ||
            !ifc_arguments(r, o[2].record, e, 4))
            return false;
        Curve edge = {0};
        Vec3 start = vertex(r, e[0].record), end = vertex(r, e[1].record);
        int curve = ifc_type(r, o[2].record) == T_EDGECURVE ? e[2].record : -1;
        if (!ifc_edge(r, curve, start, end, !ifc_is(r, &e[3], "F"), &edge)) return false;
        bool turn = ifc_is(r, &o[3], "F");
        for (int i = 0; i < edge.count; i++)
            ifc_curve_push(r, out, edge.points[turn ? edge.count - 1 - i : i]);
    }
    return true;
}

// A loop's points, without one that repeats.
static bool loop_points(Reader *r, int record, Curve *out) {
    StepValue list;
    int type = ifc_type(r, record);
    if (type == T_POLYLOOP) {
        ifc_arguments(r, record, &list, 1);
        StepCursor c = ifc_list(r, &list);
        for (StepValue p = step_next(&c); p.kind != STEP_END; p = step_next(&c)) {
            if (ifc_type(r, p.record) != T_CARTESIANPOINT) {
                ifc_note(r, record, "has a corner that is no point of the file: #%d",
                         p.kind == STEP_REF ? p.entity : 0);
                return false;
            }
            ifc_curve_push(r, out, ifc_point(r, p.record));
        }
    } else if (type == T_EDGELOOP) {
        if (!edge_loop(r, record, out)) {
            ifc_note(r, record, "has an edge that is not read");
            return false;
        }
    } else {
        return type == T_VERTEXLOOP;
    }
    if (out->count > 1 && vec3_length(vec3_sub(out->points[0], out->points[out->count - 1])) < IFC_SAME_POINT)
        out->count--;
    return true;
}

static void push_ring(Reader *r, FaceRings *f, const Curve *ring, bool turn) {
    for (int i = 0; i < ring->count; i++)
        *ARENA_PUSH(&r->scratch, f->corners, f->count, f->room) =
            ring->points[turn ? ring->count - 1 - i : i];
    *ARENA_PUSH(&r->scratch, f->size, f->ring_count, f->size_room) = ring->count;
}

// Puts one ring before the others.
static void put_first(Reader *r, FaceRings *f, int ring) {
    if (ring <= 0) return;
    FaceRings out = {0};
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0, first = 0; i < f->ring_count; first += f->size[i], i++) {
            if ((i == ring) != (pass == 0)) continue;
            push_ring(r, &out, &(Curve){.points = f->corners + first, .count = f->size[i]}, false);
        }
    }
    *f = out;
}

// The rings of a face, its outline first: the bound that is told as such. On a plane a larger bound is the outline all the same: holes
// lie within it, and some files tell a hole as the outline of what surrounds it.
static bool face_rings(Reader *r, const StepValue *bounds, bool flat, FaceRings *out) {
    StepCursor c = ifc_list(r, bounds);
    int outer = -1, largest = 0;
    double most = -1, outer_area = 0;
    for (StepValue b = step_next(&c); b.kind != STEP_END; b = step_next(&c)) {
        StepValue v[2];
        Curve ring = {0};
        if (!ifc_arguments(r, b.record, v, 2) || !loop_points(r, v[0].record, &ring)) return false;
        if (ring.count < 3) continue;
        double area = polygon_area(ring.points, ring.count);
        if (ifc_type(r, b.record) == T_FACEOUTERBOUND && outer < 0) {
            outer = out->ring_count;
            outer_area = area;
        }
        if (area > most) {
            most = area;
            largest = out->ring_count;
        }
        push_ring(r, out, &ring, ifc_is(r, &v[1], "F"));
    }
    put_first(r, out, outer < 0 || (flat && most > outer_area) ? largest : outer);
    return true;
}

static void add_rings(Reader *r, int record, const FaceRings *f, Shape *out) {
    if (f->ring_count == 0) return;
    if (!shape_add_rings(&r->scratch, out, f->corners, f->size, f->ring_count, -1))
        ifc_note(r, record, "has %d corners and cannot be cut into convex faces", f->count);
}

// A shell under construction: where each face begins, and the edges of faces on surfaces.
typedef struct Shell {
    int *first;
    ShapeEdge *edges;
    int count, room, edge_count, edge_room;
    bool curved;  // one of its faces is
} Shell;

// The edges of a face's outline; holes turn either way.
static void push_edges(Reader *r, const FaceRings *f, Shell *shell) {
    for (int k = 0; f->ring_count > 0 && k < f->size[0]; k++)
        *ARENA_PUSH(&r->scratch, shell->edges, shell->edge_count, shell->edge_room) =
            (ShapeEdge){f->corners[k], f->corners[(k + 1) % f->size[0]], shell->count - 1};
}

// The picture of an IfcTextureMap, whose places are in the order of the loop, which a bound may turn.
static void lay_on_face(Reader *r, int record, const StepValue *bounds, const FaceRings *f, int first,
                        Shape *out) {
    IfcPlaces places;
    StepValue bound[2];
    if (f->ring_count == 0 || !ifc_places(r, record, &places) || places.count != f->size[0]) return;
    StepCursor c = ifc_list(r, bounds);
    if (ifc_arguments(r, step_next(&c).record, bound, 2) && ifc_is(r, &bound[1], "F")) {
        for (int i = 0; i < places.count / 2; i++) {
            Vec2 keep = places.at[i];
            places.at[i] = places.at[places.count - 1 - i];
            places.at[places.count - 1 - i] = keep;
        }
    }
    ifc_lay_picture(r, out, first, f->corners, places.at, places.count);
}

static void brep_face(Reader *r, int record, Shell *shell, Shape *out) {
    StepValue v[3];
    int type = ifc_type(r, record), before = out->face_count;
    FaceRings f = {0};
    if ((type != T_FACE && type != T_FACESURFACE && type != T_ADVANCEDFACE) ||
        !ifc_arguments(r, record, v, 3)) {
        ifc_note(r, record, "is no face that is read");
        return;
    }
    bool same = !ifc_is(r, &v[2], "F"),
         curved = type != T_FACE && v[1].record >= 0 && ifc_type(r, v[1].record) != T_PLANE;
    if (!face_rings(r, &v[0], !curved, &f)) return;
    if (type != T_FACE) push_edges(r, &f, shell);
    if (!curved) {
        add_rings(r, record, &f, out);
        lay_on_face(r, record, &v[0], &f, before, out);
    } else if (!ifc_curved_face(r, v[1].record, &f, same, out)) {
        ifc_note(r, v[1].record, "is no surface that is read: its faces are flat between their edges");
        add_rings(r, record, &f, out);
    }
    int look = ifc_style_of(r, record);
    for (int i = before; look >= 0 && i < out->face_count; i++) out->faces[i].material = look;
    shell->curved |= curved;
}

static void add_shell(Reader *r, int record, Shape *out) {
    StepValue list;
    int type = ifc_type(r, record), before = out->face_count;
    if ((type != T_CLOSEDSHELL && type != T_OPENSHELL && type != T_CONNECTEDFACESET) ||
        !ifc_arguments(r, record, &list, 1)) {
        ifc_note(r, record, "is no shell that is read");
        return;
    }
    StepCursor c = ifc_list(r, &list);
    Shell shell = {0};
    for (StepValue f = step_next(&c); f.kind != STEP_END && !ifc_too_many(r); f = step_next(&c)) {
        *ARENA_PUSH(&r->scratch, shell.first, shell.count, shell.room) = out->face_count;
        brep_face(r, f.record, &shell, out);
    }
    if (shell.curved) shape_orient(&r->scratch, out, shell.first, shell.count, shell.edges, shell.edge_count);
    int look = ifc_style_of(r, record);
    for (int i = before; look >= 0 && i < out->face_count; i++)
        if (out->faces[i].material < 0) out->faces[i].material = look;
}

bool ifc_brep(Reader *r, int record, Shape *out) {
    StepValue v[2];
    int type = ifc_type(r, record);
    ifc_arguments(r, record, v, 2);
    bool brep = type == T_FACETEDBREP || type == T_FACETEDBREPWITHVOIDS || type == T_ADVANCEDBREP ||
                type == T_ADVANCEDBREPWITHVOIDS;
    if (brep) {
        add_shell(r, v[0].record, out);
        if (shape_volume(out) < 0) shape_flip(out);
    } else if (type == T_FACE || type == T_FACESURFACE || type == T_ADVANCEDFACE) {
        int first = 0;
        brep_face(r, record, &(Shell){.first = &first, .count = 1}, out);
    } else if (type == T_CLOSEDSHELL || type == T_OPENSHELL || type == T_CONNECTEDFACESET) {
        add_shell(r, record, out);
        if (type == T_CLOSEDSHELL && shape_volume(out) < 0) shape_flip(out);
    } else {
        StepCursor c = ifc_list(r, &v[0]);
        for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
            brep |= ifc_type(r, s.record) == T_CLOSEDSHELL;
            add_shell(r, s.record, out);
        }
    }
    if (type == T_FACETEDBREPWITHVOIDS || type == T_ADVANCEDBREPWITHVOIDS) {
        StepCursor c = ifc_list(r, &v[1]);
        for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
            Shape hole = shape_empty(true);
            add_shell(r, s.record, &hole);
            if (shape_volume(&hole) > 0) shape_flip(&hole);
            shape_append(&r->scratch, out, &hole);
        }
    }
    out->solid = brep || type == T_CLOSEDSHELL;
    return out->face_count > 0;
}

// ---- face sets

// A colour map of a face set: colours, and one index for each face.
typedef struct FaceColours {
    int *material;  // [count] of face i
    int count;
} FaceColours;

static int find_colour(Reader *r, const float colour[3], float alpha) {
    for (int i = 0; i < r->file->material_count; i++) {
        const IfcMaterial *m = &r->file->materials[i];
        if (m->colour[0] == colour[0] && m->colour[1] == colour[1] && m->colour[2] == colour[2] &&
            m->alpha == alpha)
            return i;
    }
    return -1;
}

// Colours of IfcIndexedColourMap were put among the materials with the styles.
static FaceColours face_colours(Reader *r, int record) {
    FaceColours out = {0};
    StepValue v[4], list;
    int at = ifc_pair(&r->file->colour_maps, record), room = 0, colour_count = 0, colour_room = 0,
        *colours = NULL;
    if (at < 0 || !ifc_arguments(r, r->file->colour_maps.pair[at].value, v, 4) ||
        !ifc_arguments(r, v[2].record, &list, 1))
        return out;
    float alpha = (float)ifc_number(r, &v[1], 1);
    StepCursor c = ifc_list(r, &list);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        double rgb[3] = {0};
        step_numbers(&c, &s, rgb, 3);
        *ARENA_PUSH(&r->scratch, colours, colour_count, colour_room) =
            find_colour(r, (float[3]){(float)rgb[0], (float)rgb[1], (float)rgb[2]}, alpha);
    }
    c = ifc_list(r, &v[3]);
    for (StepValue i = step_next(&c); i.kind != STEP_END; i = step_next(&c)) {
        double index = ifc_number(r, &i, 0);
        *ARENA_PUSH(&r->scratch, out.material, out.count, room) =
            index >= 1 && index <= colour_count ? colours[(int)index - 1] : -1;
    }
    return out;
}

typedef struct FaceSet {
    Vec3 *points;
    int count;
    int *pn, pn_count;  // IfcTessellatedFaceSet.PnIndex
    FaceColours colours;
    IfcPlaces places;
} FaceSet;

// The point of an index; -1 where there is none.
static int index_of(const FaceSet *set, double number) {
    if (set->pn_count) {
        if (!(number >= 1 && number <= set->pn_count)) return -1;
        number = set->pn[(int)number - 1];
    }
    return number >= 1 && number <= set->count ? (int)number - 1 : -1;
}

static void read_pn(Reader *r, const StepValue *list, FaceSet *set) {
    int room = 0;
    StepCursor c = ifc_list(r, list);
    for (StepValue i = step_next(&c); i.kind != STEP_END; i = step_next(&c))
        *ARENA_PUSH(&r->scratch, set->pn, set->pn_count, room) =
            (int)fmax(0, fmin(2e9, ifc_number(r, &i, 0)));
}

static void colour_faces(const FaceSet *set, int face, int before, Shape *out) {
    if (face >= set->colours.count || set->colours.material[face] < 0) return;
    for (int i = before; i < out->face_count; i++) out->faces[i].material = set->colours.material[face];
}

static bool ring_of(Reader *r, int record, const FaceSet *set, const StepValue *list, Curve *out) {
    StepCursor c = ifc_list(r, list);
    for (StepValue i = step_next(&c); i.kind != STEP_END; i = step_next(&c)) {
        double number = ifc_number(r, &i, 0);
        int at = index_of(set, number);
        if (at < 0) {
            ifc_note(r, record, "has the index %g (allowed 1 to %d)", number,
                     set->pn_count ? set->pn_count : set->count);
            return false;
        }
        ifc_curve_push(r, out, set->points[at]);
    }
    if (out->count > 1 && vec3_length(vec3_sub(out->points[0], out->points[out->count - 1])) < IFC_SAME_POINT)
        out->count--;
    return true;
}

static bool polygonal(Reader *r, const StepValue *faces, FaceSet *set, Shape *out) {
    StepCursor c = ifc_list(r, faces);
    int face = 0;
    for (StepValue f = step_next(&c); f.kind != STEP_END && !ifc_too_many(r); f = step_next(&c), face++) {
        StepValue v[2];
        FaceRings rings = {0};
        Curve ring = {0};
        int type = ifc_type(r, f.record), before = out->face_count;
        if ((type != T_INDEXEDPOLYGONALFACE && type != T_INDEXEDPOLYGONALFACEWITHVOIDS) ||
            !ifc_arguments(r, f.record, v, 2))
            continue;
        if (!ring_of(r, f.record, set, &v[0], &ring)) continue;
        if (ring.count < 3) continue;
        push_ring(r, &rings, &ring, false);
        StepCursor h = ifc_list(r, type == T_INDEXEDPOLYGONALFACEWITHVOIDS ? &v[1] : &(StepValue){0});
        for (StepValue hole = step_next(&h); hole.kind != STEP_END; hole = step_next(&h)) {
            Curve inner = {0};
            if (ring_of(r, f.record, set, &hole, &inner) && inner.count > 2)
                push_ring(r, &rings, &inner, false);
        }
        add_rings(r, f.record, &rings, out);
        colour_faces(set, face, before, out);
    }
    return out->face_count > 0;
}

static bool triangulated(Reader *r, int record, const StepValue *triangles, FaceSet *set, Shape *out) {
    StepCursor c = ifc_list(r, triangles);
    int face = 0;
    for (StepValue t = step_next(&c); t.kind != STEP_END; t = step_next(&c), face++) {
        double index[3] = {0};
        Vec3 corner[3];
        bool good = step_numbers(&c, &t, index, 3) == 3;
        for (int i = 0; i < 3 && good; i++) {
            int at = index_of(set, index[i]);
            good = at >= 0;
            if (good) corner[i] = set->points[at];
        }
        if (!good) {
            ifc_note(r, record, "has a triangle whose corners are %g, %g and %g (allowed 1 to %d)", index[0],
                     index[1], index[2], set->pn_count ? set->pn_count : set->count);
            continue;
        }
        int before = out->face_count;
        shape_add(&r->scratch, out, corner, 3, -1);
        colour_faces(set, face, before, out);
        if (face < set->places.index_count / 3 && out->face_count > before) {
            Vec2 places[3];
            for (int i = 0; i < 3; i++) places[i] = set->places.at[set->places.index[3 * face + i]];
            ifc_lay_picture(r, out, before, corner, places, 3);
        }
    }
    return out->face_count > 0;
}

// Does a surface of which the file does not say so enclose a body? The areas of its faces, as vectors, have the sum 0 then.
static bool is_closed(const Shape *shape) {
    Vec3 sum = {0, 0, 0};
    double area = 0;
    for (int i = 0; i < shape->face_count; i++) {
        const ShapeFace *f = &shape->faces[i];
        double own = polygon_area(shape->corners + f->first, f->count);
        sum = vec3_add(sum, vec3_scale(f->plane.n, own));
        area += own;
    }
    return vec3_length(sum) <= 1e-3 * area;
}

bool ifc_face_set(Reader *r, int record, Shape *out) {
    StepValue v[5];
    FaceSet set = {0};
    int type = ifc_type(r, record);
    ifc_arguments(r, record, v, 5);
    set.count = ifc_point_list(r, v[0].record, &set.points);
    set.colours = face_colours(r, record);
    ifc_places(r, record, &set.places);
    // IfcPolygonalFaceSet: points, closed, faces, PnIndex. The triangulated one has normals before `closed`.
    bool polygons = type == T_POLYGONALFACESET;
    const StepValue *closed = &v[polygons ? 1 : 2], *faces = &v[polygons ? 2 : 3], *pn = &v[polygons ? 3 : 4];
    if (pn->kind == STEP_LIST && type != T_TRIANGULATEDIRREGULARNETWORK) read_pn(r, pn, &set);
    bool good = polygons ? polygonal(r, faces, &set, out) : triangulated(r, record, faces, &set, out);
    bool told = closed->kind == STEP_ENUM,
         sheet = type == T_TRIANGULATEDIRREGULARNETWORK || (told && ifc_is(r, closed, "F"));
    // Faces that should enclose a body and do not may just have contradictory sides.
    if (!sheet && !is_closed(out)) {
        int *first = ARENA_ARRAY(&r->scratch, int, out->face_count + 1);
        for (int i = 0; i < out->face_count; i++) first[i] = i;
        shape_orient(&r->scratch, out, first, out->face_count, NULL, 0);
    }
    out->solid = !sheet && (told || is_closed(out));
    if (out->solid && shape_volume(out) < 0) shape_flip(out);
    return good;
}
