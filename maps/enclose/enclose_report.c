// enclose_report.c - notes on the rooms and openings of the sketch: areas, overlaps, terraces, closed gaps.
#include "maps/enclose/enclose.h"

// A room that keeps less than this share of its area is lost.
static const double LEAST_KEPT = 0.1;
// Overlaps of rooms and losses of openings below are not worth a note, mm^2 and share.
static const double SMALL_OVERLAP = 5e4, SMALL_LOSS = 0.2;

typedef struct RoomAreas {
    double drawn, overlapped, open, kept, terrace;
} RoomAreas;

static void measure_rooms(Enclosure *e, RoomAreas *areas) {
    const Plan *p = &e->pass.plan;
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (!e->room_used[i]) continue;
        const Spot *spots = e->pass.spots + (size_t)e->sketch->rooms[i].storey * (size_t)p->face_count;
        for (int k = plan_faces_in(e, p, &e->rooms[i]); k-- > 0;) {
            const Spot *spot = &spots[e->faces.items[k]];
            double area = p->faces[e->faces.items[k]].area;
            if (spot->room != i) {
                if (spot_is_open(spot)) areas[i].overlapped += area;
                continue;
            }
            areas[i].drawn += area;
            if (spot_is_open(spot)) areas[i].open += area;
            if (spot->indoor >= 0) areas[i].kept += area;
            if (spot->terrace >= 0) areas[i].terrace += area;
        }
    }
}

static void report_room(Enclosure *e, int i, const RoomAreas *a) {
    const SketchRoom *r = &e->sketch->rooms[i];
    Vec3 p = enclose_place(e, e->rooms[i].points[0], r->storey);
    const char *name = enclose_text(r->place);
    double m2 = ENCLOSE_MM * ENCLOSE_MM, usable = a->kept + a->terrace;
    double lost = usable < LEAST_KEPT * a->drawn ? a->drawn : fmax(0, a->open - usable);
    e->b->drawn_area += a->drawn / m2;
    e->b->lost_area += lost / m2;
    if (a->overlapped > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) overlaps earlier ones by %.2f m^2: they keep it", name, p.x, p.y,
                      a->overlapped / m2);
    }
    if (a->drawn <= 0 || lost == a->drawn) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f) left out: walls or other rooms cover its %.2f m^2", name, p.x, p.y,
                      (a->drawn + a->overlapped) / m2);
    } else if (lost > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_DROPPED, p,
                      "%s at (%.2f, %.2f): %.2f of its %.2f m^2 lie outside the walls and are left out", name,
                      p.x, p.y, lost / m2, a->drawn / m2);
    }
    if (a->terrace > SMALL_OVERLAP) {
        building_note(e->arena, e->b, NOTE_CHANGED, p,
                      "%s at (%.2f, %.2f) is not enclosed: %.2f m^2 of it are a terrace", name, p.x, p.y,
                      a->terrace / m2);
    }
}

static void report_holes(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    for (int i = 0; i < e->sketch->opening_count; i++) {
        Hole *h = &e->holes[i];
        if (!h->used) continue;
        int storey = e->sketch->openings[i].storey;
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        double kept = 0, lost = 0;
        int other = -1;
        for (int k = plan_faces_in(e, p, &h->box); k-- > 0;) {
            const Spot *spot = &spots[e->faces.items[k]];
            if (spot->hole[0] == i || spot->hole[1] == i) {
                kept += p->faces[e->faces.items[k]].area;
            } else {
                lost += p->faces[e->faces.items[k]].area;
                if (spot->hole[0] >= 0 && (other < 0 || spot->hole[0] < other)) other = spot->hole[0];
            }
        }
        Vec3 at = enclose_place(e, h->centre, storey);
        const char *name = enclose_text(e->sketch->openings[i].place);
        const char *by = other >= 0 ? enclose_text(e->sketch->openings[other].place) : "its own thinness";
        if (kept <= 0) {
            h->used = false;
            building_note(e->arena, e->b, NOTE_DROPPED, at, "%s at (%.2f, %.2f) left out: covered by %s",
                          name, at.x, at.y, by);
        } else if (lost > SMALL_LOSS * (kept + lost)) {
            building_note(e->arena, e->b, NOTE_CHANGED, at,
                          "%s at (%.2f, %.2f) loses %.0f %% of its place to %s", name, at.x, at.y,
                          100 * lost / (kept + lost), by);
        }
    }
}

static void report_plugs(Enclosure *e) {
    const Plan *p = &e->pass.plan;
    for (int storey = 0; storey < e->b->storey_count; storey++) {
        const Spot *spots = e->pass.spots + (size_t)storey * (size_t)p->face_count;
        int count = 0, widest = -1;
        for (int f = 0; f < p->face_count; f++) {
            if (spots[f].wall != WALL_PLUG) continue;
            count++;
            if (widest < 0 || p->faces[f].area > p->faces[widest].area) widest = f;
        }
        if (count == 0) continue;
        Vec3 at = enclose_place(e, p->faces[widest].inner, storey);
        building_note(e->arena, e->b, NOTE_CHANGED, at,
                      "storey %d: %d small gaps between walls were closed, the largest at (%.2f, %.2f)",
                      storey, count, at.x, at.y);
    }
}

void indoor_report(Enclosure *e) {
    RoomAreas *areas = ARENA_ARRAY(e->scratch, RoomAreas, e->sketch->room_count);
    measure_rooms(e, areas);
    for (int i = 0; i < e->sketch->room_count; i++) {
        if (e->room_used[i]) report_room(e, i, &areas[i]);
    }
    report_holes(e);
    report_plugs(e);
}
