// direct_points.h - light straight from lamps and the sun at the points of a mesh; for direct.c alone.
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
} Within;

// Lamps of one object: Direct.lamp[first] and so on.
typedef struct LampObject {
    int object, first, count;
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
    bool *settled;                 // [patch_count] all light of its corners is known
    // [face_count] the source of each lamp's face; NULL: sources are not told apart. The sun is source `day`
    const int *source_of;
    int day;
    Arena *kept;                     // [threads] the caller's, of all PointSources
    const PointSources **corner_by;  // [corner_count] NULL: nothing
    // [element_count] other light, W/m^2; NULL: bends are not looked for
    const double *besides;
    Bend **bends;    // [element_count]
    Within *within;  // [element_count]
} Direct;

// `day`: NULL: night.
void direct_start(Direct *d, const Mesh *mesh, const StabForest *forest, const Nodes *nodes,
                  const Daylight *day, Arena *arena);
// Patches times the faces of lamps that they may see.
double direct_pairs(const Direct *d);
// The irradiance at each node, into `out` [nodes->count]. Takes memory that direct_end frees. With Direct.besides bends are found, too.
// False where progress asked to stop.
bool direct_light(Direct *d, int threads, const Progress *progress, double (*out)[3], RadReport *report);
// May be called twice.
void direct_end(Direct *d);

// The place towards which the point of a corner is moved. False: another corner of the node has its light, which lies in one plane.
bool direct_corner_counts(const Direct *d, int element, int corner, Vec3 *towards);
// The light that each source gives at each node, into `out` [nodes->count], after direct_light and before direct_end.
void direct_node_sources(const Direct *d, const PointSources **out);

// Points of two meshes nearer than this are in one place, metres.
#define DIRECT_SAME_PLACE 1e-7
// The point in a place; NULL: none of them is.
static inline const BendPoint *direct_find_point(const BendPoint *points, int count, Vec3 at) {
    for (int i = 0; i < count; i++)
        if (vec3_length(vec3_sub(points[i].point, at)) < DIRECT_SAME_PLACE) return &points[i];
    return NULL;
}

#endif
