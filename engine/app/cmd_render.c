// cmd_render.c - `enfilade render FILE`: a still by rays, with mirrors and glass.
#include <stddef.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/app/app.h"
#include "engine/core/clock.h"
#include "engine/draw/image.h"
#include "engine/scene/light.h"
#include "engine/stills/still.h"
#include "engine/walk/first_view.h"

typedef struct RenderArguments {
    // Its `light` is the file that was given, or NULL.
    SceneOptions load;
    const char *file, *out;
    // NULL: where a walk begins.
    const char *view;
    // `eye`, `look`, `fov` were given.
    bool from, towards, widened;
    Vec3 eye, look;
    // Radians, horizontal.
    double fov;
    // Width and height, pixels.
    int size[2];
    StillOptions still;
    // Else `still.direct` is as fits the building.
    bool direct_given;
    bool json;
} RenderArguments;

// Where neither the command nor a view of the building says, radians.
static const double USUAL_FOV = 70 * (M_PI / 180);
// The eye and the point that it looks at are at least so far apart, metres.
static const double NEAREST_LOOK = 1e-6;

typedef struct Render {
    const RenderArguments *a;
    StillOptions still;  // as asked for, and as fits
    LoadedScene scene;
    const WalkLight *light;
    Camera camera;
    StillReport report;
    double seconds_light;
    bool baked;  // here, not found
    bool stopped;
} Render;

// ---- the camera

static bool find_view(const RenderArguments *a, const LoadedScene *scene, Viewpoint *out, Error *error) {
    const Building *b = &scene->building;
    *out = (Viewpoint){.name = "", .fov = USUAL_FOV};
    if (a->from) return true;
    if (!a->view) {
        *out = first_view_of_walk(&scene->graph, &scene->forest);
        if (!*out->name) out->fov = USUAL_FOV;
        return true;
    }
    char names[512] = "";
    size_t used = 0;
    for (int i = 0; i < b->viewpoint_count; i++) {
        if (strcmp(b->viewpoints[i].name, a->view) == 0) {
            *out = b->viewpoints[i];
            return true;
        }
        int more =
            snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", b->viewpoints[i].name);
        if (more > 0 && used + (size_t)more < sizeof names) used += (size_t)more;
    }
    return error_set(error, "%s: there is no view `%s` (allowed: %s)", a->file, a->view,
                     used ? names : "none, it has no views");
}

static bool find_camera(Render *r, Error *error) {
    const RenderArguments *a = r->a;
    Viewpoint v;
    if (!find_view(a, &r->scene, &v, error)) return false;
    if (a->from) v.eye = a->eye;
    if (a->widened) v.fov = a->fov;
    if (a->towards) {
        Vec3 way = vec3_sub(a->look, v.eye);
        double length = vec3_length(way);
        if (!(length > NEAREST_LOOK))
            return error_set(error, "%s: --look is where the eye is (allowed: another place)", a->file);
        v.yaw = atan2(way.y, way.x);
        v.pitch = asin(fmin(fmax(way.z / length, -1), 1));
    }
    r->camera = camera_look(v.eye, v.yaw, v.pitch, v.fov, a->size[0], a->size[1]);
    return true;
}

// ---- light

static bool bake_light(Render *r, const Progress *progress, Arena *arena, Error *error) {
    LightBaker baker = light_baker(&r->scene, true, arena);
    WalkLight *light = ARENA_ARRAY(arena, WalkLight, 1);
    if (!baker.bake)
        return error_set(error,
                         "%s: nothing emits light: it has no lamps (--fill-lamps on lights its rooms, --day "
                         "brings daylight)",
                         r->a->file);
    LightHooks hooks = {.progress = *progress, .threads = r->a->still.threads};
    bool good = baker.bake(baker.context, &hooks, arena, light, error);
    if (good && *error->text) app_warn(error->text);
    r->light = light;
    r->baked = true;
    return good;
}

// The light of all that is seen from the eye.
static bool read_part(Render *r, const LightOfParts *parts, Arena *arena, Error *error) {
    double start = clock_seconds();
    Vec3 eye = r->camera.eye;
    int part = light_part_of(parts, vis_locate(&r->scene.graph, eye, -1));
    WalkLight *light = ARENA_ARRAY(arena, WalkLight, 1);
    if (part < 0)
        return error_set(error,
                         "%s: there is no light about the eye at (%.2f, %.2f, %.2f), which is in no room",
                         r->a->file, eye.x, eye.y, eye.z);
    if (!light_load_part(parts, part, arena, light, error)) return false;
    r->light = light;
    r->seconds_light = clock_seconds() - start;
    return true;
}

static bool get_light(Render *r, const Progress *progress, Arena *arena, Error *error) {
    double start = clock_seconds();
    const LightOfParts *parts;
    if (!light_find_parts(&r->scene, arena, &parts, error)) return false;
    if (parts) return read_part(r, parts, arena, error);
    bool good = light_find(&r->scene, r->a->load.light != NULL, arena, &r->light, error) &&
                (r->light || bake_light(r, progress, arena, error));
    r->seconds_light = clock_seconds() - start;
    return good;
}

// ---- the picture

// Where so much of all surfaces emits shadows have no edges: rays would bring noise alone.
static const double MOST_EMITTING = 0.25;

static int fitting_direct(const Mesh *mesh) {
    double emitting = 0, all = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        all += mesh->elements[e].area;
        if (mesh_emits(mesh, mesh->elements[e].face)) emitting += mesh->elements[e].area;
    }
    return emitting > MOST_EMITTING * all ? STILL_BAKED : STILL_RAYS;
}

// A picture is black where no channel of a pixel reaches this, of 255.
enum { BLACK = 4 };

// Why a picture is black: the eye is in a wall, or no light arrives.
static void tell_black(const Render *r, const uint8_t *rgb) {
    const RenderArguments *a = r->a;
    for (size_t i = 0; i < (size_t)a->size[0] * (size_t)a->size[1] * 3; i++)
        if (rgb[i] >= BLACK) return;
    Vec3 eye = r->camera.eye;
    const CellGraph *graph = &r->scene.graph;
    int cell = vis_locate(graph, eye, -1);
    const char *reason = "no light reaches what is seen from there (--day and --fill-lamps on bring some)";
    if (cell < 0)
        reason = "that is in no room and not outdoors, but in a wall or in the ground, or beyond the world";
    else if (daylight_shines(&r->light->solution->day))
        reason =
            "no daylight and no lamp reaches what is seen from there, or something stands right before it";
    Error sentence;
    error_set(&sentence, "%s: is black: its eye is at (%.2f, %.2f, %.2f), and %s", a->out, eye.x, eye.y,
              eye.z, reason);
    app_warn(sentence.text);
}

static bool draw(Render *r, const Progress *progress, Arena *arena, Error *error) {
    const RenderArguments *a = r->a;
    uint8_t *rgb = ARENA_ARRAY(arena, uint8_t, (size_t)a->size[0] * (size_t)a->size[1] * 3);
    if (!still_draw(&r->scene.forest, r->light, &r->camera, &r->still, progress, rgb, &r->report))
        return error_set(error, "stopped");
    tell_black(r, rgb);
    return image_write_png(a->out, rgb, a->size[0], a->size[1], error);
}

static bool load(Render *r, const SceneOptions *from, Arena *arena, Error *error) {
    SceneOptions load = *from;
    load.lamps = SCENE_LAMPS_ALL;
    load.find_light = true;
    load.work = "drawing";
    load.vis.threads = r->a->still.threads;
    return app_load(r->a->file, &load, arena, &r->scene, error) && scene_has_walls(&r->scene, error);
}

static void print_render(const Render *r) {
    const StillReport *s = &r->report;
    const RenderArguments *a = r->a;
    double millions = (double)s->work.rays / 1e6;
    if (!a->json) {
        printf("%s: %dx%d, %d samples a pixel, %.1f million rays, %d lamps, %.2f s", a->out, a->size[0],
               a->size[1], a->still.samples, millions, s->lamps, s->seconds);
        printf(" (light %s in %.2f s, scene %.2f s)\n", r->baked ? "baked" : "read", r->seconds_light,
               s->seconds_scene);
        return;
    }
    app_print_json(json_pack(
        "{s:s s:i s:i s:i s:i s:s s:s s:f s:i s:I s:I s:I s:I s:I s:b s:f s:f s:f}", "file", a->out, "width",
        a->size[0], "height", a->size[1], "samples", a->still.samples, "depth", a->still.depth, "direct",
        STILL_DIRECT_NAMES[r->still.direct], "tree", STILL_TREE_NAMES[a->still.tree], "exposure", s->exposure,
        "lamps", s->lamps, "rays", (json_int_t)s->work.rays, "ended_matt", (json_int_t)s->work.matt,
        "ended_escaped", (json_int_t)s->work.escaped, "ended_faint", (json_int_t)s->work.faint, "ended_deep",
        (json_int_t)s->work.deep, "baked", r->baked, "seconds_light", r->seconds_light, "seconds_scene",
        s->seconds_scene, "seconds", s->seconds));
}

// the exit code
static int render(const RenderArguments *arguments) {
    Render r = {.a = arguments, .still = arguments->still};
    Arena arena = {0};
    Error error = {""};
    Progress progress = app_progress_stoppable(0);
    const char *read[] = {arguments->file, arguments->load.light};
    SceneOptions options = arguments->load;
    bool good = app_check_files(&arguments->out, 1, read, 2, &options, &error) &&
                load(&r, &options, &arena, &error) && find_camera(&r, &error) &&
                get_light(&r, &progress, &arena, &error);
    if (good && !arguments->direct_given) r.still.direct = fitting_direct(r.light->mesh);
    good = good && draw(&r, &progress, &arena, &error);
    app_progress_end();
    if (good) print_render(&r);
    arena_free(&arena);
    if (good) return APP_GOOD;
    if (strcmp(error.text, "stopped") == 0)
        return app_fail(APP_STOPPED, "stopped: %s was not written", arguments->out);
    return app_fail(APP_BAD_INPUT, "%s", error.text);
}

#define AT(field) offsetof(RenderArguments, field)
static const Option ROWS[] = {
    {.name = "o",
     .value = "OUT.png",
     .type = OPTION_OUTPUT,
     .names = (const char *const[]){"png"},
     .name_count = 1,
     .at = AT(out),
     .help = "where to write; @"},
    OPTION_MAP(AT(load.map)),
    OPTION_PHOTOMETRY(AT(load.photometry)),
    OPTION_DAYLIGHT(AT(load.day), "default: stored light as it is, else a day as --day has it"),
    OPTION_FILL_LAMPS(AT(load.fill_lamps)),
    OPTION_LAMPS(AT(load.lamp_state), ""),
    {.name = "view",
     .value = "NAME",
     .type = OPTION_TEXT,
     .at = AT(view),
     .help = "a stored viewpoint (default: where a walk begins)"},
    {.name = "eye",
     .value = "X,Y,Z",
     .type = OPTION_POINT,
     .at = AT(eye),
     .help = "from there instead, metres"},
    {.name = "look", .value = "X,Y,Z", .type = OPTION_POINT, .at = AT(look), .help = "towards this place"},
    {.name = "fov",
     .value = "DEG",
     .type = OPTION_DEGREES,
     .at = AT(fov),
     .low = 1,
     .high = 170,
     .help = "angle of view across, degrees, @ (default: the view's, or 70)"},
    {.name = "size",
     .value = "WxH",
     .type = OPTION_SIZE,
     .at = AT(size),
     .low = 16,
     .high = 8192,
     .help = "pixels, @ (default 1280x720)"},
    {.name = "samples",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(still.samples),
     .low = 1,
     .high = 4096,
     .help = "of a pixel, @ (default 16)"},
    {.name = "depth",
     .value = "N",
     .type = OPTION_INT,
     .at = AT(still.depth),
     .low = 1,
     .high = 64,
     .help = "rays on top of one another in mirrors and glass, @ (default 12)"},
    {.name = "direct",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(still.direct),
     .names = STILL_DIRECT_NAMES,
     .name_count = STILL_DIRECTS,
     .help = "light straight from lamps: @ (default: rays, with sharp shadows, unless more than a quarter of "
             "all surfaces "
             "emit)"},
    {.name = "tree",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(still.tree),
     .names = STILL_TREE_NAMES,
     .name_count = STILL_TREES,
     .help = "the structure in which rays find surfaces: @ (default own, a hierarchy of boxes)"},
    {.name = "exposure",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(still.stops),
     .low = -EXPOSURE_STOPS_MOST,
     .high = EXPOSURE_STOPS_MOST,
     .help = "brighter by so many stops, @ (default 0)"},
    {.name = "light",
     .value = "FILE.rad",
     .type = OPTION_TEXT,
     .at = AT(load.light),
     .help = "the light that `enfilade bake` stored (default: FILE with the suffix .rad, or the light that "
             "`enfilade bake "
             "FILE` left in the user's cache)"},
    OPTION_MEMORY(AT(load.memory), "what fits the file to open it, then three quarters of the machine's"),
    OPTION_THREADS(AT(still.threads)),
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS =
    OPTION_TABLE("render", "FILE -o OUT.png [OPTIONS]",
                 "Draws a picture of a building by rays: mirrors, glass, curved shapes as they are, lamps "
                 "with sharp shadows, and the "
                 "light that `enfilade bake` found; where there is none it is baked first, and kept. The "
                 "same bytes come out on any "
                 "number of threads. Ctrl-C leaves no file, with exit status 3.",
                 ROWS);

static int parse_render(int argc, char **argv, RenderArguments *a, bool *help) {
    bool given[sizeof ROWS / sizeof *ROWS] = {false};
    int code = options_parse_file(&OPTIONS, argc, argv, a, given, &a->file, help);
    if (code != APP_GOOD || *help) return code;
    a->from = options_given(&OPTIONS, given, "eye");
    a->towards = options_given(&OPTIONS, given, "look");
    a->widened = options_given(&OPTIONS, given, "fov");
    a->direct_given = options_given(&OPTIONS, given, "direct");
    if (!a->out) return app_misuse("render", "render: where to write is not said: give -o OUT.png");
    if (a->view && a->from) return app_misuse("render", "render: --view or --eye (one of them is allowed)");
    if (a->from && !a->towards) return app_misuse("render", "render: --eye needs --look X,Y,Z");
    return app_check_day("render", &a->load.day);
}

int cmd_render(int argc, char **argv) {
    RenderArguments a = {.load = app_scene_options(), .size = {1280, 720}, .still = still_default_options()};
    bool help = false;
    a.load.fill_lamps = FILL_LAMPS_ON;
    a.load.day.usual = true;
    int code = parse_render(argc, argv, &a, &help);
    if (help) options_print_help(&OPTIONS);
    return code != APP_GOOD || help ? code : render(&a);
}
