// soup_files.c - files that a building's file refers to. Symbolic links are followed: whoever made the folder made them.
#include <string.h>
#include <unistd.h>

#include "maps/polygons/soup_readers.h"

// Whether a part between slashes is `..`.
static bool leaves_folder(const char *name) {
    if (*name == 0 || *name == '/') return true;
    for (const char *part = name; part; part = strchr(part, '/')) {
        if (*part == '/') part++;
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == 0)) return true;
    }
    return false;
}

bool soup_read_beside(SoupFolder *folder, const char *name, Arena *arena, Bytes *out, Error *error) {
    const char *path = folder->path;
    char *slashed = arena_string(arena, name);
    for (char *c = slashed; *c; c++)
        if (*c == '\\') *c = '/';
    if (leaves_folder(slashed)) {
        return error_set(error, "%s: refers to the file `%.100s` (allowed: files in its own folder or below)",
                         path, name);
    }
    if (folder->files == SOUP_MAX_FILES)
        return error_set(error, "%s: refers to more than %d files", path, SOUP_MAX_FILES);
    folder->files++;
    const char *slash = strrchr(path, '/');
    char *full = arena_format(arena, "%.*s%s", slash ? (int)(slash - path + 1) : 0, path, slashed);
    if (access(full, F_OK) == 0)
        *ARENA_PUSH(folder->arena, folder->b->beside, folder->b->beside_count, folder->b->beside_capacity) =
            arena_string(folder->arena, full);
    if (!file_read(full, SOUP_MAX_BYTES - folder->bytes, arena, out, error)) return false;
    folder->bytes += out->size;
    folder->hash = file_hash(out->data, out->size, folder->hash);
    return true;
}
