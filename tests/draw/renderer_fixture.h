// renderer_fixture.h - a building drawn to memory.
#ifndef TESTS_RENDERER_FIXTURE_H
#define TESTS_RENDERER_FIXTURE_H

#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "tests/support/support.h"

// Odd, so that rows are of no even number of bytes.
enum { WIDTH = 97, HEIGHT = 55 };

typedef struct Stage {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    VisQuery *query;
    GlContext *context;
    WalkRenderer *renderer;
    float *doors;
    Camera camera;  // at the building's start
} Stage;

void renderer_check_open_stage(Stage *s, const char *path);
void renderer_check_open_building(Stage *s);  // of the stage, which holds nothing else yet

void renderer_check_close_stage(Stage *s);

// The picture, in the stage's arena.
uint8_t *renderer_check_picture(Stage *s, const Camera *camera, Culling culling, WalkLook look);

int renderer_check_differing(const uint8_t *a, const uint8_t *b, int pixels);

// Looks at the first door with a leaf, from two metres in front of it; the picture has so many pixels.
Camera renderer_check_door(const Stage *s, int width, int height);

#endif
