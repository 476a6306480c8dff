// main.c - the program `enfilade`: picks the subcommand.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "engine/app/app.h"
#include "maps/maps.h"

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

// Else the first files that are opened would take their places, and get what is printed. What is printed to a closed one fails.
static void open_standard_streams(void) {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0)
            _exit(APP_BAD_INPUT);
}

// A result that did not arrive is none.
static int check_printed(int code) {
    bool lost = ferror(stdout) != 0;
    errno = 0;
    if (fclose(stdout) == 0 && !lost) return code;
    app_fail(0, "standard output: cannot be written%s%s", errno ? ": " : "", errno ? strerror(errno) : "");
    return code == APP_GOOD ? APP_BAD_INPUT : code;
}

static int run(int argc, char **argv) {
    app_count_libraries();
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
    open_standard_streams();
    // A limit of files' sizes is told of as a full disk is.
    signal(SIGXFSZ, SIG_IGN);
    return check_printed(run(argc, argv));
}
