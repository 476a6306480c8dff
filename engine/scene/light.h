// light.h - the light of a scene for those who show it: found where `enfilade bake` stored it, or baked.
#ifndef SCENE_LIGHT_H
#define SCENE_LIGHT_H

#include "engine/scene/scene.h"
#include "engine/scene/walk_light.h"

// Where `enfilade bake` leaves the light of a building; NULL: there is no cache.
const char *light_place(const Building *building, Arena *arena);
// Room that a cache must have before light is made, bytes: less than most buildings' light takes.
enum { LIGHT_ROOM = 1 << 20 };

// The first of the scene's lights that fits its mesh, which is made again as it was baked; NULL: none does. Fails where the light
// was given (SceneOptions.light) and does not fit; others are passed over with a warning.
bool light_find(const LoadedScene *scene, bool given, Arena *arena, const WalkLight **out, Error *error);
// One file. Refuses a file that is damaged, of another building, or made under another day than the scene's.
bool light_load(const char *path, const LoadedScene *scene, Arena *arena, WalkLight *out, Error *error);

// Light that is stored in parts (light_parts.h), each of which is read by itself.
typedef struct LightOfParts LightOfParts;
// The first of the scene's lights, if it is in parts; NULL: it is not. Fails where it does not fit.
bool light_find_parts(const LoadedScene *scene, Arena *arena, const LightOfParts **out, Error *error);
// The part that has the light on all that is seen from a cell; -1: the cell is none.
int light_part_of(const LightOfParts *parts, int cell);
int light_parts_number(const LightOfParts *parts);
const LoadedScene *light_parts_scene(const LightOfParts *parts);
double light_parts_level(const LightOfParts *parts);  // of the whole (light_level.h)
const char *light_parts_file(const LightOfParts *parts, int part, Arena *arena);  // the .rad file
// Reads the light of a part, with a mesh of what is seen from there alone. Fails as light_load does.
bool light_load_part(const LightOfParts *parts, int part, Arena *arena, WalkLight *out, Error *error);

// Light on the mesh that it was found on, as it is shown: finer where it bends, on the model that stand-ins replaced.
bool light_shown(const Mesh *mesh, const RadSolution *solution, const float *doors, const Lamps *lamps,
                 Arena *arena, WalkLight *out, Error *error);

// Refuses a solution from a file that was made under another day.
bool light_check_day(const char *file, const RadSolution *solution, const Daylight *day, Error *error);

// Brings a solution from a file into the state of the lamps that the scene asks for. Refuses light of another state, unless the light of
// each lamp is known by itself.
bool light_take_lamps(const char *file, const LoadedScene *scene, RadSolution *solution, Error *error);

// Instructions to a bake, and its news.
typedef struct LightHooks {
    // Asks to stop.
    Progress progress;
    // A state of the light worth showing; the first time as soon as there is a mesh, which stays the same. NULL: none is shown.
    void (*show)(void *context, const Mesh *mesh, const RadSolution *so_far);
    void *context;
    // At most so often, seconds.
    double show_every;
    // 0: all cores.
    int threads;
    // Keep what light needs to follow the doors (WalkLight.follower, until light_end); all lamps are fully lit then, whatever the scene
    // asks for.
    bool follow;
    // The same, and find the light of each lamp, too (WalkLight.states). Before that begins, `whole` is called with all light together,
    // which is not to be asked to follow before the bake has ended; NULL: nobody is.
    bool each;
    void (*whole)(void *context, const WalkLight *light);
} LightHooks;

// A party that knows how to bake the building shown, and where to store the light, which lives in the arena. A fault that is no
// reason to show no light, such as a full disk, is told in `error`, which is empty otherwise.
typedef struct LightBaker {
    bool (*bake)(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error);
    void *context;
    // The next walk finds the light.
    bool keeps;
    // For stored light without the light of each lamp: bakes all anew; NULL: `bake` does, or nobody can.
    const struct LightBaker *anew;
    // Light that is stored is read, not baked, where it fits; and it was asked for: without it nothing is to be shown.
    bool stored, asked;
    // The stored light is in parts: the one about the eye is read (light_load_part), and nothing is baked. NULL: it is not.
    const LightOfParts *parts;
} LightBaker;

// The baker that bakes as `enfilade bake FILE` does by itself, under the scene's day, and stores the light where that stores it. Its
// `bake` is NULL where nothing emits light and it is night, or there is no surface that light could fall on. The scene was loaded
// with all lamps. `keep`: false, the light is not stored.
LightBaker light_baker(LoadedScene *scene, bool keep, Arena *arena);

// The light of one source by itself, fully lit, on light->mesh: of lamp `source`, or of the day, states->lamps->count; without the fields
// `direct`, `unshot` and `rest`. The light must have `states`. The result lives in the arena.
RadSolution light_of_source(const WalkLight *light, int source, Arena *arena);

// The light with the doors, [opening_count], and the lamps, [count of the scene's], elsewhere than where light->solution has them, on
// light->mesh, as light_of_source gives it. The light must have a `follower`, which one thread at a time may ask. False where progress
// asked to stop. The result lives in the arena.
bool light_follow(const WalkLight *light, const float *door_open, const Rgb *lit, const Progress *progress,
                  Arena *arena, RadSolution *out);
// Finds all that light goes on from when the first door moves, so that this change takes no longer than others. False where this was done,
// or progress asked to stop.
bool light_follow_begin(const WalkLight *light, const Progress *progress);
// The first step of it, soon done: the doors are there, but all light that is reflected is that of the light that is shown. False where
// the lamps are not as they were then, or that light is not known.
bool light_follow_soon(const WalkLight *light, const float *door_open, const Rgb *lit, Arena *arena,
                       RadSolution *out);
// Can the hour of the light turn? It follows, and was found by day.
bool light_turns(const WalkLight *light);
// The light of another day that shines, all lamps fully lit, with the doors `door_open` [opening_count]: along the rows that are there,
// on a mesh of its own. `out` follows in the place of `light`, which is not to be asked any more, nor to be ended. It lives in the arena,
// which must outlive what is found from it; memory that the light before lives in may go once `out` has turned in its turn. False where
// progress asked to stop: all is as it was.
bool light_turn(const WalkLight *light, const Daylight *day, const float *door_open, const Progress *progress,
                Arena *arena, WalkLight *out);
// Tells the follower that a sum of the light of lamps (light_of_source) is shown now.
void light_follow_sum(const WalkLight *light, const Rgb *lit);
// The lamps of a light that follows.
const Lamps *light_follower_lamps(const WalkLight *light);
// Frees what the follower keeps.
void light_end(WalkLight *light);

// ---- loading a building to walk through

// A building to walk through. All parts live as long as the arena they were loaded into.
typedef struct WalkScene {
    const LoadedScene *scene;
    const CellGraph *graph;
    const StabForest *forest;
    // Baked, or NULL.
    const WalkLight *light;
    // Bakes light in the background, or reads it, where its `bake` is not NULL and there is no light.
    LightBaker baker;
} WalkScene;

// Loads a building to walk through: stab trees, light, or a baker for it, where there is no light and all lamps were asked for
// (SCENE_LAMPS_ALL). `context` is a SceneOptions. After the first building its memory is asked for gently, for there is one to go on with.
bool walk_scene_load(void *context, const char *path, Arena *arena, WalkScene *out, Error *error);
// Turns the hour at which the next buildings are loaded: so many minutes on from that of the first. `shown` is one that was loaded; 0:
// loaded as at first, stored light and all. Tells the hour in `said` [size], and its day, all zeros by night. False, with a sentence, where
// no light is baked, or the sky has no hours. Light of other hours is not stored.
bool walk_scene_turn(void *context, const WalkScene *shown, int minutes, char *said, size_t size,
                     Daylight *day, Error *error);

#endif
