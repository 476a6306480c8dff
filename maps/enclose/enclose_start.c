// enclose_start.c - where a walk begins, and which way it looks.
#include "engine/core/polygon.h"
#include "maps/enclose/enclose.h"

// Eye height of a walk, metres; clear of the ceiling by EYE_CLEAR.
static const double EYE = 1.6, EYE_CLEAR = 0.1;

static double region_area(const Building *b, const Region *r) {
    double sum = 0;
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &b->rings[r->first_ring + k];
        const Vec2 *p = &b->points[ring->first_point];
        for (int i = 1; i + 1 < ring->point_count; i++)
            sum += vec2_cross(vec2_sub(p[i], p[0]), vec2_sub(p[i + 1], p[0])) / 2;
    }
    return sum;
}

// The distance of q to the region's outline, negative outside, metres.
static double depth_in(const Building *b, const Region *r, Vec2 q) {
    double nearest = INFINITY;
    bool inside = false;
    for (int k = 0; k < r->ring_count; k++) {
        const Ring *ring = &b->rings[r->first_ring + k];
        const Vec2 *p = &b->points[ring->first_point];
        for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++) {
            Vec2 d = vec2_sub(p[i], p[j]), aq = vec2_sub(q, p[j]);
            double t = fmin(1, fmax(0, vec2_dot(aq, d) / vec2_dot(d, d)));
            nearest = fmin(nearest, vec2_length(vec2_sub(aq, vec2_scale(d, t))));
            inside ^= ring_edge_is_crossed(p[i], p[j], q, RING_MULTIPLY_FIRST);
        }
    }
    return inside ? nearest : -nearest;
}

typedef struct Furniture {
    const Object **objects;
    int count;
} Furniture;

// Collects the furniture that can be nearer to a place in the rectangle than the rectangle's sides are.
static Furniture furniture_near(const Building *b, Vec2 low, Vec2 high, double z0, double z1, Arena *arena) {
    Furniture out = {ARENA_ARRAY(arena, const Object *, b->object_count), 0};
    double reach = fmin(high.x - low.x, high.y - low.y);  // twice as far as a place can be from the sides
    for (int i = 0; i < b->object_count; i++) {
        const Object *o = &b->objects[i];
        if (!o->proxy || o->proxy->z0 >= z1 || o->proxy->z1 <= z0 || o->leaf >= 0) continue;
        Box box = box_empty();
        for (int k = 0; k < 4; k++) box = box_add(box, vec3(o->proxy->corner[k].x, o->proxy->corner[k].y, 0));
        if (box.min.x > high.x + reach || box.max.x < low.x - reach || box.min.y > high.y + reach ||
            box.max.y < low.y - reach)
            continue;
        out.objects[out.count++] = o;
    }
    return out;
}

// The distance from q to the nearest furniture, negative inside it, at most `limit`, metres.
static double clear_of(const Furniture *furniture, Vec2 q, double limit) {
    for (int i = 0; i < furniture->count; i++) {
        const Object *o = furniture->objects[i];
        double out =
            -INFINITY;  // distance to the farthest side plane: exact beside a side, small at a corner
        for (int k = 0; k < 4; k++) {
            Vec2 a = o->proxy->corner[k], d = vec2_sub(o->proxy->corner[(k + 1) % 4], a);
            double length = vec2_length(d);
            if (length > 0) out = fmax(out, vec2_cross(vec2_sub(q, a), d) / length);
        }
        limit = fmin(limit, out);
    }
    return limit;
}

static Vec2 best_stand(const Building *b, const Region *r, Arena *arena) {
    enum { STEPS = 40 };
    const Ring *ring = &b->rings[r->first_ring];
    Vec2 low = b->points[ring->first_point], high = low;
    for (int i = 0; i < ring->point_count; i++) {
        Vec2 p = b->points[ring->first_point + i];
        low = vec2(fmin(low.x, p.x), fmin(low.y, p.y));
        high = vec2(fmax(high.x, p.x), fmax(high.y, p.y));
    }
    // Furniture at the height of a person's body.
    Furniture furniture = furniture_near(b, low, high, r->z0 + 0.3, r->z0 + 1.8, arena);
    Vec2 best = low;
    double most = -INFINITY;
    for (int j = 0; j < STEPS; j++) {
        for (int i = 0; i < STEPS; i++) {
            Vec2 q = vec2(low.x + (high.x - low.x) * (i + 0.5) / STEPS,
                          low.y + (high.y - low.y) * (j + 0.5) / STEPS);
            double depth = depth_in(b, r, q);
            if (depth <= 0 || depth <= most) continue;
            depth = clear_of(&furniture, q, depth);
            // A place inside furniture, below 0, is worse than a place beside it; places outside the room are skipped above.
            if (depth > most) {
                most = depth;
                best = q;
            }
        }
    }
    return best;
}

// The yaw of the longest view within the region.
static double longest_view(const Building *b, const Region *r, Vec2 from) {
    enum { WAYS = 32 };
    double best = 0, yaw = 0;
    for (int w = 0; w < WAYS; w++) {
        double angle = 2 * M_PI * w / WAYS, nearest = INFINITY;
        Vec2 d = vec2(cos(angle), sin(angle));
        for (int k = 0; k < r->ring_count; k++) {
            const Ring *ring = &b->rings[r->first_ring + k];
            const Vec2 *p = &b->points[ring->first_point];
            for (int i = 0, j = ring->point_count - 1; i < ring->point_count; j = i++) {
                Vec2 a = vec2_sub(p[j], from), c = vec2_sub(p[i], p[j]);
                double det = vec2_cross(d, c);
                if (det == 0) continue;
                double t = vec2_cross(a, c) / det, s = vec2_cross(a, d) / det;
                if (t > 0 && s >= 0 && s <= 1) nearest = fmin(nearest, t);
            }
        }
        if (!isfinite(nearest) || nearest <= best) continue;
        best = nearest;
        yaw = angle;
    }
    return yaw;
}

// [region_count] whether a door leads from the region to the outdoors.
static bool *find_entrances(const Building *b, Arena *arena) {
    bool *entrance = ARENA_ARRAY(arena, bool, b->region_count);
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind == OPENING_WINDOW || o->region[0] < 0 || o->region[1] < 0) continue;
        for (int s = 0; s < 2; s++) {
            if (b->regions[o->region[!s]].kind == REGION_OUTDOORS) entrance[o->region[s]] = true;
        }
    }
    return entrance;
}

// Starts in the largest room with a door to the outdoors, else in the largest room, else in the open air.
void enclose_choose_start(Enclosure *e) {
    Building *b = e->b;
    const bool *entrance = find_entrances(b, e->scratch);
    int best = -1;
    double most = -1;
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->kind != REGION_ROOM && r->kind != REGION_OUTDOORS) continue;
        double area = region_area(b, r);
        // Lexicographic: a room before the open air, high enough to stand in, at an entrance, large.
        double rank = (r->kind == REGION_ROOM ? 8 : 0) + (r->z1 - r->z0 > EYE + EYE_CLEAR ? 4 : 0) +
                      (entrance[i] ? 2 : 0);
        double score = rank + area / (1 + area);
        if (score <= most) continue;
        most = score;
        best = i;
    }
    if (best < 0) return;
    const Region *r = &b->regions[best];
    Vec2 at = best_stand(b, r, e->scratch);
    double z = r->z0 + EYE > r->z1 - EYE_CLEAR ? (r->z0 + r->z1) / 2 : r->z0 + EYE;
    b->start = vec3(at.x, at.y, z);
    b->start_yaw = longest_view(b, r, at);
}
