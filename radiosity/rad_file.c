// rad_file.c - the .rad file: a solution, under the hash of its building, with the mesh's options and the doors' states.
//
// Layout: header, state of each door, radiosities, unshot; the machine's own byte order, which the header shows. The
// mesh is not stored: it is made again from the building, and `mesh` says whether it came out the same.
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "radiosity/shoot.h"

enum { VERSION = 1, BYTE_ORDER_MARK = 0x01020304 };
static const char MAGIC[8] = "ENFRAD";
static const size_t LARGEST_FILE = (size_t)16 << 30;

typedef struct Header {
    char magic[8];
    uint32_t version, byte_order;
    uint64_t building;  // hash of the building's file
    uint64_t mesh;      // hash of the elements
    uint64_t body;      // checksum of all that follows the header
    uint64_t head;      // checksum of what comes after it in the header
    int32_t element_count, patch_count, door_count, per_patch;
    double element;
    double emitted[3], absorbed[3], escaped[3];
    int64_t shots;
} Header;

static uint64_t head_hash(const Header *h) {
    const char *from = (const char *)&h->element_count;
    return file_hash(from, (size_t)((const char *)(h + 1) - from), VERSION);
}

static uint64_t mesh_hash(const Mesh *mesh) {
    uint64_t hash = file_hash(mesh->vertices, (size_t)mesh->vertex_count * sizeof *mesh->vertices, VERSION);
    hash = file_hash(mesh->corners, (size_t)mesh->corner_count * sizeof *mesh->corners, hash);
    for (int e = 0; e < mesh->element_count; e++)
        hash = file_hash(&mesh->elements[e].patch, sizeof mesh->elements[e].patch, hash);
    return hash;
}

typedef struct Sizes {
    size_t doors, radiosity, unshot, total;
} Sizes;

static Sizes sizes_of(int doors, int elements, int patches) {
    // Doubles stay aligned behind the floats of doors.
    Sizes s = {.doors = ((size_t)doors * sizeof(float) + 7) / 8 * 8,
               .radiosity = (size_t)elements * 3 * sizeof(double),
               .unshot = (size_t)patches * 3 * sizeof(double)};
    s.total = s.doors + s.radiosity + s.unshot;
    return s;
}

static const Building *building_of(const Mesh *mesh) { return mesh->graph->building; }

// Of a door in a file's body.
static float stored_state(const unsigned char *body, int door) {
    float state;
    memcpy(&state, body + (size_t)door * sizeof state, sizeof state);
    return state;
}

// NULL stands for all wide open.
static float door_state(const float *door_open, int door) { return door_open ? door_open[door] : 1; }

bool rad_save(const char *path, const Mesh *mesh, const float *door_open, const RadSolution *solution,
              Error *error) {
    int doors = building_of(mesh)->opening_count;
    Sizes s = sizes_of(doors, solution->element_count, solution->patch_count);
    unsigned char *file = calloc(1, sizeof(Header) + s.total);
    if (!file) return error_set(error, "%s: no memory for %zu bytes", path, sizeof(Header) + s.total);
    unsigned char *body = file + sizeof(Header);
    for (int i = 0; i < doors; i++) {
        float state = door_state(door_open, i);
        memcpy(body + (size_t)i * sizeof state, &state, sizeof state);
    }
    memcpy(body + s.doors, solution->radiosity, s.radiosity);
    memcpy(body + s.doors + s.radiosity, solution->unshot, s.unshot);
    Header header = {.version = VERSION,
                     .byte_order = BYTE_ORDER_MARK,
                     .building = building_of(mesh)->hash,
                     .mesh = mesh_hash(mesh),
                     .body = file_hash(body, s.total, 0),
                     .element_count = solution->element_count,
                     .patch_count = solution->patch_count,
                     .door_count = doors,
                     .per_patch = mesh->options.per_patch,
                     .element = mesh->options.element,
                     .shots = solution->shots};
    memcpy(header.magic, MAGIC, sizeof MAGIC);
    memcpy(header.emitted, solution->emitted, sizeof header.emitted);
    memcpy(header.absorbed, solution->absorbed, sizeof header.absorbed);
    memcpy(header.escaped, solution->escaped, sizeof header.escaped);
    header.head = head_hash(&header);
    memcpy(file, &header, sizeof header);
    bool good = file_write(path, file, sizeof header + s.total, error);
    free(file);
    return good;
}

// All that can be said of a file without a mesh.
static bool check_header(const char *path, const Header *h, const Building *building, size_t size,
                         Error *error) {
    if (memcmp(h->magic, MAGIC, sizeof MAGIC) != 0) return error_set(error, "%s: is not a .rad file", path);
    if (h->byte_order != BYTE_ORDER_MARK)
        return error_set(error, "%s: was written on a machine of another byte order", path);
    if (h->version != VERSION) {
        return error_set(error, "%s: has version %u (this program reads version %d)", path, h->version,
                         VERSION);
    }
    if (h->building != building->hash) {
        return error_set(error, "%s: belongs to another building, or to an earlier state of this one", path);
    }
    if (h->head != head_hash(h) || h->door_count != building->opening_count || h->element_count < 0 ||
        h->patch_count < 0)
        return error_set(error, "%s: is damaged: its header's checksum is wrong", path);
    size_t expected = sizeof *h + sizes_of(h->door_count, h->element_count, h->patch_count).total;
    if (size != expected)
        return error_set(error, "%s: has %zu bytes (its header says %zu)", path, size, expected);
    return true;
}

static bool read_file(const char *path, const Building *building, Arena *arena, Header *h,
                      const unsigned char **body, Error *error) {
    Bytes bytes;
    if (!file_read(path, LARGEST_FILE, arena, &bytes, error)) return false;
    if (bytes.size < sizeof *h)
        return error_set(error, "%s: has %zu bytes, less than a .rad header", path, bytes.size);
    memcpy(h, bytes.data, sizeof *h);
    *body = bytes.data + sizeof *h;
    if (!check_header(path, h, building, bytes.size, error)) return false;
    if (file_hash(*body, bytes.size - sizeof *h, 0) == h->body) return true;
    return error_set(error, "%s: is damaged: its checksum is wrong", path);
}

static bool check_mesh(const char *path, const Header *h, const Mesh *mesh, const float *door_open,
                       const unsigned char *body, Error *error) {
    const MeshOptions *o = &mesh->options;
    if (h->element != o->element || h->per_patch != o->per_patch) {
        return error_set(error, "%s: has elements of %g m, %d along a patch (asked for: %g m, %d)", path,
                         h->element, h->per_patch, o->element, o->per_patch);
    }
    for (int i = 0; i < h->door_count; i++) {
        if (stored_state(body, i) == door_state(door_open, i)) continue;
        return error_set(error, "%s: was made with door %s at %g (asked for: %g; 0 closed, 1 wide open)",
                         path, building_of(mesh)->openings[i].name, (double)stored_state(body, i),
                         (double)door_state(door_open, i));
    }
    if (h->element_count == mesh->element_count && h->patch_count == mesh->patch_count &&
        h->mesh == mesh_hash(mesh))
        return true;
    return error_set(error, "%s: its elements are not those of this program's version", path);
}

// The checksums find accidents; this keeps a forged file from spreading what is no light.
static bool is_light(const double *v, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (!(v[i] >= 0 && isfinite(v[i]))) return false;
    }
    return true;
}

bool rad_load(const char *path, const Mesh *mesh, const float *door_open, Arena *arena, RadSolution *out,
              Error *error) {
    Arena scratch = {0};
    Header h;
    const unsigned char *body;
    bool good = read_file(path, building_of(mesh), &scratch, &h, &body, error) &&
                check_mesh(path, &h, mesh, door_open, body, error);
    if (good) {
        Sizes s = sizes_of(h.door_count, h.element_count, h.patch_count);
        *out =
            (RadSolution){.element_count = h.element_count, .patch_count = h.patch_count, .shots = h.shots};
        out->radiosity = memcpy(arena_alloc(arena, s.radiosity, 1), body + s.doors, s.radiosity);
        out->unshot = memcpy(arena_alloc(arena, s.unshot, 1), body + s.doors + s.radiosity, s.unshot);
        memcpy(out->emitted, h.emitted, sizeof h.emitted);
        memcpy(out->absorbed, h.absorbed, sizeof h.absorbed);
        memcpy(out->escaped, h.escaped, sizeof h.escaped);
        good = is_light(&out->radiosity[0][0], s.radiosity / sizeof(double)) &&
               is_light(&out->unshot[0][0], s.unshot / sizeof(double)) && is_light(out->emitted, 3) &&
               is_light(out->absorbed, 3) && is_light(out->escaped, 3) && out->shots >= 0 &&
               out->emitted[0] + out->emitted[1] + out->emitted[2] > 0;
        if (!good) error_set(error, "%s: is damaged: not all its radiosities are finite and positive", path);
    }
    arena_free(&scratch);
    return good;
}

static bool check_options(const char *path, const Header *h, const unsigned char *body, Error *error) {
    bool good = h->element >= 0.01 && h->element <= 100 && h->per_patch >= 1 && h->per_patch <= 16;
    for (int i = 0; i < h->door_count; i++)
        good = good && stored_state(body, i) >= 0 && stored_state(body, i) <= 1;
    return good || error_set(error, "%s: is damaged: its mesh or doors are out of range", path);
}

bool rad_load_options(const char *path, const Building *building, MeshOptions *out, float *door_open,
                      Error *error) {
    Arena scratch = {0};
    Header h;
    const unsigned char *body;
    bool good = read_file(path, building, &scratch, &h, &body, error) && check_options(path, &h, body, error);
    if (good) {
        *out = (MeshOptions){.element = h.element, .per_patch = h.per_patch};
        memcpy(door_open, body, (size_t)h.door_count * sizeof *door_open);
    }
    arena_free(&scratch);
    return good;
}
