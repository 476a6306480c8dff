// soup_readers.c - the parts that all readers of soups share: files beside the one read, colours within their limit, and the end of
// reading. Symbolic links are followed: whoever made the folder made them.
#include "maps/polygons/soup_readers.h"

#include <string.h>
#include <unistd.h>

#include "maps/polygons/foreign.h"

static const double EYE_HEIGHT = 1.6;  // metres above the lowest polygon
// The largest extent of a building that can be walked in, metres: less than a cupboard or more than a town is a
// mistake of units.
static const double SMALLEST = 1, LARGEST = 5000;

// Whether a part between slashes is `..`.
static bool leaves_folder(const char *name) {
    if (*name == 0 || *name == '/') return true;
    for (const char *part = name; part; part = strchr(part, '/')) {
        if (*part == '/') part++;
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == 0)) return true;
    }
    return false;
}

bool soup_read_beside(SoupReader *reader, const char *name, Arena *arena, Bytes *out, Error *error) {
    const char *path = reader->path;
    if (reader->library.data && foreign_is_library(name)) {
        *out = reader->library;
        return true;
    }
    char *slashed = arena_string(arena, name);
    for (char *c = slashed; *c; c++)
        if (*c == '\\') *c = '/';
    if (leaves_folder(slashed)) {
        return error_set(error, "%s: refers to the file `%.100s` (allowed: files in its own folder or below)",
                         path, name);
    }
    if (reader->files == SOUP_MAX_FILES)
        return error_set(error, "%s: refers to more than %d files", path, SOUP_MAX_FILES);
    reader->files++;
    const char *slash = strrchr(path, '/');
    char *full = arena_format(arena, "%.*s%s", slash ? (int)(slash - path + 1) : 0, path, slashed);
    if (access(full, F_OK) == 0)
        *ARENA_PUSH(reader->arena, reader->b->beside, reader->b->beside_count, reader->b->beside_capacity) =
            arena_string(reader->arena, full);
    if (!file_read(full, SOUP_MAX_BYTES - reader->bytes, arena, out, error)) return false;
    reader->bytes += out->size;
    reader->hash = file_hash(out->data, out->size, reader->hash);
    return true;
}

Rgb soup_cap(SoupReader *reader, Rgb reflectance, float limit, const char *material) {
    float most = fmaxf(reflectance.r, fmaxf(reflectance.g, reflectance.b));
    if (most > limit) {
        if (reader->capped++ == 0) reader->first_capped = material;
        reader->most_capped = fmax(reader->most_capped, (double)most);
        reader->limit = (double)limit;
    }
    return (Rgb){fminf(reflectance.r, limit), fminf(reflectance.g, limit), fminf(reflectance.b, limit)};
}

static void note_size(const char *path, const char *resize, Arena *arena, Building *b) {
    Vec3 size = vec3_sub(b->world.max, b->world.min);
    double largest = fmax(size.x, fmax(size.y, size.z));
    if (largest >= SMALLEST && largest <= LARGEST) return;
    building_note(
        arena, b, NOTE_CHANGED, b->world.min,
        "%s: is %g m wide, %g m deep and %g m high, which no building is (%g to %g m are usual); %s", path,
        size.x, size.y, size.z, SMALLEST, LARGEST, resize);
}

static void set_start(Building *b) {
    if (b->viewpoint_count > 0) {
        b->start = b->viewpoints[0].eye;
        b->start_yaw = b->viewpoints[0].yaw;
        return;
    }
    b->start = vec3_scale(vec3_add(b->world.min, b->world.max), 0.5);
    b->start.z = fmin(b->start.z, b->world.min.z + EYE_HEIGHT);
}

bool soup_finish(const SoupReader *reader, const char *resize, Error *error) {
    Building *b = reader->b;
    if (b->polygon_count == 0)
        return error_set(error, "%s: holds no polygon that has an area (at least one is needed)",
                         reader->path);
    b->form = FORM_SOUP;
    b->hash = reader->hash;
    b->world = box_empty();
    for (int i = 0; i < b->vertex_count; i++) b->world = box_add(b->world, b->vertices[i]);
    set_start(b);
    if (reader->capped > 0) {
        building_note(reader->arena, b, NOTE_CHANGED, b->start,
                      "%s: %d colours reflect more than %g and were capped, `%.60s` first; the most was %g",
                      reader->path, reader->capped, reader->limit, reader->first_capped, reader->most_capped);
    }
    note_size(reader->path, resize, reader->arena, b);
    return true;
}
