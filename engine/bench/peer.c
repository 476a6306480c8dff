// peer.c - runs an external visibility compiler in a folder of its own.
#include "engine/bench/peer.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"

enum { VERSION = 29, LUMPS = 15, ENTITIES = 0, TEXTURES = 2, VISIBILITY = 4, LEAVES = 10, MODELS = 14 };
enum { HEAD = 4 + 8 * LUMPS, LEAF_SIZE = 28, MODEL_SIZE = 64 };
enum { CONTENTS_EMPTY = -1, CONTENTS_SOLID = -2, NONE = -1 };
// Where in their records what is not zero stands.
enum { LEAF_ROW = 4, MODEL_HEAD_NODES = 36, MODEL_LEAVES = 52 };
static const char ENTITY_TEXT[] = "{\n\"classname\" \"worldspawn\"\n}\n";

static void put_int(unsigned char *at, int value) {
    for (int k = 0; k < 4; k++) at[k] = (unsigned char)((uint32_t)value >> (8 * k));
}
static int get(const unsigned char *at) {
    return (int)(at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24);
}

// A level of `cell_count` leaves and nothing else.
static Bytes bsp29_make(int cell_count, Arena *arena) {
    size_t sizes[LUMPS] = {[ENTITIES] = sizeof ENTITY_TEXT,
                           [TEXTURES] = 4,
                           [LEAVES] = LEAF_SIZE * ((size_t)cell_count + 1),
                           [MODELS] = MODEL_SIZE};
    size_t at[LUMPS], size = HEAD;
    for (int i = 0; i < LUMPS; i++) {
        at[i] = size;
        size += (sizes[i] + 3) / 4 * 4;
    }
    unsigned char *data = arena_alloc(arena, size, 1);
    put_int(data, VERSION);
    for (int i = 0; i < LUMPS; i++) {
        put_int(data + 4 + 8 * i, (int)at[i]);
        put_int(data + 8 + 8 * i, (int)sizes[i]);
    }
    memcpy(data + at[ENTITIES], ENTITY_TEXT, sizeof ENTITY_TEXT);
    for (int c = 0; c <= cell_count; c++) {
        unsigned char *leaf = data + at[LEAVES] + (size_t)c * LEAF_SIZE;
        put_int(leaf, c == 0 ? CONTENTS_SOLID : CONTENTS_EMPTY);
        put_int(leaf + LEAF_ROW, NONE);
    }
    for (int k = 1; k < 3; k++) put_int(data + at[MODELS] + MODEL_HEAD_NODES + 4 * k, NONE);
    put_int(data + at[MODELS] + MODEL_LEAVES, cell_count);
    return (Bytes){data, size};
}

static bool find_lump(const char *path, Bytes content, int lump, Bytes *out, Error *error) {
    int from = get(content.data + 4 + 8 * lump), size = get(content.data + 8 + 8 * lump);
    if (from < 0 || size < 0 || (size_t)from + (size_t)size > content.size)
        return error_set(error, "%s: lump %d reaches from %d over %d bytes (the file has %zu)", path, lump,
                         from, size, content.size);
    *out = (Bytes){content.data + from, (size_t)size};
    return true;
}

// Unpacks the row that begins at `from`; false where it is cut short.
static bool unpack(Bytes packed, size_t from, int cell_count, uint64_t *row) {
    size_t bytes = ((size_t)cell_count + 7) / 8, at = from;
    for (size_t k = 0; k < bytes;) {
        if (at >= packed.size) return false;
        unsigned char byte = packed.data[at++];
        if (byte) {
            row[k / 8] |= (uint64_t)byte << (k % 8 * 8);
            k++;
        } else {
            if (at >= packed.size || packed.data[at] == 0) return false;
            k += packed.data[at++];
        }
    }
    if (cell_count % 64) row[cell_count / 64] &= ((uint64_t)1 << (cell_count % 64)) - 1;
    return true;
}

// What the leaves of such a level see once it was compiled, as PairSet.seen. Refuses one without visibility.
static bool bsp29_read_seen(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error) {
    enum { LIMIT = 1 << 30 };
    Bytes content, leaves, packed;
    if (!file_read(path, LIMIT, arena, &content, error)) return false;
    if (content.size < HEAD || get(content.data) != VERSION)
        return error_set(error, "%s: is no level of version %d", path, VERSION);
    if (!find_lump(path, content, LEAVES, &leaves, error) ||
        !find_lump(path, content, VISIBILITY, &packed, error))
        return false;
    if (leaves.size != LEAF_SIZE * ((size_t)cell_count + 1)) {
        return error_set(error, "%s: has %zu leaves (expected %d)", path, leaves.size / LEAF_SIZE,
                         cell_count + 1);
    }
    size_t words = ((size_t)cell_count + 63) / 64;
    *rows = ARENA_ARRAY(arena, uint64_t, (size_t)cell_count * words);
    for (int c = 0; c < cell_count; c++) {
        int from = get(leaves.data + (size_t)(c + 1) * LEAF_SIZE + LEAF_ROW);
        if (from < 0 || !unpack(packed, (size_t)from, cell_count, *rows + (size_t)c * words))
            return error_set(error, "%s: leaf %d has no visibility", path, c + 1);
    }
    return true;
}

enum { MOST_BYTES = 1 << 28, MOST_CELLS = 1 << 16, OPEN_FOLDERS = 8 };

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *at) {
    (void)status, (void)type, (void)at;
    return remove(path);
}

static int count_cells(Bytes content) {
    int cells = 0;
    return sscanf((const char *)content.data, "PRT1 %d", &cells) == 1 && cells > 0 && cells <= MOST_CELLS
               ? cells
               : 0;
}

// Its output goes to `log`.
_Noreturn static void become(const char *program, const char *threads, const char *level, const char *log) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for it then
    int in = open("/dev/null", O_RDONLY), out = open(log, O_WRONLY | O_CREAT, 0600);
    if (in >= 0 && out >= 0 && dup2(in, 0) >= 0 && dup2(out, 1) >= 0 && dup2(out, 2) >= 0)
        execlp(program, program, "-threads", threads, level, (char *)NULL);
    fprintf(stderr, "%s\n", strerror(errno));
    _exit(127);
}

// The last line that a failed program wrote, for the sentence about it.
static const char *last_line(const char *log, Arena *arena) {
    Bytes text;
    if (!file_read(log, MOST_BYTES, arena, &text, NULL)) return "";
    char *start = (char *)text.data, *end = start + text.size;
    while (end > start && (end[-1] == '\n' || end[-1] == '\r')) *--end = 0;
    char *line = strrchr(start, '\n');
    return line ? line + 1 : start;
}

static bool run_compiler(const char *program, int threads, const char *folder, Arena *arena, PeerRun *out,
                         Error *error) {
    const char *level = arena_format(arena, "%s/map.bsp", folder),
               *log = arena_format(arena, "%s/log", folder);
    const char *number = arena_format(arena, "%d", threads);
    double start = clock_seconds();
    pid_t child = fork();
    if (child < 0) return error_set(error, "%s: cannot be started: %s", program, strerror(errno));
    if (child == 0) become(program, number, level, log);
    int status;
    struct rusage used;
    while (wait4(child, &status, 0, &used) < 0) {
        if (errno != EINTR) return error_set(error, "%s: is lost: %s", program, strerror(errno));
    }
    out->wall_seconds = clock_seconds() - start;
    out->cpu_seconds = (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                       1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    out->peak_mb = (double)used.ru_maxrss / 1024;
    if (WIFSIGNALED(status)) return error_set(error, "%s: ended by signal %d", program, WTERMSIG(status));
    if (WEXITSTATUS(status) == 0) return bsp29_read_seen(level, out->cell_count, arena, &out->seen, error);
    return error_set(error, "%s: exit status %d: %s", program, WEXITSTATUS(status), last_line(log, arena));
}

static void remove_folder(void *folder) { nftw(folder, remove_entry, OPEN_FOLDERS, FTW_DEPTH | FTW_PHYS); }

bool peer_run(const char *program, const char *file, int threads, Arena *arena, PeerRun *out, Error *error) {
    Bytes portals;
    if (!file_read(file, MOST_BYTES, arena, &portals, error)) return false;
    *out = (PeerRun){.cell_count = count_cells(portals)};
    if (!out->cell_count) return error_set(error, "%s: is no PRT1 file, which `%s` reads", file, program);
    const char *base = getenv("TMPDIR");
    char *folder = arena_format(arena, "%s/enfilade-peer-XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(folder)) return error_set(error, "%s: cannot be made: %s", folder, strerror(errno));
    MemoryEnd end = {.undo = remove_folder, .context = folder};
    memory_add_end(&end);
    Bytes level = bsp29_make(out->cell_count, arena);
    bool good = file_write(arena_format(arena, "%s/map.prt", folder), portals.data, portals.size, error) &&
                file_write(arena_format(arena, "%s/map.bsp", folder), level.data, level.size, error) &&
                run_compiler(program, threads, folder, arena, out, error);
    memory_remove_end(&end);
    remove_folder(folder);
    return good;
}
