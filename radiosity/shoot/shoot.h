// shoot.h - progressive refinement: the patch with most unshot power shoots, until little is left (Cohen, Chen, Wallace &
// Greenberg 1988).
#ifndef RADIOSITY_SHOOT_H
#define RADIOSITY_SHOOT_H

#include <stdint.h>

#include "engine/core/progress.h"
#include "engine/core/sets.h"
#include "radiosity/daylight/daylight.h"
#include "radiosity/factors/form_factor.h"
#include "radiosity/mesh/borders.h"
#include "radiosity/shoot/lamp_light.h"

typedef struct RadSolution RadSolution;
typedef struct ShootRows ShootRows;  // shoot_rows.h
typedef struct SkyLooks SkyLooks;    // sky.h

// How light is shot, and when to stop.
typedef struct RadOptions {
    const FormFactorMethod *method;
    FormFactorOptions form_factor;
    Culling culling;
    bool lamps_only;  // only emitted light is shot, no reflected light
    bool gather;  // once reflected light is shot, patches gather it along their rows (RadSolution.reflected)
    // Patches that emit shoot at the resolution times this factor, which is reduced where there are very many (shoot_rows.c).
    int lamp_detail;
    // Elements within this many radii of a patch are lit from the whole patch instead of its centre (near_pairs.h); 0: none.
    double reach;
    double residual;  // stop when unshot power is this share of the emitted power, 0 .. 1
    bool
        each_room;  // and this share of the light of each room (room_shares.h); light that goes on does not ask
    long long shots;  // or when the solution has this many shots, 0: no limit
    // Or when the faces before the patches that shot sum to this number (shoot.c), 0: no limit.
    double looks;
    int threads;       // 0: all cores; the result is the same on any number
    size_t row_bytes;  // rows kept for shooters that shoot again; does not change the result
    // The rows of this mesh, the caller's, who goes on with them: the next light is shot along the same rows. NULL: rad_shoot makes its
    // own. Once light was gathered along them it is known which patches are strong, and which are noisy.
    ShootRows *rows;
    // Looks at the sky from this mesh, the same way; NULL: rad_shine looks anew.
    SkyLooks *sky;
    // The mesh is that of a part of the building (MeshOptions.part): light of all parts is found side by side, each by a member of a team.
    // Sums of power, and what was stopped, are those of all. Then `shots` is not asked. NULL: the mesh is that of the whole building.
    const Borders *borders;
    // Called with the solution so far, between shots, by the thread that shoots, whenever `show_due` returns true; NULL: never. Of parts:
    // by each member at one moment, where that of any member returns true, and when they stop; a member that begins with such a solution
    // goes on as it would have.
    void (*show)(void *context, const RadSolution *so_far);
    bool (*show_due)(void *context);
    void *show_context;
    // The caller's clock, seconds, called from all threads; it measures RadReport.seconds_visibility. NULL: that field stays 0.
    double (*clock)(void);
} RadOptions;
// The hemisphere method, culling by stab trees, a residual of a thousandth, 128 MB of rows.
RadOptions rad_default_options(void);
// Faces of things whose rectangles along their grids are smaller than this, m^2, have the reflected light that was shot to them, not
// gathered light: homes have tens of thousands of them.
#define RAD_SMALL 0.0025
// Memory for rows as fits a mesh and the machine, for rad_fit to replace.
#define RAD_ROWS_FIT SIZE_MAX
// Replaces a residual of 0 by 1e-4, and a resolution of 0 by one that suits the mesh: with few patches, light is found more exactly. And
// replaces RAD_ROWS_FIT by 128 MB, and more for a large mesh, but no more than an eighth of the memory of the machine.
void rad_fit(const Mesh *mesh, RadOptions *options);

// Radiosities in W/m^2 (radiant exitance), one value a channel: r, g, b. rad_shoot writes the solution in its caller's thread;
// between two calls any number of threads may read it. It lives in the arena of rad_start or rad_load.
struct RadSolution {
    int element_count, patch_count;
    // [element_count] B = E + the reflected part of the light that has arrived so far
    double (*radiosity)[3];
    // [element_count] the part of `radiosity` that came straight from lamps, as it was shot; the light of the sky is not in it.
    double (*direct)[3];
    // [element_count] the part of `radiosity` that came straight from sun and sky; NULL on a mesh that only shows light, like `sun`
    double (*daylight)[3];
    // [patch_count] if `gathered`: the irradiance by reflected light and by sky and ground, gathered along each patch's row once the light
    // is shot. An element has few samples of each shot, and errs with them; a row has all its samples for this one sum. A .rad file does
    // not hold it.
    double (*reflected)[3];
    // [element_count] if `gathered`: the part of `daylight` that came straight from the sun
    double (*sun)[3];
    // [patch_count] if `gathered`: the part of `reflected` that comes from strong patches, which send it along their own rows; and which
    // patches are strong (shoot_rows.h)
    double (*sent)[3];
    bool *strong;
    // [patch_count] if `gathered`: the share of the row that meets surfaces closer than the patch is wide
    float *close;
    // [patch_count] if `gathered`: the share by which the samples of a row of the usual resolution may miscount
    // the light, about
    float *noise;
    bool gathered;
    double (*unshot)[3];  // [patch_count] the part of `radiosity` that was not shot yet, mean over the patch
    double (*shot)
        [3];  // [patch_count] what was shot of it along the patch's row, without what lamps emit. A .rad file does not hold it.
    // Power, W a channel: emitted = absorbed + escaped + unshot but for rounding.
    double emitted[3], absorbed[3], escaped[3];
    Daylight day;        // the day that shone (sky.h); its light that came in counts as `emitted`
    double outdoors[3];  // the part of `emitted` that sky and sun sent to surfaces outdoors, W
    long long shots;
    // [node_count] radiosity found at the nodes (direct.h, final_gather.h) of the mesh that shows the light, in the order of nodes_of;
    // NULL and 0: not found.
    double (*node)[3];
    // [node_count] the part of it that comes neither straight from lamps nor from the sun, emission included; NULL: not known apart
    double (*rest)[3];
    int node_count;
    MeshSplits *shown;  // of the mesh that shows the light (shown.h); NULL: it is the mesh of the elements
    // The state of the lamps under which all this is the light (lamps.h), [lamp_count]; 0 and NULL: all are fully lit.
    const Rgb *lit;
    int lamp_count;
    // The light of each source by itself, [lamp_count] of lamps, then that of the day if it shines; NULL: not known. All other fields are
    // their sum.
    const LampLight *each;
    int each_count;
};

// The work that was done.
typedef struct RadReport {
    double residual;  // unshot power / emitted power, all channels; under a sky, see residual_of in shoot.c
    long long shots, rows_made, rows_kept;
    double faces_drawn_mean, elements_drawn_mean;  // of rows made
    double seconds_visibility;                     // of all threads, by the caller's clock
    size_t row_bytes;
    // By direct_show: points, faces of lamps in front of points, and those that other faces may cut.
    long long direct_points, direct_pairs, direct_cut;
    bool stopped;  // by `progress`, which is asked every few shots and may enforce a time limit
} RadReport;

// A solution with the emitted light, in which nothing was shot. Fails where nothing emits light, or a reflectance is not in [0, 1).
bool rad_start(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error);
// Like rad_start, but does not fail where nothing emits light: the sky may shine.
bool rad_start_dark(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error);
// Shoots on from `solution`, which is valid whenever rad_shoot returns.
RadReport rad_shoot(const Mesh *mesh, const StabForest *forest, const float *door_open,
                    const RadOptions *options, const Progress *progress, RadSolution *solution);

// ---- light that goes on from another state of the doors

// Light that goes on, and what it has gathered so far.
typedef struct RadFollow {
    bool *again;         // [patch_count] lamps whose emitted light was taken back
    double (*taken)[3];  // [patch_count] the reflected light that was taken back of what a patch shot, W/m^2
    // A patch gathers its reflected light again if its row was dropped since, or its light has changed: [patch_count]; and [element_count]
    // the radiosities that there were when their patches gathered
    bool *dropped;
    double (*gathered)[3];
    Marks found;  // patches that gathered just now; limit patch_count
} RadFollow;
// Before shoot_rows_move: takes back what patches have shot along rows of options->rows that depend on a door that moves. The light of
// others may be negative from now on (Chen 1990). False where a row is not there any more; then nothing has changed.
bool rad_take_back(const Mesh *mesh, const RadOptions *options, const MovedDoors *moved,
                   RadSolution *solution, RadFollow *follow);
// Shoots on after rad_take_back and shoot_rows_move: first all that was taken back, so that what others are left with is the difference
// between the old rows and the new ones; then what is unshot, until its absolute power is options->residual of the light.
// solution->reflected is what patches have gathered so far. Else like rad_shoot.
RadReport rad_shoot_on(const Mesh *mesh, const StabForest *forest, const float *door_open,
                       const RadOptions *options, RadFollow *follow, const Progress *progress,
                       RadSolution *solution);

// Writes a .rad file. The mesh is not stored: it is made again from the building. The file holds the building's hash, the mesh's
// options and the doors' states, and rad_load refuses the file where they differ.
bool rad_save(const char *path, const Mesh *mesh, const float *door_open, const RadSolution *solution,
              Error *error);
// Fails, with a message in `error`, where the file is damaged or of another building, mesh or state of the doors.
bool rad_load(const char *path, const Mesh *mesh, const float *door_open, Arena *arena, RadSolution *out,
              Error *error);
// Reads the options of the file's mesh, from which the mesh can be made, and the states of the doors, `door_open` [opening_count].
bool rad_load_options(const char *path, const Building *building, Arena *arena, MeshOptions *out,
                      float *door_open, Error *error);
// The checksum of a file's light, as its header says: what was made from the file and stored tells by it whether it is of the same light.
bool rad_checksum(const char *path, const Building *building, uint64_t *out, Error *error);
// The day under which a file's light was made; all zeros: by night. Only the file's header is read: rad_load may find damage in the rest.
bool rad_load_day(const char *path, const Building *building, Daylight *out, Error *error);

#endif
