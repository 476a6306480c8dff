// ifc_building.c - reads building models as buildings. A model with walls or spaces becomes a sketch, in which maps_enclose finds the
// free space; one that has neither is polygons alone.
#include "maps/ifc_building/ifc_building.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "maps/building/reader.h"
#include "maps/building/texture.h"
#include "maps/polygons/soup_readers.h"

// Where the file has no style: white paint, a light grey of wood or stone, light wood, clear glass. sRGB.
static const unsigned WALL_COLOUR = 0xF2F2F2, FLOOR_COLOUR = 0xC8BEB0, DOOR_COLOUR = 0xD8CCB8,
                      THING_COLOUR = 0xC8C4BC, GLASS_COLOUR = 0xBCD8DE, GROUND_COLOUR = 0xA8A8A8;

static int add_colour(IfcPlan *p, const char *name, unsigned rgb, float alpha) {
    return building_add_material(p->arena, p->b,
                                 (Material){.name = name, .reflectance = maps_colour(rgb), .alpha = alpha});
}

static void set_defaults(IfcPlan *p) {
    p->wall_material = add_colour(p, "wall", WALL_COLOUR, 1);
    p->ceiling_material = add_colour(p, "ceiling", WALL_COLOUR, 1);
    p->floor_material = add_colour(p, "floor", FLOOR_COLOUR, 1);
    p->door_material = add_colour(p, "door", DOOR_COLOUR, 1);
    p->thing_material = add_colour(p, "furniture", THING_COLOUR, 1);
    p->glass_material = add_colour(p, "glass", GLASS_COLOUR, 0.3f);
    p->sketch.outer_material = p->wall_material;
    p->sketch.slab_material = add_colour(p, "slab", WALL_COLOUR, 1);
    p->sketch.ground_material = add_colour(p, "ground", GROUND_COLOUR, 1);
    for (int i = 0; i < p->model->material_count; i++) p->material[i] = p->pictured[i] = -1;
    for (int i = 0; i < p->model->texture_count; i++) p->texture[i] = -1;
}

static void set_site(IfcPlan *p) {
    const IfcModel *m = p->model;
    Site *site = &p->b->site;
    site->placed = m->placed;
    site->latitude = m->latitude;
    site->longitude = m->longitude;
    site->north = m->north;
    if (m->origin.x == 0 && m->origin.y == 0 && m->origin.z == 0) return;
    building_note(p->arena, p->b, NOTE_CHANGED, vec3(0, 0, 0),
                  "%s: lies at (%.10g, %.10g, %.10g) m: coordinates here count from there", p->path,
                  m->origin.x, m->origin.y, m->origin.z);
}

static void add_notes(IfcPlan *p) {
    const IfcModel *m = p->model;
    for (int i = 0; i < m->note_count; i++) {
        int product = m->notes[i].product;
        Vec3 at = product >= 0 ? m->products[product].place : vec3(0, 0, 0);
        building_note(p->arena, p->b, NOTE_DROPPED, at, "%s: %s", p->path, m->notes[i].text);
    }
    building_note_tally(p->arena, p->b, p->path, &p->no_body, "products have no body: left out");
    building_note_tally(p->arena, p->b, p->path, &p->recesses,
                        "openings do not go through their walls: the walls stay whole there");
    building_note_tally(p->arena, p->b, p->path, &p->small_holes,
                        "openings narrower or lower than 0.3 m, in which nothing stands, were left closed");
    building_note_tally(p->arena, p->b, p->path, &p->roof_windows,
                        "doors or windows stand in roofs or floors: seen, but nothing is seen through them");
    building_note_tally(
        p->arena, p->b, p->path, &p->low_doors,
        "doors or windows stand in walls that do not bound rooms: they are seen, and stay shut");
    for (int i = 0; i < m->product_count; i++)
        if (m->products[i].kind == IFC_UNBUILT)
            building_tally(&p->unbuilt, ifc_place(p, i), m->products[i].place);
    building_note_tally(p->arena, p->b, p->path, &p->unbuilt,
                        "members for structural analysis, zones or referents are no part of the building");
    building_note_tally(p->arena, p->b, p->path, &p->too_many,
                        "products would make more than 4000000 polygons: left out");
}

// A model of products that bound nothing.
static bool read_polygons(IfcPlan *p, Error *error) {
    SoupReader reader = {.path = p->path, .arena = p->arena, .b = p->b};
    for (int i = 0; i < p->model->product_count; i++) {
        const IfcProduct *it = &p->model->products[i];
        if (it->kind == IFC_OPENING || it->kind == IFC_SPACE || it->kind == IFC_UNBUILT) continue;
        ifc_add_mesh(p, &it->mesh, it->kind == IFC_STAIR ? OBJECT_STAIR : OBJECT_FURNITURE, ifc_name(p, i),
                     p->thing_material);
    }
    add_notes(p);
    building_note(p->arena, p->b, NOTE_CHANGED, vec3(0, 0, 0),
                  "%s: has neither walls nor spaces: read as polygons alone", p->path);
    return soup_finish(&reader, "the unit is that of IFCUNITASSIGNMENT", error);
}

static bool bounds_rooms(const IfcModel *m) {
    for (int i = 0; i < m->product_count; i++) {
        IfcKind kind = m->products[i].kind;
        bool body = !box_is_empty(m->products[i].box);
        if (body && (kind == IFC_SPACE || kind == IFC_WALL || kind == IFC_CURTAIN_WALL)) return true;
    }
    return false;
}

static bool make_building(IfcPlan *p, Error *error) {
    set_defaults(p);
    set_site(p);
    if (!bounds_rooms(p->model)) return read_polygons(p, error);
    if (!ifc_plan_storeys(p, error)) return false;
    ifc_plan_walls(p);
    ifc_plan_rooms(p);
    // Walls that are not upright, as those of a bridge, bound nothing either.
    if (p->sketch.wall_count + p->sketch.room_count == 0) {
        p->b->storey_count = 0;
        return read_polygons(p, error);
    }
    ifc_plan_openings(p);
    ifc_plan_floors(p);
    ifc_add_objects(p);
    add_notes(p);
    if (!maps_enclose(&p->sketch, p->b, p->arena, error)) return false;
    ifc_check_doors(p);
    return true;
}

static void list_parts(IfcPlan *p) {
    const IfcModel *m = p->model;
    int *first = ARENA_ARRAY(&p->scratch, int, m->product_count + 1);
    for (int i = 0; i < m->product_count; i++)
        if (m->products[i].whole >= 0) first[m->products[i].whole + 1]++;
    for (int i = 0; i < m->product_count; i++) first[i + 1] += first[i];
    int *fill = ARENA_ARRAY(&p->scratch, int, m->product_count + 1);
    memcpy(fill, first, (size_t)(m->product_count + 1) * sizeof *fill);
    p->parts = ARENA_ARRAY(&p->scratch, int, m->product_count + 1);
    for (int i = 0; i < m->product_count; i++)
        if (m->products[i].whole >= 0) p->parts[fill[m->products[i].whole]++] = i;
    p->first_part = first;
}

static bool read_ifc(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    IfcPlan p = {.path = path, .arena = arena, .scratch = {.dense = true}, .b = out};
    IfcModel model;
    IfcOptions options = ifc_default_options();
    bool good = ifc_read(path, content, &options, &p.scratch, &model, error);
    if (good) {
        p.model = &model;
        p.walls = ARENA_ARRAY(&p.scratch, SolidOutlines, model.product_count);
        p.storey = ARENA_ARRAY(&p.scratch, int, model.storey_count);
        p.material = ARENA_ARRAY(&p.scratch, int, model.material_count);
        p.pictured = ARENA_ARRAY(&p.scratch, int, model.material_count);
        p.texture = ARENA_ARRAY(&p.scratch, int, model.texture_count + 1);
        p.beside = (SoupReader){.path = path, .arena = arena, .b = out, .hash = out->hash};
        p.pixels = TEXTURE_FREE_PIXELS;
        list_parts(&p);
        p.tracer = solid_begin(&p.scratch);
        good = make_building(&p, error);
        solid_end(p.tracer);
    }
    arena_free(&p.scratch);
    return good;
}

const MapsReader MAPS_READER_IFC = {
    .name = "ifc",
    .suffixes = ".ifc",
    .summary = "building models of IFC 2x3 and 4 as STEP files: spaces, walls, doors, furniture",
    .recognise = ifc_recognise,
    .read = read_ifc,
};
