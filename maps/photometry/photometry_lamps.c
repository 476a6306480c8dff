// photometry_lamps.c - which reader reads a photometric file, and which lamps have which file: by their own statement, by a file of their
// name beside the building, or by an option. A lamp without a flux of its own has that of the file, and so has one that did not name the
// file itself.
#include <string.h>
#include <unistd.h>

#include "maps/photometry/photometry_file.h"

// ---- which reader

static bool is_ies(Bytes content) {
    static const char MARK[] = "TILT=";
    const char *from = (const char *)content.data, *end = from + content.size, *at = from;
    while ((at = memmem(at, (size_t)(end - at), MARK, strlen(MARK)))) {
        const char *before = at++;
        while (before > from && (before[-1] == ' ' || before[-1] == '\t')) before--;
        if (before == from || before[-1] == '\n') return true;
    }
    return false;
}

bool photometry_read(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error) {
    return is_ies(content) ? photometry_read_ies(path, content, arena, out, error)
                           : photometry_read_ldt(path, content, arena, out, error);
}

// ---- which lamps

static int read_file(const char *path, Arena *arena, Building *b, Error *error) {
    Bytes content;
    for (int i = 1; i < b->photometry_count; i++)
        if (strcmp(b->photometries[i].name, path) == 0) return i;
    Arena scratch = {0};
    Photometry table;
    bool good = file_read(path, PHOTOMETRY_MAX_BYTES, &scratch, &content, error);
    if (good) {
        uint64_t hash = file_hash(content.data, content.size, b->hash);
        good = photometry_read(path, content, arena, &table, error);
        if (good) b->hash = hash;
    }
    arena_free(&scratch);
    if (!good) return 0;
    if (b->photometry_count == 0)
        *ARENA_PUSH(arena, b->photometries, b->photometry_count, b->photometry_capacity) = (Photometry){0};
    *ARENA_PUSH(arena, b->photometries, b->photometry_count, b->photometry_capacity) = table;
    *ARENA_PUSH(arena, b->beside, b->beside_count, b->beside_capacity) = table.name;
    return b->photometry_count - 1;
}

// The flux of the table, in the colour that the light had.
static void take_flux(const Building *b, Light *light) {
    double colour[3], lumens = photometry_lumens(&b->photometries[light->photometry]);
    rgb_doubles(light->flux, colour);
    double luminous = light_luminous(colour);
    if (!(luminous > 0)) colour[0] = colour[1] = colour[2] = luminous = 1;
    double scale = lumens / (LIGHT_LUMENS_PER_WATT * luminous);
    light->flux = (Rgb){(float)(scale * colour[0]), (float)(scale * colour[1]), (float)(scale * colour[2])};
}

static int folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path) + 1 : 0;
}

// NAME.ies or NAME.ldt beside the building; NULL: neither is there.
static const char *find_beside(const char *path, const char *name, Arena *arena) {
    static const char *const ENDINGS[] = {"ies", "ldt", "IES", "LDT"};
    if (!name || !*name || *name == '.' || strchr(name, '/')) return NULL;
    for (int i = 0; i < 4; i++) {
        const char *file = arena_format(arena, "%.*s%s.%s", folder_length(path), path, name, ENDINGS[i]);
        if (access(file, F_OK) == 0) return file;
    }
    return NULL;
}

// A light's own statement names a file.
static bool take_named(const char *path, Arena *arena, Building *b, Light *light, Error *error) {
    Error why = {""};
    const char *file = light->file;
    if (*file == '/' || strstr(file, ".."))
        return error_set(error,
                         "%s: light %s refers to the file `%.100s` (allowed: files in its own folder or "
                         "below)",
                         path, light->name, file);
    light->photometry =
        read_file(arena_format(arena, "%.*s%s", folder_length(path), path, file), arena, b, &why);
    if (light->photometry == 0) return error_set(error, "%s: light %s: %.800s", path, light->name, why.text);
    const Rgb f = light->flux;
    if (f.r + f.g + f.b <= 0) take_flux(b, light);
    return true;
}

bool photometry_of_lamps(const char *path, Arena *arena, Building *b, Error *error) {
    Arena scratch = {0};
    bool good = true;
    for (int i = 0; i < b->light_count && good; i++) {
        Light *light = &b->lights[i];
        const char *name = light->name, *file;
        if (light->file) {
            good = take_named(path, arena, b, light, error);
            continue;
        }
        // Lamps of one name follow each other where there are thousands.
        bool same = i > 0 && !light[-1].file && light[-1].name && name && strcmp(light[-1].name, name) == 0;
        if (same) {
            light->photometry = light[-1].photometry;
        } else if ((file = find_beside(path, name, &scratch))) {
            Error why = {""};
            light->photometry = read_file(arena_string(arena, file), arena, b, &why);
            if (light->photometry == 0)
                building_note(arena, b, NOTE_CHANGED, light->position, "passed over: %.800s", why.text);
        }
        if (light->photometry > 0) take_flux(b, light);
    }
    arena_free(&scratch);
    return good;
}

// ---- by option

// The light of an object that glows, in the middle of what glows; false: nothing does.
static bool light_of_glow(const Building *b, int object, Light *out) {
    const Object *o = &b->objects[object];
    Box box = box_empty();
    *out = (Light){.name = o->name, .object = object};
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        Rgb e = b->materials[p->material].emission;
        if (!(e.r + e.g + e.b > 0)) continue;
        out->flux = e;
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, b->vertices[p->first_vertex + k]);
    }
    if (box_is_empty(box)) return false;
    out->position = vec3_lerp(box.min, box.max, 0.5);
    out->radius = fmax(box.max.x - box.min.x, box.max.y - box.min.y) / 2;
    return true;
}

bool photometry_for_name(const char *name_and_file, Arena *arena, Building *b, Error *error) {
    const char *equals = strrchr(name_and_file, '=');
    if (!equals || equals == name_and_file || !equals[1])
        return error_set(error, "--photometry is `%s` (allowed NAME=FILE)", name_and_file);
    int length = (int)(equals - name_and_file), found = 0;
    const char *name = arena_format(arena, "%.*s", length, name_and_file);
    int table = read_file(equals + 1, arena, b, error);
    if (table == 0) return false;
    for (int i = 0; i < b->light_count; i++) found += b->lights[i].name && !strcmp(b->lights[i].name, name);
    for (int i = 0; i < b->object_count && found == 0; i++) {
        Light light;
        if (strcmp(b->objects[i].name, name) == 0 && light_of_glow(b, i, &light))
            *ARENA_PUSH(arena, b->lights, b->light_count, b->light_capacity) = light;
    }
    for (int i = found = 0; i < b->light_count; i++) {
        if (!b->lights[i].name || strcmp(b->lights[i].name, name) != 0) continue;
        found++;
        b->lights[i].photometry = table;
        take_flux(b, &b->lights[i]);
    }
    b->hash = file_hash(name, strlen(name), b->hash);
    if (found > 0) return true;
    const char *some = b->light_count > 0 ? b->lights[0].name : NULL;
    return error_set(error, "--photometry: no lamp of %s is called `%s`%s%.100s%s", b->source, name,
                     some ? " (one that there is: `" : "", some ? some : "", some ? "`)" : "");
}
