// direct_points.h - light straight from lamps and the sun at the points of a mesh; for direct*.c alone.
#ifndef RADIOSITY_DIRECT_POINTS_H
#define RADIOSITY_DIRECT_POINTS_H

#include "engine/core/box_tree.h"
#include "radiosity/show/bends.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/lamp_ways.h"
#include "radiosity/show/sun_nodes.h"

// The irradiance that one source gives straight to a point, W/m^2 a channel.
typedef struct SourceLight {
    int source;
    float light[3];
} SourceLight;

// The sources of the light at a point.
typedef struct PointSources {
    int count;
    SourceLight by[];
} PointSources;

// Points whose light is known within an element, beyond its corners.
typedef struct Within {
    const BendPoint *points;  // [count] NULL: it does not bend
    const PointSources **by;  // [count] NULL: sources are not told apart
    int count;
    bool middle_known;
    double middle[3];  // irradiance at its centroid, W/m^2
    const PointSources *middle_by;
    bool looked;       // bends were looked for, and the light at the centroid found as for them:
    double seemed[3];  // irradiance, where some faces of a lamp may stand for all
} Within;

// Lamps of one object: Direct.lamp[first] and so on.
typedef struct LampObject {
    int object, first, count;
    int source;  // of all its faces, -1: several, or not known
    Box box;
} LampObject;

typedef struct Direct {
    const Mesh *mesh;
    const Nodes *nodes;
    BoxTree tree;  // of faces
    double *size;  // [face_count] m^2
    int *lamp;     // [lamp_count] faces that emit
    int lamp_count;
    Vec3 *place;  // of each vertex in Mesh.outline
    LampObject *lamp_objects;
    LampWays *ways;  // to lamp objects
    bool lamps;      // their light is looked for
    SunNodes *sun;   // NULL: there is none
    struct DirectGroup *groups;
    struct DirectBatch *batches;
    int lamp_object_count, group_count, batch_count, first;  // `first` batch of this look
    int threads;
    Arena arena;                   // of the workers
    struct DirectWorker *workers;  // [threads]
    double (*at_corner)[3];        // [corner_count]
    bool *known;                   // [corner_count] its light is in `at_corner`; NULL: none is
    // [corner_count] the way from a corner to the place towards which its point is moved, along gx and gy of its face, metres; NAN: as the
    // mesh has it (direct_corner_counts). NULL: all are.
    float (*towards)[2];
    bool *settled;  // [patch_count] all light of its corners is known
    // [patch_count * touched_words] a bit for each source whose light is to be found anew in a patch, while `corner_by` and `middle_by`
    // hold that of the others; NULL: all light is.
    uint64_t *touched;
    int touched_words;
    // [face_count] the source of each lamp's face; NULL: sources are not told apart. The sun is source `day`
    const int *source_of;
    int day;
    Arena *kept;                     // [threads] the caller's, of all PointSources
    const PointSources **corner_by;  // [corner_count] NULL: nothing
    // [element_count] other light, W/m^2; NULL: bends are not looked for
    const double *besides;
    Bend **bends;    // [element_count]
    Within *within;  // [element_count]
    // The same in another state of the doors, whose bends are known: they are looked for where the light differs. NULL: everywhere.
    const struct Direct *usual;
    // [element_count] the sources of the light at an element's centroid, found where `middle_wanted`; NULL: nowhere
    const PointSources **middle_by;
    const bool *middle_wanted;
    const Mesh *rough;  // the mesh within whose elements such centroids were found first; NULL: this one
} Direct;

// `day`: NULL: night.
void direct_start(Direct *d, const Mesh *mesh, const StabForest *forest, const Nodes *nodes,
                  const Daylight *day, Arena *arena);
// Patches times the faces of lamps that they may see.
double direct_pairs(const Direct *d);
// The irradiance at each node, into `out` [nodes->count] (NULL: it stays at the corners). Takes memory that direct_end frees. With
// Direct.besides bends are found, too. False where progress asked to stop.
bool direct_light(Direct *d, int threads, const Progress *progress, double (*out)[3], RadReport *report);
// May be called twice.
void direct_end(Direct *d);

// Doors have moved, to where they stand in the mesh: light is to be found anew in those patches alone to which light straight from a lamp
// or the sun of `day` may pass one of these doors. The others are settled, and so are their corners. To be called before direct_light.
// Where sources are told apart, of other patches only the light of those sources is found anew.
void direct_settle(Direct *d, const MovedDoors *moved, const Daylight *day, int threads);

// The place towards which the point of a corner is moved. False: another corner of the node has its light, which lies in one plane.
bool direct_corner_counts(const Direct *d, int element, int corner, Vec3 *towards);
// The way from a place in an element to where its point is moved towards, as Direct.towards has it: the place of a corner, or of no corner
// (-1), then it is the element's middle.
void direct_way(const Direct *d, int element, int corner, Vec3 from, float out[2]);
// Where no lamp is before a patch any more nothing is found anew: takes away what is to be found anew in a patch.
void direct_forget(const Direct *d, int patch, const PointSources **by);

// The light that each source gives at each node, into `out` [nodes->count], after direct_light and before direct_end.
// `anew`: leaves `out` as it is for nodes whose patches are all settled.
void direct_node_sources(const Direct *d, bool anew, const PointSources **out);

// Points of two meshes nearer than this are in one place, metres.
#define DIRECT_SAME_PLACE 1e-7
// The point in a place; NULL: none of them is.
static inline const BendPoint *direct_find_point(const BendPoint *points, int count, Vec3 at) {
    for (int i = 0; i < count; i++)
        if (vec3_length(vec3_sub(points[i].point, at)) < DIRECT_SAME_PLACE) return &points[i];
    return NULL;
}

#endif
