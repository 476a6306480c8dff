// file_watch.h - has a file changed on disk? Asked as often as one likes, once a frame for instance.
#ifndef WALK_FILE_WATCH_H
#define WALK_FILE_WATCH_H

#include <stdbool.h>
#include <sys/stat.h>

typedef struct FileWatch {
    const char *path;   // the caller's
    struct stat known;  // as last reported; all 0: it was not there
    struct stat seen;   // as last found
    double since;       // when `seen` was first found, seconds
} FileWatch;

// The answers of file_watch_look.
enum {
    FILE_SAME,
    FILE_CHANGED,  // and has been still for FILE_WATCH_STILL: said once for a change
    FILE_GONE      // for as long: said once. When it comes back it has changed
};

// A file that is being written is not read: it must have been still for so long, seconds. Longer than an editor or an
// exporter pauses between two writes, shorter than anybody waits.
#define FILE_WATCH_STILL 0.2

// Takes the file as it is now for known: begin before reading it, so that no change is missed.
FileWatch file_watch_begin(const char *path);
// `now`: seconds of any clock that only goes forward.
int file_watch_look(FileWatch *watch, double now);

#endif
