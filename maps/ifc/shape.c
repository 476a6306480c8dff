// shape.c - bodies as lists of convex polygons: adding, mapping, measuring.
#include "maps/ifc/shape.h"

#include "engine/core/polygon.h"

void shape_add_in_plane(Arena *arena, Shape *shape, const Vec3 *corners, int count, int material,
                        Plane plane) {
    if (count < 3) return;
    shape->corners = arena_room(arena, shape->corners, sizeof(Vec3), shape->corner_count,
                                shape->corner_count + count, &shape->corner_room);
    ShapeFace *face = ARENA_PUSH(arena, shape->faces, shape->face_count, shape->face_room);
    *face = (ShapeFace){shape->corner_count, count, material, 0, plane};
    for (int i = 0; i < count; i++) {
        shape->corners[shape->corner_count++] = corners[i];
        shape->box = box_add(shape->box, corners[i]);
    }
}

void shape_add(Arena *arena, Shape *shape, const Vec3 *corners, int count, int material) {
    // Newell's sum about the first corner, for the area and the plane at once.
    Vec3 sum = vec3(0, 0, 0), middle = corners[0];
    for (int i = 1; i + 1 < count; i++)
        sum =
            vec3_add(sum, vec3_cross(vec3_sub(corners[i], corners[0]), vec3_sub(corners[i + 1], corners[0])));
    double twice = vec3_length(sum);
    if (count < 3 || !(twice >= 2 * SHAPE_SMALLEST_AREA)) return;
    for (int i = 1; i < count; i++) middle = vec3_add(middle, corners[i]);
    Vec3 n = vec3_scale(sum, 1 / twice);
    shape_add_in_plane(arena, shape, corners, count, material, (Plane){n, vec3_dot(n, middle) / count});
}

bool shape_add_rings(Arena *arena, Shape *shape, const Vec3 *corners, const int *size, int ring_count,
                     int material) {
    Plane plane = plane_of_polygon(corners, size[0]);
    if (vec3_length(plane.n) == 0 || polygon_area(corners, size[0]) < SHAPE_SMALLEST_AREA) return true;
    if (ring_count == 1 && (size[0] == 3 || polygon_is_convex(corners, size[0], plane.n))) {
        // A bent polygon has a plane of its own for each triangle.
        if (size[0] > 3 && polygon_bend(corners, size[0], plane) > SHAPE_EPSILON) {
            for (int k = 1; k + 1 < size[0]; k++)
                shape_add(arena, shape, (Vec3[3]){corners[0], corners[k], corners[k + 1]}, 3, material);
        } else {
            shape_add_in_plane(arena, shape, corners, size[0], material, plane);
        }
        return true;
    }
    int total = 0;
    for (int i = 0; i < ring_count; i++) total += size[i];
    // The plane's own axes, right-handed about its normal.
    Vec3 n = plane.n, u = fabs(n.x) < fabs(n.y) ? vec3(1, 0, 0) : vec3(0, 1, 0);
    u = vec3_normalize(vec3_sub(u, vec3_scale(n, vec3_dot(u, n))));
    Vec3 v = vec3_cross(n, u);
    Vec2 *flat = ARENA_ARRAY(arena, Vec2, total);
    int *from = ARENA_ARRAY(arena, int, total);
    for (int i = 0, first = 0; i < ring_count; first += size[i], i++) {
        double twice = 0;
        for (int k = 0; k < size[i]; k++) {
            Vec3 p = vec3_sub(corners[first + k], corners[0]),
                 q = vec3_sub(corners[first + (k + 1) % size[i]], corners[0]);
            twice += vec2_cross(vec2(vec3_dot(p, u), vec3_dot(p, v)), vec2(vec3_dot(q, u), vec3_dot(q, v)));
        }
        bool turn = (twice > 0) == (i > 0);
        for (int k = 0; k < size[i]; k++) {
            int at = first + (turn ? size[i] - 1 - k : k);
            Vec3 p = vec3_sub(corners[at], corners[0]);
            flat[first + k] = vec2(vec3_dot(p, u), vec3_dot(p, v));
            from[first + k] = at;
        }
    }
    int *index, *piece;
    int count = convex_pieces(arena, flat, size, ring_count, &index, &piece);
    if (count < 0) return false;
    // A bent polygon has a plane of its own for each piece.
    bool bent = polygon_bend(corners, total, plane) > SHAPE_EPSILON;
    Vec3 *ring = ARENA_ARRAY(arena, Vec3, total + 1);
    for (int i = 0; i < count; index += piece[i], i++) {
        for (int k = 0; k < piece[i]; k++) ring[k] = corners[from[index[k]]];
        if (polygon_area(ring, piece[i]) < SHAPE_SMALLEST_AREA) continue;
        if (bent) {
            for (int k = 1; k + 1 < piece[i]; k++)
                shape_add(arena, shape, (Vec3[3]){ring[0], ring[k], ring[k + 1]}, 3, material);
        } else {
            shape_add_in_plane(arena, shape, ring, piece[i], material, plane);
        }
    }
    return true;
}

// Appends the maps of a shape that `back` leads to from where they come to lie; returns how many there were before.
static int append_maps(Arena *arena, Shape *to, const Shape *from, const Frame *back) {
    int before = to->map_count;
    for (int i = 0; i < from->map_count; i++) {
        TextureMap m = from->maps[i], *out = ARENA_PUSH(arena, to->maps, to->map_count, to->map_room);
        *out = m;
        if (!back) continue;
        out->u = vec3(vec3_dot(m.u, back->x), vec3_dot(m.u, back->y), vec3_dot(m.u, back->z));
        out->v = vec3(vec3_dot(m.v, back->x), vec3_dot(m.v, back->y), vec3_dot(m.v, back->z));
        out->u0 += vec3_dot(m.u, back->o);
        out->v0 += vec3_dot(m.v, back->o);
    }
    return before;
}

static int map_after(int map, int before) { return map ? map + before : 0; }

void shape_append(Arena *arena, Shape *to, const Shape *from) {
    int maps = append_maps(arena, to, from, NULL);
    for (int i = 0; i < from->face_count; i++) {
        const ShapeFace *f = &from->faces[i];
        int at = to->face_count;
        shape_add_in_plane(arena, to, from->corners + f->first, f->count, f->material, f->plane);
        if (to->face_count > at) to->faces[at].map = map_after(f->map, maps);
    }
}

void shape_flip_faces(Shape *shape, int first, int end) {
    for (int i = first; i < end; i++) {
        ShapeFace *f = &shape->faces[i];
        f->plane = (Plane){vec3_scale(f->plane.n, -1), -f->plane.d};
        for (int k = 1; k <= (f->count - 1) / 2; k++) {
            Vec3 *a = &shape->corners[f->first + k], *b = &shape->corners[f->first + f->count - k], keep = *a;
            *a = *b;
            *b = keep;
        }
    }
}

void shape_flip(Shape *shape) { shape_flip_faces(shape, 0, shape->face_count); }

double shape_volume(const Shape *shape) {
    double six = 0;
    if (shape->face_count == 0) return 0;
    Vec3 o = shape->corners[0];
    for (int i = 0; i < shape->face_count; i++) {
        const ShapeFace *f = &shape->faces[i];
        const Vec3 *c = shape->corners + f->first;
        for (int k = 1; k + 1 < f->count; k++)
            six += vec3_dot(vec3_sub(c[0], o), vec3_cross(vec3_sub(c[k], o), vec3_sub(c[k + 1], o)));
    }
    return six / 6;
}

Frame frame_inverse(const Frame *f) {
    double volume = frame_volume(f);
    // The rows of the inverse are the cross products of the columns.
    Vec3 a = vec3_scale(vec3_cross(f->y, f->z), 1 / volume),
         b = vec3_scale(vec3_cross(f->z, f->x), 1 / volume),
         c = vec3_scale(vec3_cross(f->x, f->y), 1 / volume);
    Frame out = {{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}, {0, 0, 0}};
    out.o = vec3_scale(frame_turn(&out, f->o), -1);
    return out;
}

void shape_append_mapped(Arena *arena, Shape *to, const Shape *from, const Frame *frame) {
    double volume = frame_volume(frame);
    if (from->face_count == 0) return;
    int before_faces = to->face_count, before = to->corner_count, maps = 0;
    if (from->map_count > 0 && volume != 0) {
        Frame back = frame_inverse(frame);
        maps = append_maps(arena, to, from, &back);
    }
    to->corners =
        arena_room(arena, to->corners, sizeof(Vec3), before, before + from->corner_count, &to->corner_room);
    to->faces = arena_room(arena, to->faces, sizeof(ShapeFace), before_faces, before_faces + from->face_count,
                           &to->face_room);
    for (int i = 0; i < from->face_count; i++) {
        const ShapeFace *f = &from->faces[i];
        int first = to->corner_count;
        for (int k = 0; k < f->count; k++) {
            Vec3 p = frame_point(frame, from->corners[f->first + (volume < 0 && k > 0 ? f->count - k : k)]);
            to->corners[to->corner_count++] = p;
            to->box = box_add(to->box, p);
        }
        // Normals go by the inverse transposed, which the cross products of the columns are.
        Vec3 n = f->plane.n;
        n = vec3_add(vec3_add(vec3_scale(vec3_cross(frame->y, frame->z), n.x),
                              vec3_scale(vec3_cross(frame->z, frame->x), n.y)),
                     vec3_scale(vec3_cross(frame->x, frame->y), n.z));
        n = vec3_normalize(volume < 0 ? vec3_scale(n, -1) : n);
        // A frame that mirrors keeps the side that normals point to.
        if (vec3_length(n) == 0) {
            to->corner_count = first;
            continue;
        }
        Vec3 middle = vec3(0, 0, 0);
        for (int k = 0; k < f->count; k++) middle = vec3_add(middle, to->corners[first + k]);
        middle = vec3_scale(middle, 1.0 / f->count);
        to->faces[to->face_count++] = (ShapeFace){first,
                                                  f->count,
                                                  f->material,
                                                  volume != 0 ? map_after(f->map, maps) : 0,
                                                  {n, vec3_dot(n, middle)}};
    }
}
