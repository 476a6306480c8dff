// bench_hidden_scenes.h - what `bench hidden` draws: random polygons of a given depth complexity, and buildings along the auto
// tour, culled and not.
#ifndef APP_BENCH_HIDDEN_SCENES_H
#define APP_BENCH_HIDDEN_SCENES_H

#include "engine/bench/bench.h"
#include "visibility/hidden/hidden.h"

typedef struct HiddenView {
    Scene scene;
    Camera camera;
    bool same;  // the scene of the view before it
} HiddenView;

typedef struct HiddenViews {
    HiddenView *views;
    int count;
} HiddenViews;

// `scenes` scenes of so many polygons each, in a box before the camera, turned every way; together they cover the picture
// about `depth` times over.
HiddenViews hidden_views_random(int polygons, double depth, int width, int height, int scenes, uint64_t seed,
                                Arena *arena);

// Triangles of 2 to 20 pixels anywhere in the picture.
HiddenViews hidden_views_triangles(int triangles, int width, int height, uint64_t seed, Arena *arena);

// So many frames of the auto tour, doors open: all polygons, and those that the stab trees leave.
bool hidden_views_building(const char *file, const BenchArguments *a, int frames, Arena *arena,
                           HiddenViews *whole, HiddenViews *culled, Error *error);

#endif
