// cmd_bench.c - `enfilade bench NAME`: tables of measurements, a benchmark a row of the table below.
#include <ctype.h>
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/bench/bench.h"
#include "engine/core/file.h"
#include "radiosity/factors/view.h"

extern const Bench BENCH_WALK, BENCH_COLLISION, BENCH_VISIBILITY, BENCH_FORMFACTORS, BENCH_RADIOSITY,
    BENCH_LIGHT, BENCH_MESHES, BENCH_ROOMS, BENCH_HIDDEN, BENCH_BREAKS, BENCH_RAYS;
static const Bench *const BENCHES[] = {
    &BENCH_WALK,   &BENCH_COLLISION, &BENCH_VISIBILITY, &BENCH_FORMFACTORS, &BENCH_RADIOSITY, &BENCH_LIGHT,
    &BENCH_MESHES, &BENCH_ROOMS,     &BENCH_HIDDEN,     &BENCH_BREAKS,      &BENCH_RAYS};
enum { BENCH_COUNT = sizeof BENCHES / sizeof *BENCHES };

static const char USUAL_FILES[] = "build/maps/office.plan";

bool bench_table(const BenchArguments *a, const char *head,
                 bool (*first)(const BenchArguments *arguments, Text *csv, Error *error), BenchFile *each,
                 Error *error) {
    Arena arena = {0};
    Text csv = {.arena = &arena};
    text_append(&csv, "%s", head);
    fputs(head, stdout);
    bool good = !first || first(a, &csv, error);
    for (int i = 0; i < a->file_count && good; i++) good = each(a->files[i], a, &csv, error);
    if (good && a->csv) good = file_write(a->csv, csv.data, csv.size, error);
    arena_free(&arena);
    return good;
}

const char *bench_name(const char *file) {
    const char *slash = strrchr(file, '/');
    return slash ? slash + 1 : file;
}

bool bench_listed(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && *at; at += strcspn(at, ","), at += *at == ',')
        if (strcspn(at, ",") == length && strncmp(at, word, length) == 0) return true;
    return !list;
}

static int parse_look(const char *text, WalkLook *out) {
    int look = WALK_FAST;
    // The baked look needs light, which is not looked for here.
    int code = app_parse_name("bench", "--look", text, WALK_LOOK_NAMES, WALK_FINE + 1, &look);
    *out = (WalkLook)look;
    return code;
}

// Words, separated by commas: the next one, of at most 39 bytes; false after the last.
static bool next_word(const char **words, char word[40]) {
    if (!**words) return false;
    size_t length = strcspn(*words, ",");
    snprintf(word, 40, "%.*s", (int)length, *words);
    *words += length + ((*words)[length] == ',');
    return true;
}

static int parse_cullings(const char *names, BenchArguments *a) {
    char name[40];
    int culling, code = APP_GOOD;
    a->cullings = names;
    while (code == APP_GOOD && next_word(&names, name))
        code = app_parse_name("bench", "--cullings", name, VIEW_CULLING_NAMES, VIEW_CULLINGS, &culling);
    return code;
}

// Names of methods, separated by commas.
static bool are_methods(const char *names, bool (*knows)(const char *)) {
    char name[40];
    while (next_word(&names, name))
        if (!knows(name)) return false;
    return true;
}

enum {
    METHODS = 256,
    SAMPLES,
    SECONDS,
    PEER,
    CSV,
    RESOLUTIONS,
    CULLINGS,
    SHOOTERS,
    RAYS,
    QUICK,
    PICTURES,
    POINTS,
    TRUTH_ERROR,
    VERBOSE,
    SKY
};

// Whole numbers, separated by commas.
static bool parse_resolutions(const char *text, BenchArguments *a) {
    char number[16];
    for (a->resolution_count = 0; *text && a->resolution_count < 16; text += *text == ',') {
        size_t length = strcspn(text, ",");
        snprintf(number, sizeof number, "%.*s", (int)length, text);
        if (!app_parse_int(number, 8, 2000, &a->resolutions[a->resolution_count++])) return false;
        text += length;
    }
    return *text == 0 && a->resolution_count > 0;
}

static int parse_light_option(int c, char **argv, BenchArguments *a) {
    switch (c) {
    case POINTS:
        if (app_parse_int(optarg, 1, 1000000, &a->points)) return APP_GOOD;
        return app_misuse("bench", "bench: --points is `%s` (allowed 1 to 1000000)", optarg);
    case TRUTH_ERROR:
        if (app_parse_number(optarg, 1e-6, 1, &a->error)) return APP_GOOD;
        return app_misuse("bench", "bench: --error is `%s` (allowed 1e-6 to 1)", optarg);
    case SKY:
        if (app_parse_sky(optarg, a->sky)) return APP_GOOD;
        return app_misuse("bench", "bench: --sky is `%s` (allowed L or R,G,B, 0 to 1e6 each)", optarg);
    case VERBOSE:
        a->verbose = true;
        return APP_GOOD;
    default:
        return app_misuse_option("bench", c, argv);
    }
}

static int parse_form_factor_option(int c, char **argv, BenchArguments *a) {
    switch (c) {
    case RESOLUTIONS:
        if (parse_resolutions(optarg, a)) return APP_GOOD;
        return app_misuse("bench", "bench: --resolutions is `%s` (allowed 8 to 2000, 16 of them at most)",
                          optarg);
    case CULLINGS:
        return parse_cullings(optarg, a);
    case SHOOTERS:
        if (app_parse_int(optarg, 1, 10000, &a->shooters)) return APP_GOOD;
        return app_misuse("bench", "bench: --shooters is `%s` (allowed 1 to 10000)", optarg);
    case RAYS:
        if (app_parse_int(optarg, 1000, 2000000000, &a->rays)) return APP_GOOD;
        return app_misuse("bench", "bench: --rays is `%s` (allowed 1000 to 2000000000)", optarg);
    case QUICK:
        a->shooters = 20;
        a->rays = 300000;
        return APP_GOOD;
    case PICTURES:
        a->pictures = optarg;
        return APP_GOOD;
    default:
        return parse_light_option(c, argv, a);
    }
}

static int parse_visibility_option(int c, char **argv, BenchArguments *a) {
    switch (c) {
    case METHODS:
        a->methods = optarg;
        return APP_GOOD;
    case SAMPLES:
        if (app_parse_int(optarg, 0, 1000000, &a->samples)) return APP_GOOD;
        return app_misuse("bench", "bench: --samples is `%s` (allowed 0 to 1000000)", optarg);
    case SECONDS:
        if (app_parse_number(optarg, 0.001, 1e6, &a->seconds)) return APP_GOOD;
        return app_misuse("bench", "bench: --seconds is `%s` (allowed 0.001 to 1e6)", optarg);
    case PEER:
        a->peer = optarg;
        return APP_GOOD;
    case CSV:
        a->csv = optarg;
        return APP_GOOD;
    default:
        return parse_form_factor_option(c, argv, a);
    }
}

static int parse_option(int c, char **argv, BenchArguments *a) {
    int number;
    switch (c) {
    case 'm':
        a->map = optarg;
        return APP_GOOD;
    case 'y':
        return app_take_memory("bench", optarg);
    case 's':
        if (app_parse_size(optarg, &a->width, &a->height)) return APP_GOOD;
        return app_misuse("bench", "bench: --size is `%s` (allowed WxH, 16 to 8192 each)", optarg);
    case 'f':
        if (app_parse_int(optarg, 1, 1000000, &a->frames)) return APP_GOOD;
        return app_misuse("bench", "bench: --frames is `%s` (allowed 1 to 1000000)", optarg);
    case 'l':
        return parse_look(optarg, &a->look);
    case 'n':
        if (app_parse_int(optarg, 1, 100000000, &a->steps)) return APP_GOOD;
        return app_misuse("bench", "bench: --steps is `%s` (allowed 1 to 100000000)", optarg);
    case 'r':
        if (!app_parse_int(optarg, 0, INT32_MAX, &number))
            return app_misuse("bench", "bench: --seed is `%s` (allowed 0 to 2147483647)", optarg);
        a->seed = (uint64_t)number;
        return APP_GOOD;
    default:
        return parse_visibility_option(c, argv, a);
    }
}

static bool print_help(void) {
    printf("usage: enfilade bench NAME [FILE ...] [options]\n\n"
           "Measures, and writes CSV with a header on standard output (default FILE: %s).\n"
           "--map NAME chooses among the maps of files that hold several (default: the first); --memory MB "
           "sets what may "
           "be used,\n16 to 1000000 (default: what fits a file to open it, then three quarters of the "
           "machine's).\n",
           USUAL_FILES);
    for (int i = 0; i < BENCH_COUNT; i++) {
        printf("\n%s", BENCHES[i]->help);
        if (BENCHES[i]->print_methods) BENCHES[i]->print_methods();
    }
    return fflush(stdout) == 0;
}

static int misuse_name(const char *what) {
    char names[256] = "";
    for (int i = 0; i < BENCH_COUNT; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", BENCHES[i]->name);
    }
    return app_misuse("bench", "bench: %s (allowed: %s)", what, names);
}

// An option is a benchmark's if its help tells of it; --map and --memory are any's.
static bool has_option(const Bench *bench, const char *name) {
    char option[40];
    size_t length = (size_t)snprintf(option, sizeof option, "--%s", name);
    for (const char *at = bench->help; (at = strstr(at, option)); at += length)
        if (!isalpha((unsigned char)at[length]) && at[length] != '-') return true;
    return strcmp(name, "map") == 0 || strcmp(name, "memory") == 0;
}

static int run(const Bench *bench, BenchArguments *a, char **files, int file_count) {
    if (a->methods && !are_methods(a->methods, bench->knows))
        return app_misuse("bench", "bench: --methods is `%s` (`enfilade %s --help` lists those allowed)",
                          a->methods, bench->list);
    Error error;
    char usual[128], *word[4];
    snprintf(usual, sizeof usual, "%s", bench->files ? bench->files : USUAL_FILES);
    if (file_count == 0) {
        for (char *at = strtok(usual, " "); at && file_count < 4; at = strtok(NULL, " "))
            word[file_count++] = at;
        files = word;
    }
    a->files = files;
    a->file_count = file_count;
    bool good =
        app_check_files(&a->csv, 1, (const char *const *)files, file_count, &error) && bench->run(a, &error);
    return good ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
}

int cmd_bench(int argc, char **argv) {
    static const struct option options[] = {{"help", no_argument, NULL, 'h'},
                                            {"size", required_argument, NULL, 's'},
                                            {"frames", required_argument, NULL, 'f'},
                                            {"look", required_argument, NULL, 'l'},
                                            {"steps", required_argument, NULL, 'n'},
                                            {"seed", required_argument, NULL, 'r'},
                                            {"methods", required_argument, NULL, METHODS},
                                            {"samples", required_argument, NULL, SAMPLES},
                                            {"seconds", required_argument, NULL, SECONDS},
                                            {"peer", required_argument, NULL, PEER},
                                            {"map", required_argument, NULL, 'm'},
                                            {"memory", required_argument, NULL, 'y'},
                                            {"csv", required_argument, NULL, CSV},
                                            {"resolutions", required_argument, NULL, RESOLUTIONS},
                                            {"cullings", required_argument, NULL, CULLINGS},
                                            {"shooters", required_argument, NULL, SHOOTERS},
                                            {"rays", required_argument, NULL, RAYS},
                                            {"quick", no_argument, NULL, QUICK},
                                            {"pictures", required_argument, NULL, PICTURES},
                                            {"points", required_argument, NULL, POINTS},
                                            {"error", required_argument, NULL, TRUTH_ERROR},
                                            {"verbose", no_argument, NULL, VERBOSE},
                                            {"sky", required_argument, NULL, SKY},
                                            {0}};
    BenchArguments a = {.width = 640,
                        .height = 360,
                        .frames = 200,
                        .steps = 100000,
                        .seed = 1,
                        .samples = 12,
                        .cullings = "none,depth,portals",
                        .resolutions = {50, 71, 100, 141, 200},
                        .resolution_count = 5,
                        .shooters = 60,
                        .rays = 4000000};
    bool given[sizeof options / sizeof *options] = {false};
    opterr = 0;
    for (int c, at = 0; (c = getopt_long(argc, argv, ":h", options, &at)) != -1;) {
        given[at] = true;
        if (c == 'h') return print_help() ? APP_GOOD : APP_BAD_INPUT;
        int code = parse_option(c, argv, &a);
        if (code != APP_GOOD) return code;
    }
    if (optind == argc) return misuse_name("which one?");
    for (int i = 0; i < BENCH_COUNT; i++) {
        const Bench *bench = BENCHES[i];
        if (strcmp(bench->name, argv[optind]) != 0) continue;
        for (int k = 0; options[k].name; k++)
            if (given[k] && !has_option(bench, options[k].name))
                return app_misuse("bench", "bench: %s has no --%s", bench->name, options[k].name);
        return run(bench, &a, argv + optind + 1, argc - optind - 1);
    }
    char what[80];
    snprintf(what, sizeof what, "there is no benchmark `%.40s`", argv[optind]);
    return misuse_name(what);
}
