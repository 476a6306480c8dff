// gl_context.h - OpenGL 3.3 in memory (OSMesa), without a window or a display, and the functions that every user of OpenGL needs.
#ifndef ENGINE_GL_CONTEXT_H
#define ENGINE_GL_CONTEXT_H

#include <stdbool.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"

// Each thread that draws has its own context; an object that is made in one context does not exist in another.
typedef struct GlContext GlContext;

// Makes a context and makes it current. Returns NULL, with the reason, when there is no OpenGL 3.3.
GlContext *gl_context_open(Arena *arena, Error *error);
bool gl_context_use(GlContext *context, Error *error);  // makes it current
void gl_context_close(GlContext *context);              // frees all its objects; NULL is allowed

// Does the current context draw with the processor? True too where it does not say.
bool gl_is_software(void);

// A linked program of the current context, 0 on failure.
unsigned gl_program(const char *vertex, const char *fragment, Error *error);
// Returns false, with an error that names `stage`, when OpenGL has reported an error since the last call (out of memory, mostly).
bool gl_check(const char *stage, Error *error);

#endif
