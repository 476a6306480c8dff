// session_state.h - what the files session*.c share.
#ifndef WALK_SESSION_STATE_H
#define WALK_SESSION_STATE_H

#include "engine/overlay/hud.h"
#include "engine/sim/doors.h"
#include "engine/sim/person.h"
#include "engine/sim/recording.h"
#include "engine/walk/file_watch.h"
#include "engine/walk/light_thread.h"
#include "engine/walk/session.h"

// Ticks of a walk in a second. Recorded paths keep every second one.
#define SESSION_TICKS 120
#define SESSION_TICKS_KEPT (SESSION_TICKS / RECORDING_TICKS)

// Frames whose times one line of the trace tells, at most: more than a screen shows in a tenth of a second.
enum { SESSION_PERIODS = 256 };

// Keys that are held, not struck.
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

// A building and everything that was made of it: swapped as a whole when the file is read again.
typedef struct Shown {
    Arena arena;
    WalkScene scene;
    VisQuery *query;
    WalkRenderer *renderer;
    Doors doors;
    BodyWorld world;
    int *hidden;          // [object_count] the surfaces of cells that are not visible
    LightThread *baking;  // or NULL
    bool told;            // that it has ended
    struct Shown *next;   // of those that are no longer shown, but whose light is still being baked
} Shown;

struct Session {
    SessionOptions options;
    SessionLoader loader;
    Arena *arena;
    Shown *shown, *leaving;
    Overlay *overlay;
    Person person;
    double fov;           // horizontal, radians
    int held[HELD_KEYS];  // how many keys for it are down
    Culling culling;
    WalkLook look;
    WalkLook sketched;  // the look until there is light
    bool look_chosen;   // no longer changed by itself
    Exposure exposure;
    FalseColour false_colour;
    bool frozen, wireframe, stab_tree, plan, statistics, help, full_screen, mouse, ended;
    VisResult visible;
    // Time.
    double now, behind;  // seconds; `behind`: not yet walked
    long tick;
    double frame_ms, query_us, frame_period, frames_per_second;  // smoothed
    double last_frame, drawn_at;
    double periods[SESSION_PERIODS];  // ms, of the frames since the last line of the trace
    int period_count;
    // The sentence on the screen.
    char message[512];
    bool message_is_error;
    double message_since;
    // Files.
    FileWatch watch;
    Recording *recording;  // under way, or NULL
    Recording *replay;     // being followed, or NULL
    int replay_next;
    Arena recording_arena, replay_arena, frame_arena;
    int pictures, paths;  // the numbers of the last ones written
    char last_path[1024];
    bool picture_wanted;  // of the next frame
    int trace;            // -1: none
    double trace_due;
};

// ---- session_scene.c
Shown *shown_load(const Session *s, Error *error);
// Waits a moment for a bake under way to end, 0: not at all; false: it has not, and all stays as it is.
bool shown_free(Shown *shown, double seconds);
// Frees what has ended of what was shown before.
void session_let_go(Session *s);
// The building shown gives way to another; it is freed when its bake has ended.
void session_leave(Session *s, Shown *shown);
// On foot where this eye looks from, in flight where no body comes near enough to it. Ends a replay.
void session_stand(Session *s, Vec3 eye, double yaw, double pitch);
// To a stored viewpoint; false if there are fewer.
bool session_jump(Session *s, int viewpoint);
bool session_jump_to(Session *s, const char *name, Error *error);
void session_start(Session *s);
void session_change_storey(Session *s, int by);

// ---- session_files.c
void session_take_picture(Session *s);
void session_write_picture(Session *s, int width, int height);  // of the frame just drawn
void session_record(Session *s);                                // begins, or ends and writes
void session_replay(Session *s);                                // follows the last path written, or stops
void session_stop_replay(Session *s);
bool session_follow(Session *s, const char *path, Error *error);
void session_record_tick(Session *s);
bool session_replay_tick(Session *s);               // false: nothing is being replayed
bool session_open_trace(Session *s, Error *error);  // true where none is asked for
void session_trace(Session *s);

// ---- session_light.c
void session_receive_light(Session *s);                 // once a frame, before it
void session_expose(Session *s, const Camera *camera);  // of what is visible
bool session_light_shown(const Session *s);             // light by radiosity
double session_light_done(const Session *s);            // 0 .. 1
const char *session_light_text(const Session *s, Arena *arena);
bool session_legend(const Session *s, HudLegend *out);  // false: there is none
void session_brighten(Session *s, int by);
void session_fix_exposure(Session *s);
void session_change_colours(Session *s);

// ---- session_state.c
void session_say(Session *s, bool error, const char *format, ...) __attribute__((format(printf, 3, 4)));
const char *session_room(const Session *s);
// -1: outdoors or nowhere.
int session_storey(const Session *s);
// Looked at and within reach, or -1.
int session_door(const Session *s);
// A bake in the background has not yet ended.
bool session_light_arriving(const Session *s);
enum { SESSION_FLAGS = 10 };
// Words for everything that is not as usual; returns how many.
int session_flags(const Session *s, const char **out);

// ---- session.c
// Reads the file again; the walk goes on where it was. A fault is said, and the building shown stays.
void session_reload(Session *s);

#endif
