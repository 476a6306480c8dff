// session_scene.c - the building shown: read, read again, and the places in it where the person stands.
#include <stdio.h>

#include <string.h>

#include "engine/lit/lit_parts.h"
#include "engine/walk/session_state.h"

// An eye that no body can come this near to, metres, is looked from in flight.
static const double NEAR_ENOUGH = 0.3;

static void set_doors(Doors *doors, const Building *b, WalkDoors state) {
    Random random = {1};
    WalkDoors stand = state == WALK_DOORS ? WALK_DOORS_DRAWN : state;
    for (int i = 0; i < b->opening_count; i++) doors_set(doors, i, walk_door_share(b, i, stand, &random));
    if (state != WALK_DOORS) return;
    walk_clear_views(b, doors->open);
    for (int i = 0; i < b->opening_count; i++) doors_set(doors, i, doors->open[i]);
}

FirstScene shown_first_scene(Shown *shown) {
    return (FirstScene){shown->scene.graph, shown->query, shown->doors.open, &shown->world};
}

Shown *shown_load(const Session *s, Error *error) {
    Arena first = {0};
    Shown *shown = ARENA_ARRAY(&first, Shown, 1);
    *shown = (Shown){.turned = s->turned, .part = -1, .prepared = -1, .ahead_cell = -1, .ahead = -1};
    shown->arena = first;  // stored in the object that it holds
    Arena *arena = &shown->arena;
    if (!s->loader.load(s->loader.context, s->options.file, arena, &shown->scene, error)) {
        shown_free(shown, 0);
        return NULL;
    }
    const CellGraph *graph = shown->scene.graph;
    shown->query = vis_query_new(graph, shown->scene.forest, arena);
    shown->mirrors = mirrors_new(graph, shown->scene.forest, arena);
    shown->doors = doors_new(graph, arena);
    shown->places = plan_places(graph, arena);
    shown->world = body_world(graph, shown->doors.open, arena);
    shown->drawn_open = ARENA_ARRAY(arena, float, graph->building->opening_count + 1);
    shown->hidden = ARENA_ARRAY(arena, int, graph->object_count + 1);
    set_doors(&shown->doors, graph->building, s->options.doors);
    shown->asked_open = ARENA_ARRAY(arena, float, graph->building->opening_count + 1);
    memcpy(shown->asked_open, shown->doors.open,
           (size_t)graph->building->opening_count * sizeof *shown->asked_open);
    Arena scratch = {0};
    FirstScene scene = shown_first_scene(shown);
    shown->first = first_view(&scene, FIRST_VIEW_FOV, &scratch);
    arena_free(&scratch);
    return shown;
}

bool shown_upload(const Session *s, Shown *shown, Error *error) {
    const WalkLight *light = shown->scene.light;
    shown->renderer = walk_renderer_new(shown->scene.graph, &shown->arena, error);
    if (!shown->renderer || (light && !walk_renderer_light(shown->renderer, light, &shown->arena, error))) {
        shown_free(shown, 0);
        return false;
    }
    // The part about the eye and the next one.
    if (shown->scene.baker.parts)
        walk_renderer_reserve(shown->renderer, lit_parts_most_vertices(shown->scene.baker.parts), 2);
    const LoadedScene *scene = shown->scene.scene;
    if (scene) {
        shown->lit = ARENA_ARRAY(&shown->arena, Rgb, scene->lamps.count + 1);
        memcpy(shown->lit, scene->lit, (size_t)scene->lamps.count * sizeof *shown->lit);
    }
    if (!light && (shown->scene.baker.bake || shown->scene.baker.parts))
        shown->baking =
            light_thread_start(&shown->scene.baker, s->options.wake, s->options.wake_context, &shown->arena);
    if (shown->baking && !shown->scene.baker.parts && scene && !scene_fully_lit(scene))
        session_ask_light(shown);
    return true;
}

bool shown_free(Shown *shown, double seconds) {
    if (!shown) return true;
    walk_renderer_free(shown->renderer);
    shown->renderer = NULL;
    if (shown->baking) {
        light_thread_stop(shown->baking);
        if (!light_thread_free(shown->baking, seconds)) return false;
    }
    mirrors_free(shown->mirrors);
    Arena arena = shown->arena;
    arena_free(&arena);
    return true;
}

void session_show_next(Session *s, Shown *next) {
    doors_keep(&next->doors, &s->shown->doors);
    session_leave(s, s->shown);
    s->shown = next;
    s->visible = (VisResult){.eye_cell = -1};
    s->frozen = false;
    s->person.cell = -1;
    person_put(&s->person, &next->world, s->person.eye, s->person.yaw, s->person.pitch);
}

void session_leave(Session *s, Shown *shown) {
    if (shown_free(shown, 0)) return;
    shown->next = s->leaving;
    s->leaving = shown;
}

void session_let_go(Session *s) {
    for (Shown **at = &s->leaving; *at;) {
        Shown *next = (*at)->next;
        if (shown_free(*at, 0))
            *at = next;
        else
            at = &(*at)->next;
    }
}

// ---- where the person stands

void session_stand(Session *s, Vec3 eye, double yaw, double pitch) {
    s->replay = NULL;
    s->person.cell = -1;
    s->person.flying = false;
    person_put(&s->person, &s->shown->world, eye, yaw, pitch);
    if (vec3_length(vec3_sub(s->person.eye, eye)) <= NEAR_ENOUGH) return;
    s->person.flying = true;
    person_put(&s->person, &s->shown->world, eye, yaw, pitch);
}

// Puts the person where a walk begins, on foot, however far the nearest place for a body is.
void session_start(Session *s) {
    const Viewpoint *first = &s->shown->first;
    s->replay = NULL;
    s->person.cell = -1;
    s->person.flying = false;
    person_put(&s->person, &s->shown->world, first->eye, first->yaw, first->pitch);
}

static void look_from(Session *s, const Viewpoint *v) {
    session_stand(s, v->eye, v->yaw, v->pitch);
    session_say(s, false, "%s", v->name);
}

bool session_jump(Session *s, int viewpoint) {
    const Building *b = s->shown->scene.graph->building;
    if (viewpoint >= b->viewpoint_count) return false;
    look_from(s, &b->viewpoints[viewpoint]);
    return true;
}

bool session_jump_to(Session *s, const char *name, Error *error) {
    const Building *b = s->shown->scene.graph->building;
    for (int i = 0; i < b->viewpoint_count; i++) {
        if (strcmp(b->viewpoints[i].name, name) == 0) return session_jump(s, i);
    }
    return error_set(error, "%s: there is no viewpoint `%s` (%d are stored)", s->options.file, name,
                     b->viewpoint_count);
}

// Goes to the place above or below the person; if the storey has no free place there, to the middle of its first room.
void session_change_storey(Session *s, int by) {
    const CellGraph *graph = s->shown->scene.graph;
    const Building *b = graph->building;
    int storey = session_storey(s) + by;
    if (storey < 0 || storey >= b->storey_count) {
        session_say(s, false, "there is no storey %s", by > 0 ? "above" : "below");
        return;
    }
    Vec3 eye = vec3(s->person.eye.x, s->person.eye.y, b->storeys[storey].floor + BODY_EYE);
    int cell = vis_locate(graph, eye, -1);
    if (cell < 0 || vis_region(graph, cell)->storey != storey) {
        for (cell = 0; cell < graph->cell_count; cell++) {
            const Region *r = vis_region(graph, cell);
            if (r->storey == storey && r->kind == REGION_ROOM) break;
        }
        if (cell == graph->cell_count) return;
        Box box = graph->cells[cell].box;
        eye = vec3((box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2, box.min.z + BODY_EYE);
    }
    session_stand(s, eye, s->person.yaw, s->person.pitch);
    session_say(s, false, "%s", b->storeys[storey].name);
}
