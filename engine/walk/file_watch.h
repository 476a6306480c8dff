// file_watch.h - has a file changed on disk? May be asked at any rate, for instance once a frame.
#ifndef WALK_FILE_WATCH_H
#define WALK_FILE_WATCH_H

#include <stdbool.h>
#include <sys/stat.h>

typedef struct FileWatch {
    const char *path;   // memory of the caller
    struct stat known;  // as last reported; all 0: the file was not there
    struct stat seen;   // as last found
    double since;       // when `seen` was first found, seconds
} FileWatch;

// The answers of file_watch_look.
enum {
    FILE_SAME,
    FILE_CHANGED,  // the file has changed and then been still for FILE_WATCH_STILL; reported once a change
    FILE_GONE      // it has been absent for as long; reported once. A file that comes back has changed
};

// A file that is still being written is not read: it must have been still for this long, seconds. That is longer than an editor or an
// exporter pauses between two writes, and shorter than a wait that anybody notices.
#define FILE_WATCH_STILL 0.2

// Takes the file's present state as known. Call this before reading the file, so that no change is missed.
FileWatch file_watch_begin(const char *path);
// `now`: seconds of any clock that only goes forward.
int file_watch_look(FileWatch *watch, double now);

#endif
