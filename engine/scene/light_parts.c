// light_parts.c - the small file: a header that says all, and no body.
#include "engine/scene/light_parts.h"

#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "radiosity/shoot/shoot.h"

typedef struct Header {
    DerivedHead head;
    uint64_t rest;  // checksum of what follows
    int32_t cells, parts, set, unused;
    double level;
    Daylight day;
} Header;

static const DerivedKind KIND = {
    .magic = "ENFPARTS", .name = ".rad", .version = 2, .header = sizeof(Header), .largest = sizeof(Header)};

static uint64_t rest_hash(const Header *h) {
    return file_hash(&h->cells, sizeof *h - offsetof(Header, cells), KIND.version);
}

static void put_nothing(DerivedSink *sink, const void *context) { (void)sink, (void)context; }

bool light_parts_save(const char *path, const Building *building, const LightParts *parts, Error *error) {
    Header header = {.cells = parts->cells,
                     .parts = parts->parts,
                     .set = parts->set,
                     .level = parts->level,
                     .day = parts->day};
    header.rest = rest_hash(&header);
    return derived_write(path, &KIND, building->hash, 0, &header, put_nothing, NULL, error);
}

// Nobody waits for a pipe.
bool light_parts_is(const char *path) {
    char magic[sizeof KIND.magic] = "";
    struct stat about;
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    bool is = fd >= 0 && fstat(fd, &about) == 0 && S_ISREG(about.st_mode) &&
              read(fd, magic, sizeof magic) == (ssize_t)sizeof magic &&
              memcmp(magic, KIND.magic, sizeof magic) == 0;
    if (fd >= 0) close(fd);
    return is;
}

bool light_parts_load(const char *path, const Building *building, LightParts *out, Error *error) {
    Arena scratch = {0};
    Bytes file;
    Header h;
    bool good = derived_read(path, &KIND, building->hash, &scratch, &file, error);
    if (good) memcpy(&h, file.data, sizeof h);
    good = good && derived_check_body(path, &KIND, file, 0, error);
    if (good && (h.rest != rest_hash(&h) || h.head.geometry != 0 || h.cells < 1 || h.parts < 1 || h.set < 1 ||
                 !(h.level >= 0 && isfinite(h.level)) || !daylight_is_sound(&h.day)))
        good = error_set(error, "%s: is damaged: its header's checksum is wrong", path);
    if (good) *out = (LightParts){h.cells, h.parts, h.set, h.level, h.day};
    arena_free(&scratch);
    return good;
}

bool light_stored_day(const char *path, const Building *building, Daylight *out, Error *error) {
    LightParts parts;
    if (!light_parts_is(path)) return rad_load_day(path, building, out, error);
    if (!light_parts_load(path, building, &parts, error)) return false;
    *out = parts.day;
    return true;
}
