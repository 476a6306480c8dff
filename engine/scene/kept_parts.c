// kept_parts.c - sets of files by their names.
#include "engine/scene/kept_parts.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

// SET-PART-of-PARTS.rad; a file that belongs to it, or that a killed program left behind, has more after it.
#define NAME "%06d-%d-of-%d.rad"

typedef struct KeptFile {
    int set, part, parts;
    bool whole;
} KeptFile;

const char *kept_folder(const char *rad, Arena *arena) { return arena_format(arena, "%s.parts", rad); }

const char *kept_file(const char *folder, int set, int part, int parts, Arena *arena) {
    return arena_format(arena, "%s/" NAME, folder, set, part, parts);
}

static bool read_name(const char *name, KeptFile *out) {
    int end = 0;
    if (sscanf(name, "%d-%d-of-%d.rad%n", &out->set, &out->part, &out->parts, &end) != 3 || end == 0)
        return false;
    out->whole = name[end] == 0;
    return out->set > 0 && out->part >= 0 && out->part < out->parts;
}

// All files of the folder, and their number; NULL: there is none.
static KeptFile *list(const char *path, Arena *arena, int *count) {
    KeptFile *out = NULL, file;
    int capacity = 0;
    *count = 0;
    DIR *folder = opendir(path);
    for (const struct dirent *entry; folder && (entry = readdir(folder));)
        if (read_name(entry->d_name, &file)) *ARENA_PUSH(arena, out, *count, capacity) = file;
    if (folder) closedir(folder);
    return out;
}

int kept_last(const char *folder) {
    Arena scratch = {0};
    int count, last = 0;
    const KeptFile *file = list(folder, &scratch, &count);
    for (int i = 0; i < count; i++) last = file[i].set > last ? file[i].set : last;
    arena_free(&scratch);
    return last;
}

bool kept_find(const char *folder, int parts, int *set, Error *error) {
    Arena scratch = {0};
    int count, other = 0;
    const KeptFile *file = list(folder, &scratch, &count);
    *set = 0;
    for (int i = 0; i < count; i++) {
        int there = 0;
        for (int k = 0; k < count; k++)
            there += file[k].whole && file[k].set == file[i].set && file[k].parts == file[i].parts;
        if (there < file[i].parts) continue;
        if (file[i].parts != parts)
            other = file[i].parts;
        else if (file[i].set > *set)
            *set = file[i].set;
    }
    arena_free(&scratch);
    if (*set > 0) return true;
    if (other > 0)
        return error_set(error, "%s: holds the light of %d parts (asked for: %d; --parts)", folder, other,
                         parts);
    return error_set(error, "%s: holds no light of all %d parts to go on from", folder, parts);
}

void kept_remove(const char *path, int set, int spared) {
    DIR *folder = opendir(path);
    if (!folder) return;
    KeptFile file;
    // A name that is removed while the folder is read may come again: that does no harm.
    for (const struct dirent *entry; (entry = readdir(folder));)
        if (read_name(entry->d_name, &file) && file.set < set && file.set != spared)
            unlinkat(dirfd(folder), entry->d_name, 0);
    closedir(folder);
    rmdir(path);
}
