// light_thread.h - light baked in the background of a walk: a thread of lowest priority, whose states of the light the walk
// takes one by one. Everything here but the bake itself is called from the walk's thread and never waits, unless it says so.
#ifndef WALK_LIGHT_THREAD_H
#define WALK_LIGHT_THREAD_H

#include "engine/draw/lit_mesh.h"
#include "engine/scene/light.h"

typedef struct LightThread LightThread;

// Lives in the arena, which may go only when the thread has ended; so it is with all that the baker uses. NULL where no
// thread can be started.
LightThread *light_thread_start(const LightBaker *baker, Arena *arena);

LitMesh *light_thread_mesh(const LightThread *thread);  // NULL: not yet
// A new state, or NULL. It stays as it is until the one after it was received.
const LitLight *light_thread_light(LightThread *thread);
void light_thread_received(LightThread *thread);  // it was copied: the thread may fill the one before it anew
double light_thread_done(const LightThread *thread);  // 0 .. 1

enum {
    LIGHT_UNDER_WAY,
    LIGHT_READY,   // the last state is the whole solution
    LIGHT_FAILED,  // there is none; or it was stopped
};
int light_thread_end(const LightThread *thread);
// A sentence for the user after the end; "": none.
const char *light_thread_note(const LightThread *thread);

void light_thread_stop(LightThread *thread);
// Waits until the thread has ended, up to so many seconds after it was asked to stop, and frees what it made. False: it is
// still at work.
bool light_thread_free(LightThread *thread, double seconds);
// Lets one that is still at work go down with the program; all that it uses stays until then.
void light_thread_abandon(LightThread *thread);

#endif
