// session_state.h - the state and the functions that the files session*.c share.
#ifndef WALK_SESSION_STATE_H
#define WALK_SESSION_STATE_H

#include "engine/overlay/hud.h"
#include "engine/sim/doors.h"
#include "engine/sim/person.h"
#include "engine/sim/recording.h"
#include "engine/walk/file_watch.h"
#include "engine/walk/first_view.h"
#include "engine/walk/light_thread.h"
#include "engine/walk/session.h"

// Ticks of a walk in a second. Recorded paths keep one tick in SESSION_TICKS_KEPT.
#define SESSION_TICKS 120
#define SESSION_TICKS_KEPT (SESSION_TICKS / RECORDING_TICKS)

// How long the hint of the first keys is shown, seconds; it fades during the last second.
#define SESSION_HINT_SECONDS 12.0

// One line of the trace holds the times of at most so many frames: more than a screen shows in a tenth of a second.
enum { SESSION_PERIODS = 256 };

// Actions that last while a key is held.
enum {
    HELD_FORWARD,
    HELD_BACK,
    HELD_LEFT,
    HELD_RIGHT,
    HELD_UP,
    HELD_DOWN,
    HELD_TURN_LEFT,
    HELD_TURN_RIGHT,
    HELD_HURRY,
    HELD_KEYS
};

// A building and everything that was made from it: replaced as a whole when the file is read again.
typedef struct Shown {
    Arena arena;
    WalkScene scene;
    VisQuery *query;
    Mirrors *mirrors;  // or NULL
    WalkRenderer *renderer;
    Doors doors;
    PlanPlaces *places;
    BodyWorld world;
    Viewpoint first;      // the view that a walk begins with
    float *drawn_open;    // [opening_count] the doors as the last frame shows them
    int *hidden;          // [object_count] room for the surfaces of cells that are not visible
    LightThread *baking;  // or NULL
    Rgb *lit;             // [lamps of the scene] as they are switched
    float *asked_open;    // [opening_count] the doors for which light was asked last
    bool doors_moved;     // since the building was opened: light that shows them otherwise is wrong
    int turned;           // minutes by which its hour was turned
    bool turning;         // its light is on its way to another day:
    int turning_to;       // minutes
    Daylight turning_day;
    // Where light is in parts (LightBaker.parts): the one that is shown, and the one that was uploaded ahead, -1: none; the cell for which
    // the next part was found, and that part.
    int part, prepared, ahead_cell, ahead;
    int told;            // the end of the bake that has been reported, LIGHT_UNDER_WAY: none
    struct Shown *next;  // in the list of those no longer shown whose light is still being baked
} Shown;

// Contents of a frame besides the eye's place and the doors: two that are the same byte for byte show the same picture.
typedef struct SessionSeen {
    const void *shown, *light, *recording, *replay;
    double yaw, pitch, fov, scale, stops, message_since;
    float door_wanted;
    unsigned flags;
    int choices[3], width, height, message, hint, door, door_halt, light_done, lamp, lamp_chosen;
} SessionSeen;

// A building on its way (session_load.c).
typedef struct SessionLoad SessionLoad;

struct Session {
    SessionOptions options;
    SessionLoader loader;
    Arena *arena;
    SessionLoad *load;  // the building is being read, or NULL
    // At another hour: the building is being read, or is there and gets its light, or both are NULL.
    SessionLoad *coming_load;
    Shown *coming;
    int turned;     // minutes, of the building that comes, or that is shown
    char hour[32];  // in words; "": it was never turned
    Shown *shown, *leaving;
    Overlay *overlay;
    Person person;
    double fov;           // horizontal, radians
    int held[HELD_KEYS];  // how many keys for each action are down
    Culling culling;
    WalkLook look;
    WalkLook sketched;  // the look until there is light
    bool look_chosen;   // the look no longer changes by itself
    Exposure exposure;
    FalseColour false_colour;
    bool lamps;       // the list of lamps is shown
    int lamp_chosen;  // in it
    bool chose[2];    // the keys up and down were struck in it, and are held still
    bool frozen, wireframe, stab_tree, plan, statistics, help, full_screen, mouse, ended;
    VisResult visible;
    // Time.
    double now, behind;  // seconds; `behind`: passed but not yet walked
    long tick;
    double frame_ms, query_us, frame_period, frames_per_second;  // smoothed
    double last_frame, drawn_at;
    // The last frame, and what has happened since.
    SessionSeen seen;
    Vec3 seen_eye;
    long frames;                      // drawn
    bool changed;                     // session_changed as last asked
    bool exposed;                     // the window lost its picture
    bool moved;                       // the last tick moved the person
    bool adapting;                    // the exposure is on its way
    double periods[SESSION_PERIODS];  // ms, of the frames since the last line of the trace
    int period_count;
    // The sentence on the screen.
    char message[512];
    bool message_is_error;
    bool failed;  // the message is why the walk has ended
    double message_since;
    double began;        // when the first frame was drawn; -1: not yet
    double leave_asked;  // when Escape was answered by a question
    // Files.
    FileWatch watch;
    Recording *recording;  // under way, or NULL
    Recording *replay;     // being followed, or NULL
    int replay_next;
    Arena recording_arena, replay_arena, frame_arena;
    int pictures, paths;  // the numbers of the last ones written
    char last_path[1024];
    bool picture_wanted;  // the next frame is to be written
    int trace;            // file descriptor, -1: no trace
    double trace_due;
};

// ---- session_load.c
// NULL: no thread can be started.
SessionLoad *session_load_begin(const Session *s, int width, int height, Arena *arena);
// Waits for its end, and frees it.
Shown *session_load_end(SessionLoad *load, Error *error);
// Turns the hour: the building is read and lit once more, and takes the place of the one that is shown once all its light is there.
void session_turn_hour(Session *s, int minutes);
// Goes on with that. Needs OpenGL.
void session_take_coming(Session *s);
// The light of the building that is shown has turned to another hour.
void session_take_turned(Session *s);
// Gives the building up that was to come.
void session_drop_coming(Session *s);

// ---- session_scene.c
Shown *shown_load(const Session *s, Error *error);  // without OpenGL, in any thread
FirstScene shown_first_scene(Shown *shown);
// Uploads it, and begins its light. False after a failure, with which the building is freed.
bool shown_upload(const Session *s, Shown *shown, Error *error);
// Frees it after waiting at most so many seconds for a bake under way to end. False: the bake has not ended, and its data stays.
bool shown_free(Shown *shown, double seconds);
// Frees the buildings no longer shown whose bakes have ended.
void session_let_go(Session *s);
// Stops showing a building; it is freed when its bake has ended.
void session_leave(Session *s, Shown *shown);
// Shows another building of the same file; the person and the doors stay where they are.
void session_show_next(Session *s, Shown *next);
// Puts the person on foot where this eye looks from, or in flight where no body comes near enough to the eye. Ends a replay.
void session_stand(Session *s, Vec3 eye, double yaw, double pitch);
// Goes to a stored viewpoint; false if there are fewer viewpoints.
bool session_jump(Session *s, int viewpoint);
bool session_jump_to(Session *s, const char *name, Error *error);
void session_start(Session *s);
void session_change_storey(Session *s, int by);

// ---- session_files.c
void session_take_picture(Session *s);
void session_write_picture(Session *s, int width, int height);  // the frame just drawn
void session_record(Session *s);                                // begins a recording, or ends and writes it
void session_replay(Session *s);                                // follows the last path written, or stops
void session_stop_replay(Session *s);
bool session_follow(Session *s, const char *path, Error *error);
void session_record_tick(Session *s);
bool session_replay_tick(Session *s);               // false: nothing is being replayed
bool session_open_trace(Session *s, Error *error);  // true where none is wanted
void session_trace(Session *s);

// ---- session_light.c
void session_receive_light(Session *s);  // once a frame, before drawing
// Uploads light that has come, about `bytes` bytes of it.
void shown_receive_light(Shown *shown, size_t bytes);
// Asks for the light of the lamps as they are switched, and of the doors, once one of them has moved.
void session_ask_light(Shown *shown);
void session_expose(Session *s, const Camera *camera);  // adapts to the visible objects
bool session_light_shown(const Session *s);             // is light by radiosity shown?
WalkLook session_drawn_look(const Session *s);  // where light in parts has none about the eye, another one
bool session_light_waits(const Session *s);     // has light come that the next frame takes?
double session_light_done(const Session *s);    // 0 .. 1
const char *session_light_text(const Session *s, Arena *arena);
bool session_legend(const Session *s, HudLegend *out);  // false: no legend is shown
void session_brighten(Session *s, int by);
void session_fix_exposure(Session *s);
void session_change_colours(Session *s);

// The lamp that the eye looks at, -1: none, or none that could be switched.
int session_lamp(const Session *s);
// How many of the building's lamps, [*count], are off.
int session_dark_lamps(const Session *s, int *count);
const char *session_lamp_prompt(const Session *s, int lamp, Arena *arena);
// Switches the lamp chosen in the list, or the one looked at, or all of the room; or makes it brighter by so many tenths.
void session_switch_lamps(Session *s);
void session_dim_lamps(Session *s, int by);
void session_list_lamps(Session *s);  // shows the list, or hides it
void session_choose_lamp(Session *s, int by);
// The lines of the list about the lamp chosen, [*count]; NULL: it is not shown.
const HudKey *session_lamp_list(const Session *s, int *count, Arena *arena);

// ---- session_state.c
void session_say(Session *s, bool error, const char *format, ...) __attribute__((format(printf, 3, 4)));
const char *session_room(const Session *s);
// The storey that the person is in (plan_view_storey); -1: the building has no storeys.
int session_storey(const Session *s);
// The door that is looked at within reach, or -1.
int session_door(const Session *s);
// Has a bake in the background not yet ended?
bool session_light_arriving(const Session *s);
// How much is there of the building at another hour, 0 .. 1; below 0: none comes.
double session_coming_done(const Session *s);
// The words about a door that is looked at: open it, close it, or step out of its way.
const char *session_door_prompt(const Session *s, int door, Arena *arena);
// The opacity of the hint of the first keys, 0 .. 1: it fades in the walk's first seconds.
double session_hint_opacity(const Session *s);
enum { SESSION_FLAGS = 10 };
// Writes a word for each state that is not as usual; returns how many.
int session_flags(const Session *s, const char **out);

// ---- session_idle.c
void session_note_seen(Session *s, int width, int height, double scale);  // a frame was drawn

// ---- session.c
// Reads the file again; the walk goes on where it was. If that fails, a message says why, and the building shown stays.
void session_reload(Session *s);

#endif
