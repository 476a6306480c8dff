// prt_scene.h - graphs of given cells, from the text of portal files made by tests.
#ifndef TESTS_PRT_SCENE_H
#define TESTS_PRT_SCENE_H

#include "engine/core/random.h"
#include "visibility/vis.h"

// The cells of a portal file's text. Fails the running test when it cannot be read.
CellGraph *prt_scene(Arena *arena, const char *text);

// A portal file: ../shared/data/prt/NAME.prt, else one made of the cells of a building, all tilted by one shear, so that no portal of
// it is upright or level.
const char *prt_file(Arena *arena, const char *name, const char *building);

// Whole game units, 32 a metre: a doorway of a wall across x.
typedef struct Doorway {
    int y[2], z[2];
} Doorway;

enum { ROW_MOST = 16, ROW_SHORTEST = 32 };
// Rooms in a row along x, ROW_SHORTEST units long or up to three times that; doorway k leads from room k to room k + 1.
typedef struct Row {
    int room_count;
    Doorway doorway[ROW_MOST];
    int wall[ROW_MOST + 1];  // where the wall of doorway k stands, x
} Row;

Row row_random(Random *random, int room_count);
CellGraph *row_graph(Arena *arena, const Row *row);

typedef enum RowSight { ROW_HIDDEN, ROW_TOUCHED, ROW_SEEN } RowSight;  // TOUCHED: by a line along edges only
// Whether room a sees room b > a, computed in whole numbers: heights and widths apart, since doorways are upright
// rectangles in parallel walls.
RowSight row_sight(const Row *row, int a, int b, bool heights);

#endif
