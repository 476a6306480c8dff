// gl_context.c - an OSMesa context with glad's loader, and shader programs.
#include "engine/gl/gl_context.h"

#include <glad/gl.h>

#include <GL/osmesa.h>
#include <string.h>

// OSMesa requires a buffer of its own; all drawing goes to framebuffer objects, so this buffer is as small as possible. Pixels.
#define GL_CONTEXT_SIDE 4

struct GlContext {
    OSMesaContext osmesa;
    unsigned char pixels[GL_CONTEXT_SIDE * GL_CONTEXT_SIDE * 4];
};

bool gl_context_use(GlContext *context, Error *error) {
    if (OSMesaGetCurrentContext() == context->osmesa) return true;
    if (OSMesaMakeCurrent(context->osmesa, context->pixels, GL_UNSIGNED_BYTE, GL_CONTEXT_SIDE,
                          GL_CONTEXT_SIDE)) {
        return true;
    }
    return error_set(error, "OSMesa: the OpenGL context cannot be made current");
}

bool gl_is_software(void) {
    const char *name = (const char *)glGetString(GL_RENDERER);
    return !name || strstr(name, "llvmpipe") || strstr(name, "softpipe") || strstr(name, "SWR");
}

GlContext *gl_context_open(Arena *arena, Error *error) {
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     3,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0};
    GlContext *context = ARENA_ARRAY(arena, GlContext, 1);
    context->osmesa = OSMesaCreateContextAttribs(attributes, NULL);
    if (!context->osmesa) {
        error_set(error, "OSMesa: no OpenGL context (3.3 core is needed)");
        return NULL;
    }
    if (gl_context_use(context, error) && gladLoadGL((GLADloadfunc)OSMesaGetProcAddress)) return context;
    error_set(error, "OSMesa: OpenGL 3.3 core is needed, its functions cannot be loaded");
    gl_context_close(context);
    return NULL;
}

void gl_context_close(GlContext *context) {
    if (!context || !context->osmesa) return;
    OSMesaDestroyContext(context->osmesa);
    context->osmesa = NULL;
}

static unsigned shader(unsigned kind, const char *text, Error *error) {
    unsigned name = glCreateShader(kind);
    glShaderSource(name, 1, &text, NULL);
    glCompileShader(name);
    int good = 0;
    glGetShaderiv(name, GL_COMPILE_STATUS, &good);
    if (good) return name;
    char log[512] = "";
    glGetShaderInfoLog(name, sizeof log, NULL, log);
    error_set(error, "OpenGL: %s shader: %s", kind == GL_VERTEX_SHADER ? "vertex" : "fragment", log);
    glDeleteShader(name);
    return 0;
}

unsigned gl_program(const char *vertex, const char *fragment, Error *error) {
    unsigned v = shader(GL_VERTEX_SHADER, vertex, error),
             f = v ? shader(GL_FRAGMENT_SHADER, fragment, error) : 0;
    unsigned program = 0;
    if (f) {
        program = glCreateProgram();
        glAttachShader(program, v);
        glAttachShader(program, f);
        glLinkProgram(program);
        int good = 0;
        glGetProgramiv(program, GL_LINK_STATUS, &good);
        if (!good) {
            char log[512] = "";
            glGetProgramInfoLog(program, sizeof log, NULL, log);
            error_set(error, "OpenGL: linking: %s", log);
            glDeleteProgram(program);
            program = 0;
        }
    }
    glDeleteShader(v);
    glDeleteShader(f);
    return program;
}

bool gl_check(const char *stage, Error *error) {
    unsigned code = glGetError();
    if (code == GL_NO_ERROR) return true;
    // OpenGL keeps one flag per kind of error, so all of them are cleared.
    while (glGetError() != GL_NO_ERROR) continue;
    return error_set(error, "OpenGL: error 0x%04x while %s%s", code, stage,
                     code == GL_OUT_OF_MEMORY ? " (out of memory)" : "");
}
