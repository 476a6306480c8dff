// rad_file.c - the .rad file: a solution, under the hash of its building, with the mesh's options and the doors' states.
//
// Layout: header (DerivedHead), state of each door, splits of the mesh, radiosities, direct radiosities, unshot, daylight, radiosities
// of nodes if they were found, and the rest of these, splits of the mesh with these nodes if it is another, the state of each lamp, and the
// light of each source by itself if it is known. Meshes are not stored: they
// are made again from the building and their splits, and `geometry`, the hash of the elements and of the materials that their light
// depends on, says whether the mesh came out the same.
#include <math.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

enum { VERSION = 9 };

typedef struct Header {
    DerivedHead head;
    uint64_t rest;  // checksum of the rest of the header
    int32_t element_count, patch_count, door_count;
    int16_t per_patch, fill_lamps;  // the latter as in Building
    int32_t node_count;
    int32_t proxy;             // tolerance of stand-ins, PROXY_STEP; 0: there are none
    int32_t split_bits, even;  // -1 each: no splits; no bits: all roots are split so often
    int32_t shown_bits,
        rest_count;  // the latter node_count or 0; 0: light is shown on the mesh that it was found on
    double element, close;
    double emitted[3], absorbed[3], escaped[3], outdoors[3];
    Daylight day;
    int64_t shots;
    int32_t lamp_count, each_count;  // states of lamps; sources whose light is known by itself
    int64_t each_bytes;
} Header;

static const DerivedKind KIND = {.magic = "ENFRAD",
                                 .name = ".rad",
                                 .version = VERSION,
                                 .header = sizeof(Header),
                                 .largest = (size_t)16 << 30};

static uint64_t rest_hash(const Header *h) {
    const char *from = (const char *)&h->element_count;
    return file_hash(from, (size_t)((const char *)(h + 1) - from), VERSION);
}

static uint64_t spread_hash(const LampSpread *spread, uint64_t hash) {
    const Photometry *t = spread->table;
    size_t angles = (size_t)t->gamma_count, values = angles * (size_t)t->plane_count;
    hash = file_hash(t->gamma, angles * sizeof *t->gamma, hash);
    hash = file_hash(t->candela, values * sizeof *t->candela, hash);
    if (t->plane_count > 1) hash = file_hash(t->plane, (size_t)t->plane_count * sizeof *t->plane, hash);
    hash = file_hash(&spread->turn, sizeof spread->turn, hash);
    return file_hash(&spread->side, sizeof spread->side, hash);
}

static uint64_t mesh_hash(const Mesh *mesh) {
    uint64_t hash = file_hash(mesh->vertices, (size_t)mesh->vertex_count * sizeof *mesh->vertices, VERSION);
    hash = file_hash(mesh->corners, (size_t)mesh->corner_count * sizeof *mesh->corners, hash);
    for (int e = 0; e < mesh->element_count; e++)
        hash = file_hash(&mesh->elements[e].patch, sizeof mesh->elements[e].patch, hash);
    if (mesh->reflectance)
        hash = file_hash(mesh->reflectance, (size_t)mesh->element_count * sizeof *mesh->reflectance, hash);
    for (int p = 0; p < mesh->panes.count; p++)
        hash = file_hash(&mesh->panes.panes[p].plane, sizeof mesh->panes.panes[p].plane, hash);
    // Glass has no faces; mirrors and gloss count in stills alone.
    for (int f = 0; f < mesh->face_count; f++) {
        const Material *m = mesh_material(mesh, f);
        Rgb full = m->full.r + m->full.g + m->full.b > 0 ? m->full : m->emission;
        hash = file_hash(&full, sizeof full, file_hash(&m->reflectance, sizeof m->reflectance, hash));
        const LampSpread *spread = mesh_spread(mesh, f);
        if (spread) hash = spread_hash(spread, hash);
    }
    return hash;
}

// Where nothing stands in, it does not matter how far it might have been off.
static int32_t proxy_of(const MeshOptions *options) {
    return options->proxies ? (int32_t)lrint(options->proxies->tolerance / PROXY_STEP) : 0;
}

// Doubles stay aligned.
static size_t round_up(size_t bytes) { return (bytes + 7) / 8 * 8; }

typedef struct Sizes {
    size_t doors, splits, radiosity, direct, unshot, daylight, nodes, rest, shown, lit, each, total;
} Sizes;

static size_t bit_bytes(int32_t bits) { return bits > 0 ? ((size_t)bits + 7) / 8 : 0; }
static size_t split_bytes(const Header *h) { return bit_bytes(h->split_bits); }

static Sizes sizes_of(const Header *h) {
    Sizes s = {.doors = round_up((size_t)h->door_count * sizeof(float)),
               .splits = round_up(split_bytes(h)),
               .radiosity = (size_t)h->element_count * 3 * sizeof(double),
               .direct = (size_t)h->element_count * 3 * sizeof(double),
               .unshot = (size_t)h->patch_count * 3 * sizeof(double),
               .daylight = (size_t)h->element_count * 3 * sizeof(double),
               .nodes = (size_t)h->node_count * 3 * sizeof(double),
               .rest = (size_t)h->rest_count * 3 * sizeof(double),
               .shown = round_up(bit_bytes(h->shown_bits)),
               .lit = round_up((size_t)h->lamp_count * sizeof(Rgb)),
               .each = (size_t)h->each_bytes};
    s.total = s.doors + s.splits + s.radiosity + s.direct + s.unshot + s.daylight + s.nodes + s.rest +
              s.shown + s.lit + s.each;
    return s;
}

// ---- the light of each source: for each of its four vectors a SparseHead, blocks and values; then its powers

typedef struct SparseHead {
    int32_t count, block_count;
    float greatest;
    int32_t unused;
} SparseHead;

enum { VECTORS = 4 };

// The vectors of a source.
static void vectors_of(LampLight *light, SparseLight *out[VECTORS]) {
    out[0] = &light->radiosity;
    out[1] = &light->direct;
    out[2] = &light->straight;
    out[3] = &light->rest;
}

static size_t sparse_size(int block_count) {
    return sizeof(SparseHead) + round_up((size_t)block_count * sizeof(int32_t)) +
           (size_t)block_count * sizeof(uint32_t[LIGHT_BLOCK]);
}

static int64_t each_size(const RadSolution *s) {
    size_t size = 0;
    for (int i = 0; i < s->each_count; i++) {
        LampLight light = s->each[i];
        SparseLight *vector[VECTORS];
        vectors_of(&light, vector);
        for (int v = 0; v < VECTORS; v++) size += sparse_size(vector[v]->block_count);
        size += sizeof light.emitted + sizeof light.absorbed + sizeof light.escaped;
    }
    return (int64_t)size;
}

// Puts zeros after so many bytes, up to a multiple of eight.
static void put_zeros(DerivedSink *sink, size_t size) {
    static const uint64_t ZEROS = 0;
    derived_put(sink, &ZEROS, round_up(size) - size);
}

static void put_padded(DerivedSink *sink, const void *data, size_t size) {
    derived_put(sink, data, size);
    put_zeros(sink, size);
}

static void put_sparse(DerivedSink *sink, const SparseLight *light) {
    SparseHead head = {light->count, light->block_count, light->greatest, 0};
    derived_put(sink, &head, sizeof head);
    put_padded(sink, light->block, (size_t)light->block_count * sizeof(int32_t));
    derived_put(sink, light->value, (size_t)light->block_count * sizeof *light->value);
}

static void put_each(DerivedSink *sink, const RadSolution *s) {
    for (int i = 0; i < s->each_count; i++) {
        LampLight light = s->each[i];
        SparseLight *vector[VECTORS];
        vectors_of(&light, vector);
        for (int v = 0; v < VECTORS; v++) put_sparse(sink, vector[v]);
        derived_put(sink, light.emitted, sizeof light.emitted);
        derived_put(sink, light.absorbed, sizeof light.absorbed);
        derived_put(sink, light.escaped, sizeof light.escaped);
    }
}

// Bytes of a body that are not read yet.
typedef struct Rest {
    const unsigned char *at;
    size_t left;
} Rest;

static const void *take_rest(Rest *rest, size_t size) {
    if (size > rest->left) return NULL;
    const void *out = rest->at;
    rest->at += size;
    rest->left -= size;
    return out;
}

static bool read_sparse(Rest *rest, int count, Arena *arena, SparseLight *out) {
    SparseHead head;
    const void *from = take_rest(rest, sizeof head);
    if (!from) return false;
    memcpy(&head, from, sizeof head);
    int most = (count + LIGHT_BLOCK - 1) / LIGHT_BLOCK;
    if (head.count != count || head.block_count < 0 || head.block_count > most ||
        !(head.greatest >= 0 && isfinite(head.greatest)))
        return false;
    size_t blocks = (size_t)head.block_count * sizeof(int32_t),
           values = (size_t)head.block_count * sizeof *out->value;
    const void *block = take_rest(rest, round_up(blocks)), *value = take_rest(rest, values);
    if (!block || !value) return false;
    *out = (SparseLight){.count = count, .block_count = head.block_count, .greatest = head.greatest};
    out->block = ARENA_ARRAY(arena, int, head.block_count + 1);
    out->value = arena_alloc(arena, (size_t)head.block_count + 1, sizeof *out->value);
    if (head.block_count > 0) {
        memcpy(out->block, block, blocks);
        memcpy(out->value, value, values);
    }
    for (int b = 0; b < head.block_count; b++)
        if (out->block[b] < 0 || out->block[b] >= most || (b > 0 && out->block[b] <= out->block[b - 1]))
            return false;
    return true;
}

static bool read_each(const Header *h, const unsigned char *from, Arena *arena, RadSolution *s) {
    Rest rest = {from, (size_t)h->each_bytes};
    LampLight *each = ARENA_ARRAY(arena, LampLight, h->each_count + 1);
    for (int i = 0; i < h->each_count; i++) {
        SparseLight *vector[VECTORS];
        vectors_of(&each[i], vector);
        for (int v = 0; v < VECTORS; v++)
            if (!read_sparse(&rest, v < 2 ? h->element_count : h->node_count, arena, vector[v])) return false;
        double(*power[])[3] = {&each[i].emitted, &each[i].absorbed, &each[i].escaped};
        for (int k = 0; k < 3; k++) {
            const void *p = take_rest(&rest, sizeof *power[k]);
            if (!p) return false;
            memcpy(power[k], p, sizeof *power[k]);
            for (int c = 0; c < 3; c++)
                if (!((*power[k])[c] >= 0 && isfinite((*power[k])[c]))) return false;
        }
    }
    s->each = h->each_count > 0 ? each : NULL;
    s->each_count = h->each_count;
    return rest.left == 0;
}

static const Building *building_of(const Mesh *mesh) { return mesh->graph->building; }

// The number of lamps tells apart the sets that a building can have: none, those of the night, and fewer by day.
static int16_t fill_lamps_of(const Building *b) {
    return (int16_t)(b->fill_lamps < INT16_MAX ? b->fill_lamps : INT16_MAX);
}

// A door in a file's body.
static float stored_state(const unsigned char *body, int door) {
    float state;
    memcpy(&state, body + (size_t)door * sizeof state, sizeof state);
    return state;
}

// NULL stands for all wide open.
static float door_state(const float *door_open, int door) { return door_open ? door_open[door] : 1; }

// A solution to be stored.
typedef struct Stored {
    const Header *header;
    const Mesh *mesh;
    const float *door_open;
    const RadSolution *solution;
} Stored;

static void put_body(DerivedSink *sink, const void *context) {
    const Stored *stored = context;
    const Header *h = stored->header;
    const RadSolution *s = stored->solution;
    Sizes size = sizes_of(h);
    for (int i = 0; i < h->door_count; i++) {
        float state = door_state(stored->door_open, i);
        derived_put(sink, &state, sizeof state);
    }
    put_zeros(sink, (size_t)h->door_count * sizeof(float));
    if (h->split_bits > 0) put_padded(sink, stored->mesh->options.splits->bits, split_bytes(h));
    derived_put(sink, s->radiosity, size.radiosity);
    derived_put(sink, s->direct, size.direct);
    derived_put(sink, s->unshot, size.unshot);
    derived_put(sink, s->daylight, size.daylight);
    derived_put(sink, s->node, size.nodes);
    derived_put(sink, s->rest, size.rest);
    if (s->shown) put_padded(sink, s->shown->bits, bit_bytes(h->shown_bits));
    put_padded(sink, s->lit, (size_t)h->lamp_count * sizeof(Rgb));
    put_each(sink, s);
}

bool rad_save(const char *path, const Mesh *mesh, const float *door_open, const RadSolution *solution,
              Error *error) {
    const MeshSplits *splits = mesh->options.splits;
    Header header = {.element_count = solution->element_count,
                     .patch_count = solution->patch_count,
                     .door_count = building_of(mesh)->opening_count,
                     .split_bits = splits ? splits->bit_count : -1,
                     .even = splits ? splits->even : -1,
                     .per_patch = (int16_t)mesh->options.per_patch,
                     .fill_lamps = fill_lamps_of(building_of(mesh)),
                     .node_count = solution->node_count,
                     .rest_count = solution->rest ? solution->node_count : 0,
                     .shown_bits = solution->shown ? solution->shown->bit_count : 0,
                     .proxy = proxy_of(&mesh->options),
                     .element = mesh->options.element,
                     .close = mesh->options.close,
                     .shots = solution->shots,
                     .lamp_count = solution->lit ? solution->lamp_count : 0,
                     .each_count = solution->each_count,
                     .each_bytes = each_size(solution)};
    memcpy(header.emitted, solution->emitted, sizeof header.emitted);
    memcpy(header.absorbed, solution->absorbed, sizeof header.absorbed);
    memcpy(header.outdoors, solution->outdoors, sizeof header.outdoors);
    header.day = solution->day;
    memcpy(header.escaped, solution->escaped, sizeof header.escaped);
    header.rest = rest_hash(&header);
    Stored stored = {&header, mesh, door_open, solution};
    return derived_write(path, &KIND, building_of(mesh)->hash, mesh_hash(mesh), &header, put_body, &stored,
                         error);
}

static bool check_rest(const char *path, const Header *h, const Building *building, Error *error) {
    bool splits = h->split_bits >= 0 && h->even >= 0 && h->even <= MESH_IN_PATCH;
    if (h->rest == rest_hash(h) && h->door_count == building->opening_count && h->element_count >= 0 &&
        h->patch_count >= 0 && h->node_count >= 0 && (h->rest_count == 0 || h->rest_count == h->node_count) &&
        h->shown_bits >= 0 && (h->shown_bits == 0 || splits) && h->lamp_count >= 0 &&
        (h->each_count == 0 || h->each_count == h->lamp_count + daylight_shines(&h->day)) &&
        h->each_bytes >= 0 && (splits || (h->split_bits == -1 && h->even == -1)))
        return true;
    return error_set(error, "%s: is damaged: its header's checksum is wrong", path);
}

// All that can be said of a file without a mesh.
static bool read_file(const char *path, const Building *building, Arena *arena, Header *h,
                      const unsigned char **body, Error *error) {
    Bytes file;
    if (!derived_read(path, &KIND, building->hash, arena, &file, error)) return false;
    memcpy(h, file.data, sizeof *h);
    *body = file.data + sizeof *h;
    return check_rest(path, h, building, error) &&
           derived_check_body(path, &KIND, file, sizes_of(h).total, error);
}

static bool same_splits(const MeshSplits *splits, const Header *h, const unsigned char *body) {
    if (!splits || h->split_bits < 0) return !splits && h->split_bits < 0;
    return splits->bit_count == h->split_bits && splits->even == h->even &&
           (split_bytes(h) == 0 || memcmp(splits->bits, body + sizes_of(h).doors, split_bytes(h)) == 0);
}

// Nodes of another mesh are counted when it is made.
static bool check_nodes(const Header *h, const Mesh *mesh) {
    Arena scratch = {0};
    bool good = h->node_count == 0 || h->shown_bits > 0 || h->node_count == nodes_of(mesh, &scratch).count;
    arena_free(&scratch);
    return good;
}

static bool check_mesh(const char *path, const Header *h, const Mesh *mesh, const float *door_open,
                       const unsigned char *body, Error *error) {
    const MeshOptions *o = &mesh->options;
    int lamps = fill_lamps_of(building_of(mesh));
    if (h->fill_lamps != lamps)
        return error_set(error, "%s: was made with %d fill lamps (asked for: %d; --fill-lamps on or off)",
                         path, h->fill_lamps, lamps);
    if (h->element != o->element || h->per_patch != o->per_patch) {
        return error_set(error, "%s: has elements of %g m, %d along a patch (asked for: %g m, %d)", path,
                         h->element, h->per_patch, o->element, o->per_patch);
    }
    if (h->close != o->close)
        return error_set(error, "%s: has elements cut along what is %g m from them (asked for: %g m)", path,
                         h->close, o->close);
    if (h->proxy != proxy_of(o))
        return error_set(error, "%s: has stand-ins for fine furniture within %g m (asked for: %g m; 0: none)",
                         path, h->proxy * PROXY_STEP, proxy_of(o) * PROXY_STEP);
    if (!same_splits(o->splits, h, body))
        return error_set(error, "%s: its elements are not split as those asked for", path);
    for (int i = 0; i < h->door_count; i++) {
        if (stored_state(body, i) == door_state(door_open, i)) continue;
        return error_set(error, "%s: was made with door %s at %g (asked for: %g; 0 closed, 1 wide open)",
                         path, building_of(mesh)->openings[i].name, (double)stored_state(body, i),
                         (double)door_state(door_open, i));
    }
    if (h->element_count == mesh->element_count && h->patch_count == mesh->patch_count &&
        h->head.geometry == mesh_hash(mesh) && check_nodes(h, mesh))
        return true;
    return error_set(error, "%s: its elements are not those of this program's version", path);
}

static void *take_bytes(Arena *arena, const unsigned char *from, size_t size) {
    return memcpy(arena_alloc(arena, size, 1), from, size);
}

static bool take_body(const Header *h, const unsigned char *body, Arena *arena, RadSolution *out) {
    Sizes s = sizes_of(h);
    *out = (RadSolution){.element_count = h->element_count,
                         .patch_count = h->patch_count,
                         .node_count = h->node_count,
                         .shots = h->shots};
    body += s.doors + s.splits;
    out->radiosity = take_bytes(arena, body, s.radiosity);
    body += s.radiosity;
    out->direct = take_bytes(arena, body, s.direct);
    body += s.direct;
    out->unshot = take_bytes(arena, body, s.unshot);
    body += s.unshot;
    out->reflected = arena_alloc(arena, (size_t)h->patch_count + 1, sizeof *out->reflected);
    out->sun = arena_alloc(arena, (size_t)h->element_count + 1, sizeof *out->sun);
    out->sent = arena_alloc(arena, (size_t)h->patch_count + 1, sizeof *out->sent);
    out->strong = ARENA_ARRAY(arena, bool, h->patch_count + 1);
    out->close = ARENA_ARRAY(arena, float, h->patch_count + 1);
    out->noise = ARENA_ARRAY(arena, float, h->patch_count + 1);
    out->daylight = take_bytes(arena, body, s.daylight);
    body += s.daylight;
    if (h->node_count > 0) out->node = take_bytes(arena, body, s.nodes);
    if (h->rest_count > 0) out->rest = take_bytes(arena, body + s.nodes, s.rest);
    if (h->shown_bits > 0) {
        out->shown = ARENA_ARRAY(arena, MeshSplits, 1);
        *out->shown = (MeshSplits){.bit_count = h->shown_bits,
                                   .bits = take_bytes(arena, body + s.nodes + s.rest, s.shown)};
    }
    body += s.nodes + s.rest + s.shown;
    out->lamp_count = h->lamp_count;
    if (h->lamp_count > 0) out->lit = take_bytes(arena, body, s.lit);
    memcpy(out->emitted, h->emitted, sizeof h->emitted);
    memcpy(out->absorbed, h->absorbed, sizeof h->absorbed);
    memcpy(out->escaped, h->escaped, sizeof h->escaped);
    out->day = h->day;
    memcpy(out->outdoors, h->outdoors, sizeof h->outdoors);
    return read_each(h, body + s.lit, arena, out);
}

// The checksums find accidents; this keeps a forged file from spreading numbers that are no light.
static bool is_light(double (*v)[3], int count) {
    for (int i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++)
            if (!(v[i][c] >= 0 && isfinite(v[i][c]))) return false;
    }
    return true;
}

static bool are_states(const Rgb *lit, int count) {
    for (int i = 0; i < count; i++)
        if (!(lit[i].r >= 0 && lit[i].g >= 0 && lit[i].b >= 0 && isfinite(lit[i].r + lit[i].g + lit[i].b)))
            return false;
    return true;
}

// A part of a building may have no light of its own.
static bool check_light(const char *path, const Mesh *mesh, RadSolution *s, Error *error) {
    if (are_states(s->lit, s->lamp_count) && is_light(s->radiosity, s->element_count) &&
        is_light(s->direct, s->element_count) && is_light(s->unshot, s->patch_count) &&
        is_light(s->daylight, s->element_count) && is_light(s->node, s->node_count) &&
        (!s->rest || is_light(s->rest, s->node_count)) && is_light(&s->emitted, 1) &&
        is_light(&s->absorbed, 1) && is_light(&s->escaped, 1) && daylight_is_sound(&s->day) &&
        is_light(&s->outdoors, 1) && s->shots >= 0 && (mesh->options.part || rgb_sum(s->emitted) > 0))
        return true;
    return error_set(error, "%s: is damaged: not all its radiosities are finite and positive", path);
}

bool rad_load(const char *path, const Mesh *mesh, const float *door_open, Arena *arena, RadSolution *out,
              Error *error) {
    Arena scratch = {0};
    Header h;
    const unsigned char *body;
    bool good = read_file(path, building_of(mesh), &scratch, &h, &body, error) &&
                check_mesh(path, &h, mesh, door_open, body, error);
    if (good && !take_body(&h, body, arena, out))
        good = error_set(error, "%s: is damaged: the light of its lamps is out of range", path);
    good = good && check_light(path, mesh, out, error);
    arena_free(&scratch);
    return good;
}

static bool check_options(const char *path, const Header *h, const unsigned char *body, Error *error) {
    bool good = h->element >= 0.01 && h->element <= 100 && h->per_patch >= 1 && h->per_patch <= 16 &&
                h->close >= 0 && h->close <= 1 && h->proxy >= 0 && h->proxy * PROXY_STEP <= 1 &&
                h->fill_lamps >= 0;
    for (int i = 0; i < h->door_count; i++)
        good = good && stored_state(body, i) >= 0 && stored_state(body, i) <= 1;
    return good || error_set(error, "%s: is damaged: its mesh or doors are out of range", path);
}

static MeshSplits *read_splits(const Header *h, const unsigned char *body, Arena *arena) {
    if (h->split_bits < 0) return NULL;
    MeshSplits *splits = ARENA_ARRAY(arena, MeshSplits, 1);
    *splits = (MeshSplits){.bit_count = h->split_bits, .even = h->even};
    if (h->split_bits == 0) return splits;
    splits->bits = ARENA_ARRAY(arena, unsigned char, split_bytes(h));
    memcpy(splits->bits, body + sizes_of(h).doors, split_bytes(h));
    return splits;
}

static bool read_rad_header(const char *path, const Building *building, Header *out, Error *error) {
    Arena scratch = {0};
    Bytes start;
    size_t whole;
    bool good = derived_read_header(path, &KIND, building->hash, &scratch, &start, &whole, error);
    if (good) memcpy(out, start.data, sizeof *out);
    good = good && check_rest(path, out, building, error) &&
           derived_check_size(path, &KIND, whole, sizes_of(out).total, error);
    arena_free(&scratch);
    return good;
}

bool rad_load_day(const char *path, const Building *building, Daylight *out, Error *error) {
    Header h;
    if (!read_rad_header(path, building, &h, error)) return false;
    *out = h.day;
    return true;
}

bool rad_checksum(const char *path, const Building *building, uint64_t *out, Error *error) {
    Header h;
    if (!read_rad_header(path, building, &h, error)) return false;
    *out = h.head.body;
    return true;
}

bool rad_load_options(const char *path, const Building *building, Arena *arena, MeshOptions *out,
                      float *door_open, Error *error) {
    Arena scratch = {0};
    Header h;
    const unsigned char *body;
    bool good = read_file(path, building, &scratch, &h, &body, error) && check_options(path, &h, body, error);
    if (good) {
        *out = (MeshOptions){.element = h.element,
                             .per_patch = h.per_patch,
                             .close = h.close,
                             .proxy = h.proxy * PROXY_STEP,
                             .splits = read_splits(&h, body, arena)};
        memcpy(door_open, body, (size_t)h.door_count * sizeof *door_open);
    }
    arena_free(&scratch);
    return good;
}
