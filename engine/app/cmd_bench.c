// cmd_bench.c - `enfilade bench NAME`: tables of measurements, a benchmark a row of the table below.
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/bench.h"
#include "engine/core/file.h"
#include "radiosity/form_factor.h"
#include "visibility/pairs/pairs.h"

static bool is_pair_method(const char *name) { return pair_method(name) != NULL; }
static bool is_culling(const char *name) {
    for (int c = 0; c < VIEW_CULLINGS; c++)
        if (strcmp(VIEW_CULLING_NAMES[c], name) == 0) return true;
    return false;
}

static const struct {
    const char *name;
    bool (*run)(const BenchArguments *arguments, Error *error);
    bool (*knows)(const char *method);  // of --methods; NULL: it has none
    const char *list;                   // the command whose help lists them
} BENCHES[] = {{"walk", bench_walk, NULL, NULL},
               {"collision", bench_collision, NULL, NULL},
               {"visibility", bench_visibility, is_pair_method, "vis"},
               {"formfactors", bench_formfactors, bench_formfactors_knows, "bake"},
               {"radiosity", bench_radiosity, NULL, NULL},
               {"light", bench_light, bench_light_knows, "bench"},
               {"meshes", bench_meshes, NULL, NULL},
               {"rooms", bench_rooms, NULL, NULL},
               {"hidden", bench_hidden, bench_hidden_knows, "bake"},
               {"breaks", bench_breaks, NULL, NULL},
               {"rays", bench_rays, NULL, NULL}};

static const char ALLOWED[] =
    "walk, collision, visibility, formfactors, radiosity, light, meshes, rooms, hidden, breaks, rays";

enum { BENCH_COUNT = sizeof BENCHES / sizeof *BENCHES };

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

static int parse_look(const char *text, WalkLook *out) {
    *out = WALK_FAST;
    while (*out < WALK_LOOKS && strcmp(WALK_LOOK_NAMES[*out], text) != 0) ++*out;
    if (*out < WALK_LOOKS) return APP_GOOD;
    return app_misuse("bench", "bench: --look is `%s` (allowed fast, fine)", text);
}

// Names of methods, separated by commas.
static bool are_methods(const char *names, bool (*knows)(const char *)) {
    char name[40];
    for (; *names; names += strcspn(names, ","), names += *names == ',') {
        snprintf(name, sizeof name, "%.*s", (int)strcspn(names, ","), names);
        if (!knows(name)) return false;
    }
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
        a->cullings = optarg;
        if (are_methods(optarg, is_culling)) return APP_GOOD;
        return app_misuse("bench", "bench: --cullings is `%s` (allowed none, cells, plan, portals)", optarg);
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
    static char office[] = "build/maps/office.plan", plain[] = "build/maps/office-plain.plan",
                house[] = "build/maps/house.plan";
    static char *usual[] = {office}, *usual_light[] = {plain, house};
    BenchArguments a = {.width = 640,
                        .height = 360,
                        .frames = 200,
                        .steps = 100000,
                        .seed = 1,
                        .samples = 12,
                        .cullings = "none,portals",
                        .resolutions = {50, 71, 100, 141, 200},
                        .resolution_count = 5,
                        .shooters = 60,
                        .rays = 4000000};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":h", options, NULL)) != -1;) {
        if (c == 'h') return bench_print_help() ? APP_GOOD : APP_BAD_INPUT;
        int code = parse_option(c, argv, &a);
        if (code != APP_GOOD) return code;
    }
    if (optind == argc) return app_misuse("bench", "bench: which one? (allowed: %s)", ALLOWED);
    bool given = optind + 1 < argc;
    a.files = given ? argv + optind + 1 : usual;
    a.file_count = given ? argc - optind - 1 : 1;
    if (!given && (strcmp(argv[optind], "light") == 0 || strcmp(argv[optind], "meshes") == 0)) {
        a.files = usual_light;
        a.file_count = 2;
    }
    for (int i = 0; i < BENCH_COUNT; i++) {
        if (strcmp(BENCHES[i].name, argv[optind]) != 0) continue;
        if (a.methods && BENCHES[i].knows && !are_methods(a.methods, BENCHES[i].knows))
            return app_misuse("bench", "bench: --methods is `%s` (`enfilade %s --help` lists those allowed)",
                              a.methods, BENCHES[i].list);
        Error error;
        return BENCHES[i].run(&a, &error) ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
    }
    return app_misuse("bench", "bench: there is no benchmark `%s` (allowed: %s)", argv[optind], ALLOWED);
}
