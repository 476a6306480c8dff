// bake_probes.h - the light at points that somebody asks about.
#ifndef APP_BAKE_PROBES_H
#define APP_BAKE_PROBES_H

#include <jansson.h>

#include "radiosity/show/gather.h"

typedef struct Probe {
    Vec3 place, normal;    // unit
    double irradiance[3];  // W/m^2 a channel
    double radiosity[3];   // of the face it lies on, seen from its front; 0 where it lies on none
} Probe;

typedef struct Probes {
    Probe *probes;
    int count, capacity;
} Probes;

// X,Y,Z,NX,NY,NZ of one probe.
bool bake_probe_parse(const char *text, Arena *arena, Probes *out, Error *error);
// A file of them, a line each, numbers with commas or spaces between; `#` begins a remark. Of a .quads file, its points.
bool bake_probes_read(const char *path, Arena *arena, Probes *out, Error *error);

// Gathers the light of the elements that each point sees, by an exact row of form factors for each point: a sliver of a lamp in a
// doorway's corner may give a third of the light that arrives at a point. On so many threads, 0: all cores; the light is the same.
void bake_probes_gather(const GatherScene *scene, int threads, Probes *probes);

void bake_probes_print(const Probes *probes);  // x y z nx ny nz HR HG HB BR BG BB, a line each
json_t *bake_probes_json(const Probes *probes);

#endif
