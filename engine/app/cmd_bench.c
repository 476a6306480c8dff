// cmd_bench.c - `enfilade bench NAME`: tables of measurements, a benchmark a row of the table below.
#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "engine/app/bench.h"

static const char HELP[] =
    "usage: enfilade bench NAME [FILE ...] [options]\n\n"
    "Measures, and writes CSV with a header on standard output (default FILE: build/maps/office.plan).\n\n"
    "  walk           each culling method along the auto tour of each building: polygons drawn, cells seen, "
    "time of\n"
    "                 the query and of the whole frame\n"
    "    --size WxH   of the frames, pixels, 16 to 8192 each (default 640x360)\n"
    "    --look NAME  fast (default) or fine\n"
    "    --frames N   of the tour, evenly taken, 1 to 1000000 (default 200)\n\n"
    "  collision      a body walks at random while doors move: walls and pieces of furniture looked at a "
    "step, places\n"
    "                 where it may not be, ways of a flood of the floor that it cannot walk, time\n"
    "    --steps N    1 to 100000000 (default 100000)\n"
    "    --seed N     of the walk, 0 to 2147483647 (default 1)\n";

static const struct {
    const char *name;
    bool (*run)(const BenchArguments *arguments, Error *error);
} BENCHES[] = {{"walk", bench_walk}, {"collision", bench_collision}};

enum { BENCH_COUNT = sizeof BENCHES / sizeof *BENCHES };

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

static int parse_option(int c, char **argv, BenchArguments *a) {
    int number;
    switch (c) {
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
        return app_misuse_option("bench", c, argv);
    }
}

int cmd_bench(int argc, char **argv) {
    static const struct option options[] = {{"help", no_argument, NULL, 'h'},
                                            {"size", required_argument, NULL, 's'},
                                            {"frames", required_argument, NULL, 'f'},
                                            {"look", required_argument, NULL, 'l'},
                                            {"steps", required_argument, NULL, 'n'},
                                            {"seed", required_argument, NULL, 'r'},
                                            {0}};
    static char office[] = "build/maps/office.plan";
    static char *usual[] = {office};
    BenchArguments a = {.width = 640, .height = 360, .frames = 200, .steps = 100000, .seed = 1};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":h", options, NULL)) != -1;) {
        if (c == 'h') return fputs(HELP, stdout) >= 0 ? APP_GOOD : APP_BAD_INPUT;
        int code = parse_option(c, argv, &a);
        if (code != APP_GOOD) return code;
    }
    if (optind == argc) return app_misuse("bench", "bench: which one? (allowed: walk, collision)");
    bool given = optind + 1 < argc;
    a.files = given ? argv + optind + 1 : usual;
    a.file_count = given ? argc - optind - 1 : 1;
    for (int i = 0; i < BENCH_COUNT; i++) {
        if (strcmp(BENCHES[i].name, argv[optind]) != 0) continue;
        Error error;
        return BENCHES[i].run(&a, &error) ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
    }
    return app_misuse("bench", "bench: there is no benchmark `%s` (allowed: walk, collision)", argv[optind]);
}
