// wad_fixture.c - see the header.
#include "tests/maps/doom/wad_fixture.h"

#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

const char *wad_write_wad(Arena *arena, Bytes file) {
    Error error;
    char *path = arena_format(arena, "%s/test.wad", support_folder(arena));
    cr_assert(file_write(path, file.data, file.size, &error), "%s", error.text);
    return path;
}

const char *wad_write_map(Arena *arena, const WadMaker *maker) {
    static const char *const NAMES[] = {"MAP01"};
    return wad_write_wad(arena, wad_file(maker, NAMES, 1, NULL));
}

void wad_open_file(Made *m, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
    m->doors = doors_new(&m->graph, &m->arena);
    m->world = body_world(&m->graph, m->doors.open, &m->arena);
    m->body = (Body){.cell = -1};
}

void wad_open_two_rooms(Made *m) {
    *m = (Made){.arena = {0}};
    WadMaker maker = {.arena = &m->arena};
    wad_two_rooms(&maker);
    wad_open_file(m, wad_write_map(&m->arena, &maker));
}

const Region *wad_region_of(const Building *b, int sector) {
    char name[32];
    snprintf(name, sizeof name, "sector %d", sector);
    for (int i = 0; i < b->region_count; i++) {
        if (strcmp(b->regions[i].name, name) == 0) return &b->regions[i];
    }
    return NULL;
}

double wad_area_of_sector(const Building *b, int sector) {
    char name[32];
    double area = 0;
    snprintf(name, sizeof name, "sector %d", sector);
    for (int i = 0; i < b->region_count; i++)
        if (strcmp(b->regions[i].name, name) == 0) area += fixture_region_area(b, &b->regions[i]);
    return area;
}
