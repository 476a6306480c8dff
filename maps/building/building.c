// building.c - appending to a building. Colours are decoded by the sRGB transfer function of IEC 61966-2-1.
#include "maps/building/building.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/core/polygon.h"

static bool same_material(const Material *a, const Material *b) {
    const Rgb *r = &a->reflectance, *s = &b->reflectance, *e = &a->emission, *f = &b->emission;
    return r->r == s->r && r->g == s->g && r->b == s->b && e->r == f->r && e->g == f->g && e->b == f->b &&
           a->alpha == b->alpha && a->mirror == b->mirror && a->index == b->index && a->gloss == b->gloss &&
           a->texture == b->texture && a->texture_map == b->texture_map && a->spread == b->spread &&
           strcmp(a->name ? a->name : "", b->name ? b->name : "") == 0;
}

int building_add_material(Arena *arena, Building *b, Material material) {
    for (int i = 0; i < b->material_count; i++) {
        if (same_material(&b->materials[i], &material)) return i;
    }
    Material *m = ARENA_PUSH(arena, b->materials, b->material_count, b->material_capacity);
    *m = material;
    m->name = arena_string(arena, material.name ? material.name : "");
    return b->material_count - 1;
}

int building_add_object(Arena *arena, Building *b, ObjectKind kind, const char *name) {
    Object *o = ARENA_APPEND(arena, b->objects, b->object_count, b->object_capacity);
    *o = (Object){.kind = kind,
                  .name = arena_string(arena, name ? name : ""),
                  .first_polygon = b->polygon_count,
                  .opening = -1,
                  .leaf = -1};
    return b->object_count - 1;
}

static bool same_map(const TextureMap *a, const TextureMap *b) {
    return vec3_equal(a->u, b->u) && vec3_equal(a->v, b->v) && a->u0 == b->u0 && a->v0 == b->v0;
}

int building_first_band(const Building *b, int edge) {
    int low = 0, high = b->band_count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (b->bands[middle].edge < edge)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

int building_add_texture_map(Arena *arena, Building *b, TextureMap map) {
    if (b->texture_map_count == 0)
        *ARENA_PUSH(arena, b->texture_maps, b->texture_map_count, b->texture_map_capacity) = (TextureMap){0};
    int last = b->texture_map_count - 1;
    if (last > 0 && same_map(&b->texture_maps[last], &map)) return last;
    *ARENA_PUSH(arena, b->texture_maps, b->texture_map_count, b->texture_map_capacity) = map;
    return last + 1;
}

static void push_polygon(Arena *arena, Building *b, const Vec3 *vertices, int count, int material,
                         int texture_map) {
    CORE_ASSERT(b->object_count > 0);
    *ARENA_APPEND(arena, b->polygons, b->polygon_count, b->polygon_capacity) =
        (Polygon){b->vertex_count, count, material, texture_map};
    b->vertices = arena_regrow(arena, b->vertices, sizeof *b->vertices, b->vertex_count,
                               b->vertex_count + count, &b->vertex_capacity);
    memcpy(b->vertices + b->vertex_count, vertices, (size_t)count * sizeof *vertices);
    b->vertex_count += count;
    b->objects[b->object_count - 1].polygon_count++;
}

static bool inside_triangle(Vec3 a, Vec3 b, Vec3 c, Vec3 p, Vec3 n) {
    return polygon_corner_sine(a, b, p, n) >= 0 && polygon_corner_sine(b, c, p, n) >= 0 &&
           polygon_corner_sine(c, a, p, n) >= 0;
}

// Why a corner may not be cut off: TURNS_RIGHT, or the index of a vertex that lies in the corner's triangle. EAR: the corner may be
// cut off. UNKNOWN: not yet found out.
enum { EAR = -3, TURNS_RIGHT, UNKNOWN };

static int obstacle(const Vec3 *v, const int *ring, int left, int i, Vec3 n) {
    Vec3 a = v[ring[(i + left - 1) % left]], b = v[ring[i]], c = v[ring[(i + 1) % left]];
    if (polygon_corner_sine(a, b, c, n) <= POLYGON_COLLINEAR) return TURNS_RIGHT;
    for (int j = 0; j < left; j++) {
        Vec3 p = v[ring[j]];
        if (vec3_equal(p, a) || vec3_equal(p, b) || vec3_equal(p, c)) continue;
        if (inside_triangle(a, b, c, p, n)) return ring[j];
    }
    return EAR;
}

// Whether doubles give a plane through the corners of a triangle: not where it is as long as a country and as wide as a hair.
static bool has_plane(const Vec3 triangle[3]) {
    return polygon_bend(triangle, 3, plane_of_polygon(triangle, 3)) < MAPS_PLANARITY / 2;
}

void building_half_texel(const Texture *texture, double half[2]) {
    half[0] = 0.5 / texture->width;
    half[1] = 0.5 / texture->height;
}

bool building_fit_map(const Vec3 *v, const Vec2 *places, int count, Vec3 n, const double most[2],
                      TextureMap *out) {
    Vec3 middle = vec3(0, 0, 0), x = vec3_normalize(vec3_sub(v[1], v[0])), y = vec3_cross(n, x);
    Vec2 mean = vec2(0, 0);
    for (int i = 0; i < count; i++) {
        middle = vec3_add(middle, vec3_scale(v[i], 1.0 / count));
        mean = vec2_add(mean, vec2_scale(places[i], 1.0 / count));
    }
    double xx = 0, xy = 0, yy = 0;
    Vec2 along[2] = {{0, 0}, {0, 0}};  // sums of places times x, times y
    for (int i = 0; i < count; i++) {
        Vec3 d = vec3_sub(v[i], middle);
        double dx = vec3_dot(d, x), dy = vec3_dot(d, y);
        Vec2 off = vec2_sub(places[i], mean);
        xx += dx * dx, xy += dx * dy, yy += dy * dy;
        along[0] = vec2_add(along[0], vec2_scale(off, dx));
        along[1] = vec2_add(along[1], vec2_scale(off, dy));
    }
    double det = xx * yy - xy * xy;
    if (!(det > 0)) return false;
    Vec2 by_x = vec2_scale(vec2_sub(vec2_scale(along[0], yy), vec2_scale(along[1], xy)), 1 / det),
         by_y = vec2_scale(vec2_sub(vec2_scale(along[1], xx), vec2_scale(along[0], xy)), 1 / det);
    out->u = vec3_add(vec3_scale(x, by_x.x), vec3_scale(y, by_y.x));
    out->v = vec3_add(vec3_scale(x, by_x.y), vec3_scale(y, by_y.y));
    out->u0 = mean.x - vec3_dot(out->u, middle);
    out->v0 = mean.y - vec3_dot(out->v, middle);
    for (int i = 0; i < count; i++) {
        if (!(fabs(vec3_dot(out->u, v[i]) + out->u0 - places[i].x) <= most[0])) return false;
        if (!(fabs(vec3_dot(out->v, v[i]) + out->v0 - places[i].y) <= most[1])) return false;
    }
    return true;
}

// The map of a polygon of this material; 0 where it has no picture or `places` is NULL, or one of its numbers makes no sense;
// -1: no single map fits.
static int map_of(Arena *arena, Building *b, const Vec3 *v, const Vec2 *places, int count, Vec3 n,
                  int material) {
    int texture =
        b->materials && material >= 0 && material < b->material_count ? b->materials[material].texture : 0;
    if (!places || texture == 0) return 0;
    for (int i = 0; i < count; i++)
        if (!(fabs(places[i].x) <= TEXTURE_FARTHEST) || !(fabs(places[i].y) <= TEXTURE_FARTHEST)) return 0;
    TextureMap map;
    // A triangle has always a map, up to rounding.
    double half[2] = {INFINITY, INFINITY};
    if (count > 3) building_half_texel(&b->textures[texture], half);
    if (building_fit_map(v, places, count, n, half, &map)) return building_add_texture_map(arena, b, map);
    return count == 3 ? 0 : -1;
}

// Ear clipping in the polygon's plane. Where no ear is left (a polygon that crosses itself) the first corner is
// cut off. A corner that is not an ear cannot become one while its neighbours and the vertex in its triangle are left.
static int add_as_triangles(Arena *arena, Building *b, const Vec3 *v, const Vec2 *places, int count, Vec3 n,
                            int material) {
    int *ring = memory_new(sizeof(int) * 2 * (size_t)count), *why = ring + count, added = 0;
    for (int i = 0; i < count; i++) {
        ring[i] = i;
        why[i] = UNKNOWN;
    }
    for (int left = count; left > 2; left--) {
        int ear = 0;
        for (; ear < left; ear++) {
            if (why[ear] == UNKNOWN) why[ear] = obstacle(v, ring, left, ear, n);
            if (why[ear] == EAR) break;
        }
        if (ear == left) ear = 0;
        why[(ear + left - 1) % left] = why[(ear + 1) % left] = UNKNOWN;
        for (int i = 0; i < left; i++)
            if (why[i] == ring[ear]) why[i] = UNKNOWN;
        const int corner[3] = {ring[(ear + left - 1) % left], ring[ear], ring[(ear + 1) % left]};
        Vec3 t[3];
        Vec2 place[3] = {{0, 0}, {0, 0}, {0, 0}};
        for (int i = 0; i < 3; i++) {
            t[i] = v[corner[i]];
            if (places) place[i] = places[corner[i]];
        }
        if (polygon_area(t, 3) > MAPS_SMALLEST_AREA && has_plane(t)) {
            int map = map_of(arena, b, t, places ? place : NULL, 3, plane_of_polygon(t, 3).n, material);
            push_polygon(arena, b, t, 3, material, map);
            added++;
        }
        for (int i = ear; i + 1 < left; i++) {
            ring[i] = ring[i + 1];
            why[i] = why[i + 1];
        }
    }
    memory_free(ring);
    return added;
}

int building_add_textured(Arena *arena, Building *b, const Vec3 *vertices, const Vec2 *places, int count,
                          int material) {
    if (count < 3) return 0;
    enum { FEW = 64 };
    Vec3 few[FEW], *v = count <= FEW ? few : memory_new(sizeof(Vec3) * (size_t)count);
    Vec2 few_places[FEW], *at = count <= FEW ? few_places : memory_new(sizeof(Vec2) * (size_t)count);
    int kept = 0, added = 0;
    for (int i = 0; i < count; i++) {
        Vec3 p = vertices[i];
        if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z)) kept = -count - 1;
        if (kept < 0 || (kept > 0 && vec3_equal(v[kept - 1], p))) continue;
        if (places) at[kept] = places[i];
        v[kept++] = p;
    }
    while (kept > 1 && vec3_equal(v[kept - 1], v[0])) kept--;
    if (kept >= 3 && polygon_area(v, kept) > MAPS_SMALLEST_AREA) {
        Plane plane = plane_of_polygon(v, kept);
        // Half the limit, so that later rounding cannot push the polygon over it.
        bool whole = polygon_bend(v, kept, plane) < MAPS_PLANARITY / 2 && polygon_is_convex(v, kept, plane.n);
        int map = whole ? map_of(arena, b, v, places ? at : NULL, kept, plane.n, material) : -1;
        if (map >= 0) {
            push_polygon(arena, b, v, kept, material, map);
            added = 1;
        } else {
            added = add_as_triangles(arena, b, v, places ? at : NULL, kept, plane.n, material);
        }
    }
    if (v != few) memory_free(v);
    if (at != few_places) memory_free(at);
    return added;
}

int building_add_polygon(Arena *arena, Building *b, const Vec3 *vertices, int count, int material) {
    return building_add_textured(arena, b, vertices, NULL, count, material);
}

int building_polygons_allowed(double file_size) {
    static const double LEAST = 300000, A_BYTE = 0.25,
                        MEMORY = 2500;  // bytes for each polygon, with its cells and squares
    double most = fmax(A_BYTE * file_size, (double)memory_granted() / MEMORY);
    return (int)fmin(fmax(most, LEAST), BUILDING_MOST_POLYGONS);
}

void building_set_proxy(Arena *arena, Building *b, double angle) {
    if (b->object_count == 0) return;
    Object *o = &b->objects[b->object_count - 1];
    Vec2 u = vec2(cos(angle), sin(angle)), w = vec2(-u.y, u.x);
    Box box = box_empty();
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        for (int k = 0; k < p->vertex_count; k++) {
            Vec3 v = b->vertices[p->first_vertex + k];
            box = box_add(box, vec3(v.x * u.x + v.y * u.y, v.x * w.x + v.y * w.y, v.z));
        }
    }
    o->proxy = NULL;
    if (!(box.min.z < box.max.z)) return;
    double x[4] = {box.min.x, box.max.x, box.max.x, box.min.x},
           y[4] = {box.min.y, box.min.y, box.max.y, box.max.y};
    ObjectProxy *proxy = ARENA_ARRAY(arena, ObjectProxy, 1);
    for (int i = 0; i < 4; i++) proxy->corner[i] = vec2_add(vec2_scale(u, x[i]), vec2_scale(w, y[i]));
    proxy->z0 = box.min.z;
    proxy->z1 = box.max.z;
    o->proxy = proxy;
}

void building_fit(Arena *arena, Building *b) {
    b->vertices = arena_fit(arena, b->vertices, sizeof *b->vertices, b->vertex_count, b->vertex_capacity);
    b->polygons = arena_fit(arena, b->polygons, sizeof *b->polygons, b->polygon_count, b->polygon_capacity);
    b->objects = arena_fit(arena, b->objects, sizeof *b->objects, b->object_count, b->object_capacity);
    b->vertex_capacity = b->vertex_count;
    b->polygon_capacity = b->polygon_count;
    b->object_capacity = b->object_count;
}

void building_note(Arena *arena, Building *b, int kind, Vec3 place, const char *format, ...) {
    va_list args;
    va_start(args, format);
    char *text = arena_format_list(arena, format, args);
    va_end(args);
    *ARENA_PUSH(arena, b->notes, b->note_count, b->note_capacity) = (Note){kind, text, place, 0, 0};
}

void building_tally(NoteTally *tally, const char *name, Vec3 place) {
    static const int SHOWN = 5;  // names in the note
    if (tally->count++ == 0) tally->place = place;
    size_t used = strlen(tally->names);
    if (tally->shown == SHOWN || strstr(tally->names, name)) return;
    tally->shown++;
    snprintf(tally->names + used, sizeof tally->names - used, "%s%.60s", used ? ", " : "", name);
}

void building_note_tally(Arena *arena, Building *b, const char *where, const NoteTally *tally,
                         const char *what) {
    if (tally->count == 0) return;
    building_note(arena, b, NOTE_CHANGED, tally->place, "%s: %d %s%s%s", where, tally->count, what,
                  *tally->names ? ": " : "", tally->names);
}

// Filled before main, since pictures are read by the million.
static float linear_of[256];

static void __attribute__((constructor)) fill_linear(void) {
    for (int i = 0; i < 256; i++) {
        double c = i / 255.0, linear = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        linear_of[i] = fminf((float)linear, MAPS_MAX_COLOUR);
    }
}

float maps_linear(int srgb) { return linear_of[srgb < 0 ? 0 : srgb > 255 ? 255 : srgb]; }

Rgb maps_colour(unsigned rgb) {
    return (Rgb){maps_linear((int)(rgb >> 16 & 255)), maps_linear((int)(rgb >> 8 & 255)),
                 maps_linear((int)(rgb & 255))};
}

bool region_is_convex(const Building *b, const Region *region) {
    if (region->ring_count != 1) return false;
    const Ring *ring = &b->rings[region->first_ring];
    const Vec2 *p = b->points + ring->first_point;
    double turned = 0;
    for (int i = 0, n = ring->point_count; i < n; i++) {
        Vec2 a = vec2_sub(p[(i + 1) % n], p[i]), c = vec2_sub(p[(i + 2) % n], p[(i + 1) % n]);
        double cross = vec2_cross(a, c), chord = vec2_length(vec2_add(a, c));
        if (cross < -MAPS_DENT * chord || (cross <= 0 && vec2_dot(a, c) <= 0)) return false;
        turned += atan2(cross, vec2_dot(a, c));
    }
    // A star turns left at every corner too, but more than once around.
    return turned < 3 * M_PI;
}

// The middle of the longest stretch of the region on the line through the middle of its box.
static Vec2 place_inside(const Building *b, const Region *r) {
    double low = INFINITY, high = -INFINITY, longest = -1;
    const Ring *rings = b->rings + r->first_ring;
    for (int i = 0; i < rings->point_count; i++) {
        low = fmin(low, b->points[rings->first_point + i].y);
        high = fmax(high, b->points[rings->first_point + i].y);
    }
    double y = low + (high - low) / 2;
    Vec2 best = b->points[rings->first_point];
    // From each crossing to the next one on its right: free space lies to the right of edges that go down.
    for (int k = 0; k < r->ring_count; k++) {
        for (int i = 0; i < rings[k].point_count; i++) {
            const Vec2 *p = b->points + rings[k].first_point, a = p[i], c = p[(i + 1) % rings[k].point_count];
            if (!(a.y > y && c.y <= y)) continue;
            double x = a.x + (c.x - a.x) * (y - a.y) / (c.y - a.y), next = INFINITY;
            for (int m = 0; m < r->ring_count; m++) {
                const Vec2 *q = b->points + rings[m].first_point;
                for (int n = 0; n < rings[m].point_count; n++) {
                    Vec2 s = q[n], t = q[(n + 1) % rings[m].point_count];
                    double at = s.x + (t.x - s.x) * (y - s.y) / (t.y - s.y);
                    if (s.y <= y && t.y > y && at > x) next = fmin(next, at);
                }
            }
            if (!isfinite(next) || next - x <= longest) continue;
            longest = next - x;
            best = vec2((x + next) / 2, y);
        }
    }
    return best;
}

const char *region_title(const Building *b, const Region *region, Arena *arena) {
    if (region->kind == REGION_OUTDOORS) return "outdoors";
    if (*region->name) return region->name;
    Vec2 at = place_inside(b, region);
    return arena_format(arena, "a room at (%.1f, %.1f)", at.x, at.y);
}

Vec3 leaf_point(const Leaf *leaf, double open, Vec3 closed) {
    double angle = open * leaf->turn, c = cos(angle), s = sin(angle);
    Vec2 from = vec2(closed.x - leaf->pivot.x, closed.y - leaf->pivot.y);
    double z = closed.z + open * leaf->rise;
    // An unmoved leaf stays where it was read, to the last bit.
    if (angle == 0) return vec3(closed.x + open * leaf->slide.x, closed.y + open * leaf->slide.y, z);
    return vec3(leaf->pivot.x + c * from.x - s * from.y + open * leaf->slide.x,
                leaf->pivot.y + s * from.x + c * from.y + open * leaf->slide.y, z);
}

Vec3 leaf_point_closed(const Leaf *leaf, double open, Vec3 point) {
    double angle = open * leaf->turn, c = cos(angle), s = sin(angle);
    Vec2 from =
        vec2(point.x - leaf->pivot.x - open * leaf->slide.x, point.y - leaf->pivot.y - open * leaf->slide.y);
    return vec3(leaf->pivot.x + c * from.x + s * from.y, leaf->pivot.y - s * from.x + c * from.y,
                point.z - open * leaf->rise);
}

void leaf_box(const Leaf *leaf, double open, Vec2 corner[4]) {
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    Vec2 half = vec2_scale(vec2(-along.y, along.x), leaf->thickness / 2 / vec2_length(along));
    for (int i = 0; i < 4; i++) {
        Vec2 end = leaf->axis[i == 1 || i == 2];
        Vec2 p = i < 2 ? vec2_sub(end, half) : vec2_add(end, half);
        Vec3 at = leaf_point(leaf, open, vec3(p.x, p.y, 0));
        corner[i] = vec2(at.x, at.y);
    }
}

int leaf_plan(const Building *b, const Leaf *leaf, double open, Vec2 corner[LEAF_CORNERS]) {
    if (leaf->corner_count == 0) {
        leaf_box(leaf, open, corner);
        return 4;
    }
    for (int i = 0; i < leaf->corner_count; i++) {
        Vec2 p = b->points[leaf->first_corner + i];
        Vec3 at = leaf_point(leaf, open, vec3(p.x, p.y, 0));
        corner[i] = vec2(at.x, at.y);
    }
    return leaf->corner_count;
}

const char *opening_kind_name(OpeningKind kind) {
    static const char *const names[OPENING_KINDS] = {"door", "passage", "window"};
    return kind >= 0 && kind < OPENING_KINDS ? names[kind] : "unknown opening";
}

bool maps_portal_is_thin(const Vec3 *corners, int count) {
    static const double THIN = 1e-12;
    double longest = 0;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < i; k++) {
            Vec3 d = vec3_sub(corners[i], corners[k]);
            longest = fmax(longest, vec3_dot(d, d));
        }
    }
    return !(polygon_area(corners, count) > THIN * longest);
}
