// session_keys.c - the effect of each key: one table of actions, and one of texts for the help.
#include "engine/walk/session_state.h"

// Radians for each point that the mouse moves: a hand's breadth turns half around.
static const double LOOK = 0.0024;
// Each notch of the wheel widens or narrows the view by this factor, within these limits, radians.
static const double ZOOM = 1.08, NARROWEST = 20 * M_PI / 180, WIDEST = 110 * M_PI / 180;

// How long a question by Escape can be answered, seconds: as long as it is shown.
static const double ASKED_SECONDS = HUD_MESSAGE_SECONDS;

static void on_off(Session *s, bool *what, const char *name) {
    *what = !*what;
    session_say(s, false, "%s %s", name, *what ? "on" : "off");
}

static void use_door(Session *s, int key) {
    (void)key;
    int door = session_door(s);
    if (door < 0) {
        session_say(s, false, "no door within reach");
        return;
    }
    doors_toggle(&s->shown->doors, door);
}

// Opens all doors, or closes all if all are open.
static void use_all_doors(Session *s, int key) {
    (void)key;
    const Building *b = s->shown->scene.graph->building;
    bool all_open = true;
    for (int i = 0; i < b->opening_count; i++)
        all_open = all_open && (b->openings[i].leaf_count == 0 || s->shown->doors.wanted[i] > 0.5f);
    for (int i = 0; i < b->opening_count; i++) s->shown->doors.wanted[i] = all_open ? 0 : 1;
    session_say(s, false, all_open ? "all doors close" : "all doors open");
}

static void fly(Session *s, int key) {
    (void)key;
    person_fly(&s->person, &s->shown->world, !s->person.flying);
    session_say(s, false, s->person.flying ? "flight: Space rises, C sinks" : "on foot");
}

static void show_plan(Session *s, int key) {
    (void)key;
    s->plan = !s->plan;
}

static void show_statistics(Session *s, int key) {
    (void)key;
    s->statistics = !s->statistics;
}

static void show_help(Session *s, int key) {
    (void)key;
    s->help = !s->help;
}

static void freeze(Session *s, int key) {
    (void)key;
    s->frozen = !s->frozen;
    session_say(s, false, s->frozen ? "what is visible from here stays" : "what is visible is asked anew");
}

static void change_method(Session *s, int key) {
    (void)key;
    s->culling = (Culling)((s->culling + 1) % QUERY_CULLINGS);
    session_say(s, false, "culling: %s", CULLING_NAMES[s->culling]);
}

static void stop_culling(Session *s, int key) {
    (void)key;
    s->culling = s->culling == CULL_NONE ? CULL_STAB : CULL_NONE;
    session_say(s, false, "culling: %s", CULLING_NAMES[s->culling]);
}

static void show_wireframe(Session *s, int key) {
    (void)key;
    on_off(s, &s->wireframe, "hidden cells in wireframe");
}

static void show_stab_tree(Session *s, int key) {
    (void)key;
    on_off(s, &s->stab_tree, "stab tree of the current cell");
    s->plan = s->plan || s->stab_tree;
}

static void change_look(Session *s, int key) {
    (void)key;
    s->look = (WalkLook)((s->look + 1) % WALK_LOOKS);
    if (s->look == WALK_BAKED && !walk_renderer_lit(s->shown->renderer)) s->look = WALK_FAST;
    s->look_chosen = true;
    session_say(s, false, "look: %s", WALK_LOOK_NAMES[s->look]);
}

static void brighten(Session *s, int key) { session_brighten(s, key == '=' ? 1 : -1); }

static void fix_exposure(Session *s, int key) {
    (void)key;
    session_fix_exposure(s);
}

static void switch_lamps(Session *s, int key) {
    (void)key;
    session_switch_lamps(s);
}

static void dim_lamps(Session *s, int key) { session_dim_lamps(s, key == ']' ? 1 : -1); }

// By ten minutes, with Shift by an hour.
static void turn_hour(Session *s, int key) {
    session_turn_hour(s, (key == '.' ? 1 : -1) * (s->held[HELD_HURRY] > 0 ? 60 : 10));
}

static void list_lamps(Session *s, int key) {
    (void)key;
    session_list_lamps(s);
}

// In the list of lamps; else the key walks.
static void choose_lamp(Session *s, int key) {
    if (s->lamps) session_choose_lamp(s, key == DISPLAY_KEY_DOWN ? 1 : -1);
}

static void change_colours(Session *s, int key) {
    (void)key;
    session_change_colours(s);
}

static void take_picture(Session *s, int key) {
    (void)key;
    session_take_picture(s);
}

static void record(Session *s, int key) {
    (void)key;
    session_record(s);
}

static void replay(Session *s, int key) {
    (void)key;
    session_replay(s);
}

static void change_storey(Session *s, int key) {
    session_change_storey(s, key == DISPLAY_KEY_PAGE_UP ? 1 : -1);
}

static void jump(Session *s, int key) {
    if (!session_jump(s, key - '1')) session_say(s, false, "there is no viewpoint %c", key);
}

static void start_key(Session *s, int key) {
    (void)key;
    session_start(s);
}

static void reload(Session *s, int key) {
    (void)key;
    session_reload(s);
}

static void full_screen(Session *s, int key) {
    (void)key;
    s->full_screen = !s->full_screen;
}

// Escape closes the help or the list of lamps, then frees the mouse, then ends the walk. While a path is recorded it asks before it ends
// the walk: it is struck easily, and ends the recording too.
static void leave(Session *s, int key) {
    (void)key;
    if (s->help) {
        s->help = false;
    } else if (s->lamps) {
        s->lamps = false;
    } else if (s->mouse) {
        s->mouse = false;
    } else if (s->recording && s->now - s->leave_asked > ASKED_SECONDS) {
        s->leave_asked = s->now;
        session_say(s, false,
                    "a path is being recorded: Esc again ends and keeps it, and leaves; R only ends it");
    } else {
        s->ended = true;
    }
}

// ---- the tables

static const struct {
    int key;
    int held;
} HELD[] = {{'W', HELD_FORWARD},
            {'S', HELD_BACK},
            {'A', HELD_LEFT},
            {'D', HELD_RIGHT},
            {DISPLAY_KEY_UP, HELD_FORWARD},
            {DISPLAY_KEY_DOWN, HELD_BACK},
            {DISPLAY_KEY_LEFT, HELD_TURN_LEFT},
            {DISPLAY_KEY_RIGHT, HELD_TURN_RIGHT},
            {DISPLAY_KEY_LEFT_SHIFT, HELD_HURRY},
            {DISPLAY_KEY_RIGHT_SHIFT, HELD_HURRY},
            {' ', HELD_UP},
            {'C', HELD_DOWN}};

static const struct {
    int first, last;  // keys
    void (*act)(Session *s, int key);
} STRUCK[] = {{'E', 'E', use_door},
              {'O', 'O', use_all_doors},
              {'F', 'F', fly},
              {'M', 'M', show_plan},
              {'I', 'I', show_statistics},
              {'H', 'H', show_help},
              {DISPLAY_KEY_F1, DISPLAY_KEY_F1, show_help},
              {'V', 'V', freeze},
              {'N', 'N', change_method},
              {'B', 'B', stop_culling},
              {'X', 'X', show_wireframe},
              {'T', 'T', show_stab_tree},
              {'G', 'G', change_look},
              {'-', '-', brighten},
              {'=', '=', brighten},
              {'U', 'U', fix_exposure},
              {'K', 'K', change_colours},
              {'Q', 'Q', switch_lamps},
              {'[', ']', dim_lamps},
              {'J', 'J', list_lamps},
              {',', ',', turn_hour},
              {'.', '.', turn_hour},
              {DISPLAY_KEY_UP, DISPLAY_KEY_UP, choose_lamp},
              {DISPLAY_KEY_DOWN, DISPLAY_KEY_DOWN, choose_lamp},
              {'P', 'P', take_picture},
              {DISPLAY_KEY_F12, DISPLAY_KEY_F12, take_picture},
              {'R', 'R', record},
              {'L', 'L', replay},
              {DISPLAY_KEY_PAGE_UP, DISPLAY_KEY_PAGE_UP, change_storey},
              {DISPLAY_KEY_PAGE_DOWN, DISPLAY_KEY_PAGE_DOWN, change_storey},
              {'1', '9', jump},
              {'0', '0', start_key},
              {DISPLAY_KEY_F5, DISPLAY_KEY_F5, reload},
              {DISPLAY_KEY_F11, DISPLAY_KEY_F11, full_screen},
              {DISPLAY_KEY_ESCAPE, DISPLAY_KEY_ESCAPE, leave}};

const HudKey SESSION_KEYS[] = {
    {"mouse, left right", "look around; a click takes the mouse, Esc gives it back"},
    {"W A S D, up down", "walk; with Shift run"},
    {"E", "open or close the door looked at; O all doors"},
    {"F", "flight through everything, and back; Space rises, C sinks"},
    {"1 ... 9, 0", "to a stored viewpoint; to the start"},
    {"Page up, down", "to the storey above or below"},
    {"wheel", "narrow or widen the view"},
    {"M", "plan"},
    {"I", "statistics"},
    {"V", "freeze what is visible, and look at it from elsewhere"},
    {"B, N", "culling off and on; the next way of culling"},
    {"X", "hidden cells in wireframe"},
    {"T", "stab tree of the current cell on the plan"},
    {"G", "fast, fine or baked look"},
    {"-, =, U", "darker, brighter; the eye adapts, or stays as it is"},
    {"Q, [ ]", "switch the lamp looked at, or the room's; darker, brighter"},
    {"J", "list of lamps: up and down choose, Q [ ] switch"},
    {", .", "ten minutes earlier, later; with Shift an hour"},
    {"K", "light in false colours: radiosity, irradiance, illuminance"},
    {"P, F12", "screenshot"},
    {"R, L", "record a path, and end it; replay it"},
    {"F5, F11", "read the file again; full screen"},
    {"H, F1, Esc", "this help; Esc leaves"}};
const HudKey SESSION_HINT[] = {
    {"click", "to look around"}, {"W A S D", "walk"}, {"E", "open a door"}, {"H", "all keys"}};
const int SESSION_HINT_COUNT = sizeof SESSION_HINT / sizeof *SESSION_HINT;
const int SESSION_KEY_COUNT = sizeof SESSION_KEYS / sizeof *SESSION_KEYS;

// A key that was struck in the list of lamps does not walk, nor does its release, wherever the list went meanwhile.
static bool chooses(Session *s, int key, int by) {
    if (key != DISPLAY_KEY_UP && key != DISPLAY_KEY_DOWN) return false;
    bool *chose = &s->chose[key == DISPLAY_KEY_DOWN], was = *chose;
    *chose = by > 0 && s->lamps;
    return by > 0 ? *chose : was;
}

static void hold(Session *s, int key, int by) {
    if (chooses(s, key, by)) return;
    for (size_t i = 0; i < sizeof HELD / sizeof *HELD; i++) {
        if (HELD[i].key != key) continue;
        s->held[HELD[i].held] += by;
        if (by > 0) session_stop_replay(s);
    }
}

static void strike(Session *s, int key) {
    for (size_t i = 0; i < sizeof STRUCK / sizeof *STRUCK; i++) {
        if (STRUCK[i].first <= key && key <= STRUCK[i].last) STRUCK[i].act(s, key);
    }
}

void session_event(Session *s, const DisplayEvent *event) {
    switch (event->kind) {
    case DISPLAY_KEY_PRESSED:
        hold(s, event->key, 1);
        strike(s, event->key);
        break;
    case DISPLAY_KEY_RELEASED:
        hold(s, event->key, -1);
        break;
    case DISPLAY_LOOK:
        if (!s->mouse) break;
        person_look(&s->person, -LOOK * event->x, -LOOK * event->y);
        break;
    case DISPLAY_BUTTON_PRESSED:
        s->mouse = true;
        break;
    case DISPLAY_SCROLLED:
        s->fov = fmin(fmax(s->fov * pow(ZOOM, -event->y), NARROWEST), WIDEST);
        break;
    case DISPLAY_FOCUS_LOST:
        s->mouse = false;
        break;
    case DISPLAY_EXPOSED:
        s->exposed = true;
        break;
    case DISPLAY_CLOSED:
        s->ended = true;
        break;
    default:
        break;
    }
}
