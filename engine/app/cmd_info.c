// cmd_info.c - `enfilade info FILE`: what is in a building.
#include <getopt.h>
#include <stdio.h>

#include "engine/app/app.h"

static const char HELP[] =
    "usage: enfilade info FILE [--map NAME] [--memory MB] [--json]\n\n"
    "Tells what is in a building: storeys, rooms, cells, portals, doors and what they "
    "join, polygons, and what was\n"
    "not enclosed, left out or changed on reading.\n\n"
    "  --map NAME   which one of a file that holds several maps (default: the first)\n"
    "  --memory MB  memory that may be used, 16 to 1000000 (default: what fits the file)\n"
    "  --json       one JSON object on standard output\n";

static void print_doors(const Building *b) {
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind == OPENING_WINDOW) continue;
        if (b->form != FORM_REGIONS) {
            printf("  %-8s %-20s at (%.2f, %.2f)\n", opening_kind_name(o->kind), o->name,
                   (o->line[0].x + o->line[1].x) / 2, (o->line[0].y + o->line[1].y) / 2);
            continue;
        }
        const char *side[2];
        for (int k = 0; k < 2; k++) {
            const Region *r = o->region[k] < 0 ? NULL : &b->regions[o->region[k]];
            side[k] = !r                           ? "nowhere"
                      : r->kind == REGION_OUTDOORS ? "outdoors"
                      : *r->name                   ? r->name
                                                   : "a room";
        }
        printf("  %-8s %-20s at (%.2f, %.2f): %s - %s", opening_kind_name(o->kind), o->name,
               (o->line[0].x + o->line[1].x) / 2, (o->line[0].y + o->line[1].y) / 2, side[0], side[1]);
        printf(o->reason ? "; %s\n" : "\n", o->reason);
    }
}

int cmd_info(int argc, char **argv) {
    static const struct option options[] = {{"json", no_argument, NULL, 'j'},
                                            {"help", no_argument, NULL, 'h'},
                                            {"map", required_argument, NULL, 'm'},
                                            {"memory", required_argument, NULL, 'y'},
                                            {0}};
    AppOptions load = app_default_options();
    bool json = false;
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":h", options, NULL)) != -1;) {
        switch (c) {
        case 'm':
            load.map = optarg;
            break;
        case 'y':
            if (app_take_memory("info", optarg) != APP_GOOD) return APP_BAD_USE;
            break;
        case 'j':
            json = true;
            break;
        case 'h':
            fputs(HELP, stdout);
            return APP_GOOD;
        default:
            return app_misuse_option("info", c, argv);
        }
    }
    if (argc - optind != 1)
        return app_misuse("info", "info: one building file is needed, %d were given", argc - optind);
    Arena arena = {0};
    AppScene scene;
    Error error;
    if (!app_load(argv[optind], &load, &arena, &scene, &error)) {
        arena_free(&arena);
        return app_fail(APP_BAD_INPUT, "%s", error.text);
    }
    json_t *counts = app_counts(&scene);
    if (json) {
        app_print_json(counts);
    } else {
        const char *key;
        json_t *value;
        printf("%s\n", argv[optind]);
        json_object_foreach(counts, key, value) {
            if (json_is_integer(value)) printf("  %-14s %lld\n", key, (long long)json_integer_value(value));
            if (json_is_real(value)) printf("  %-14s %.2f m2\n", key, json_real_value(value));
        }
        json_decref(counts);
        print_doors(&scene.building);
    }
    app_print_notes(&scene.building, 1000);
    arena_free(&arena);
    return APP_GOOD;
}
