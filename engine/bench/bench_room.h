// bench_room.h - a furnished room of 18 faces, as Doi & Itoh's test data has, shot in and looked at.
#ifndef APP_BENCH_ROOM_H
#define APP_BENCH_ROOM_H

#include "engine/app/app.h"
#include "radiosity/factors/form_factor.h"

typedef struct BenchRoom {
    Building building;
    CellGraph graph;
    StabForest forest;
    Mesh mesh;
} BenchRoom;

// With about so many elements.
bool bench_room_make(int elements, int per_patch, Arena *arena, BenchRoom *out, Error *error);

// Progressive refinement as it was published, one channel (Cohen, Chen, Wallace & Greenberg 1988).
typedef struct RoomLight {
    const BenchRoom *room;
    double *light;   // [element_count] W/m^2
    double *unshot;  // [patch_count] W
} RoomLight;
RoomLight bench_room_start(const BenchRoom *room, double *light, Arena *arena);
int bench_room_brightest(const RoomLight *state);  // the patch with most unshot power
void bench_room_shoot(RoomLight *state, int patch, const Row *row);

// Of what arrives at elements, the lamp left out: the area-weighted mean of |difference|, over the mean light, percent.
double bench_room_error(const BenchRoom *room, const double *light, const double *reference);
// A look into the room, an element one shade.
bool bench_room_picture(const BenchRoom *room, const double *light, const char *path, Error *error);

#endif
