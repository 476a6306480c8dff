// scene.h - a building loaded from its file, ready to be looked at, walked in and lit: read, with faces for its lamps, prepared for
// visibility with the user's cache, within a budget of memory.
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include "engine/core/text.h"
#include "engine/scene/day.h"
#include "engine/scene/fill_lamps.h"
#include "radiosity/mesh/lamps.h"

// How a building is loaded. Strings and arrays last as long as the scene.
typedef struct SceneOptions {
    VisOptions vis;
    // Make the stab trees anew even where the cache has them.
    bool fresh;
    // Store the stab trees in the cache.
    bool keep;
    // Which lights get faces that emit (lamp_faces.h).
    enum {
        SCENE_LAMPS_NONE,
        SCENE_LAMPS_ALL,
        // All where the building has stored light, else none.
        SCENE_LAMPS_IF_LIT,
    } lamps;
    // FILL_LAMPS_ON: rooms without light get lamps (fill_lamps.h), where lights get faces. By day, under `sky` or the sky of light that
    // is found, rooms with openings to outdoors get none.
    int fill_lamps;
    // A state of the lamps (lamp_state.h); NULL: all fully lit.
    const char *lamp_state;
    // One of a file that holds several maps; NULL: the first.
    const char *map;
    // Each `NAME=FILE`: photometric files for lamps by their names, beside those that the building has.
    TextList photometry;
    // Look for stored light: `light`, a .rad file that must fit, or, where that is NULL, beside the building and in the cache.
    bool find_light;
    const char *light;
    // The caller shows the building before its light: a baker reads stored light later (walk_scene_load).
    bool light_later;
    // The daylight asked for: stored light of another day does not fit, and light that is baked is of this one. None: any stored light
    // fits, and light is baked by night.
    DayOptions day;
    // Minutes by which the hour is turned on from that of another day (walk_scene_turn); not 0: stored light is not looked for.
    int turned;
    DayOptions turned_from;
    // The use of the building, where it may take too much memory: "baking"; NULL: "working on it".
    const char *work;
    // Memory that may be used, bytes; 0: as much as fits the file to open it, then three quarters of the machine's.
    size_t memory;
    // A building that takes too much memory is given up with a sentence as long as that is possible, since the caller has another
    // to go on with.
    bool gentle;
    // [written_count] files that the caller will write: a building that refers to one of them is refused. NULLs are passed over.
    const char *const *written;
    int written_count;
    // The search for visible sets; where it asks to stop, the sets are too large, never too small.
    Progress progress;
    // Takes sentences on faults that do not end the loading, such as a damaged cache; NULL: nobody is told.
    void (*warn)(const char *sentence);
} SceneOptions;
SceneOptions scene_default_options(void);

// Light files that a building may have, the likeliest first: beside it, and in the cache.
enum { SCENE_LIGHTS = 2 };

typedef struct LoadedScene {
    Building building;
    CellGraph graph;
    StabForest forest;
    double read_seconds, cells_seconds, trees_seconds;
    // Objects added for lights.
    int lamp_faces;
    // Rooms without light that got lamps (Building.fill_lamps).
    int filled_rooms;
    // All lamps, and the state asked for, [lamps.count]; the building has them fully lit.
    Lamps lamps;
    Rgb *lit;
    // The trees came from the cache; the cache has them; their search was stopped early.
    bool cached, kept, stopped;
    // Pairs of cells, both ways round, that are neither proven to see each other nor excluded.
    long long undecided;
    // The day asked for, over this building, or the usual one; all zeros: none.
    Daylight day;
    bool day_given;  // a day or night was asked for: light made under another day does not fit
    // Files of light whose header fits the building, where light was looked for, and the day of the first one.
    const char *lights[SCENE_LIGHTS];
    int light_count;
    Daylight light_day;
    // The cache cannot be written, and `warn` was told.
    bool no_cache;
    void (*warn)(const char *sentence);
} LoadedScene;

// Reads the building, makes cells, and stab trees or finds them in the cache. A cache that cannot be used is passed over with a
// warning.
bool scene_load(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error);
// The same without stab trees.
bool scene_load_cells(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                      Error *error);

// False, and a sentence, for a file of cells and portals alone, in which there is nothing to draw or to walk on.
bool scene_has_walls(const LoadedScene *scene, Error *error);
// Has the building any material that emits light?
bool scene_emits(const LoadedScene *scene);

// Does the scene ask for all lamps fully lit?
bool scene_fully_lit(const LoadedScene *scene);
// The mesh of the scene's graph in the state of the lamps that was asked for; it lives in the arena.
Mesh scene_lit_mesh(const LoadedScene *scene, const Mesh *mesh, Arena *arena);

// Are the files that are written none of those that are read? NULLs are passed over.
bool scene_spares(const char *const *written, int write_count, const char *const *read, int read_count,
                  Error *error);

// ---- the cache

// A file in the user's cache, or NULL: there is no cache.
char *scene_cache_path(Arena *arena, const char *name);
// Can the file be written there, of `size` bytes and more? Makes the cache's folder.
bool scene_cache_check(const char *path, size_t size, Error *error);
// The same for those who do without a cache: the scene's `warn` is told once.
bool scene_cache_takes(LoadedScene *scene, const char *path, size_t size);

#endif
