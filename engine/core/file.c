// file.c - reads whole files, makes folders, finds the cache, and writes files that appear whole or not at all: a file is written
// without a name, gets a temporary name beside its own, and is renamed.
#include "engine/core/file.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

// XXH3 is compiled into this object, so that no library is needed for it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"

// Only regular files are read: a device or a pipe may have no end, or nobody may ever write into it.
static bool check_regular(const char *path, mode_t mode, Error *error) {
    if (S_ISREG(mode)) return true;
    const char *kind = S_ISDIR(mode)    ? "folder"
                       : S_ISFIFO(mode) ? "pipe"
                       : S_ISSOCK(mode) ? "socket"
                                        : "device";
    return error_set(error, "%s: is a %s (allowed: a regular file)", path, kind);
}

// Returns a descriptor, or -1 with an error. Does not wait for a writer of a pipe.
static int open_regular(const char *path, struct stat *info, Error *error) {
    if (strcmp(path, "-") == 0) {
        error_set(error, "-: standard input is not read (allowed: a regular file; one of this name as ./-)");
        return -1;
    }
    // The kind of the file is also checked before opening it, since opening alone has effects on some devices.
    int fd = -1;
    if (stat(path, info) == 0) {
        if (!check_regular(path, info->st_mode, error)) return -1;
        fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    }
    if (fd < 0 || fstat(fd, info) != 0)
        error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
    else if (check_regular(path, info->st_mode, error))
        return fd;
    if (fd >= 0) close(fd);
    return -1;
}

// As open_regular, of a file of at most `limit` bytes.
static int open_within(const char *path, size_t limit, size_t *size, Error *error) {
    struct stat info;
    int fd = open_regular(path, &info, error);
    if (fd < 0) return -1;
    *size = (size_t)info.st_size;
    if ((uint64_t)info.st_size <= limit) return fd;
    error_set(error, "%s: has %lld bytes (at most %zu are read)", path, (long long)info.st_size, limit);
    close(fd);
    return -1;
}

// Bytes that a thread reads at a time; and from this size on, several threads read.
enum { PART = 8 << 20, LARGE = 64 << 20 };
enum { SHRANK = -1 };  // beside the system's numbers of errors

// The reading of a file that is open.
typedef struct Fetch {
    int fd;
    Bytes into;
    atomic_int fault;  // 0: none so far
} Fetch;

static void fetch_part(void *context, int index, int thread) {
    (void)thread;
    Fetch *f = context;
    size_t at = (size_t)index * PART, end = at + PART < f->into.size ? at + PART : f->into.size;
    while (at < end) {
        ssize_t got = pread(f->fd, f->into.data + at, end - at, (off_t)at);
        if (got <= 0) {
            atomic_store(&f->fault, got < 0 ? errno : SHRANK);
            return;
        }
        at += (size_t)got;
    }
}

// Reads the first bytes of a file, which has so many. Several threads read large files: most of the time goes by until the system has
// found fresh pages for the bytes.
static bool read_first(const char *path, int fd, const Bytes *out, int threads, Error *error) {
    Fetch f = {.fd = fd, .into = *out};
    parallel_for(out->size < LARGE ? 1 : parallel_threads(threads), (int)((out->size + PART - 1) / PART),
                 fetch_part, &f);
    int fault = atomic_load(&f.fault);
    if (fault == 0) return true;
    return error_set(error, "%s: cannot be read: %s", path, fault == SHRANK ? "it shrank" : strerror(fault));
}

// Reads the first `most` bytes of a file of at most `limit` bytes, and tells the size of the whole file.
static bool read_start(const char *path, size_t limit, size_t most, int threads, Arena *arena, Bytes *out,
                       size_t *whole, Error *error) {
    int fd = open_within(path, limit, whole, error);
    if (fd < 0) return false;
    out->size = *whole < most ? *whole : most;
    memory_note_read(out->size);
    out->data = arena_alloc(arena, out->size + 1, 1);
    memory_expect_full(out->data, out->size);
    bool good = read_first(path, fd, out, threads, error);
    close(fd);
    return good;
}

bool file_read(const char *path, size_t limit, Arena *arena, Bytes *out, Error *error) {
    return file_read_by(path, limit, 0, arena, out, error);
}

bool file_read_by(const char *path, size_t limit, int threads, Arena *arena, Bytes *out, Error *error) {
    size_t whole;
    return read_start(path, limit, limit, threads, arena, out, &whole, error);
}

bool file_make_folder(const char *path, Error *error) {
    char part[PATH_MAX];
    if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part) {
        return error_set(error, "%s: the path is too long", path);
    }
    for (char *p = part + 1;; p++) {
        if (*p != '/' && *p != 0) continue;
        char kept = *p;
        *p = 0;
        if (mkdir(part, 0777) != 0 && errno != EEXIST) {
            return error_set(error, "%s: cannot be made: %s", part, strerror(errno));
        }
        *p = kept;
        if (!kept) break;
    }
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return error_set(error, "%s: is not a folder", path);
    return true;
}

bool file_cache_folder(Arena *arena, char **path, Error *error) {
    // A relative path in XDG_CACHE_HOME is invalid (XDG Base Directory Specification).
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (cache && *cache == '/') {
        *path = arena_format(arena, "%s/enfilade", cache);
    } else if (home && *home) {
        *path = arena_format(arena, "%s/.cache/enfilade", home);
    } else {
        return error_set(error, "there is no cache, since neither XDG_CACHE_HOME nor HOME is set");
    }
    return true;
}

uint64_t file_hash(const void *data, size_t size, uint64_t seed) {
    return XXH3_64bits_withSeed(data, size, seed);
}

// ---- writing

// Temporary names: NAMES writers may write one path at once. Most writers hold a name for microseconds, so that waiting helps.
enum { NAMES = 8, TRIES = 800, PAUSE = 1000 /* microseconds */ };
enum { MOST_LINKS = 40 };  // as many as the system follows
#define BESIDE "%s.enfilade-%d"
enum { BESIDE_BYTES = sizeof ".enfilade-0" };
#define ACCESS_LIST "system.posix_acl_access"
enum { MOST_ACCESS_LIST = 4096 };

static bool fail(const char *path, Error *error) {
    return error_set(error, "%s: cannot be written: %s", path, strerror(errno));
}

// ---- where

// The number N of a path `/dev/fd/N` or `/proc/self/fd/N`, to which `/dev/stdout` leads; -1 for any other path.
static int own_descriptor(const char *path) {
    static const char *const folders[] = {"/proc/self/fd/", "/dev/fd/"};
    for (int i = 0; i < 2; i++) {
        size_t length = strlen(folders[i]);
        char *end;
        if (strncmp(path, folders[i], length) != 0 || !isdigit((unsigned char)path[length])) continue;
        long fd = strtol(path + length, &end, 10);
        if (*end == 0 && fd <= INT_MAX) return (int)fd;
    }
    return -1;
}

// Replaces `target`, the beginning of a chain of symbolic links, by the end of the chain, which need not exist. False with errno.
static bool follow_links(char target[FILE_LONGEST_PATH]) {
    char link[FILE_LONGEST_PATH], joined[FILE_LONGEST_PATH];
    for (int i = 0; i < MOST_LINKS; i++) {
        ssize_t length = own_descriptor(target) >= 0 ? -1 : readlink(target, link, sizeof link - 1);
        if (length < 0) return true;
        link[length] = 0;
        const char *slash = *link == '/' ? NULL : strrchr(target, '/');
        int folder = slash ? (int)(slash - target + 1) : 0;
        if (snprintf(joined, sizeof joined, "%.*s%s", folder, target, link) >= (int)sizeof joined) {
            errno = ENAMETOOLONG;
            return false;
        }
        memcpy(target, joined, sizeof joined);
    }
    errno = ELOOP;
    return false;
}

static bool is_writable_descriptor(int fd) {
    int flags = fcntl(fd, F_GETFL);
    if (flags >= 0 && (flags & O_ACCMODE) != O_RDONLY) return true;
    errno = EBADF;
    return false;
}

static bool name_fits(const char *target) {
    const char *slash = strrchr(target, '/');
    if (strlen(target) + BESIDE_BYTES <= FILE_LONGEST_PATH &&
        strlen(slash ? slash + 1 : target) + BESIDE_BYTES <= NAME_MAX)
        return true;
    errno = ENAMETOOLONG;
    return false;
}

// Fills in the draft except its descriptor. False with errno.
static bool find_target(const char *path, FileDraft *draft, bool *exists) {
    struct stat info;
    *draft = (FileDraft){.fd = -1, .path = path};
    if (*path == 0) {
        errno = ENOENT;
        return false;
    }
    if (snprintf(draft->target, sizeof draft->target, "%s", path) >= (int)sizeof draft->target) {
        errno = ENAMETOOLONG;
        return false;
    }
    // stat has the system follow the links first: it refuses links that others put into folders open to all (protected_symlinks).
    *exists = stat(path, &info) == 0;
    if ((!*exists && errno != ENOENT) || !follow_links(draft->target)) return false;
    int own = own_descriptor(draft->target);
    draft->stream = own >= 0 || (*exists && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode));
    if (own >= 0) return is_writable_descriptor(own);
    if (*exists && S_ISDIR(info.st_mode)) {
        errno = EISDIR;
        return false;
    }
    if (*exists && faccessat(AT_FDCWD, draft->target, W_OK, AT_EACCESS) != 0) return false;
    return draft->stream || name_fits(draft->target);
}

static void put_folder(const char *path, char folder[FILE_LONGEST_PATH]) {
    snprintf(folder, FILE_LONGEST_PATH, "%s", path);
    char *slash = strrchr(folder, '/');
    if (slash) {
        slash[slash == folder] = 0;
    } else {
        strcpy(folder, ".");
    }
}

// A rename is on disk only once its folder is.
static void sync_folder(const char *path) {
    char folder[FILE_LONGEST_PATH];
    put_folder(path, folder);
    int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    fsync(fd);
    close(fd);
}

// ---- temporary names

static void name_beside(const char *target, int i, char beside[FILE_LONGEST_PATH]) {
    CORE_ASSERT(snprintf(beside, FILE_LONGEST_PATH, BESIDE, target, i % NAMES) < FILE_LONGEST_PATH);
}

// Removes the files that killed writers left. A living writer holds a lock on its file, on whatever machine it runs; a dead one
// does not.
static void sweep(const char *target) {
    for (int i = 0; i < NAMES; i++) {
        char beside[FILE_LONGEST_PATH];
        name_beside(target, i, beside);
        // On a network file system an exclusive lock needs write access; elsewhere a descriptor for reading is enough.
        const int flags = O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
        int fd = open(beside, O_RDWR | flags);
        if (fd < 0 && errno == EACCES) fd = open(beside, O_RDONLY | flags);
        if (fd < 0) continue;
        struct stat held, named;
        // Once the lock is free its writer may have renamed the file, so the name must still lead to the locked file.
        if (fstat(fd, &held) == 0 && S_ISREG(held.st_mode) && flock(fd, LOCK_EX | LOCK_NB) == 0 &&
            lstat(beside, &named) == 0 && held.st_ino == named.st_ino && held.st_dev == named.st_dev)
            unlink(beside);
        close(fd);
    }
}

// Opens a file without a name, so that a program that ends while it writes leaves nothing. False where the file system has no
// nameless files, or where the file could not be named later, which needs /proc.
static bool open_nameless(FileDraft *draft, mode_t mode) {
    char folder[FILE_LONGEST_PATH], own[64];
    put_folder(draft->target, folder);
    draft->fd = open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, mode);
    if (draft->fd < 0) return false;
    snprintf(own, sizeof own, "/proc/self/fd/%d", draft->fd);
    if (access(own, F_OK) == 0) {
        flock(draft->fd, LOCK_EX | LOCK_NB);
        return true;
    }
    close(draft->fd);
    draft->fd = -1;
    return false;
}

static bool name_nameless(FileDraft *draft) {
    char own[64];
    snprintf(own, sizeof own, "/proc/self/fd/%d", draft->fd);
    for (int i = 0; i < TRIES; i++) {
        name_beside(draft->target, i, draft->beside);
        if (linkat(AT_FDCWD, own, AT_FDCWD, draft->beside, AT_SYMLINK_FOLLOW) == 0) return true;
        if (errno != EEXIST) break;
        if (i >= NAMES) usleep(PAUSE);
    }
    *draft->beside = 0;
    return false;
}

static bool open_named(FileDraft *draft, mode_t mode) {
    for (int i = 0; i < TRIES; i++) {
        name_beside(draft->target, i, draft->beside);
        draft->fd = open(draft->beside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (draft->fd < 0 && errno != EEXIST) break;
        struct stat info;
        // Before this writer locked the file, another writer may have removed it.
        if (draft->fd >= 0) {
            flock(draft->fd, LOCK_EX);
            if (fstat(draft->fd, &info) == 0 && info.st_nlink > 0) return true;
            close(draft->fd);
            draft->fd = -1;
        }
        if (i >= NAMES) usleep(PAUSE);
    }
    *draft->beside = 0;
    return false;
}

// ---- drafts

// Opens the device or pipe of a draft. False with errno.
static bool open_stream(FileDraft *draft) {
    int own = own_descriptor(draft->target);
    draft->fd = own >= 0 ? fcntl(own, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)
                         : open(draft->target, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return draft->fd >= 0;
}

static bool begin_draft(const char *path, bool named, FileDraft *draft, Error *error) {
    bool exists;
    if (strcmp(path, "-") == 0)
        return error_set(error, "-: is not written (allowed: /dev/stdout; a file of this name as ./-)");
    if (!find_target(path, draft, &exists)) return fail(path, error);
    if (draft->stream) return open_stream(draft) || fail(path, error);
    sweep(draft->target);
    // The earlier file may be private, so a file that replaces it is private from its beginning.
    mode_t mode = exists ? 0600 : 0666;
    if ((!named && open_nameless(draft, mode)) || open_named(draft, mode)) return true;
    if (!exists || (errno != EACCES && errno != EPERM)) return fail(path, error);
    return error_set(error,
                     "%s: cannot be written: its folder takes no other file, by which it is replaced: %s",
                     path, strerror(errno));
}

bool file_begin(const char *path, FileDraft *out, Error *error) {
    return begin_draft(path, false, out, error);
}

// Copies an access list. The list names further users with rights, and the group bits of the mode are then the upper bound of these
// rights; without the list the group would get all of them. Returns true if the list was copied or there is none.
static bool copy_access_list(int fd, const char *from) {
    char list[MOST_ACCESS_LIST];
    ssize_t size = getxattr(from, ACCESS_LIST, list, sizeof list);
    return size < 0 ? errno == ENODATA || errno == ENOTSUP
                    : fsetxattr(fd, ACCESS_LIST, list, (size_t)size, 0) == 0;
}

// Gives a draft the rights of the earlier file, and never more.
static void take_over_rights(const FileDraft *draft) {
    struct stat old;
    if (stat(draft->target, &old) != 0 || !S_ISREG(old.st_mode)) return;
    bool kept =
        fchown(draft->fd, old.st_uid, old.st_gid) == 0 || fchown(draft->fd, (uid_t)-1, old.st_gid) == 0;
    mode_t mode = old.st_mode & 0777, others_too = (mode & 0707) | (mode & ((mode & 07) << 3));
    fchmod(draft->fd, kept ? mode : others_too);
    if (!copy_access_list(draft->fd, draft->target)) fchmod(draft->fd, others_too);
}

// Flushes a draft to disk and puts it under its name. False with errno.
static bool settle_draft(FileDraft *draft) {
    take_over_rights(draft);
    return fsync(draft->fd) == 0 && (*draft->beside || name_nameless(draft)) &&
           rename(draft->beside, draft->target) == 0;
}

bool file_keep(FileDraft *draft, Error *error) {
    if (draft->stream) return close(draft->fd) == 0 || fail(draft->path, error);
    if (!settle_draft(draft)) {
        fail(draft->path, error);
        file_drop(draft);
        return false;
    }
    close(draft->fd);
    sync_folder(draft->target);
    return true;
}

void file_drop(FileDraft *draft) {
    // While this writer holds the lock, the temporary name is its own.
    if (*draft->beside) unlink(draft->beside);
    close(draft->fd);
}

// ---- whole files

static bool write_all(int fd, const char *data, size_t size) {
    while (size > 0) {
        ssize_t step = write(fd, data, size);
        if (step < 0 && errno == EINTR) continue;
        if (step <= 0) return false;
        data += step;
        size -= (size_t)step;
    }
    return true;
}

// Writes the content of a file; it may be asked for twice.
typedef bool Write(int fd, const void *context);

static bool write_whole(const char *path, Write *content, const void *context, Error *error) {
    // A file system may make nameless files and yet refuse to name them, so the second try uses a named file. Any other failure
    // occurs again on the second try.
    for (int named = 0; named < 2; named++) {
        FileDraft draft;
        if (!begin_draft(path, named, &draft, error)) return false;
        bool again = !draft.stream && !*draft.beside;
        if (content(draft.fd, context)) {
            if (file_keep(&draft, error)) return true;
        } else {
            fail(path, error);
            file_drop(&draft);
        }
        if (!again) break;
    }
    return false;
}

static bool write_content(const char *path, Write *content, const void *context, Error *error) {
    memory_hold_end();
    bool good = write_whole(path, content, context, error);
    memory_release_end();
    return good;
}

typedef struct Content {
    const void *data;
    size_t size;
} Content;

static bool write_data(int fd, const void *context) {
    const Content *content = context;
    return write_all(fd, content->data, content->size);
}

bool file_write(const char *path, const void *data, size_t size, Error *error) {
    Content content = {data, size};
    return write_content(path, write_data, &content, error);
}

bool file_check(const char *path, size_t size, Error *error) {
    FileDraft draft;
    bool exists;
    // A pipe is neither written nor opened: its reader would see the end of the data.
    if (strcmp(path, "-") != 0) {
        if (!find_target(path, &draft, &exists)) return fail(path, error);
        if (draft.stream) return true;
    }
    if (!file_begin(path, &draft, error)) return false;
    bool good = size == 0 || fallocate(draft.fd, 0, 0, (off_t)size) == 0 || errno == EOPNOTSUPP;
    if (!good) fail(path, error);
    file_drop(&draft);
    return good;
}

bool file_same(const char *a, const char *b) {
    struct stat x, y;
    bool there = stat(a, &x) == 0;
    if ((stat(b, &y) == 0) != there) return false;
    if (there) return S_ISREG(x.st_mode) && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
    FileDraft p, q;
    return find_target(a, &p, &there) && find_target(b, &q, &there) && strcmp(p.target, q.target) == 0;
}

// ---- the common head of derived files: written, and checked for kind, version, building and checksum

static const uint32_t BYTE_ORDER_MARK = 0x01020304;

_Static_assert(sizeof(DerivedHead) == 40, "the files that exist begin with 40 bytes");

// Pieces are written or hashed in blocks of so many bytes.
enum { BLOCK = 1 << 16 };

struct DerivedSink {
    int fd;               // -1: bytes are hashed
    XXH3_state_t *state;  // of the hash
    bool good;
    size_t used;
    unsigned char block[BLOCK];
};

static void drain(DerivedSink *sink, const void *data, size_t size) {
    if (sink->fd < 0)
        XXH3_64bits_update(sink->state, data, size);
    else
        sink->good = sink->good && write_all(sink->fd, data, size);
}

void derived_put(DerivedSink *sink, const void *data, size_t size) {
    if (sink->used + size > BLOCK) {
        drain(sink, sink->block, sink->used);
        sink->used = 0;
    }
    if (size > BLOCK) {
        drain(sink, data, size);
    } else if (size > 0) {
        memcpy(sink->block + sink->used, data, size);
        sink->used += size;
    }
}

typedef struct Derived {
    const DerivedKind *kind;
    const void *header, *context;
    DerivedBody *body;
} Derived;

static bool put_derived(const Derived *d, DerivedSink *sink) {
    d->body(sink, d->context);
    drain(sink, sink->block, sink->used);
    return sink->good;
}

static uint64_t hash_derived(const Derived *d) {
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    DerivedSink sink = {.fd = -1, .state = &state, .good = true};
    put_derived(d, &sink);
    return XXH3_64bits_digest(&state);
}

static bool write_derived(int fd, const void *context) {
    const Derived *d = context;
    DerivedSink sink = {.fd = fd, .good = true};
    derived_put(&sink, d->header, d->kind->header);
    return put_derived(d, &sink);
}

bool derived_write(const char *path, const DerivedKind *kind, uint64_t building, uint64_t geometry,
                   void *header, DerivedBody *body, const void *context, Error *error) {
    Derived d = {kind, header, context, body};
    DerivedHead head = {.version = kind->version,
                        .byte_order = BYTE_ORDER_MARK,
                        .building = building,
                        .geometry = geometry,
                        .body = hash_derived(&d)};
    memcpy(head.magic, kind->magic, sizeof head.magic);
    memcpy(header, &head, sizeof head);
    return write_content(path, write_derived, &d, error);
}

static bool check_head(const char *path, const DerivedKind *kind, const DerivedHead *head, uint64_t building,
                       Error *error) {
    if (memcmp(head->magic, kind->magic, sizeof head->magic) != 0)
        return error_set(error, "%s: is not a %s file", path, kind->name);
    if (head->byte_order != BYTE_ORDER_MARK)
        return error_set(error, "%s: was written on a machine of another byte order", path);
    if (head->version != kind->version) {
        return error_set(error, "%s: has version %u (this program reads version %u)", path, head->version,
                         kind->version);
    }
    if (head->building != building)
        return error_set(error, "%s: belongs to another building, or to an earlier state of this one", path);
    return true;
}

static bool read_derived(const char *path, const DerivedKind *kind, uint64_t building, size_t most,
                         Arena *arena, Bytes *out, size_t *whole, Error *error) {
    if (!read_start(path, kind->largest, most, 0, arena, out, whole, error)) return false;
    if (out->size < kind->header)
        return error_set(error, "%s: has %zu bytes, less than a %s header", path, out->size, kind->name);
    DerivedHead head;
    memcpy(&head, out->data, sizeof head);
    return check_head(path, kind, &head, building, error);
}

bool derived_read(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena, Bytes *out,
                  Error *error) {
    size_t whole;
    return read_derived(path, kind, building, kind->largest, arena, out, &whole, error);
}

bool derived_read_header(const char *path, const DerivedKind *kind, uint64_t building, Arena *arena,
                         Bytes *out, size_t *whole, Error *error) {
    return read_derived(path, kind, building, kind->header, arena, out, whole, error);
}

bool derived_check_size(const char *path, const DerivedKind *kind, size_t whole, size_t body_size,
                        Error *error) {
    size_t expected = kind->header + body_size;
    if (whole == expected) return true;
    return error_set(error, "%s: has %zu bytes (its header says %zu)", path, whole, expected);
}

bool derived_check_body(const char *path, const DerivedKind *kind, Bytes file, size_t body_size,
                        Error *error) {
    if (!derived_check_size(path, kind, file.size, body_size, error)) return false;
    DerivedHead head;
    memcpy(&head, file.data, sizeof head);
    if (file_hash(file.data + kind->header, body_size, 0) != head.body)
        return error_set(error, "%s: is damaged: its checksum is wrong", path);
    return true;
}

// Opens a file for reading from its beginning; it counts as read.
static FILE *open_derived(const char *path, const DerivedKind *kind, size_t *whole, Error *error) {
    int fd = open_within(path, kind->largest, whole, error);
    if (fd < 0) return NULL;
    memory_note_read(*whole);
    FILE *file = fdopen(fd, "r");
    if (file) return file;
    error_set(error, "%s: cannot be opened: %s", path, strerror(errno));
    close(fd);
    return NULL;
}

bool derived_begin(const char *path, const DerivedKind *kind, uint64_t building, void *header,
                   DerivedReader *out, Error *error) {
    size_t whole;
    FILE *file = open_derived(path, kind, &whole, error);
    if (!file) return false;
    DerivedHead head;
    bool good = true;
    if (whole < kind->header)
        good = error_set(error, "%s: has %zu bytes, less than a %s header", path, whole, kind->name);
    else if (fread(header, 1, kind->header, file) != kind->header)
        good = error_set(error, "%s: cannot be read", path);
    if (good) {
        memcpy(&head, header, sizeof head);
        good = check_head(path, kind, &head, building, error);
    }
    if (good)
        *out = (DerivedReader){path, file, kind->header, whole - kind->header};
    else
        fclose(file);
    return good;
}

bool derived_sound(DerivedReader *reader, const void *header, Error *error) {
    unsigned char block[BLOCK];
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_64bits_reset(&state);
    DerivedReader from = *reader;
    for (size_t size; (size = from.left < BLOCK ? from.left : BLOCK) > 0;) {
        if (!derived_take(&from, block, size)) return error_set(error, "%s: cannot be read", reader->path);
        XXH3_64bits_update(&state, block, size);
    }
    DerivedHead head;
    memcpy(&head, header, sizeof head);
    if (XXH3_64bits_digest(&state) != head.body)
        return error_set(error, "%s: is damaged: its checksum is wrong", reader->path);
    return fseeko(reader->file, (off_t)reader->header, SEEK_SET) == 0 ||
           error_set(error, "%s: cannot be read: %s", reader->path, strerror(errno));
}

bool derived_take(DerivedReader *reader, void *out, size_t size) {
    if (size > reader->left || fread(out, 1, size, reader->file) != size) return false;
    reader->left -= size;
    return true;
}

void derived_end(DerivedReader *reader) { fclose(reader->file); }
