// bake_probes.c - irradiance at points, gathered from the elements they see; and the radiosity of the face they lie on,
// B = E + rho H.
#include "engine/app/bake_probes.h"

#include <stdio.h>
#include <stdlib.h>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "radiosity/planner/room_light.h"

// How far a point may lie off a face, metres: the rounding error of coordinates written by hand.
static const double ON_FACE = 1e-4;
// And how far its normal may lean from the face's: the cosine of a degree and a half.
static const double SAME_WAY = 0.9997;
enum { LONGEST_LINE = 512 };
static const size_t LARGEST_FILE = (size_t)64 << 20;

static bool add_probe(const char *where, const double v[6], Arena *arena, Probes *out, Error *error) {
    Probe probe = {.place = vec3(v[0], v[1], v[2]), .normal = vec3(v[3], v[4], v[5])};
    double length = vec3_length(probe.normal);
    for (int i = 0; i < 6; i++) {
        if (!(fabs(v[i]) <= MAPS_LIMIT))
            return error_set(error, "%s: a probe has the number %g (allowed: within %g)", where, v[i],
                             MAPS_LIMIT);
    }
    if (!(length > 1e-6))
        return error_set(error, "%s: a probe has no normal (allowed: above 1e-6 long)", where);
    probe.normal = vec3_scale(probe.normal, 1 / length);
    *ARENA_PUSH(arena, out->probes, out->count, out->capacity) = probe;
    return true;
}

// Six numbers and no more; commas count as spaces.
static bool read_numbers(const char *text, double v[6], const char **rest) {
    char line[LONGEST_LINE];
    int length = snprintf(line, sizeof line, "%s", text);
    if (length < 0 || length >= (int)sizeof line) return false;
    for (char *c = line; *c; c++) *c = *c == ',' ? ' ' : *c;
    char *at = line;
    for (int i = 0; i < 6; i++) {
        char *end;
        v[i] = strtod(at, &end);
        if (end == at) return false;
        at = end;
    }
    *rest = text + (at - line);
    return true;
}

bool bake_probe_parse(const char *text, Arena *arena, Probes *out, Error *error) {
    double v[6];
    const char *rest;
    if (!read_numbers(text, v, &rest) || *rest)
        return error_set(error, "a probe is `%.60s` (expected X,Y,Z,NX,NY,NZ)", text);
    return add_probe("--probe", v, arena, out, error);
}

static bool read_line(const char *where, char *line, Arena *arena, Probes *out, Error *error) {
    char *remark = strchr(line, '#');
    if (remark) *remark = 0;
    line += strspn(line, " \t\r");
    if (*line == 0 || strncmp(line, "quad ", 5) == 0) return true;
    bool named = strncmp(line, "point ", 6) == 0;
    if (named) {  // point NAME, six numbers, QUAD
        line += 6;
        line += strspn(line, " \t");
        line += strcspn(line, " \t");
    }
    double v[6];
    const char *rest;
    if (!read_numbers(line, v, &rest) || (!named && rest[strspn(rest, " \t\r")] != 0))
        return error_set(error, "%s: is `%.60s` (expected x y z nx ny nz)", where, line);
    return add_probe(where, v, arena, out, error);
}

bool bake_probes_read(const char *path, Arena *arena, Probes *out, Error *error) {
    Bytes bytes;
    if (!file_read(path, LARGEST_FILE, arena, &bytes, error)) return false;
    char *line = (char *)bytes.data;
    for (int number = 1; line; number++) {
        char *end = strchr(line, '\n'), where[300];
        if (end) *end = 0;
        snprintf(where, sizeof where, "%.250s:%d", path, number);
        if (!read_line(where, line, arena, out, error)) return false;
        line = end ? end + 1 : NULL;
    }
    return true;
}

static bool is_inside(const Mesh *mesh, const Face *face, Vec3 p) {
    for (int i = 0; i < face->vertex_count; i++) {
        const int *outline = mesh->outline + face->first_vertex;
        Vec3 a = mesh->vertices[outline[i]], b = mesh->vertices[outline[(i + 1) % face->vertex_count]];
        Vec3 inwards = vec3_normalize(vec3_cross(face->plane.n, vec3_sub(b, a)));
        if (vec3_dot(inwards, vec3_sub(p, a)) < -ON_FACE) return false;
    }
    return true;
}

// The nearest face that has the point on its front; -1: none.
static int face_at(const Mesh *mesh, const Probe *probe) {
    int best = -1;
    double nearest = ON_FACE;
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        double off = fabs(plane_distance(face->plane, probe->place));
        if (face->hidden) continue;
        if (off > nearest || (best >= 0 && off == nearest)) continue;
        if (vec3_dot(face->plane.n, probe->normal) < SAME_WAY || !is_inside(mesh, face, probe->place))
            continue;
        best = f;
        nearest = off;
    }
    return best;
}

// Where light is gathered: on the face itself, for a place given to a few digits may lie behind a slanted face, in the dark.
static Vec3 place_on(const Mesh *mesh, int face, Vec3 place) {
    if (face < 0) return place;
    Vec3 n = mesh->faces[face].plane.n, off = vec3_sub(place, mesh->faces[face].origin);
    return vec3_sub(place, vec3_scale(n, vec3_dot(n, off)));
}

static void set_radiosity(const Mesh *mesh, int face, Probe *probe) {
    if (face < 0) return;
    const Material *m = mesh_material(mesh, face);
    Rgb reflectance = mesh_reflectance_at(mesh, face, probe->place, 0);
    const float rho[3] = {reflectance.r, reflectance.g, reflectance.b};
    const float e[3] = {m->emission.r, m->emission.g, m->emission.b};
    for (int c = 0; c < 3; c++) probe->radiosity[c] = (double)e[c] + (double)rho[c] * probe->irradiance[c];
}

typedef struct Gathering {
    const GatherScene *scene;
    Gatherer **gatherer;  // [threads]
    Probe *probes;
} Gathering;

static void gather_probe(void *context, int index, int thread) {
    const Gathering *g = context;
    const Mesh *mesh = g->scene->mesh;
    Probe *probe = &g->probes[index];
    int face = face_at(mesh, probe);
    Vec3 place = place_on(mesh, face, probe->place);
    int cell = gather_cell(mesh->graph, place, probe->normal, -1);
    gather(g->gatherer[thread], &(ViewPoint){place, probe->normal, cell}, probe->irradiance);
    set_radiosity(mesh, face, probe);
}

void bake_probes_gather(const GatherScene *scene, int threads, Probes *probes) {
    Arena scratch = {0};
    GatherOptions options = gather_exact_options();
    threads = parallel_threads(threads);
    if (threads > probes->count) threads = probes->count;
    Gathering g = {scene, ARENA_ARRAY(&scratch, Gatherer *, threads + 1), probes->probes};
    // Light through a window comes along few directions.
    if (daylight_shines(&scene->solution->day)) options.resolution = ROOM_SKY_RESOLUTION;
    for (int t = 0; t < threads; t++) g.gatherer[t] = gatherer_new(scene, &options, &scratch);
    parallel_for(threads, probes->count, gather_probe, &g);
    for (int t = 0; t < threads; t++) gatherer_end(g.gatherer[t]);
    arena_free(&scratch);
}

static void numbers_of(const Probe *p, double out[12]) {
    double v[12] = {p->place.x,       p->place.y,      p->place.z,       p->normal.x,
                    p->normal.y,      p->normal.z,     p->irradiance[0], p->irradiance[1],
                    p->irradiance[2], p->radiosity[0], p->radiosity[1],  p->radiosity[2]};
    memcpy(out, v, sizeof v);
}

void bake_probes_print(const Probes *probes) {
    for (int i = 0; i < probes->count; i++) {
        double v[12];
        numbers_of(&probes->probes[i], v);
        for (int k = 0; k < 12; k++) printf("%s%.9g", k ? " " : "", v[k]);
        putchar('\n');
    }
}

json_t *bake_probes_json(const Probes *probes) {
    json_t *list = json_array();
    for (int i = 0; i < probes->count; i++) {
        double v[12];
        numbers_of(&probes->probes[i], v);
        json_t *row = json_array();
        for (int k = 0; k < 12; k++) json_array_append_new(row, json_real(v[k]));
        json_array_append_new(list, row);
    }
    return list;
}
