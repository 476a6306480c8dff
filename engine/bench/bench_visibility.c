// bench_visibility.c - the cell-to-cell methods side by side: the time and memory of each, and how far its set of pairs
// exceeds a lower bound of the visible pairs. The bound is made here from sources that share nothing with the methods:
// sampled sightlines, a .seen file beside the building, and the methods' own sightlines if they hold when walked again.
//
// Every run has a process of its own: peak memory is the run's, and no thread is left over from an earlier one.
#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/bench/apart.h"
#include "engine/bench/bench.h"
#include "engine/bench/peer.h"
#include "engine/core/clock.h"
#include "engine/core/error.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/core/text.h"
#include "maps/quake/quake.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/sample.h"
#include "visibility/pairs/seen_file.h"

typedef struct PeerRun {
    PeerUsage usage;
    uint64_t
        *seen;  // as PairSet.seen, but as the program left it: neither symmetric nor with its diagonal set
    int cell_count;
} PeerRun;

enum { VERSION = 29, LUMPS = 15, ENTITIES = 0, TEXTURES = 2, VISIBILITY = 4, LEAVES = 10, MODELS = 14 };
enum { LEVEL_HEAD = 4 + 8 * LUMPS, LEAF_SIZE = 28, MODEL_SIZE = 64 };
enum { CONTENTS_EMPTY = -1, CONTENTS_SOLID = -2, NONE = -1 };
// The offsets of the numbers that are not zero in their records.
enum { LEAF_ROW = 4, MODEL_HEAD_NODES = 36, MODEL_LEAVES = 52 };
static const char ENTITY_TEXT[] = "{\n\"classname\" \"worldspawn\"\n}\n";

static void put_int(unsigned char *at, int value) {
    for (int k = 0; k < 4; k++) at[k] = (unsigned char)((uint32_t)value >> (8 * k));
}

// A level of `cell_count` leaves and nothing else.
static Bytes bsp29_make(int cell_count, Arena *arena) {
    size_t sizes[LUMPS] = {[ENTITIES] = sizeof ENTITY_TEXT,
                           [TEXTURES] = 4,
                           [LEAVES] = LEAF_SIZE * ((size_t)cell_count + 1),
                           [MODELS] = MODEL_SIZE};
    size_t at[LUMPS], size = LEVEL_HEAD;
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
    for (int k = 0; k < 3; k++) put_int(data + at[MODELS] + MODEL_HEAD_NODES + 4 * k, NONE);
    put_int(data + at[MODELS] + MODEL_LEAVES, cell_count);
    return (Bytes){data, size};
}

// Reads the leaves that each leaf of a level from bsp29_make sees, as PairSet.seen, after the level was compiled. Refuses a level
// without visibility.
static bool bsp29_read_seen(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error) {
    enum { LIMIT = 1 << 30 };
    Bytes content;
    QuakeLevel level;
    if (!file_read(path, LIMIT, arena, &content, error) || !quake_read(path, content, arena, &level, error))
        return false;
    if (level.cluster_count != cell_count)
        return error_set(error, "%s: has %d leaves (expected %d)", path, level.cluster_count, cell_count);
    for (int c = 0; c < cell_count; c++) {
        if (level.leaves[c + 1].row < 0)
            return error_set(error, "%s: leaf %d has no visibility", path, c + 1);
    }
    int words = (cell_count + 63) / 64;
    *rows = ARENA_ARRAY(arena, uint64_t, (size_t)cell_count * (size_t)words);
    return quake_rows(&level, words, *rows, error);
}

enum { MOST_BYTES = 1 << 28, MOST_CELLS = 1 << 16 };

static int count_cells(Bytes content) {
    int cells = 0;
    return sscanf((const char *)content.data, "PRT1 %d", &cells) == 1 && cells > 0 && cells <= MOST_CELLS
               ? cells
               : 0;
}

typedef struct PeerJob {
    const char *program, *file;
    int threads;
    PeerRun *out;
} PeerJob;

static bool run_compiler(const char *folder, void *context, Arena *arena, Error *error) {
    const PeerJob *job = context;
    PeerRun *out = job->out;
    Bytes portals;
    if (!file_read(job->file, MOST_BYTES, arena, &portals, error)) return false;
    *out = (PeerRun){.cell_count = count_cells(portals)};
    if (!out->cell_count)
        return error_set(error, "%s: is no PRT1 file, which `%s` reads", job->file, job->program);
    Bytes level = bsp29_make(out->cell_count, arena);
    const char *path = arena_format(arena, "%s/map.bsp", folder);
    const char *words[] = {job->program, "-threads", arena_format(arena, "%d", job->threads), path, NULL};
    return file_write(arena_format(arena, "%s/map.prt", folder), portals.data, portals.size, error) &&
           file_write(path, level.data, level.size, error) &&
           peer_run(words, folder, arena, &out->usage, error) &&
           bsp29_read_seen(path, out->cell_count, arena, &out->seen, error);
}

enum { MOST_METHODS = 32, FIGURES = 17 };
static const char HEAD[] =
    "building,method,cells,portals,cpu_s_1_thread,wall_s_1_thread,cpu_s_2_threads,wall_s_2_threads,peak_mb,"
    "visible_pairs,symmetric_pairs,proven_pairs,over_percent,symmetric_over_percent,misses,undecided,chains,"
    "clips,"
    "separators,stopped,note\n";

// One run of a method, in shared memory: the process that runs it fills in the results.
typedef struct MethodRun {
    const CellGraph *graph;
    const PairMethod *method;
    PairOptions options;
    double seconds;  // to stop after; 0: when done
    double cpu_seconds, wall_seconds, peak_mb;
    long long refuted;
    ChainWork work;
    bool stopped, has_proofs;
    uint64_t *seen, *checked;  // [cell_count * words] in shared memory, too
} MethodRun;

typedef struct FileBench {
    const char *file;
    const BenchArguments *arguments;
    LoadedScene scene;
    size_t rows_size;  // bytes of a matrix
    uint64_t *bound;
    const PairMethod *methods[MOST_METHODS];
    MethodRun *one[MOST_METHODS], *two[MOST_METHODS],
        *proving[MOST_METHODS];  // on 1 and 2 threads; with witnesses
    int method_count;
    PeerRun peer[2];  // on 1 and 2 threads
    bool has_peer;
    Error no_peer;  // why
} FileBench;

static void find_pairs(void *context) {
    MethodRun *run = context;
    Arena arena = {0};
    PairSet set;
    Progress progress = app_progress_stoppable(run->seconds);
    ApartUsage before = apart_usage();
    double start = clock_seconds();
    run->method->find(run->graph, &run->options, &progress, &arena, &set);
    run->wall_seconds = clock_seconds() - start;
    ApartUsage after = apart_usage();
    app_progress_end();
    run->cpu_seconds = after.cpu_seconds - before.cpu_seconds;
    run->peak_mb = after.peak_mb;
    run->work = set.work;
    run->stopped = set.stopped;
    size_t size = (size_t)set.cell_count * (size_t)set.words;
    memcpy(run->seen, set.seen, size * sizeof *set.seen);
    run->has_proofs = pair_count(set.proven, set.cell_count, set.words) > set.cell_count;
    run->refuted = pairs_check_witnesses(run->graph, &set, run->checked);
    arena_free(&arena);
}

static MethodRun *run_method(FileBench *b, const PairMethod *method, int threads, bool witnesses,
                             Error *error) {
    MethodRun *run = apart_memory(sizeof *run);
    *run = (MethodRun){.graph = &b->scene.graph,
                       .method = method,
                       .options = {.threads = threads, .witnesses = witnesses},
                       .seconds = b->arguments->seconds,
                       .seen = apart_memory(b->rows_size),
                       .checked = apart_memory(b->rows_size)};
    return apart_run(find_pairs, run, method->name, error) ? run : NULL;
}

static void free_run(const FileBench *b, MethodRun *run) {
    if (!run) return;
    apart_memory_free(run->seen, b->rows_size);
    apart_memory_free(run->checked, b->rows_size);
    apart_memory_free(run, sizeof *run);
}

// Times are taken without witnesses, as compilers work; a third run finds the pairs that can be proven.
static bool run_methods(FileBench *b, Error *error) {
    int cells = b->scene.graph.cell_count;
    for (int i = 0; i < b->method_count; i++) {
        const PairMethod *method = b->methods[i];
        if (!(b->one[i] = run_method(b, method, 1, false, error))) return false;
        if (!(b->two[i] = run_method(b, method, 2, false, error))) return false;
        bool ended = !b->one[i]->stopped && !b->two[i]->stopped;
        if (ended && memcmp(b->one[i]->seen, b->two[i]->seen, b->rows_size) != 0)
            return error_set(error, "%s: %s finds other pairs on 2 threads than on 1", b->file, method->name);
        if (!b->one[i]->has_proofs) continue;
        if (!(b->proving[i] = run_method(b, method, 2, true, error))) return false;
        pairs_unite(b->proving[i]->checked, cells, b->bound);
        if (b->proving[i]->refuted > 0)
            fprintf(stderr, "%s: %lld sightlines of %s do not hold when walked again\n", b->file,
                    b->proving[i]->refuted, method->name);
    }
    return true;
}

typedef struct Sampling {
    const CellGraph *graph;
    SampleOptions options;
    uint64_t *proven;
} Sampling;

static void sample(void *context) {
    Sampling *sampling = context;
    Arena arena = {0};
    SampleSet set;
    Progress progress = app_progress();
    sample_pairs(sampling->graph, &sampling->options, &progress, &arena, &set);
    app_progress_end();
    memcpy(sampling->proven, set.proven, (size_t)set.cell_count * (size_t)set.words * sizeof *set.proven);
    arena_free(&arena);
}

static SampleOptions sample_options(const BenchArguments *a) {
    SampleOptions options = sample_default_options();
    options.points = a->samples;
    options.seed = a->seed;
    return options;
}

// Pairs that are known to be visible before any method ran.
static bool make_bound(FileBench *b, Arena *arena, Error *error) {
    int cells = b->scene.graph.cell_count, words = (cells + 63) / 64;
    b->rows_size = (size_t)cells * (size_t)words * sizeof *b->bound;
    b->bound = ARENA_ARRAY(arena, uint64_t, (size_t)cells * (size_t)words);
    for (int c = 0; c < cells; c++)
        b->bound[(size_t)c * (size_t)words + (size_t)c / 64] |= (uint64_t)1 << (c % 64);
    if (b->arguments->samples > 0) {
        Sampling sampling = {&b->scene.graph, sample_options(b->arguments), apart_memory(b->rows_size)};
        if (!apart_run(sample, &sampling, "sampling", error)) return false;
        pairs_unite(sampling.proven, cells, b->bound);
        apart_memory_free(sampling.proven, b->rows_size);
    }
    const char *dot = strrchr(b->file, '.');
    const char *beside = arena_format(arena, "%.*s.seen", (int)(dot ? dot - b->file : 0), b->file);
    uint64_t *rows;
    if (access(beside, R_OK) != 0) return true;
    if (!seen_read(beside, cells, arena, &rows, error)) return false;
    pairs_unite(rows, cells, b->bound);
    return true;
}

static void run_peer(FileBench *b, Arena *arena) {
    const char *program = b->arguments->peer;
    if (!program) {
        error_set(&b->no_peer, "no --peer was given");
        return;
    }
    b->has_peer = true;
    for (int i = 0; i < 2 && b->has_peer; i++) {
        PeerJob job = {program, b->file, i + 1, &b->peer[i]};
        b->has_peer = peer_in_folder(run_compiler, &job, arena, &b->no_peer);
    }
}

// Where a proven pair is missed: the sightline, so that it can be looked into.
static void print_miss(const FileBench *b, const char *method, const PairFigures *f) {
    PairWitness line;
    SampleOptions options = sample_options(b->arguments);
    fprintf(stderr, "%s: %s misses that cells %d and %d see each other", b->file, method, f->miss[0],
            f->miss[1]);
    if (b->arguments->samples > 0 &&
        (sample_sightline(&b->scene.graph, &options, f->miss[0], f->miss[1], &line) ||
         sample_sightline(&b->scene.graph, &options, f->miss[1], f->miss[0], &line)))
        fprintf(stderr, " along %.17g,%.17g,%.17g to %.17g,%.17g,%.17g, which starts in %d", line.from.x,
                line.from.y, line.from.z, line.to.x, line.to.y, line.to.z, line.a);
    fputc('\n', stderr);
}

// The columns on pairs: for a set as it is, and for the pairs that remain when both cells of a pair must see each other.
static void add_pairs(const FileBench *b, const char *method, const uint64_t *seen, Text *row) {
    Arena scratch = {0};
    int cells = b->scene.graph.cell_count;
    uint64_t *both = arena_alloc(&scratch, b->rows_size, 1);
    pairs_intersect_transpose(seen, cells, both);
    PairFigures f = pairs_compare(seen, b->bound, cells), s = pairs_compare(both, b->bound, cells);
    text_append(row, "%lld,%lld,%lld,%.4f,%.4f,%lld,", f.visible, s.visible, f.bound, pairs_over(&f),
                pairs_over(&s), f.missed);
    if (f.missed > 0) print_miss(b, method, &f);
    arena_free(&scratch);
}

static void add_head(const FileBench *b, const char *method, Text *row) {
    text_append(row, "%s,%s,%d,%d,", bench_name(b->file), method, b->scene.graph.cell_count,
                b->scene.graph.portal_count);
}

static void add_method(const FileBench *b, int i, Text *row) {
    const MethodRun *one = b->one[i], *two = b->two[i], *proving = b->proving[i];
    add_head(b, one->method->name, row);
    text_append(row, "%.4f,%.4f,%.4f,%.4f,%.1f,", one->cpu_seconds, one->wall_seconds, two->cpu_seconds,
                two->wall_seconds, one->peak_mb);
    add_pairs(b, one->method->name, one->seen, row);
    // A method without sightlines leaves all pairs undecided but those of a cell with itself.
    PairFigures own = pairs_compare(one->seen, (proving ? proving : one)->checked, b->scene.graph.cell_count);
    text_append(row, "%lld,%lld,%lld,%lld,%s,\n", own.beyond, one->work.chains, one->work.clips,
                one->work.separators, one->stopped || two->stopped ? "yes" : "no");
}

static void add_peer(const FileBench *b, Text *row) {
    add_head(b, "peer", row);
    if (b->has_peer) {
        const PeerUsage *one = &b->peer[0].usage, *two = &b->peer[1].usage;
        text_append(row, "%.4f,%.4f,%.4f,%.4f,%.1f,", one->cpu_seconds, one->wall_seconds, two->cpu_seconds,
                    two->wall_seconds, one->peak_mb);
        add_pairs(b, "peer", b->peer[0].seen, row);
        text_append(row, ",,,,no,%s\n", bench_name(b->arguments->peer));
    } else {
        for (int i = 0; i < FIGURES - 1; i++) text_append(row, "skipped,");
        text_append(row, "\"%s\"\n", b->no_peer.text);
    }
}

static void choose_methods(FileBench *b) {
    const char *names = b->arguments->methods;
    for (int i = 0; PAIR_METHODS[i] && !names; i++) {
        CORE_ASSERT(i < MOST_METHODS);
        b->methods[b->method_count++] = PAIR_METHODS[i];
    }
    while (names && *names && b->method_count < MOST_METHODS) {
        char name[32];
        int length = (int)strcspn(names, ",");
        snprintf(name, sizeof name, "%.*s", length, names);
        b->methods[b->method_count++] = pair_method(name);
        names += length + (names[length] == ',');
    }
}

static bool visibility_of_file(const char *file, const BenchArguments *a, Text *table, Error *error) {
    Arena arena = {0};
    FileBench b = {.file = file, .arguments = a};
    SceneOptions options = a->load;
    choose_methods(&b);
    run_peer(&b, &arena);  // first: while this process is small, the peak of its child is the child's own
    bool good = scene_load_cells(file, &options, &arena, &b.scene, error) && make_bound(&b, &arena, error) &&
                run_methods(&b, error);
    size_t start = table->size;
    for (int i = 0; i < b.method_count && good; i++) add_method(&b, i, table);
    if (good) add_peer(&b, table);
    if (good) fputs(table->data + start, stdout);
    fflush(stdout);
    for (int i = 0; i < b.method_count; i++) {
        free_run(&b, b.one[i]);
        free_run(&b, b.two[i]);
        free_run(&b, b.proving[i]);
    }
    arena_free(&arena);
    return good;
}

static bool measure_visibility(const BenchArguments *a, Error *error) {
    return bench_table(a, HEAD, NULL, visibility_of_file, error);
}

static bool is_visibility_method(const char *name) { return pair_method(name) != NULL; }

static const Option ROWS[] = {
    BENCH_METHODS("some of the methods (default: all; `enfilade vis --help` lists them)"),
    {.name = "samples",
     .value = "N",
     .type = OPTION_INT,
     .at = BENCH_AT(samples),
     .high = 1000000,
     .help = "points on each portal for the proven pairs, @ (default 12); a file of proven pairs beside "
             "FILE, with the "
             "suffix .seen, is taken besides"},
    BENCH_SEED("of the samples"),
    {.name = "seconds",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = BENCH_AT(seconds),
     .low = 0.001,
     .high = 1e6,
     .help = "stops a method after S seconds, @"},
    {.name = "peer",
     .value = "PROGRAM",
     .type = OPTION_TEXT,
     .at = BENCH_AT(peer),
     .help = "a row for an external visibility compiler for Quake levels, of portal files"},
    BENCH_CSV,
};

const Bench BENCH_VISIBILITY = {
    .name = "visibility",
    .about = "each cell-to-cell method: CPU and wall time on 1 and 2 threads, memory, visible pairs, "
             "over-estimate "
             "against pairs proven by sightlines, misses, pairs left undecided",
    BENCH_OPTIONS(ROWS),
    .run = measure_visibility,
    .is_method = is_visibility_method,
    .list = "vis",
};
