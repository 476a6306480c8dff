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
    puts("`enfilade COMMAND --help` tells more. Exit status: 0 good, 1 bad input, 2 wrong use.");
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
    fprintf(stderr, "enfilade: there is no command `%s` (allowed:", argv[1]);
    for (int i = 0; i < COMMAND_COUNT; i++) fprintf(stderr, " %s", COMMANDS[i].name);
    fputs(")\nTry `enfilade --help`.\n", stderr);
    return APP_BAD_USE;
}

int main(int argc, char **argv) {
    app_begin();
    return app_end(run_command(argc, argv));
}
