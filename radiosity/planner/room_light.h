// room_light.h - the light of rooms as planners ask for it: at the points of a grid on a working plane, and how much of it comes from other
// rooms.
#ifndef RADIOSITY_ROOM_LIGHT_H
#define RADIOSITY_ROOM_LIGHT_H

#include "radiosity/planner/room_grid.h"
#include "radiosity/shoot/shoot.h"

// ---- light with all rooms open, and with all closed

// The light of one source: of the lamps, or of a day. The caller fills in all before `open`; `room_lux` and `room_daylight_factor` tell the
// weights.
typedef struct RoomLight {
    const Mesh *mesh;  // with the lamps as they are: by day, off
    const StabForest *forest;
    const float *door_open;
    Daylight day;      // all zeros: night
    double weight[3];  // of each channel: their sum is the number asked for
    RadOptions options;
    RadSolution open;
    Mesh closed_mesh;    // `mesh` with black panes between rooms
    RadSolution closed;  // what is left of `open` then
    ShootRows *rows;     // of both
} RoomLight;

// Lux, by the house's rule for luminous quantities (building.h).
void room_lux(double weight[3]);
// A share of the illuminance of level ground outdoors: 1 is all of it.
void room_daylight_factor(const Daylight *day, double weight[3]);

// The number that an irradiance is, W/m^2 a channel.
static inline double room_light_value(const RoomLight *light, const double irradiance[3]) {
    const double *w = light->weight;
    return w[0] * irradiance[0] + w[1] * irradiance[1] + w[2] * irradiance[2];
}

// Shoots the light. False where progress asked to stop. Takes memory that room_light_end frees.
bool room_light_open(RoomLight *light, const Progress *progress, Arena *arena, Error *error);
// Then once more with all rooms closed, along the same rows: one solution tells the light of every room without the others.
bool room_light_close(RoomLight *light, const Progress *progress, Arena *arena, Error *error);
void room_light_end(RoomLight *light);

// ---- points

typedef struct PlannedRoom {
    int region;    // in Building.regions
    double plane;  // height of the points, metres
    RoomGrid grid;
    int first_point;  // of grid.point_count in RoomPlan
} PlannedRoom;

// The rooms that are as high as the working plane, and all their points.
typedef struct RoomPlan {
    PlannedRoom *rooms;  // [room_count]
    Vec3 *points;        // [point_count]
    int room_count, point_count;
    int low_count;  // rooms that are lower
} RoomPlan;
// `height` of the working plane above each room's floor, metres.
RoomPlan room_plan(const CellGraph *graph, double height, Arena *arena);

// Directions across: a small window shows few of them, for light of the sky, and a bright place beside a lamp takes few.
enum { ROOM_RESOLUTION = 200, ROOM_SKY_RESOLUTION = 300 };
// The light that arrives at the points from above, [point_count] each: as rooms are, and with all closed. NAN inside things: where backs
// alone are in view, or no light arrives in a room that has some. The same on any number of threads (0: all cores).
typedef struct RoomValues {
    double *all, *own;
} RoomValues;
RoomValues room_values(const RoomPlan *plan, const RoomLight *light, int threads, Arena *arena);

// ---- figures

typedef struct RoomFigures {
    int points, inside;             // points that count; points inside things, which do not
    double mean, minimum, maximum;  // NAN: no point counts
    double uniformity;              // the minimum over the mean; NAN: it is dark
    double from_rooms;  // the share of the mean that came through openings from other rooms; NAN: it is dark
    double half, most;  // reached by half of the points, and by 95 % of them
} RoomFigures;
RoomFigures room_figures(const RoomPlan *plan, int room, const RoomValues *values);

// Levels of EN 17037, and what each asks of a room: an illuminance on half of its area and a least one on 95 % of it, lux.
enum {
    DAYLIGHT_LEVEL_NONE,
    DAYLIGHT_LEVEL_MINIMUM,
    DAYLIGHT_LEVEL_MEDIUM,
    DAYLIGHT_LEVEL_HIGH,
    DAYLIGHT_LEVELS
};
extern const char *const DAYLIGHT_LEVEL_NAMES[DAYLIGHT_LEVELS];
extern const double DAYLIGHT_LEVEL_TARGETS[DAYLIGHT_LEVELS][2];
// The highest level that both reach.
int daylight_level(double half_lux, double most_lux);

#endif
