// mesh_squares.c - cuts a face along its grid: a rectangle into nx x ny equal parts, another convex polygon into squares clipped at
// its outline, where slivers are joined to their neighbours (Cohen & Wallace 1993, chapter 6: elements of even size and good shape).
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh_cutting.h"

// A part of a square is a sliver below this share of the square: it would receive too few samples to tell its light.
static const double SLIVER = 0.15;
// Below this share it is rounding.
static const double NOTHING = 1e-9;

// ---- parts of a face

// The part of the face in a block, in c->part; returns how many corners it has.
static int part_in(MeshCutting *c, MeshBlock b) {
    const Face *face = c->face;
    int count = c->count;
    memcpy(c->part, c->outline, (size_t)count * sizeof *c->part);
    // The planes are in units of squares. No cuts along the grid's border, which only rounding could tell from edges.
    const struct {
        bool cut;
        Plane keep;
    } side[4] = {{b.i0 > 0, {face->gx, b.i0}},
                 {b.i1 + 1 < face->nx, {vec3_scale(face->gx, -1), -(b.i1 + 1)}},
                 {b.j0 > 0, {face->gy, b.j0}},
                 {b.j1 + 1 < face->ny, {vec3_scale(face->gy, -1), -(b.j1 + 1)}}};
    for (int k = 0; k < 4; k++) {
        if (!side[k].cut) continue;
        count = polygon_clip(c->part, count, side[k].keep, 0, c->spare);
        Vec3 *swap = c->part;
        c->part = c->spare;
        c->spare = swap;
    }
    return count;
}

static double whole_of(const MeshCutting *c, MeshBlock b) {
    return c->square * (b.i1 + 1 - b.i0) * (b.j1 + 1 - b.j0);
}

static void give(MeshCutting *c, MeshBlock b, int leaf) {
    for (int j = b.j0; j <= b.j1; j++)
        for (int i = b.i0; i <= b.i1; i++) c->owner[j * c->face->nx + i] = leaf;
}

static void measure_parts(MeshCutting *c) {
    for (int k = 0; k < c->leaf_count; k++) {
        MeshLeaf *leaf = &c->leaves[k];
        int count = part_in(c, leaf->block);
        double area = count < 3 ? 0 : polygon_area(c->part, count);
        leaf->area = area < NOTHING * c->square ? 0 : area;
        give(c, leaf->block, k);
    }
}

// The leaf beyond one side of a block if the two make a larger block, else -1.
static int beyond(const MeshCutting *c, MeshBlock b, int side) {
    int i = side == 0 ? b.i0 - 1 : side == 1 ? b.i1 + 1 : b.i0;
    int j = side == 2 ? b.j0 - 1 : side == 3 ? b.j1 + 1 : b.j0;
    if (i < 0 || j < 0 || i >= c->face->nx || j >= c->face->ny) return -1;
    int owner = c->owner[j * c->face->nx + i];
    MeshBlock other = c->leaves[owner].block;
    bool fits = side < 2 ? other.j0 == b.j0 && other.j1 == b.j1 : other.i0 == b.i0 && other.i1 == b.i1;
    return fits && c->leaves[owner].area > 0 ? owner : -1;
}

// Joins a sliver to the largest neighbour with which it makes a block, one of its own patch first: what a block cuts
// out of a convex polygon is convex.
static bool join_squares(MeshCutting *c, int at) {
    MeshLeaf *leaf = &c->leaves[at], *best = NULL;
    for (int side = 0; side < 4; side++) {
        int index = beyond(c, leaf->block, side);
        if (index < 0) continue;
        MeshLeaf *other = &c->leaves[index];
        bool own = other->patch == leaf->patch, best_own = best && best->patch == leaf->patch;
        if (!best || (own && !best_own) || (own == best_own && other->area > best->area)) best = other;
    }
    if (!best) return false;
    MeshBlock a = leaf->block, b = best->block;
    MeshLeaf *keep = leaf->area > best->area ? leaf : best, *drop = keep == leaf ? best : leaf;
    keep->area += drop->area;
    drop->area = 0;
    keep->block = (MeshBlock){a.i0 < b.i0 ? a.i0 : b.i0, a.j0 < b.j0 ? a.j0 : b.j0, a.i1 > b.i1 ? a.i1 : b.i1,
                              a.j1 > b.j1 ? a.j1 : b.j1};
    give(c, keep->block, (int)(keep - c->leaves));
    c->merged++;
    return true;
}

static void join_slivers(MeshCutting *c) {
    for (bool joined = true; joined;) {
        joined = false;
        for (int k = 0; k < c->leaf_count; k++) {
            const MeshLeaf *leaf = &c->leaves[k];
            if (leaf->area > 0 && leaf->area < SLIVER * whole_of(c, leaf->block) && join_squares(c, k))
                joined = true;
        }
    }
}

static void find_pieces(MeshCutting *c) {
    c->first_piece = ARENA_ARRAY(c->arena, int, c->leaf_count + 1);
    for (int k = 0; k < c->leaf_count; k++) {
        MeshPiece own[MESH_MOST_PIECES];
        int corners = c->leaves[k].area > 0 ? part_in(c, c->leaves[k].block) : 0;
        int pieces =
            corners >= 3 ? mesh_cut_pieces(c->builder, c->index, c->part, corners, c->arena, own) : 0;
        c->first_piece[k] = c->piece_count;
        for (int i = 0; i < pieces; i++)
            *ARENA_PUSH(c->arena, c->pieces, c->piece_count, c->piece_capacity) = own[i];
    }
    c->first_piece[c->leaf_count] = c->piece_count;
}

// ---- all faces

// So many at a time: their grids follow each other in the splits, and their elements are numbered in order. While one thread numbers
// those of a batch, the others cut the next one.
enum { FACES_AT_A_TIME = 4096, SQUARES_AT_A_TIME = 1 << 17 };
// There may be so many of all faces: what is cut is searched on small ones.
static const double MOST_SQUARES = 5e8;

typedef struct Batch {
    MeshCutting *cutting;  // [FACES_AT_A_TIME]
    int count;
    Arena arena, *arenas;  // [threads]
} Batch;

typedef struct Crew {
    MeshBuilder *builder;
    const Vec3 *points;  // of outlines: those of elements are added behind them
    Batch batches[2], *cut, *numbered;
    int threads, begun;  // faces
} Crew;

// Returns how many squares it has.
static int begin_face(MeshBuilder *builder, int index, Arena *arena, MeshCutting *c) {
    Face *face = &builder->mesh->faces[index];
    int most_leaves = face->nx * face->ny;  // of squares that are finer still, each is in one
    mesh_refine_grid(builder, index, face);
    *c = (MeshCutting){.builder = builder, .index = index, .face = face};
    c->is_cut = builder->first_cut[index + 1] > builder->first_cut[index];
    c->square = 1 / (vec3_length(face->gx) * vec3_length(face->gy));
    int squares = face->nx * face->ny;
    c->leaves = ARENA_ARRAY(arena, MeshLeaf, most_leaves);
    c->owner = ARENA_ARRAY(arena, int, squares);
    c->leaf_count = mesh_leaves(builder, face, c->leaves);
    c->element = ARENA_ARRAY(arena, int, c->leaf_count);
    c->code = ARENA_ARRAY(arena, int, c->leaf_count);
    return squares;
}

static void begin_batch(Crew *crew, Batch *batch) {
    const Mesh *mesh = crew->builder->mesh;
    arena_reset(&batch->arena);
    for (int t = 0; t < crew->threads; t++) arena_reset(&batch->arenas[t]);
    batch->count = 0;
    for (int squares = 0; crew->begun < mesh->face_count && batch->count < FACES_AT_A_TIME;) {
        if (squares > SQUARES_AT_A_TIME) break;
        squares += begin_face(crew->builder, crew->begun++, &batch->arena, &batch->cutting[batch->count++]);
    }
}

static void cut_face(const Crew *crew, MeshCutting *c, Arena *arena) {
    const Face *face = c->face;
    c->arena = arena;
    Vec3 *outline = ARENA_ARRAY(c->arena, Vec3, face->vertex_count);
    for (int i = 0; i < face->vertex_count; i++) {
        int place = c->builder->mesh->outline[face->first_vertex + i];
        outline[i] = vec3_sub(crew->points[place], face->origin);
    }
    c->outline = outline;
    c->count = face->vertex_count;
    c->part = ARENA_ARRAY(c->arena, Vec3, c->count + 8);
    c->spare = ARENA_ARRAY(c->arena, Vec3, c->count + 8);
    measure_parts(c);
    join_slivers(c);
    find_pieces(c);
}

// Numbers the elements of one batch, and cuts the faces of the other.
static void number_or_cut(void *context, int index, int thread) {
    const Crew *crew = context;
    if (index > 0) {
        cut_face(crew, &crew->cut->cutting[index - 1], &crew->cut->arenas[thread]);
        return;
    }
    for (int i = 0; i < crew->numbered->count; i++) mesh_add_patches(&crew->numbered->cutting[i]);
}

static void give_squares(void *context, int index, int thread) {
    const Crew *crew = context;
    mesh_give_squares(&crew->numbered->cutting[index], &crew->numbered->arenas[thread]);
}

static double count_squares(const MeshBuilder *builder) {
    double count = 0;
    for (int f = 0; f < builder->mesh->face_count; f++) {
        Face face = builder->mesh->faces[f];
        mesh_refine_grid(builder, f, &face);
        count += (double)face.nx * face.ny;
    }
    return count;
}

bool mesh_cut_faces(MeshBuilder *builder) {
    double squares = count_squares(builder);
    if (squares > MOST_SQUARES) return false;
    builder->mesh->squares = ARENA_ARRAY(builder->arena, int, squares);
    Arena scratch = {0};
    Crew crew = {.builder = builder,
                 .points = builder->places.points,
                 .threads = parallel_threads(builder->mesh->options.threads)};
    for (int b = 0; b < 2; b++) {
        crew.batches[b].cutting = ARENA_ARRAY(&scratch, MeshCutting, FACES_AT_A_TIME);
        crew.batches[b].arenas = ARENA_ARRAY(&scratch, Arena, crew.threads);
    }
    for (int b = 0; b == 0 || crew.cut->count > 0; b++) {
        crew.cut = &crew.batches[b % 2];
        crew.numbered = &crew.batches[(b + 1) % 2];
        begin_batch(&crew, crew.cut);
        parallel_for(crew.threads, crew.cut->count + 1, number_or_cut, &crew);
        parallel_for(crew.threads, crew.numbered->count, give_squares, &crew);
    }
    for (int b = 0; b < 2; b++) {
        for (int t = 0; t < crew.threads; t++) arena_free(&crew.batches[b].arenas[t]);
        arena_free(&crew.batches[b].arena);
    }
    arena_free(&scratch);
    return true;
}
