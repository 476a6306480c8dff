// file_watch.c - polls with stat: works on every file system, and once a frame costs nothing to speak of.
#include "engine/walk/file_watch.h"

#include <sys/stat.h>

static int64_t nanoseconds(struct timespec t) { return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec; }

static FileStamp stamp_of(const char *path) {
    struct stat info;
    if (stat(path, &info) != 0) return (FileStamp){.exists = false};
    return (FileStamp){.exists = true,
                       .device = info.st_dev,
                       .inode = info.st_ino,
                       .size = info.st_size,
                       .modified = nanoseconds(info.st_mtim),
                       .changed = nanoseconds(info.st_ctim)};
}

static bool stamps_equal(const FileStamp *a, const FileStamp *b) {
    return a->exists == b->exists && a->device == b->device && a->inode == b->inode && a->size == b->size &&
           a->modified == b->modified && a->changed == b->changed;
}

FileWatch file_watch_begin(const char *path) {
    FileStamp stamp = stamp_of(path);
    return (FileWatch){.path = path, .known = stamp, .seen = stamp};
}

FileState file_watch_look(FileWatch *watch, double now) {
    FileStamp stamp = stamp_of(watch->path);
    if (!stamps_equal(&stamp, &watch->seen)) {
        watch->seen = stamp;
        watch->since = now;
    }
    if (stamps_equal(&watch->seen, &watch->known) || now - watch->since < FILE_WATCH_STILL) return FILE_SAME;
    watch->known = watch->seen;
    return watch->known.exists ? FILE_CHANGED : FILE_GONE;
}
