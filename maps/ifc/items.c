// items.c - representation items as bodies: which reader makes which type, booleans and half spaces, mapped items.
#include "maps/ifc/ifc_file.h"

static bool one_solid(Reader *r, int record, Shape *out, Prism *prism);

static void give_look(Shape *shape, int look) {
    for (int i = 0; look >= 0 && i < shape->face_count; i++)
        if (shape->faces[i].material < 0) shape->faces[i].material = look;
}

// ---- booleans

// The half space as a body that reaches beyond the box.
static bool half_space(Reader *r, int record, Box box, Shape *out) {
    StepValue v[4], w[1];
    ifc_arguments(r, record, v, 4);
    if (ifc_type(r, v[0].record) != T_PLANE || !ifc_arguments(r, v[0].record, w, 1)) {
        ifc_note(r, record, "is bounded by a surface that is no plane");
        return false;
    }
    Frame f = ifc_axes(r, w[0].record);
    // The agreement is true where the normal points out of the half space.
    Vec3 n = ifc_is(r, &v[1], "F") ? vec3_scale(f.z, -1) : f.z;
    double size = vec3_length(vec3_sub(box.max, box.min));
    Shape half = shape_half_space(&r->scratch, box_grow(box, 0.1 + 0.1 * size), (Plane){n, vec3_dot(n, f.o)});
    if (ifc_type(r, record) != T_POLYGONALBOUNDEDHALFSPACE) {
        *out = half;
        return true;
    }
    // The prism of the boundary, as long as the box is seen along it.
    Curve ring = {0};
    Frame place = ifc_axes(r, v[2].record);
    if (!ifc_curve(r, v[3].record, &ring) || ring.count < 3) return false;
    double low = INFINITY, high = -INFINITY;
    Vec3 corner[8];
    box_corners(box, corner);
    for (int i = 0; i < 8; i++) {
        double t = vec3_dot(vec3_sub(corner[i], place.o), place.z);
        low = fmin(low, t);
        high = fmax(high, t);
    }
    place.o = vec3_add(place.o, vec3_scale(place.z, low - 0.05));
    int size_of_ring = ring.count;
    bool outer = true;
    double twice = 0;
    for (int i = 0; i < ring.count; i++) {
        Vec3 a = ring.points[i], b = ring.points[(i + 1) % ring.count];
        twice += a.x * b.y - b.x * a.y;
    }
    if (twice < 0) {
        for (int i = 0, k = ring.count - 1; i < k; i++, k--) {
            Vec3 keep = ring.points[i];
            ring.points[i] = ring.points[k];
            ring.points[k] = keep;
        }
    }
    Profile profile = {.rings = ring, .size = &size_of_ring, .outer = &outer, .ring_count = 1};
    Shape prism = shape_empty(true);
    ifc_sweep_profile(r, &profile, &place, vec3_scale(place.z, high - low + 0.1), &prism);
    const Shape *tools[1] = {&half};
    return shape_boolean(&r->scratch, SHAPE_INTERSECTION, &prism, tools, 1, &r->work, out);
}

static bool is_half_space(int type) {
    return type == T_HALFSPACESOLID || type == T_POLYGONALBOUNDEDHALFSPACE || type == T_BOXEDHALFSPACE;
}

static bool boolean_operand(Reader *r, int record, Box box, Shape *out) {
    *out = shape_empty(true);
    return is_half_space(ifc_type(r, record)) ? half_space(r, record, box, out)
                                              : one_solid(r, record, out, NULL);
}

// A chain whose first operand is a boolean again, as clipped walls have it, without recursion.
static bool boolean_chain(Reader *r, int record, Shape *out, Prism *prism) {
    int *chain = NULL, count = 0, room = 0;
    StepValue v[3];
    while (ifc_type(r, record) == T_BOOLEANRESULT || ifc_type(r, record) == T_BOOLEANCLIPPINGRESULT) {
        if (count == IFC_LONGEST_CHAIN) {
            ifc_note(r, record, "stands in a chain of more than %d booleans, or in itself",
                     IFC_LONGEST_CHAIN);
            return false;
        }
        *ARENA_PUSH(&r->scratch, chain, count, room) = record;
        ifc_arguments(r, record, v, 2);
        record = v[1].record;
    }
    Shape shape = shape_empty(true);
    if (is_half_space(ifc_type(r, record))) {
        ifc_note(r, record, "is a half space that nothing bounds");
        return false;
    }
    if (!one_solid(r, record, &shape, prism)) return false;
    if (prism) prism->clipped = true;
    Shape *tools = ARENA_ARRAY(&r->scratch, Shape, count);
    const Shape **tool = ARENA_ARRAY(&r->scratch, const Shape *, count);
    for (int i = count - 1; i >= 0;) {
        // Differences in a row are one difference of many tools.
        int n = 0, at = chain[i];
        ShapeBoolean operation = SHAPE_DIFFERENCE;
        for (; i >= 0; i--) {
            ifc_arguments(r, chain[i], v, 3);
            operation = ifc_is(r, &v[0], "UNION")          ? SHAPE_UNION
                        : ifc_is(r, &v[0], "INTERSECTION") ? SHAPE_INTERSECTION
                                                           : SHAPE_DIFFERENCE;
            if (n > 0 && operation != SHAPE_DIFFERENCE) {
                operation = SHAPE_DIFFERENCE;
                break;
            }
            if (boolean_operand(r, v[2].record, shape.box, &tools[n])) {
                tool[n] = &tools[n];
                n++;
            } else {
                ifc_note(r, v[2].record, "cannot be used as an operand of a boolean");
            }
            at = chain[i];
            if (operation != SHAPE_DIFFERENCE) {
                i--;
                break;
            }
        }
        Shape result;
        if (n > 0 && !shape_boolean(&r->scratch, operation, &shape, tool, n, &r->work, &result)) {
            ifc_note(r, at, "takes too long, or lies too far away: its operands have %d and %d faces",
                     shape.face_count, tools[0].face_count);
        } else if (n > 0) {
            shape = result;
        }
    }
    shape_append(&r->scratch, out, &shape);
    out->solid = shape.solid;
    return true;
}

// ---- one item

static bool one_solid(Reader *r, int record, Shape *out, Prism *prism) {
    StepValue v[1];
    bool good = false;
    if (ifc_too_many(r) || !ifc_enter(r, record)) return false;
    switch (ifc_type(r, record)) {
    case T_EXTRUDEDAREASOLID:
    case T_EXTRUDEDAREASOLIDTAPERED:
        good = ifc_extrusion(r, record, out, prism);
        break;
    case T_REVOLVEDAREASOLID:
        good = ifc_revolution(r, record, out);
        break;
    case T_SWEPTDISKSOLID:
    case T_SWEPTDISKSOLIDPOLYGONAL:
        good = ifc_swept_disk(r, record, out);
        break;
    case T_FIXEDREFERENCESWEPTAREASOLID:
    case T_SURFACECURVESWEPTAREASOLID:
        good = ifc_directed_sweep(r, record, out);
        break;
    case T_FACETEDBREP:
    case T_FACETEDBREPWITHVOIDS:
    case T_ADVANCEDBREP:
    case T_ADVANCEDBREPWITHVOIDS:
    case T_CLOSEDSHELL:
    case T_FACE:
    case T_FACESURFACE:
    case T_ADVANCEDFACE:
    case T_OPENSHELL:
    case T_CONNECTEDFACESET:
    case T_FACEBASEDSURFACEMODEL:
    case T_SHELLBASEDSURFACEMODEL:
        good = ifc_brep(r, record, out);
        break;
    case T_TRIANGULATEDFACESET:
    case T_TRIANGULATEDIRREGULARNETWORK:
    case T_POLYGONALFACESET:
        good = ifc_face_set(r, record, out);
        break;
    case T_BOOLEANRESULT:
    case T_BOOLEANCLIPPINGRESULT:
        good = boolean_chain(r, record, out, prism);
        break;
    case T_CSGSOLID:
        ifc_arguments(r, record, v, 1);
        good = one_solid(r, v[0].record, out, prism);
        break;
    case T_BLOCK:
    case T_RECTANGULARPYRAMID:
    case T_RIGHTCIRCULARCONE:
    case T_RIGHTCIRCULARCYLINDER:
    case T_SPHERE:
        good = ifc_primitive(r, record, out);
        break;
    default:
        ifc_note(r, record, "is no body that is read");
        break;
    }
    ifc_leave(r);
    // Items are counted when they are put together: here count operands, which stand within others.
    if (r->depth > 1) ifc_count_polygons(r, out->face_count);
    give_look(out, ifc_style_of(r, record));
    return good;
}

// Items that are no bodies and are left out without a note.
static bool is_drawing(int type) {
    switch (type) {
    case T_POLYLINE:
    case T_INDEXEDPOLYCURVE:
    case T_COMPOSITECURVE:
    case T_TRIMMEDCURVE:
    case T_CIRCLE:
    case T_ELLIPSE:
    case T_LINE:
    case T_BSPLINECURVEWITHKNOTS:
    case T_GEOMETRICSET:
    case T_GEOMETRICCURVESET:
    case T_CARTESIANPOINT:
    case T_BOUNDINGBOX:
    case T_EDGE:
    case T_EDGECURVE:
    case T_VERTEXPOINT:
        return true;
    default:
        return false;
    }
}

// Appends an item, as the frame maps it; without a frame it is taken as it stands, its arrays too.
static void map_item(Reader *r, const Item *item, const Frame *frame, int material, Body *out) {
    Item *to = ARENA_PUSH(&r->scratch, out->items, out->count, out->room);
    *to = *item;
    ifc_count_polygons(r, item->shape.face_count);
    if (frame) {
        to->shape = shape_empty(item->shape.solid);
        shape_append_mapped(&r->scratch, &to->shape, &item->shape, frame);
        int total = 0;
        for (int i = 0; i < item->prism.ring_count; i++) total += item->prism.size[i];
        if (total) to->prism.corners = ARENA_ARRAY(&r->scratch, Vec3, total);
        for (int i = 0; i < total; i++) to->prism.corners[i] = frame_point(frame, item->prism.corners[i]);
        to->prism.sweep = frame_turn(frame, item->prism.sweep);
    }
    give_look(&to->shape, material);
}

static void mapped_item(Reader *r, int record, const Frame *frame, int material, Body *out) {
    StepValue v[2], m[2];
    ifc_arguments(r, record, v, 2);
    int map = v[0].record, look = ifc_style_of(r, record);
    if (ifc_type(r, map) != T_REPRESENTATIONMAP || !ifc_arguments(r, map, m, 2)) {
        ifc_note(r, record, "maps nothing that is read");
        return;
    }
    Frame origin = ifc_axes(r, m[0].record), target = ifc_operator(r, v[1].record),
          joined = frame_join(&target, &origin);
    if (frame) joined = frame_join(frame, &joined);
    int at = ifc_pair(&r->file->maps, map);
    const Body *ready =
        at >= 0 && r->file->map_bodies ? &r->file->map_bodies[r->file->maps.pair[at].value] : NULL;
    if (ready) {
        for (int i = 0; i < ready->count && !ifc_too_many(r); i++)
            map_item(r, &ready->items[i], &joined, look >= 0 ? look : material, out);
    } else {
        ifc_representation(r, m[1].record, &joined, look >= 0 ? look : material, out);
    }
}

void ifc_item(Reader *r, int record, const Frame *frame, int material, Body *out) {
    int type = ifc_type(r, record);
    if (type < 0 || is_drawing(type) || ifc_too_many(r)) return;
    if (!ifc_enter(r, record)) return;
    if (type == T_MAPPEDITEM) {
        mapped_item(r, record, frame, material, out);
    } else {
        Item item = {.shape = shape_empty(false)};
        if (one_solid(r, record, &item.shape, &item.prism) && item.shape.face_count > 0)
            map_item(r, &item, frame, material, out);
    }
    ifc_leave(r);
}

void ifc_representation(Reader *r, int record, const Frame *frame, int material, Body *out) {
    StepValue v[4];
    int type = ifc_type(r, record);
    if ((type != T_SHAPEREPRESENTATION && type != T_TOPOLOGYREPRESENTATION) ||
        !ifc_arguments(r, record, v, 4))
        return;
    StepCursor c = ifc_list(r, &v[3]);
    for (StepValue i = step_next(&c); i.kind != STEP_END; i = step_next(&c))
        ifc_item(r, i.record, frame, material, out);
}
