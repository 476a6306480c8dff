// cmd_info.c - `enfilade info FILE`: the parts of a building. Stab trees are not made: on a large map that is most of the work.
#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "engine/app/app.h"

typedef struct Arguments {
    SceneOptions load;
    bool json, lamps;
} Arguments;

static const Option ROWS[] = {
    OPTION_MAP(offsetof(Arguments, load.map)),
    OPTION_PHOTOMETRY(offsetof(Arguments, load.photometry)),
    OPTION_MEMORY(offsetof(Arguments, load.memory), "what fits the file"),
    {.name = "lamps",
     .type = OPTION_FLAG,
     .at = offsetof(Arguments, lamps),
     .help = "the lamps instead, as --lamps of bake, walk and render counts and names them, those that are "
             "added to "
             "rooms without light included"},
    OPTION_JSON(offsetof(Arguments, json)),
};
static const OptionTable OPTIONS = OPTION_TABLE("info", "FILE [OPTIONS]",
                                                "Tells what is in a building: storeys, rooms, cells, "
                                                "portals, doors and what they join, polygons, and what was "
                                                "not enclosed, left out or changed on reading.",
                                                ROWS);

static void print_doors(const Building *b, Arena *arena) {
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
            side[k] = r ? region_title(b, r, arena) : "nowhere";
        }
        bool same = o->region[0] >= 0 && o->region[0] == o->region[1];
        printf("  %-8s %-20s at (%.2f, %.2f): ", opening_kind_name(o->kind), o->name,
               (o->line[0].x + o->line[1].x) / 2, (o->line[0].y + o->line[1].y) / 2);
        printf(same ? "%s on both sides" : "%s - %s", side[0], side[1]);
        printf(o->reason ? "; %s\n" : "\n", o->reason);
    }
}

static json_t *lamps_of(const Lamps *lamps) {
    json_t *list = json_array();
    for (int i = 0; i < lamps->count; i++) {
        const Lamp *l = &lamps->lamps[i];
        json_array_append_new(list, json_pack("{s:i s:s s:s s:[f,f,f] s:[f,f,f]}", "number", i + 1, "name",
                                              l->name, "room", l->room, "place", l->place.x, l->place.y,
                                              l->place.z, "flux_w", l->flux[0], l->flux[1], l->flux[2]));
    }
    return json_pack("{s:o}", "lamps", list);
}

static void print_lamps(const Lamps *lamps) {
    for (int i = 0; i < lamps->count; i++) {
        const Lamp *l = &lamps->lamps[i];
        printf("  %3d  %-28s %-24s at (%.2f, %.2f, %.2f), %.3g W\n", i + 1, l->name, l->room, l->place.x,
               l->place.y, l->place.z, rgb_sum(l->flux));
    }
    if (lamps->count == 0) printf("  no lamps\n");
}

// The photometric files of lamps. A table that sends more or less than the file's ratio of light output says is told.
static void print_photometry(const Building *b) {
    static const double OFF = 0.05;
    for (int i = 1; i < b->photometry_count; i++) {
        const Photometry *t = &b->photometries[i];
        double lumens = photometry_lumens(t);
        int lamps = 0;
        for (int k = 0; k < b->light_count; k++) lamps += b->lights[k].photometry == i;
        printf("  photometry %s: %d light%s, %.4g lm, %.3g %% of it upwards; %d angles in %d plane%s",
               t->name, lamps, lamps == 1 ? "" : "s", lumens, 100 * t->lumens[PHOTOMETRY_ABOVE] / lumens,
               t->gamma_count, t->plane_count > 1 ? t->plane_count - 1 : 1, t->plane_count > 1 ? "s" : "");
        if (t->size[0] > 0) printf("; opening %.3g x %.3g m", t->size[0], t->size[1]);
        if (t->stated > 0 && fabs(lumens / t->stated - 1) > OFF)
            printf("; its light output ratio says %.4g lm", t->stated);
        putchar('\n');
    }
}

int cmd_info(int argc, char **argv) {
    Arguments a = {.load = app_scene_options()};
    const char *file;
    bool help = false;
    int code = options_parse_file(&OPTIONS, argc, argv, &a, NULL, &file, &help);
    if (help) options_print_help(&OPTIONS);
    if (code != APP_GOOD || help) return code;
    Arena arena = {0};
    LoadedScene scene;
    Error error;
    if (a.lamps) {
        a.load.lamps = SCENE_LAMPS_ALL;
        a.load.fill_lamps = FILL_LAMPS_ON;
    }
    if (!scene_load_cells(file, &a.load, &arena, &scene, &error)) {
        arena_free(&arena);
        return app_fail(APP_BAD_INPUT, "%s", error.text);
    }
    json_t *counts = a.lamps ? lamps_of(&scene.lamps) : app_counts(&scene);
    if (a.lamps && !a.json) {
        printf("%s\n", file);
        print_lamps(&scene.lamps);
        json_decref(counts);
    } else if (a.json) {
        app_print_json(counts);
    } else {
        const char *key;
        json_t *value;
        printf("%s\n", file);
        json_object_foreach(counts, key, value) {
            if (json_is_integer(value)) printf("  %-14s %lld\n", key, (long long)json_integer_value(value));
            if (json_is_real(value)) printf("  %-14s %.2f m2\n", key, json_real_value(value));
        }
        json_decref(counts);
        print_doors(&scene.building, &arena);
        print_photometry(&scene.building);
    }
    if (!a.lamps) app_print_notes(&scene.building, 1000);
    arena_free(&arena);
    return APP_GOOD;
}
