// direct_sources.h - the light that each source gives to what is shown; for direct.c and direct_turn.c alone.
#ifndef RADIOSITY_DIRECT_SOURCES_H
#define RADIOSITY_DIRECT_SOURCES_H

#include "radiosity/show/direct_points.h"

// Light that is shown: the solution on `mesh`, its light but that straight from lamps and sun, and reflected light where that is gathered
// (rest.gathered); the mesh that shows it, and the elements that gather reflected light in their parts.
typedef struct Showing {
    const Mesh *mesh;
    const StabForest *forest;
    const float *door_open;
    const RadSolution *solution, *rest;
    const Mesh *shown;
    ReflectedParts parts;
    bool lamps;  // their light is known at the nodes
    int threads;
    const Progress *progress;
    DirectSources *sources;  // or NULL
    const Borders *borders;  // or NULL
    Arena *
        of_mesh;  // what light straight from lamps and sun was found with on `mesh`: it goes once the finer mesh has it
    double (*reflected)[3];  // [nodes] where to put the reflected light, NULL: it is not asked for
} Showing;

// The light that each source gives straight to what is shown, as one pass over the lamps of all has found it; and all that the light of
// one source needs to be shown likewise.
struct DirectSources {
    Arena arena;
    Arena *kept;  // [threads] of PointSources
    const int *source_of;
    int day, threads;
    Showing show;       // of all light
    const Mesh *shown;  // the mesh that shows it
    Mesh *finer;        // the same where it is not the mesh of the elements, NULL
    Nodes nodes;        // of that
    PartRows parts;
    const PointSources **node;    // [nodes.count]
    const PointSources **corner;  // [corners that show the light]
    float (*way)
        [2];  // the same, as Direct.towards; NULL: doors do not move, or the mesh is that of the elements
    const PointSources **middle;  // [elements that show the light]
    bool *middle_known;           // [elements that show the light]
    bool *lifts;                  // [elements that show the light] its nodes are lifted
    float *besides;  // [elements that show the light] other light, against which lifts are seen, W/m^2
    size_t used;     // memory of `kept` when it was tidied last, bytes
    Mesh *moving;    // NULL: doors do not move
    const float *const *state;  // [state_count] of doors
    int state_count;
    Daylight weather;  // the day that shone
    Bend **
        bends;  // [show.mesh->element_count] of lamps alone that are asked for it (direct_show_lamps), or NULL
    int *triangle;  // of these: of the elements of `shown`
    // Lamps whose light is known on a mesh of their own: it is as that mesh shows it. NULL: it is found.
    const DirectSources *lamps;
    struct ShownLast *last;  // NULL: no light was shown by direct_show_next
};

// The light that was shown last, [nodes.count] each, W/m^2.
typedef struct ShownLast {
    bool there;             // all of it is known
    double (*share)[3];     // [sources]
    double (*unlifted)[3];  // irradiance straight from the sources, as it is at the nodes
    double (*straight)[3];  // the same, lifted
    double (*reflected)[3];
    double (*rest)[3], (*all)[3];  // radiosities, as in RadSolution
    // Nodes whose sources were found anew since `straight` was; whose straight light was since `all` was; all that were just now.
    Marks moved, lifted, found;
    Marks lifts;  // [elements that show the light] around those that moved
} ShownLast;

// ---- direct_turn.c, where s->lamps tell the light of lamps

// After direct_light of the sun alone: adds the light of lamps at the corners of a mesh, `by` [corner_count], where they count
// (direct_corner_counts). `nodes`: of the mesh.
void direct_turn_corners(const DirectSources *s, const Mesh *mesh, const Nodes *nodes,
                         const PointSources **by);
// One thread's sums.
typedef struct SourceSums SourceSums;
SourceSums *source_sums_new(const DirectSources *s, Arena *arena);
// Adds to the sun's light at the middle of an element of `shown`, `by`, that of lamps, once all is known at the nodes. `sun_known`: false:
// it is that between the nodes. False: light is not known there.
bool direct_turn_middle(const DirectSources *s, SourceSums *sums, const Mesh *shown, const Nodes *nodes,
                        int element, bool sun_known, const PointSources **by);

#endif
