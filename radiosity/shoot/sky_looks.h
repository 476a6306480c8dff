// sky_looks.h - looks at the sky from elements and openings; for sky*.c alone.
#ifndef RADIOSITY_SKY_LOOKS_H
#define RADIOSITY_SKY_LOOKS_H

#include "radiosity/factors/form_factor.h"
#include "radiosity/factors/row.h"
#include "radiosity/factors/sampler.h"
#include "radiosity/shoot/sky.h"

// Light that comes in by an opening from a part of the sky, or from the ground, to an element: its power, for a radiance of 1 W/m^2/sr
// overhead or from the ground, is pi times the part's share.
typedef struct Incoming {
    int element;   // -1: backs
    bool ground;   // the part has no middle
    SkyPart part;  // its share in m^2
} Incoming;

typedef struct SkyOpening {
    int inside, outside;   // cells
    Plane plane;           // n points inside
    const Vec3 *vertices;  // [count] in CellGraph.portal_vertices
    int count;
    int first_piece, piece_count;
    // If looks are kept: what comes in, and the doors that it depends on, as in View.
    bool known;
    Arena kept;          // of `incoming`
    Incoming *incoming;  // [incoming_count]
    int incoming_count;
    uint64_t *doors;
} SkyOpening;

typedef struct SkyPiece {
    int opening;
    Vec3 centre;
    double area;  // m^2
} SkyPiece;

typedef struct SkyOpenings {
    SkyOpening *openings;  // [count]
    SkyPiece *pieces;      // [piece_count] opening after opening
    int count, piece_count;
} SkyOpenings;

// Pieces whose light is found at a time, and patches that look for the sky: a tenth of a second of one core, and then progress is
// told of.
enum { BATCH = 256, PATCH_BATCH = 4096 };
// The radiance of the sky over that overhead along each sample of views with one normal; 0 from below the horizon. It serves one patch
// or piece after the other as long as the normal is the same.
typedef struct SkyTable {
    Vec3 normal;
    double *relative;  // [samples]
} SkyTable;

// Where a line through an opening comes from.
enum { FROM_NOWHERE, FROM_SKY, FROM_GROUND, ORIGINS };

// One thread's tools.
typedef struct Watcher {
    Arena arena;
    Viewer *viewer;
    Sampler *inside, *outside;  // turned against each other: a line through both is a pixel of both
    Sampler *around;            // of elements outdoors
    int32_t *item;              // of any of them
    SkyTable behind, above;     // of `outside` and `around`
    unsigned char *origin;      // [samples] of `inside`: the origin of the light behind
    int32_t *lit;               // [samples] of `inside`: items of one origin
    int *met;                   // [samples] of `inside`: elements, if looks are kept
    struct Ray *rays;           // [samples] of `inside`, likewise
    float *weight;   // [samples] of `inside`, times the sky's radiance there, and what panes let through
    Panes panes[2];  // those before the look at hand, and those behind an opening's piece
    RowSum sum;
    FormFactorWork work;
    // If looks are kept.
    SkyCollector *collector;
    SkyPart *part;    // [SKY_PARTS_MOST]
    uint64_t *doors;  // those that the looks of a patch, or of a piece, depend on
    Arena kept;       // of Seen
} Watcher;

// The light of one origin that a piece sends in: of its power, for a radiance of `mean`, the shares of elements and backs.
typedef struct BeamPart {
    int count, *element;
    float *factor;
    double back, mean;
} BeamPart;

// Samples of one cell of the sky, or of the ground, that meet one element one after the other.
typedef struct Ray {
    int element, cell;  // element -1: backs; cell -1: the ground
    double share;       // of the view of a piece
    double light;       // times the radiance over that overhead
    Vec3 sum;           // of directions to the sky, times the share
} Ray;

typedef struct Beam {
    Arena arena;
    BeamPart parts[ORIGINS];
    // If looks are kept, instead of the parts.
    Ray *rays;  // [ray_count]
    int ray_count;
    uint64_t *doors;
} Beam;

// The hemisphere over an element, weighted by the cosine: the share that is sky, the same with the sky's radiance over that overhead, and
// the share that is ground beyond the building's.
typedef struct Seen {
    double open, sky, ground;
    SkyPart *part;  // [part_count] whose light is `sky`, if looks are kept
    int part_count;
} Seen;

typedef struct SkyLooks Shine;

struct SkyLooks {
    Arena arena;
    const Mesh *mesh;
    const StabForest *forest;
    const RadOptions *options;
    bool keep;
    int threads;
    SkyOpenings openings;
    FaceLines lines;
    Daylight day;     // under which light was found last
    double below[3];  // radiance of the ground
    bool ground;      // any of it is above 0
    bool *looks;      // [element_count] for the sky itself
    Seen *seen;       // [element_count] by those that look
    int *mirror;      // [samples] the pixel of `outside` opposite to one of `inside`, -1: none
    Watcher *watchers;
    Beam beams[BATCH];
    int first;  // piece or patch of the batch
    int *list;  // [piece_count] the pieces to look from
    // If looks are kept.
    bool *known;      // [patch_count] its elements have looked
    uint64_t *doors;  // [patch_count * door_words] that this depends on, as in View
    int door_words;
    size_t used;  // memory of Seen when it was tidied last, bytes
};

// ---- sky_kept.c

// Power on an element, for a radiance of 1.
void sky_receive(const Mesh *mesh, int element, double power, const double radiance[3],
                 RadSolution *solution);

// Rays of an opening, those of one element and one cell of the sky together, in the order in which they came.
typedef struct Gathered {
    Arena arena;
    Ray *rays;  // [count]
    int count, capacity;
    int *slot;  // [slots] an index of `rays`, -1
    int slots;  // a power of 2
} Gathered;
void sky_add_ray(Gathered *gathered, const Ray *ray);
// Stores what came in by an opening, of pieces of this area each, m^2; `gathered` begins anew.
void sky_end_opening(SkyOpening *opening, double area, const Daylight *day, Gathered *gathered);
// Adds what comes in by an opening to the light.
void sky_receive_incoming(const SkyLooks *looks, const Mesh *mesh, const SkyOpening *opening,
                          RadSolution *solution);
// Looks that were made under another day tell the light of this one.
void sky_turn_looks(SkyLooks *looks);

#endif
