// light_thread.h - bakes light in the background of a walk: a thread of low priority makes states of the light, which the walk
// takes one by one. All functions here are called from the walk's thread and never wait, unless their comment says so.
#ifndef WALK_LIGHT_THREAD_H
#define WALK_LIGHT_THREAD_H

#include "engine/lit/lit_mesh.h"
#include "engine/scene/light.h"

typedef struct LightThread LightThread;

// The result lives in the arena. The arena and all data that the baker uses may go only when the thread has ended. NULL where no
// thread can be started.
// `wake` is called from the thread with each new state and at the end, for a walk that sleeps; NULL: nobody does.
LightThread *light_thread_start(const LightBaker *baker, void (*wake)(void *context), void *wake_context,
                                Arena *arena);

// The mesh of the newest state; NULL: there is none yet. The last state has a finer mesh than those before it.
LitMesh *light_thread_mesh(const LightThread *thread);
// A new state, or NULL. The state stays unchanged until the next state has been received, and so does the mesh until this one has.
const LitLight *light_thread_light(LightThread *thread);
void light_thread_received(LightThread *thread);      // the state was copied; the one before may change
double light_thread_done(const LightThread *thread);  // 0 .. 1

enum {
    LIGHT_UNDER_WAY,
    LIGHT_READY,   // the last state is the whole solution
    LIGHT_FAILED,  // there is no solution, or the thread was stopped
};
int light_thread_end(const LightThread *thread);
// A sentence for the user after the end; "": nothing to tell.
const char *light_thread_note(const LightThread *thread);

// ---- lamps and doors

// Asks for the light with the lamps, [count of the scene's lamps], and the doors, [opening_count] (NULL: as they were baked), in a state,
// which is copied; the newest one asked for is made. What that takes is found first where it is not known yet: by a bake anew, where light
// was stored without. `day`: under another day, where light_thread_turns, then the doors are told as well; NULL: under that of the last
// state.
void light_thread_ask(LightThread *thread, const Rgb *lit, int count, const float *doors, int openings,
                      const Daylight *day);
// Can the next state be one of another day that shines?
bool light_thread_turns(const LightThread *thread);
// How far the state of another day is, 0 .. 1.
double light_thread_turned(const LightThread *thread);
enum {
    LAMPS_KNOWN,    // the next state asked for comes at once
    LAMPS_SOUGHT,   // the light of each lamp is being found
    LAMPS_UNKNOWN,  // it is looked for once light is there, or when a state is asked for
    LAMPS_NEVER,    // it is not found
};
int light_thread_lamps(const LightThread *thread);
// How much of it is found, 0 .. 1.
double light_thread_lamps_done(const LightThread *thread);
// Is a state asked for that is not there yet?
bool light_thread_behind(const LightThread *thread);
// Can states be asked for at all?
bool light_thread_switches(const LightThread *thread);

// ---- light in parts (LightBaker.parts)

// Asks for the light of a part. It is read into memory of its own while the walk shows that of another, and waits to be taken as a new
// state on a new mesh. A part that waits, and is not the one asked for, is dropped: the walk must not have begun to take it.
void light_thread_ask_part(LightThread *thread, int part);
// The part whose light waits to be taken, -1: none does.
int light_thread_part(const LightThread *thread);

void light_thread_stop(LightThread *thread);
// Waits until the thread has ended, at most for so many seconds, and frees all that it made; call light_thread_stop before. False: the
// thread is still at work.
bool light_thread_free(LightThread *thread, double seconds);
// Lets a thread that is still at work end with the program; all data that it uses must stay until then.
void light_thread_abandon(LightThread *thread);

#endif
