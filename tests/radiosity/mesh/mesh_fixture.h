// mesh_fixture.h - what holds of every mesh.
#ifndef TESTS_MESH_FIXTURE_H
#define TESTS_MESH_FIXTURE_H

#include "radiosity/mesh/mesh.h"
#include "tests/support/support.h"

// A graph of polygons alone: what the mesh needs of one where no cells are asked for.
typedef struct Sheets {
    Arena arena;
    Building building;
    CellGraph graph;
    Mesh mesh;
} Sheets;

void mesh_check_mesh(const Mesh *mesh, const Vec3 *vertices);

#endif
