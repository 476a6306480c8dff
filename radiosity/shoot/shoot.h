// shoot.h - progressive refinement: the patch with most unshot power shoots, until little is left (Cohen, Chen, Wallace &
// Greenberg 1988).
#ifndef RADIOSITY_SHOOT_H
#define RADIOSITY_SHOOT_H

#include "engine/core/progress.h"
#include "radiosity/factors/form_factor.h"

typedef struct RadSolution RadSolution;

// How light is shot, and when to stop.
typedef struct RadOptions {
    const FormFactorMethod *method;
    FormFactorOptions form_factor;
    Culling culling;
    bool lamps_only;  // only emitted light is shot, no reflected light
    int lamp_detail;  // patches that emit shoot at so many times the resolution, unless they are very many (shoot_rows.c)
    double reach;  // elements within so many radii of a patch are lit from all of it, not its centre; 0: none
    double residual;   // stop when unshot power is this share of the emitted power, 0 .. 1
    long long shots;   // or when the solution has so many, 0: no limit
    double looks;      // or when patches had so many faces before them (shoot.c), all told, 0: no limit
    int threads;       // 0: all cores; the result is the same on any number
    size_t row_bytes;  // rows kept for shooters that shoot again; does not change the result
    // Receives the solution so far, between shots, from the thread that shoots, whenever `show_due` says that it is wanted; or NULL.
    void (*show)(void *context, const RadSolution *so_far);
    bool (*show_due)(void *context);
    void *show_context;
    // The caller's clock, seconds, called from all threads; measures `seconds_visibility`. NULL: that stays 0.
    double (*clock)(void);
} RadOptions;
// Hemisphere, portals, to a thousandth, 128 MB of rows.
RadOptions rad_default_options(void);
// Replaces a residual or a resolution of 0 by one that fits a mesh: where there are few patches, light may be found more exactly.
void rad_fit(const Mesh *mesh, RadOptions *options);

// Radiosities in W/m^2 (radiant exitance), one value a channel: r, g, b. rad_shoot alone writes it, in its caller's thread; between two
// calls any number of threads may read. It lives in the arena of rad_start or rad_load.
struct RadSolution {
    int element_count, patch_count;
    double (*radiosity)[3];  // [element_count] B = E + what is reflected of what has arrived so far
    double (*unshot)[3];  // [patch_count] mean of the patch, of which `radiosity` knows but nothing else yet
    // Power, W a channel: emitted = absorbed + escaped + unshot but for rounding.
    double emitted[3], absorbed[3], escaped[3];
    double
        sky[3];  // radiance of the sky that shone (sky.h), W/m^2/sr; its light that came in counts as emitted
    double outdoors[3];  // the part of `emitted` that the sky sent to surfaces outdoors, W
    long long shots;
    // Radiosity gathered at nodes (final_gather.h), [node_count] in their order (nodes.h); NULL, 0: not gathered.
    double (*node)[3];
    int node_count;
};

// The work that was done.
typedef struct RadReport {
    double residual;  // unshot power / emitted power, all channels; under a sky, see residual_of in shoot.c
    long long shots, rows_made, rows_kept;
    double faces_drawn_mean, elements_drawn_mean;  // of rows made
    double seconds_visibility;                     // of all threads, by the caller's clock
    size_t row_bytes;
    bool stopped;  // by `progress`, which is asked every few shots and may hold a limit of time
} RadReport;

// The emitted light, nothing shot. Fails where there is no light, or a reflectance is not in [0, 1).
bool rad_start(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error);
// The same, but nothing needs to emit light: the sky may shine.
bool rad_start_dark(const Mesh *mesh, Arena *arena, RadSolution *out, Error *error);
// Goes on from `solution`, which is valid whenever it stops.
RadReport rad_shoot(const Mesh *mesh, const StabForest *forest, const float *door_open,
                    const RadOptions *options, const Progress *progress, RadSolution *solution);

// The .rad file. The mesh is made again from the building; the file holds the building's hash, the mesh's options and
// the doors' states, and is refused where they differ.
bool rad_save(const char *path, const Mesh *mesh, const float *door_open, const RadSolution *solution,
              Error *error);
// False, and a sentence, where the file is damaged or of another building, mesh or state of the doors.
bool rad_load(const char *path, const Mesh *mesh, const float *door_open, Arena *arena, RadSolution *out,
              Error *error);
// Reads from a file how its mesh was made, before there is one, and how the doors stood, [opening_count].
bool rad_load_options(const char *path, const Building *building, Arena *arena, MeshOptions *out,
                      float *door_open, Error *error);

#endif
