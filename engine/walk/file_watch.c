// file_watch.c - polls with stat, which works on every file system and costs next to nothing once a frame.
#include "engine/walk/file_watch.h"

static bool is_there(const struct stat *file) { return file->st_nlink > 0; }

static struct stat look_at(const char *path) {
    struct stat file;
    return stat(path, &file) == 0 ? file : (struct stat){0};
}

static bool times_equal(struct timespec a, struct timespec b) {
    return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

// Is the file unchanged? Editors write in place or put a new file under the old name, so both time and inode count.
static bool is_same(const struct stat *a, const struct stat *b) {
    return is_there(a) == is_there(b) && a->st_dev == b->st_dev && a->st_ino == b->st_ino &&
           a->st_size == b->st_size && times_equal(a->st_mtim, b->st_mtim) &&
           times_equal(a->st_ctim, b->st_ctim);
}

FileWatch file_watch_begin(const char *path) {
    struct stat file = look_at(path);
    return (FileWatch){.path = path, .known = file, .seen = file};
}

int file_watch_look(FileWatch *watch, double now) {
    struct stat file = look_at(watch->path);
    if (!is_same(&file, &watch->seen)) {
        watch->seen = file;
        watch->since = now;
    }
    if (is_same(&watch->seen, &watch->known) || now - watch->since < FILE_WATCH_STILL) return FILE_SAME;
    watch->known = watch->seen;
    return is_there(&watch->known) ? FILE_CHANGED : FILE_GONE;
}
