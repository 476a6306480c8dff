// patch_oracle.h - all hits of a ray with a patch, by other means: a dense grid of points, and Newton's steps in long doubles
// from each of its cells that the ray may pass. Knows nothing of clipping.
#ifndef TESTS_PATCH_ORACLE_H
#define TESTS_PATCH_ORACLE_H

#include "maps/building/building.h"
#include "visibility/bezier/ray.h"

enum { ORACLE_ROOTS = 64 };

typedef struct OracleRoot {
    double u, v, t;
    bool
        sure;  // neither at a fold or beside another root, where roots may be double, nor at the patch's border
} OracleRoot;

typedef struct PatchOracle PatchOracle;
PatchOracle *patch_oracle_new(const Building *building, int cells, Arena *arena);
double patch_oracle_size(const PatchOracle *oracle);
// The point, and the derivatives (may be NULL).
Vec3 patch_oracle_point(const PatchOracle *oracle, double u, double v, Vec3 *du, Vec3 *dv);
// Roots within the patch, wherever along the line. Trims are not looked at.
int patch_oracle_roots(const PatchOracle *oracle, const Ray *ray, OracleRoot out[ORACLE_ROOTS]);
// Newton's steps from u, v: false where they lead to no root within the patch.
bool patch_oracle_refine(const PatchOracle *oracle, const Ray *ray, double u, double v, OracleRoot *out);

#endif
