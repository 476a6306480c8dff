// sh3d_models.c - the models that pieces, doors and windows name: found in the archive, read once.
#include <stdio.h>
#include <string.h>

#include "maps/polygons/foreign.h"
#include "maps/sweethome/sh3d.h"

static const size_t MAX_MODEL = (size_t)64 << 20;  // bytes

// A model of the file, read once.
typedef struct Sh3dModel {
    const char *name;  // of the entry
    ObjModel obj;
    bool usable;
} Sh3dModel;

typedef struct Folder {
    Sh3d *s;
    const char *entry;  // of the file that refers to others
    Bytes library;      // of materials, of a model that is no OBJ; else no data
} Folder;

// Entries are spelled as they are, or as in an address, or beside the file that refers to them.
static bool read_entry(void *context, const char *name, Arena *arena, Bytes *out) {
    const Folder *folder = context;
    Sh3d *s = folder->s;
    if (folder->library.data && foreign_is_library(name)) {
        *out = folder->library;
        return true;
    }
    const char *slash = strrchr(folder->entry, '/');
    char *path =
        arena_format(arena, "%.*s%s", slash ? (int)(slash - folder->entry + 1) : 0, folder->entry, name);
    for (char *c = path; *c; c++)
        if (*c == '\\') *c = '/';
    Error ignored;
    return archive_has(s->archive, path) && archive_read(s->archive, path, MAX_MODEL, arena, out, &ignored);
}

static char *decode_address(Sh3d *s, const char *name) {
    char *out = arena_string(s->arena, name), *to = out;
    for (const char *from = name; *from; from++) {
        unsigned code;
        int used = 0;
        if (sscanf(from, "%%%2x%n", &code, &used) == 1 && used == 3 && code > 0) {
            *to++ = (char)code;
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = '\0';
    return out;
}

// 3DS and COLLADA become OBJ first.
static bool read_model(Folder *folder, Bytes content, ObjModel *out) {
    Sh3d *s = folder->s;
    ObjFiles files = {read_entry, folder, &s->pixels, s->b};
    Error ignored;
    if (foreign_recognise(content) &&
        !foreign_as_obj(folder->entry, content, s->arena, &content, &folder->library, &ignored))
        return false;
    return obj_read(content, folder->entry, &files, s->arena, out, &ignored);
}

const ObjModel *sh3d_model(Sh3d *s, const XmlNode *node) {
    const char *name = xml_get(node, "model");
    if (!name || !s->archive) return NULL;
    for (int i = 0; i < s->model_count; i++)
        if (strcmp(s->models[i].name, name) == 0) return s->models[i].usable ? &s->models[i].obj : NULL;
    Sh3dModel model = {.name = name};
    const char *entry = archive_has(s->archive, name) ? name : decode_address(s, name);
    Bytes content;
    Error ignored;
    Folder folder = {.s = s, .entry = entry};
    if (archive_has(s->archive, entry) &&
        archive_read(s->archive, entry, MAX_MODEL, s->arena, &content, &ignored))
        model.usable = read_model(&folder, content, &model.obj);
    Sh3dModel *kept = ARENA_PUSH(s->arena, s->models, s->model_count, s->model_capacity);
    *kept = model;
    return kept->usable ? &kept->obj : NULL;
}
