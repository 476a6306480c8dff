// direct.h - the light that comes straight from lamps and the sun's disc, exact at the points where light is shown: by closed form of the
// parts of both in sight.
#ifndef RADIOSITY_DIRECT_H
#define RADIOSITY_DIRECT_H

#include "engine/core/progress.h"
#include "radiosity/daylight/daylight.h"
#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"
#include "radiosity/show/reflected.h"

// The irradiance that the lamps of the mesh and the sun of the day (NULL: night) alone cause at each node, W/m^2 a channel, into `out`
// [nodes->count]. The same on any number of threads (0: all cores). False where progress asked to stop: `out` is then incomplete. The work
// is added to the fields direct_... of `report`, which may be NULL.
bool direct_irradiance(const Mesh *mesh, const StabForest *forest, const Nodes *nodes, const Daylight *day,
                       int threads, const Progress *progress, double (*out)[3], RadReport *report);

// The light that each source - a lamp, the day - gives to what is shown. Made before direct_show, which tells them apart: source_of
// [face_count] is the source of each face that emits; source `day` is the sun. Lives in the arena, but for memory that direct_sources_end
// frees.
typedef struct DirectSources DirectSources;
DirectSources *direct_sources_new(const int *source_of, int day, int threads, Arena *arena);
void direct_sources_end(DirectSources *sources);
// The same, but for the mesh that shows the light and its nodes, which live on in the arena returned.
Arena direct_sources_leave(DirectSources *sources);
// Doors will move: what shows the light is to be as fine as light in each of these states of the doors asks for, `state` [count], each
// [opening_count]. Before direct_show_apart, which moves the doors of `mesh` there and back.
void direct_sources_doors(DirectSources *sources, Mesh *mesh, const float *const *state, int count);
// Finds the light straight from lamps alone, as `sources` show it on a mesh of its own, for the hours of a day; as fine as it is seen in
// the light of a solution. False where progress asked to stop.
bool direct_show_lamps(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                       const Progress *progress, const RadSolution *solution, DirectSources *sources);
// The hour will turn (NULL, NULL); or it turns now: light straight from lamps is taken from that of direct_show_lamps, and rows of parts
// from the sources `before`. Doors of both stand where those of the mesh do. Before direct_show_apart, until the end of which `before` must
// last; the lamps must outlive the sources.
void direct_sources_turn(DirectSources *sources, const DirectSources *lamps, const DirectSources *before);
// After direct_show_apart: doors of the mesh have moved (mesh_move), to `to`. Finds anew what light straight from the
// sources may pass them, and drops rows that may see them. Returns the number of points found anew.
long long direct_sources_move(DirectSources *sources, const MovedDoors *moved, const float *to);
// The mesh that shows the light, with its doors where they are now.
const Mesh *direct_sources_shown(const DirectSources *sources);
// And its nodes.
const Nodes *direct_sources_nodes(const DirectSources *sources);

// Stores the light at each node of a finer mesh in solution->node, and the splits of that mesh in solution->shown, allocated in the
// arena: exact light straight from lamps and the sun of solution->day, and all other light as the elements tell it. Elements are halved
// where this exact light bends in them (bends.h). Where lamps are so many that exact light would take too long (DIRECT_MOST_PAIRS), their
// light stays as the elements tell it. The solution is unchanged where there is then neither lamp nor sun, and where progress asked to
// stop: then the result is false.
bool direct_show(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                 const Progress *progress, Arena *arena, RadSolution *solution, RadReport *report);
// The same, and what each source gives goes into `sources` (NULL: nowhere). `borders`: the mesh is of a part of the building, and each
// member calls this; light is then found at the nodes of its own faces. NULL: of the whole building.
bool direct_show_apart(const Mesh *mesh, const StabForest *forest, const float *door_open, int threads,
                       const Progress *progress, Arena *arena, RadSolution *solution, DirectSources *sources,
                       const Borders *borders, RadReport *report);

// The same for a state of the sources, on the same nodes: `solution`, gathered, is the light of that state, `lit` the mesh in it, and
// `share` [sources] what each source sends of its full light. If the day shines, the first call is one in which it does. Sums of states
// are the light of sums.
bool direct_show_source(DirectSources *sources, double (*share)[3], const Mesh *lit, const Progress *progress,
                        Arena *arena, RadSolution *solution);

// The same for one light after another: only what differs from the light before is found anew. `changed`: the patches of the mesh whose
// other light differs; NULL: there was no light before, or all of it differs. Doors may have moved meanwhile (direct_sources_move).
bool direct_show_next(DirectSources *sources, double (*share)[3], const Mesh *lit, const Marks *changed,
                      const Progress *progress, Arena *arena, RadSolution *solution);

// Only the light straight from the sources in a state of theirs; all other light is that of `before`, which was shown on these nodes in the
// same state of the lamps. `out` shares with it all but the light at nodes. `last`: `before` is the light that direct_show_next showed
// last.
void direct_show_straight(DirectSources *sources, double (*share)[3], const RadSolution *before, bool last,
                          Arena *arena, RadSolution *out);

// A building with more pairs of a patch and a face of a lamp that the patch may see keeps the light of lamps as it was shot: more than so
// many, and more than so many for each patch, since large buildings have more of both. A patch of a generated campus has 40 to 50.
#define DIRECT_MOST_PAIRS 20e6
#define DIRECT_PAIRS_A_PATCH 100

#endif
