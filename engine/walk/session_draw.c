// session_draw.c - draws a frame: finds what is visible, draws the building, and over it the panels that the keys asked for.
#include "engine/core/clock.h"
#include "engine/draw/view.h"
#include "engine/walk/session_state.h"

// The weight of the newest frame in smoothed figures.
static const double FRESH = 0.1;
static const float HIDDEN_COLOUR[4] = {1.0f, 0.35f, 0.2f, 0.5f};

static void smooth(double *figure, double now) { *figure += (*figure == 0 ? 1 : FRESH) * (now - *figure); }

static void ask(Session *s, const Camera *camera) {
    if (s->frozen && s->visible.objects) return;
    Eye eye = walk_eye(camera);
    double start = clock_seconds();
    s->visible = vis_query(s->shown->query, &eye, s->person.cell, s->shown->doors.open, s->culling);
    smooth(&s->query_us, 1e6 * (clock_seconds() - start));
}

// Draws the surfaces of cells that are not in the visible set, as lines.
static bool draw_hidden(Session *s, const Camera *camera, Error *error) {
    const CellGraph *graph = s->shown->scene.graph;
    int count = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        bool visible = s->visible.cell_count == 0;
        for (int i = 0; i < s->visible.cell_count && !visible; i++) visible = s->visible.cells[i].cell == c;
        for (int o = graph->surface_first[c]; o < graph->surface_first[c + 1] && !visible; o++)
            s->shown->hidden[count++] = o;
    }
    return walk_renderer_wireframe(s->shown->renderer, camera, s->shown->hidden, count, HIDDEN_COLOUR, error);
}

static void draw_hud(Session *s, int width, int height, double scale) {
    const CellGraph *graph = s->shown->scene.graph;
    const Building *b = graph->building;
    const Person *p = &s->person;
    int storey = session_storey(s), door = session_door(s);
    arena_reset(&s->frame_arena);
    HudFigures figures = {.method = CULLING_NAMES[s->culling],
                          .cells_visible = s->visible.cell_count,
                          .cell_count = graph->cell_count,
                          .polygons_drawn = s->visible.polygon_count,
                          .polygon_count = graph->polygon_count,
                          .query_us = s->query_us,
                          .frame_ms = s->frame_ms,
                          .frames_per_second = s->frames_per_second,
                          .eye = p->eye,
                          .room = session_room(s),
                          .storey = storey < 0 ? NULL : b->storeys[storey].name,
                          .light = session_light_text(s, &s->frame_arena)};
    HudLegend legend;
    PlanView plan = {.graph = graph,
                     .places = s->shown->places,
                     .forest = s->stab_tree ? s->shown->scene.forest : NULL,
                     .visible = &s->visible,
                     .door_open = s->shown->doors.open,
                     .eye = p->eye,
                     .yaw = p->yaw,
                     .fov = s->fov,
                     .cell = p->cell,
                     .storey = storey};
    const char *flags[SESSION_FLAGS];
    HudState state = {.figures = s->statistics ? &figures : NULL,
                      .help = s->help ? SESSION_KEYS : NULL,
                      .help_count = SESSION_KEY_COUNT,
                      .flags = flags,
                      .flag_count = s->statistics ? session_flags(s, flags) : 0,
                      .recording = s->recording != NULL,
                      .message = s->picture_wanted || !*s->message ? NULL : s->message,
                      .message_age = s->now - s->message_since,
                      .message_is_error = s->message_is_error,
                      .hint = SESSION_HINT,
                      .hint_count = SESSION_HINT_COUNT,
                      .hint_opacity = s->picture_wanted ? 0 : session_hint_opacity(s),
                      .plan = s->plan ? &plan : NULL,
                      .legend = session_legend(s, &legend) ? &legend : NULL,
                      .crosshair = s->mouse && !s->picture_wanted,
                      .scratch = &s->frame_arena};
    if (door >= 0 && !s->picture_wanted) {
        state.prompt_key = "E";
        state.prompt = session_door_prompt(s, door, &s->frame_arena);
    }
    int lamp = door < 0 && !s->lamps ? session_lamp(s) : -1;
    if (lamp >= 0 && !s->picture_wanted) {
        state.prompt_key = "Q";
        state.prompt = session_lamp_prompt(s, lamp, &s->frame_arena);
    }
    if (!s->help && s->lamps) state.help = session_lamp_list(s, &state.help_count, &s->frame_arena);
    overlay_begin(s->overlay, width, height, scale);
    hud_draw(s->overlay, &state);
}

static void measure_frame(Session *s, double start) {
    double end = clock_seconds();
    smooth(&s->frame_ms, 1e3 * (end - start));
    if (s->last_frame > 0) {
        smooth(&s->frame_period, end - s->last_frame);
        if (s->period_count < SESSION_PERIODS) s->periods[s->period_count++] = 1e3 * (end - s->last_frame);
    }
    s->frames_per_second = s->frame_period > 0 ? 1 / s->frame_period : 0;
    s->last_frame = end;
}

bool session_draw(Session *s, int width, int height, double scale, Error *error) {
    const Person *p = &s->person;
    double start = clock_seconds();
    if (s->began < 0) s->began = s->now;
    Camera camera = camera_look(p->eye, p->yaw, p->pitch, s->fov, width, height);
    session_receive_light(s);
    ask(s, &camera);
    session_expose(s, &camera);
    WalkRenderer *renderer = s->shown->renderer;
    walk_renderer_pose(renderer, s->shown->doors.open);
    const MirrorView *mirrors;
    int mirror_count =
        mirrors_look(s->shown->mirrors, &camera, &s->visible, s->shown->doors.open, s->culling, &mirrors);
    walk_renderer_mirrors(renderer, mirrors, mirror_count);
    if (!walk_renderer_draw(renderer, &camera, s->visible.objects, s->visible.object_count,
                            session_drawn_look(s), error))
        return false;
    if (s->wireframe && !draw_hidden(s, &camera, error)) return false;
    if (!walk_renderer_finish_scene(renderer, error)) return false;
    draw_hud(s, width, height, scale);
    if (!overlay_end(s->overlay, error)) return false;
    if (s->picture_wanted) session_write_picture(s, width, height);
    walk_renderer_finish();
    measure_frame(s, start);
    walk_renderer_ahead(renderer, s->shown->scene.forest, p->cell);
    session_note_seen(s, width, height, scale);
    return true;
}

void session_show(Session *s, unsigned framebuffer, int width, int height) {
    walk_renderer_show(s->shown->renderer, framebuffer, width, height);
}
