// session.h - a walk under way: a building, the person who walks in it, its doors, and the frames that show them. It knows no
// window: events go in, frames come out, so that a test can drive it as a person does.
#ifndef WALK_SESSION_H
#define WALK_SESSION_H

#include "engine/display/display.h"
#include "engine/draw/walk_renderer.h"
#include "engine/overlay/hud.h"
#include "engine/scene/light.h"
#include "engine/walk/walk_offscreen.h"

// Loads the building at the start, whenever its file changes, and at another hour (walk_scene_load).
typedef struct SessionLoader {
    bool (*load)(void *context, const char *path, Arena *arena, WalkScene *out, Error *error);
    void *context;
    // Turns the hour at which it is loaded next (walk_scene_turn); NULL: the hour stays.
    bool (*turn)(void *context, const WalkScene *shown, int minutes, char *said, size_t size, Daylight *day,
                 Error *error);
} SessionLoader;

typedef struct SessionOptions {
    const char *file;      // the building's file, watched for changes
    const char *view;      // the stored viewpoint to begin at; NULL: the building's start
    const char *replay;    // a recorded path to follow from the start, or NULL
    const char *pictures;  // folder for screenshots and recorded paths, made with the first of them
    const char *trace;     // a file that gets a JSON line ten times a second, or NULL
    WalkDoors doors;       // WALK_DOORS: as drawn, but clear of stored views
    Culling culling;
    WalkLook look;  // WALK_LOOKS: the best that OpenGL draws in time, and baked once there is light
    FalseColour false_colour;
    bool full_screen;  // at the start
    // Called from other threads where the walk that sleeps has something to do; NULL: nobody sleeps.
    void (*wake)(void *context);
    void *wake_context;
} SessionOptions;
SessionOptions session_default_options(void);

typedef struct Session Session;

// A picture of the building before OpenGL has drawn one, BGRA bytes.
typedef struct SessionPicture {
    const uint32_t *pixels;  // [height * width] rows from the top
    int width, height;
} SessionPicture;

// Begins to read the building in a thread of its own, which also draws the first picture in this size (0: none). Needs no OpenGL.
Session *session_begin(const SessionOptions *options, const SessionLoader *loader, int width, int height,
                       Arena *arena);
bool session_loaded(const Session *session);                          // has the reading ended, well or not?
const SessionPicture *session_first_picture(const Session *session);  // NULL: there is none, or not yet
// Waits for the reading, and uploads the building, in the current OpenGL context, in which session_free is called too. Fails, and frees
// the session, when the building cannot be read.
bool session_open(Session *session, Error *error);
// Both at once.
Session *session_new(const SessionOptions *options, const SessionLoader *loader, Arena *arena, Error *error);
void session_free(Session *session);  // NULL is allowed; a recording under way is written
// Ends and writes a recording under way, if there is one, and reports a failure to write it.
bool session_keep_recording(Session *session, Error *error);

void session_event(Session *session, const DisplayEvent *event);
// Lets the walk go on until `now`, in ticks of about a hundredth of a second; a long stall counts as a short one. `now` is of a clock
// that only goes forward, seconds.
void session_advance(Session *session, double now);
// Would a frame of this size show anything that the last frame does not? Ask once after each session_advance.
bool session_changed(Session *session, int width, int height, double scale);
// How long nothing will happen unless an event comes or `wake` is called, seconds; 0: the next frame is due. `unseen`: the window cannot
// be seen, and no frame is drawn.
double session_pause(const Session *session, bool unseen);
// Draws a frame of `width` x `height` pixels, `scale` of them to a point. Allocates only when something was loaded or resized.
bool session_draw(Session *session, int width, int height, double scale, Error *error);
// Shows the last frame in a framebuffer of the window, or reads it as [height * width * 3] sRGB, rows from the top.
void session_show(Session *session, unsigned framebuffer, int width, int height);
bool session_read(Session *session, uint8_t *rgb, Error *error);

// Requests to the window: hold the mouse, fill the screen, close.
bool session_wants_mouse(const Session *session);
bool session_wants_full_screen(const Session *session);
bool session_ended(const Session *session);
bool session_failed(const Session *session,
                    Error *error);  // ended by an error, such as light that was asked for and is damaged

// The keys and their actions, for the help on the screen and in the terminal.
extern const HudKey SESSION_KEYS[];
extern const int SESSION_KEY_COUNT;
// The first keys that a newcomer needs, shown at the start.
extern const HudKey SESSION_HINT[];
extern const int SESSION_HINT_COUNT;

#endif
