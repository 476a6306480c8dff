// gl_context.c - an OSMesa context with glad's loader, and shader programs.
//
// OSMesa is loaded when a context is first opened: with LLVM, of which it is made, it would take as long to load as a house to read, and
// neither a window nor most commands need it.
#include "engine/gl/gl_context.h"

#include <glad/gl.h>

#include <GL/osmesa.h>
#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

// OSMesa requires a buffer of its own; all drawing goes to framebuffer objects, so this buffer is as small as possible. Pixels.
#define GL_CONTEXT_SIDE 4

struct GlContext {
    OSMesaContext osmesa;
    unsigned char pixels[GL_CONTEXT_SIDE * GL_CONTEXT_SIDE * 4];
};

// OSMesa's functions; NULL where it cannot be loaded.
static __typeof__(&OSMesaCreateContextAttribs) create_context;
static __typeof__(&OSMesaDestroyContext) destroy_context;
static __typeof__(&OSMesaGetCurrentContext) current_context;
static __typeof__(&OSMesaMakeCurrent) make_current;
static __typeof__(&OSMesaGetProcAddress) function_of;

static void load_osmesa(void) {
    void *library = dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
    if (!library) return;
    *(void **)&create_context = dlsym(library, "OSMesaCreateContextAttribs");
    *(void **)&destroy_context = dlsym(library, "OSMesaDestroyContext");
    *(void **)&current_context = dlsym(library, "OSMesaGetCurrentContext");
    *(void **)&make_current = dlsym(library, "OSMesaMakeCurrent");
    *(void **)&function_of = dlsym(library, "OSMesaGetProcAddress");
}

bool gl_context_use(GlContext *context, Error *error) {
    if (current_context() == context->osmesa) return true;
    if (make_current(context->osmesa, context->pixels, GL_UNSIGNED_BYTE, GL_CONTEXT_SIDE, GL_CONTEXT_SIDE))
        return true;
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
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, load_osmesa);
    if (!create_context || !destroy_context || !current_context || !make_current || !function_of) {
        error_set(error, "OSMesa: libOSMesa.so.8 cannot be loaded");
        return NULL;
    }
    GlContext *context = ARENA_ARRAY(arena, GlContext, 1);
    context->osmesa = create_context(attributes, NULL);
    if (!context->osmesa) {
        error_set(error, "OSMesa: no OpenGL context (3.3 core is needed)");
        return NULL;
    }
    if (gl_context_use(context, error) && gladLoadGL((GLADloadfunc)function_of)) return context;
    error_set(error, "OSMesa: OpenGL 3.3 core is needed, its functions cannot be loaded");
    gl_context_close(context);
    return NULL;
}

void gl_context_close(GlContext *context) {
    if (!context || !context->osmesa) return;
    destroy_context(context->osmesa);
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
