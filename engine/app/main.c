// main.c - the program `enfilade`: picks the subcommand.
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "engine/app/app.h"
#include "maps/maps.h"

// Benchmarks are a program of their own, beside this one or on the PATH.
static int cmd_bench(int argc, char **argv) {
    (void)argc;
    char path[4096];
    ssize_t length = readlink("/proc/self/exe", path, sizeof path - 16);
    path[length > 0 ? length : 0] = 0;
    char *slash = strrchr(path, '/');
    snprintf(slash ? slash + 1 : path, 16, "enfilade-bench");
    if (slash) execv(path, argv);
    execvp("enfilade-bench", argv);
    return app_fail(APP_BAD_INPUT, "enfilade-bench: cannot be run: %s (it belongs beside this program)",
                    strerror(errno));
}

typedef struct AppCommand {
    const char *name, *summary;
    int (*run)(int argc, char **argv);  // argv[0] is the command's name
} AppCommand;

static const AppCommand COMMANDS[] = {
    {"info", "what is in a building: rooms, cells, portals, doors, what was not enclosed", cmd_info},
    {"vis", "make cells, portals and stab trees, and store them", cmd_vis},
    {"plan", "draw the plan with cells, portals, doors and a stab tree, as SVG", cmd_plan},
    {"walk", "walk through a building", cmd_walk},
    {"bake", "compute the light of a building by radiosity, and store it", cmd_bake},
    {"light", "tell the light of each room as planners ask for it", cmd_light},
    {"render", "draw a picture by rays, with mirrors and glass", cmd_render},
    {"bench", "measure, as CSV on standard output", cmd_bench},
};
enum { COMMAND_COUNT = sizeof COMMANDS / sizeof *COMMANDS };

static void print_help(void) {
    puts("enfilade - indoor walkthroughs with cell and portal visibility\n");
    puts("usage: enfilade COMMAND [OPTIONS] ...\n\ncommands:");
    for (int i = 0; i < COMMAND_COUNT; i++) printf("  %-8s %s\n", COMMANDS[i].name, COMMANDS[i].summary);
    puts("\nbuilding files:");
    for (int i = 0; MAPS_READERS[i]; i++)
        printf("  %-12s %s\n", MAPS_READERS[i]->suffixes, MAPS_READERS[i]->summary);
    puts("\nFiles are regular ones: standard input and pipes are not read; /dev/stdout may be written.");
    puts("`enfilade COMMAND --help` tells more. Exit status: 0 good, 1 bad input, 2 wrong use, 3 stopped "
         "by\nCtrl-C, with all that there was by then stored where the command stores a part.");
}

// How many letters one must change, add, leave out or swap with the next one to make one word of the other (optimal string alignment:
// F. J. Damerau, 1964); at most TYPO_LETTERS letters of each count.
enum { TYPO_LETTERS = 15, TYPO_MOST = 2 };
static int letters_apart(const char *a, const char *b) {
    int n = (int)strnlen(a, TYPO_LETTERS), m = (int)strnlen(b, TYPO_LETTERS);
    int d[TYPO_LETTERS + 1][TYPO_LETTERS + 1];
    for (int i = 0; i <= n; i++) {
        for (int j = 0; j <= m; j++) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            int change = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            int shorter = d[i - 1][j] < d[i][j - 1] ? d[i - 1][j] + 1 : d[i][j - 1] + 1;
            d[i][j] = change < shorter ? change : shorter;
            bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (swapped && d[i - 2][j - 2] + 1 < d[i][j]) d[i][j] = d[i - 2][j - 2] + 1;
        }
    }
    return d[n][m];
}

// The command that was meant, or NULL: at most two letters apart, and fewer than its own letters.
static const char *meant(const char *word) {
    const char *best = NULL;
    int least = TYPO_MOST + 1;
    for (int i = 0; i < COMMAND_COUNT; i++) {
        int apart = letters_apart(word, COMMANDS[i].name);
        if (apart >= least || apart + 1 >= (int)strlen(COMMANDS[i].name)) continue;
        least = apart;
        best = COMMANDS[i].name;
    }
    return best;
}

static int run_command(int argc, char **argv) {
    if (argc < 2) {
        fputs("enfilade: no command given\nTry `enfilade --help`.\n", stderr);
        return APP_BAD_USE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
        print_help();
        return APP_GOOD;
    }
    if (strcmp(argv[1], "--version") == 0) {
        puts("enfilade " APP_VERSION);
        return APP_GOOD;
    }
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(argv[1], COMMANDS[i].name) == 0) return COMMANDS[i].run(argc - 1, argv + 1);
    }
    const char *suggestion = meant(argv[1]);
    fprintf(stderr, "enfilade: there is no command `%s`", argv[1]);
    if (suggestion) fprintf(stderr, "; `%s` may be meant", suggestion);
    fprintf(stderr, " (allowed:");
    for (int i = 0; i < COMMAND_COUNT; i++) fprintf(stderr, " %s", COMMANDS[i].name);
    fputs(")\nTry `enfilade --help`.\n", stderr);
    return APP_BAD_USE;
}

int main(int argc, char **argv) { return app_main(argc, argv, run_command); }
