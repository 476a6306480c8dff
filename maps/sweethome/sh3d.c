// sh3d.c - reads homes of Sweet Home 3D (a ZIP with Home.xml as of versions 5.3 to 7, or with Home alone before; or Home.xml bare):
// levels, rooms, cameras, ground, compass; walls, openings and furniture are read by its sister files.
//
// Departures from the program: two levels of one elevation become one storey, since free space cannot overlap; a
// hidden level is read all the same (people hide the upper floor to draw the lower one), hidden furniture is not;
// the storey is as high as most of its walls. Labels, dimensions, polylines and the colour of the sky are not read.
#include "maps/sweethome/sh3d_walls.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "engine/core/polygon.h"
#include "maps/building/reader.h"
#include "maps/building/texture.h"
#include "maps/sweethome/java_stream.h"

static const double DEFAULT_WALL_HEIGHT = 250;  // cm, with which the program starts a home
static const double DEFAULT_SLAB = 12;          // cm, likewise
// Walls and ceilings without a colour are white paint, floors a light wood grey: sRGB.
static const unsigned WALL_COLOUR = 0xF2F2F2, FLOOR_COLOUR = 0xC8BEB0, GROUND_COLOUR = 0xA8A8A8;
static const double GROUND_HALF = 50000;      // metres, half a side of the program's ground
static const double DEFAULT_FOV = 1.0995574;  // radians, 63 degrees: the program's own

// ---- levels

static int by_elevation(const void *a, const void *b) {
    const Sh3dLevel *p = a, *q = b;
    if (p->floor != q->floor) return p->floor < q->floor ? -1 : 1;
    if (p->index != q->index) return p->index < q->index ? -1 : 1;
    return p->node->line - q->node->line;
}

static void read_level(Sh3d *s, const XmlNode *node) {
    Sh3dLevel level = {.node = node, .id = xml_get(node, "id")};
    if (!level.id) sh3d_fail(s, node, "has no attribute id (a name is needed)");
    level.floor = maps_snap(sh3d_coordinate(s, node, "elevation", NAN));
    level.height = maps_snap(sh3d_length(s, node, "height", s->wall_height / SH3D_CM));
    level.slab = maps_snap(sh3d_length(s, node, "floorThickness", DEFAULT_SLAB));
    level.index = (int)sh3d_number(s, node, "elevationIndex", 0, -1e6, 1e6);
    if (!s->failed && level.height <= 0)
        sh3d_fail(s, node, "has height='%s' (a height above 0.05 is allowed)", sh3d_text(node, "height"));
    for (int i = 0; !s->failed && i < s->level_count; i++)
        if (strcmp(s->levels[i].id, level.id) == 0)
            sh3d_fail(s, node, "has the id '%.40s' of the level in %s %d", level.id, s->unit,
                      s->levels[i].node->line);
    if (!s->failed) *ARENA_PUSH(s->arena, s->levels, s->level_count, s->level_capacity) = level;
}

static void read_levels(Sh3d *s) {
    for (const XmlNode *node = s->home->first; node && !s->failed; node = node->next)
        if (xml_is(node, "level")) read_level(s, node);
    if (s->failed) return;
    if (s->level_count == 0)
        *ARENA_PUSH(s->arena, s->levels, s->level_count, s->level_capacity) =
            (Sh3dLevel){.height = s->wall_height, .slab = SH3D_CM * DEFAULT_SLAB};
    else
        qsort(s->levels, (size_t)s->level_count, sizeof *s->levels, by_elevation);
    Building *b = s->b;
    for (int i = 0; i < s->level_count; i++) {
        Sh3dLevel *level = &s->levels[i], *below = i ? &s->levels[i - 1] : NULL;
        const char *name = level->node ? sh3d_text(level->node, "name") : "";
        if (below && below->floor == level->floor) {
            level->storey = below->storey;
            Storey *storey = &b->storeys[level->storey];
            storey->height = fmax(storey->height, level->height);
            building_note(s->arena, b, NOTE_CHANGED, vec3(0, 0, level->floor),
                          "%s:%d: level %s lies at the elevation of level %s: read as one storey", s->where,
                          level->node->line, name, storey->name);
            continue;
        }
        level->storey = b->storey_count;
        *ARENA_PUSH(s->arena, b->storeys, b->storey_count, b->storey_capacity) =
            (Storey){arena_string(s->arena, name), level->floor, level->height, level->slab};
    }
}

// ---- rooms

// Floors count to the right and up on the plan from its origin, ceilings to the right and down, as seen from below. Pictures may be
// stretched over the room's box.
static Sh3dFrame room_frame(const Sh3d *s, const SketchRoom *room, bool ceiling) {
    double up = ceiling ? -1 : 1;
    Sh3dFrame f = {.right = {1, 0, 0}, .up = {0, up, 0}, .can_fit = true};
    f.fit_low = vec2(INFINITY, INFINITY);
    f.fit_high = vec2(-INFINITY, -INFINITY);
    for (int i = 0; i < room->point_count; i++) {
        Vec2 p = s->sketch->points[room->first_point + i];
        f.fit_low = vec2(fmin(f.fit_low.x, p.x), fmin(f.fit_low.y, up * p.y));
        f.fit_high = vec2(fmax(f.fit_high.x, p.x), fmax(f.fit_high.y, up * p.y));
    }
    return f;
}

static void read_room(Sh3d *s, const XmlNode *node) {
    SketchRoom room = {.storey = sh3d_level(s, node)->storey,
                       .first_point = s->sketch->point_count,
                       .name = sh3d_text(node, "name"),
                       .z0 = NAN,
                       .z1 = NAN,
                       .wall_material = s->wall_material};
    for (const XmlNode *child = node->first; child && !s->failed; child = child->next) {
        if (!xml_is(child, "point")) continue;
        double x = sh3d_coordinate(s, child, "x", NAN), y = -sh3d_coordinate(s, child, "y", NAN);
        sh3d_add_point(s, vec2(x, y), -1);
        room.point_count++;
    }
    Vec2 first = room.point_count ? s->sketch->points[room.first_point] : vec2(0, 0);
    room.place = sh3d_place(s, node, "room");
    // floorVisible only tells the program what to draw: a walk needs a floor. Many a room has no visible ceiling, to look into it from
    // above; only where low walls fence it does that mean that there is none.
    room.open_above = !sh3d_flag(node, "ceilingVisible", true);
    Sh3dFrame floor = room_frame(s, &room, false), ceiling = room_frame(s, &room, true);
    room.floor_material = sh3d_material(s, node, "floor", s->floor_material, &floor);
    sh3d_keep_lengths(s, room.floor_material, sh3d_texture_of(s, node, "floor"));
    room.ceiling_material = sh3d_material(s, node, "ceiling", s->ceiling_material, &ceiling);
    if (room.point_count < 3) {
        building_note(s->arena, s->b, NOTE_DROPPED, vec3(first.x, first.y, 0),
                      "%s: %s has %d points (at least 3 are needed): left out", s->where, room.place,
                      room.point_count);
        return;
    }
    *ARENA_PUSH(s->arena, s->sketch->rooms, s->sketch->room_count, s->sketch->room_capacity) = room;
}

// ---- cameras

static Viewpoint read_camera(Sh3d *s, const XmlNode *node) {
    Viewpoint v = {.name = arena_string(s->arena, sh3d_text(node, "name"))};
    v.eye.x = sh3d_coordinate(s, node, "x", NAN);
    v.eye.y = -sh3d_coordinate(s, node, "y", NAN);
    // Absolute: in a home with its ground floor 112 cm up, cameras in that floor stand at 250 cm.
    v.eye.z = sh3d_coordinate(s, node, "z", NAN);
    double yaw = sh3d_number(s, node, "yaw", NAN, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
    // The file's yaw 0 looks along its +y, which is our -y, and both turn the same way seen from above.
    v.yaw = atan2(-cos(yaw), -sin(yaw));
    v.pitch = -sh3d_number(s, node, "pitch", NAN, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
    v.fov = sh3d_number(s, node, "fieldOfView", DEFAULT_FOV, 0.01, 3.1);
    return v;
}

static bool is_camera(const XmlNode *node, const char *attribute) {
    return (xml_is(node, "observerCamera") || xml_is(node, "camera")) &&
           strcmp(sh3d_text(node, "attribute"), attribute) == 0;
}

static void read_tour(Sh3d *s, const XmlNode *environment) {
    Building *b = s->b;
    Tour tour = {.name = "camera path", .first_viewpoint = b->tour_point_count};
    for (const XmlNode *node = environment->first; node && !s->failed; node = node->next)
        if (is_camera(node, "cameraPath"))
            *ARENA_PUSH(s->arena, b->tour_points, b->tour_point_count, b->tour_point_capacity) =
                read_camera(s, node);
    tour.viewpoint_count = b->tour_point_count - tour.first_viewpoint;
    if (tour.viewpoint_count > 0) *ARENA_PUSH(s->arena, b->tours, b->tour_count, b->tour_capacity) = tour;
}

// Cameras tell hours as milliseconds since 1970, in which the place's clock shows the hours of UTC.
static void read_hour(Sh3d *s, const XmlNode *camera) {
    static const double DAY = 86400e3;
    Site *site = &s->b->site;
    if (!xml_get(camera, "time")) return;
    double time = sh3d_number(s, camera, "time", 0, SH3D_FIRST_TIME, SH3D_LAST_TIME), day = floor(time / DAY);
    time_t seconds = (time_t)(day * 86400);
    struct tm date;
    if (!gmtime_r(&seconds, &date)) return;
    site->date[0] = date.tm_year + 1900;
    site->date[1] = date.tm_mon + 1;
    site->date[2] = date.tm_mday;
    site->hour = (time / DAY - day) * 24;
}

static void read_compass(Sh3d *s, const XmlNode *node) {
    Site *site = &s->b->site;
    site->placed = xml_get(node, "latitude") && xml_get(node, "longitude");
    site->latitude = sh3d_number(s, node, "latitude", 0, -SH3D_MAX_LATITUDE, SH3D_MAX_LATITUDE);
    site->longitude = sh3d_number(s, node, "longitude", 0, -2 * SH3D_MAX_LATITUDE, 2 * SH3D_MAX_LATITUDE);
    site->north = sh3d_number(s, node, "northDirection", 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
}

// The zone's hour depends on the date, which a camera tells.
static void find_zone(Sh3d *s) {
    Site *site = &s->b->site;
    if (site->date[0] == 0) return;
    struct tm date = {.tm_year = site->date[0] - 1900, .tm_mon = site->date[1] - 1, .tm_mday = site->date[2]};
    double wall = (double)timegm(&date) + site->hour * 3600;
    for (const XmlNode *node = s->home->first; node; node = node->next)
        if (xml_is(node, "compass"))
            site->zoned = sh3d_zone_find(sh3d_text(node, "timeZone"), wall, &site->ahead);
}

static void read_cameras(Sh3d *s) {
    Building *b = s->b;
    for (const XmlNode *node = s->home->first; node && !s->failed; node = node->next) {
        // The camera from above is for plans, not for walks.
        bool observer = is_camera(node, "observerCamera");
        if (xml_is(node, "environment")) read_tour(s, node);
        if (xml_is(node, "compass")) read_compass(s, node);
        if (!observer && !is_camera(node, "storedCamera")) continue;
        Viewpoint v = read_camera(s, node);
        if (observer) {
            s->has_observer = true;
            read_hour(s, node);
            v.name = "observer";
            s->observer = v;
        }
        *ARENA_PUSH(s->arena, b->viewpoints, b->viewpoint_count, b->viewpoint_capacity) = v;
    }
    if (!s->failed) find_zone(s);
}

// ---- the home

static void read_environment(Sh3d *s, const XmlNode *node) {
    // The program's ground is a square of 100 km around the plan's origin; its pictures start at the upper left corner.
    const Sh3dFrame ground = {{1, 0, 0}, {0, 1, 0}, GROUND_HALF, -GROUND_HALF, .can_fit = false};
    s->sketch->ground_material = sh3d_material(s, node, "ground", s->sketch->ground_material, &ground);
    const XmlNode *sky = sh3d_texture_of(s, node, "sky");
    if (!sky) return;
    s->b->sky_texture = sh3d_picture(s, sky);
    // The program's sky begins at the plan's right and goes round clockwise, whatever the compass says; an offset of 1 is a whole turn.
    s->b->sky_start = -2 * M_PI * sh3d_number(s, sky, "xOffset", 0, -SH3D_MAX_ANGLE, SH3D_MAX_ANGLE);
}

static void set_defaults(Sh3d *s) {
    s->wall_material = sh3d_add_colour(s, "wall", maps_colour(WALL_COLOUR));
    s->ceiling_material = sh3d_add_colour(s, "ceiling", maps_colour(WALL_COLOUR));
    s->floor_material = sh3d_add_colour(s, "floor", maps_colour(FLOOR_COLOUR));
    s->sketch->outer_material = s->wall_material;
    s->sketch->slab_material = sh3d_add_colour(s, "slab", maps_colour(WALL_COLOUR));
    s->sketch->ground = 0;  // the program's ground lies at elevation 0
    s->sketch->ground_material = sh3d_add_colour(s, "ground", maps_colour(GROUND_COLOUR));
    for (const XmlNode *node = s->home->first; node; node = node->next)
        if (xml_is(node, "environment")) read_environment(s, node);
}

static void note(Sh3d *s, const NoteTally *tally, const char *what) {
    building_note_tally(s->arena, s->b, s->where, tally, what);
}

static void add_notes(Sh3d *s) {
    note(s, &s->missing_models, "models are not in the file, their pieces are boxes or plain stairs");
    note(s, &s->missing_frames, "models of doors and windows are not in the file, they have no frames");
    note(s, &s->unknown_materials, OBJ_UNKNOWN_NOTE);
    note(s, &s->missing_textures,
         "textures are missing or could not be decoded, another colour stands for them");
    note(s, &s->plain_pictures, "surfaces show the mean of their texture, since 16,384 others have pictures");
    note(s, &s->plain_walls, "baseboards are left out, since the home has too many walls and openings");
    note(s, &s->dark_lights, "lamps have no light source and give no light");
    note(s, &s->unknown_joins, "wall ends name a wall that is not in the file and are not joined");
    note(s, &s->bad_shapes, "outlines of holes make no sense and are rectangles");
}

bool sh3d_sketch(Bytes home, Archive *archive, const char *where, Arena *arena, Building *b, Sketch *sketch,
                 Error *error) {
    bool is_serialized = java_recognise(home);
    Sh3d s = {.pixels = TEXTURE_FREE_PIXELS,
              .where = where,
              .unit = is_serialized ? "object" : "line",
              .archive = archive,
              .arena = arena,
              .b = b,
              .sketch = sketch,
              .error = error};
    if (!(is_serialized ? sh3d_serialized : xml_parse)(home, where, arena, &s.home, error)) return false;
    if (!xml_is(s.home, "home"))
        return error_set(error, "%s:%d: the file's element is %.40s (home is needed)", where, s.home->line,
                         s.home->name);
    s.wall_height = maps_snap(sh3d_length(&s, s.home, "wallHeight", DEFAULT_WALL_HEIGHT));
    if (!s.failed && s.wall_height <= 0)
        sh3d_fail(&s, s.home, "has wallHeight='%s' (a height above 0.05 is allowed)",
                  sh3d_text(s.home, "wallHeight"));
    if (!s.failed) set_defaults(&s);
    if (!s.failed) read_levels(&s);
    if (!s.failed) sh3d_read_walls(&s);
    for (const XmlNode *node = s.home->first; node && !s.failed; node = node->next)
        if (xml_is(node, "room")) read_room(&s, node);
    if (!s.failed && s.wall_count == 0 && sketch->room_count == 0)
        return error_set(error, "%s: the home is empty (at least a wall or a room is needed)", where);
    if (!s.failed) sh3d_find_ceilings(&s);
    if (!s.failed) sh3d_add_walls(&s);
    if (!s.failed) sh3d_add_sloped_ceilings(&s);
    if (!s.failed) sh3d_read_pieces(&s);
    if (!s.failed) sh3d_add_baseboards(&s);
    if (!s.failed) read_cameras(&s);
    if (!s.failed) add_notes(&s);
    if (s.has_observer) {
        b->start = s.observer.eye;
        b->start_yaw = s.observer.yaw;
    }
    return !s.failed;
}

// ---- the reader

static bool starts_as_zip(Bytes content) {
    return content.size >= 4 && memcmp(content.data, "PK\3\4", 4) == 0;
}

// A ZIP may hold anything; so the home's entry is looked for only once the reader is chosen, and missed with a reason.
static bool recognise_sh3d(Bytes content) {
    static const size_t HEAD = 4096;  // bytes in which the home element begins
    if (starts_as_zip(content) || java_recognise(content)) return true;
    size_t size = content.size < HEAD ? content.size : HEAD;
    return memmem(content.data, size, "<home", 5) != NULL;
}

static bool inside(const Building *b, Vec3 p) {
    for (int i = 0; i < b->region_count; i++) {
        const Region *r = &b->regions[i];
        if (r->kind != REGION_ROOM || p.z <= r->z0 || p.z >= r->z1) continue;
        bool in = false;
        for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
            const Ring *ring = &b->rings[k];
            in ^= ring_contains(&b->points[ring->first_point], ring->point_count, vec2(p.x, p.y));
        }
        if (in) return true;
    }
    return false;
}

// The walk begins where the home was left, if that is in a room; else where maps_enclose puts it.
static bool enclose(Sketch *sketch, Arena *arena, Building *b, Error *error) {
    Vec3 observer = b->start;
    double yaw = b->start_yaw;
    b->start = vec3(0, 0, 0);
    b->start_yaw = 0;
    if (!maps_enclose(sketch, b, arena, error)) return false;
    sh3d_finish_edges(sketch, arena, b);
    if (inside(b, observer)) {
        b->start = observer;
        b->start_yaw = yaw;
    }
    return true;
}

static bool read_zip(const char *path, Bytes content, Arena *arena, Building *b, Sketch *sketch,
                     Error *error) {
    Archive *archive;
    Bytes home;
    if (!archive_open(content, path, arena, &archive, error)) return false;
    bool is_xml = archive_has(archive, "Home.xml");
    const char *name = is_xml ? "Home.xml" : "Home";
    bool good = archive_has(archive, name);
    if (!good) error_set(error, "%s: the archive is no home (an entry Home.xml or Home is needed)", path);
    good = good && archive_read(archive, name, SH3D_MAX_XML, arena, &home, error);
    if (good && !is_xml && !java_recognise(home))
        good = error_set(error, "%s:Home: the entry is no stream of Java objects, and there is no Home.xml",
                         path);
    good =
        good && sh3d_sketch(home, archive, arena_format(arena, "%s:%s", path, name), arena, b, sketch, error);
    archive_close(archive);
    return good;
}

static bool read(const char *path, Bytes content, Arena *arena, Building *b, Error *error) {
    Sketch sketch = {0};
    const char *suffix = strrchr(path, '.');
    bool zip =
        starts_as_zip(content) || (suffix && strcasecmp(suffix, ".sh3d") == 0 && !recognise_sh3d(content));
    bool good = zip ? read_zip(path, content, arena, b, &sketch, error)
                    : sh3d_sketch(content, NULL, path, arena, b, &sketch, error);
    return good && enclose(&sketch, arena, b, error);
}

const MapsReader MAPS_READER_SH3D = {
    .name = "sh3d",
    .suffixes = ".sh3d .xml",
    .summary = "Sweet Home 3D homes, or their Home.xml or Home alone",
    .recognise = recognise_sh3d,
    .read = read,
};
