// bake_parts.h - a bake in parts, groups of cells whose light is found side by side: in this process one after the other, or in as many
// processes as mpirun started (team.h). Which parts there are, and so the light, depends on the building alone.
#ifndef SCENE_BAKE_PARTS_H
#define SCENE_BAKE_PARTS_H

#include "engine/scene/bake_mesh.h"
#include "engine/scene/walk_light.h"

// Parts have an eighth of the cells, but no fewer than the least and no more than the most.
enum { PARTS_FITTING = 8, PARTS_LEAST_CELLS = 16, PARTS_MOST_CELLS = 1024 };
int bake_parts_cells(const CellGraph *graph);
// The same of light that stays apart: as many cells as the memory allows, of which one part is to take half.
int bake_parts_cells_apart(void);

// Light is kept while it is found, in a folder (kept_parts.h) that all processes see.
typedef struct PartsKeep {
    const char *folder;
    double seconds;  // how often at most
    bool resume;     // goes on from what was kept there
    // The light of each part stays there in the end, named by this .rad file (light_parts.h), and is not joined. NULL: it is joined.
    const char *apart;
    // Is given the light of each such part as it is shown, and its .rad file, to store what drawing needs beside it; NULL: nothing is.
    bool (*drawn)(const LoadedScene *scene, const char *rad, const WalkLight *light, Error *error);
} PartsKeep;

// The work of a bake in parts.
typedef struct PartsReport {
    int parts, ranks;
    int kept;       // so many times
    Error unkept;   // why not any more, or empty
    RadReport rad;  // of all parts
    double
        elements_share;  // elements of all meshes, those of others that parts see included, over the elements of the whole
    double sent_mb;  // by this process to others
    // Where this process is alone: what the first of two and of four would have sent.
    double sent_mb_of_2, sent_mb_of_4;
    // Where light is not joined: how much there is of the whole, and its power, W.
    double polygons, patches, elements, nodes, lamp_watts;
    RadSolution power;  // sums alone
} PartsReport;

// Does the whole have so much light that it is to be found and stored in parts?
bool bake_parts_are_needed(const BakeOptions *options, const LoadedScene *scene);

// Light to its end, shown, on the mesh of the whole building: `doors`, `mesh` and `out` are made in process 0 alone, and not at all where
// light stays apart: then members that wait sleep (team.h). `cells`: of a part at
// most. `keep`: NULL, nothing is kept. Light that goes on from what was kept is, to the last bit, that of a bake that was never ended.
// False, with a sentence, in all processes where it fails or is stopped.
bool bake_parts(const BakeOptions *options, const LoadedScene *scene, int cells, const PartsKeep *keep,
                const Progress *progress, Arena *arena, float **doors, Mesh *mesh, RadSolution *out,
                PartsReport *report, Error *error);

#endif
