// walk_targets.c - framebuffer objects with their textures and render buffers.
#include "engine/draw/walk_targets.h"

#include <glad/gl.h>

#include "engine/gl/gl_context.h"

#define FINE_SAMPLES 4

static int coarse(int pixels) { return (pixels + WALK_COARSE - 1) / WALK_COARSE; }

void walk_targets_free(WalkTargets *t) {
    unsigned buffers[] = {t->fast_depth, t->fine_colour, t->fine_depth};
    glDeleteFramebuffers(WALK_TARGETS, t->frame);
    glDeleteTextures(WALK_TARGETS, t->texture);
    glDeleteRenderbuffers(3, buffers);
    *t = (WalkTargets){0};
}

bool walk_targets_resize(WalkTargets *t, int width, int height, Error *error) {
    if (t->width == width && t->height == height) return true;
    walk_targets_free(t);
    int most = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    if (width < 1 || height < 1 || width > most || height > most)
        return error_set(error, "OpenGL: an image of %d x %d pixels (1 to %d each)", width, height, most);
    t->width = width;
    t->height = height;
    return true;
}

typedef struct TextureKind {
    int internal;
    unsigned format, type, attachment;
    int filter;
    bool coarse;
} TextureKind;

// All mirrors have that of the first.
static const TextureKind TEXTURES[] = {
    // This format is a software window's own order of bytes: showing the frame is then a plain copy there, in a sixth of the time.
    // A sized format would be laid out in the order of its name.
    [WALK_TARGET_FINAL] = {GL_RGBA, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, GL_COLOR_ATTACHMENT0, GL_NEAREST,
                           false},
    [WALK_TARGET_FAST] = {GL_RGBA, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, GL_COLOR_ATTACHMENT0, GL_NEAREST,
                          false},
    [WALK_TARGET_DEPTH] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, GL_DEPTH_ATTACHMENT,
                           GL_NEAREST, false},
    [WALK_TARGET_OCCLUSION] = {GL_RG32F, GL_RG, GL_FLOAT, GL_COLOR_ATTACHMENT0, GL_NEAREST, true},
    [WALK_TARGET_MIRROR] = {GL_RGBA, GL_BGRA, GL_UNSIGNED_INT_8_8_8_8_REV, GL_COLOR_ATTACHMENT0, GL_NEAREST,
                            false},
    [WALK_TARGET_BLUR] = {GL_R32F, GL_RED, GL_FLOAT, GL_COLOR_ATTACHMENT0, GL_LINEAR, true},
};

static const TextureKind *kind_of(WalkTarget which) {
    return &TEXTURES[which < WALK_TARGET_MIRROR ? which : WALK_TARGET_MIRROR];
}

static void make_texture(WalkTargets *t, WalkTarget which) {
    const TextureKind *kind = kind_of(which);
    glGenTextures(1, &t->texture[which]);
    glBindTexture(GL_TEXTURE_2D, t->texture[which]);
    glTexImage2D(GL_TEXTURE_2D, 0, kind->internal, kind->coarse ? coarse(t->width) : t->width,
                 kind->coarse ? coarse(t->height) : t->height, 0, kind->format, kind->type, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, kind->filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, kind->filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static void attach_buffer(unsigned *buffer, unsigned attachment, unsigned format, int samples,
                          const WalkTargets *t) {
    glGenRenderbuffers(1, buffer);
    glBindRenderbuffer(GL_RENDERBUFFER, *buffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, t->width, t->height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, *buffer);
}

static void attach_texture(const WalkTargets *t, WalkTarget which) {
    glFramebufferTexture2D(GL_FRAMEBUFFER, kind_of(which)->attachment, GL_TEXTURE_2D, t->texture[which], 0);
}

static void attach(WalkTargets *t, WalkTarget which) {
    int samples = 0;
    switch (which) {
    case WALK_TARGET_FAST:
        attach_texture(t, WALK_TARGET_FAST);
        attach_buffer(&t->fast_depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, 0, t);
        break;
    case WALK_TARGET_FINE:
        glGetIntegerv(GL_MAX_SAMPLES, &samples);
        if (samples > FINE_SAMPLES) samples = FINE_SAMPLES;
        attach_buffer(&t->fine_colour, GL_COLOR_ATTACHMENT0, GL_RGBA8, samples, t);
        attach_buffer(&t->fine_depth, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, samples, t);
        break;
    default:
        attach_texture(t, which);
    }
    if (which == WALK_TARGET_DEPTH) {
        glDrawBuffer(GL_NONE);
        glReadBuffer(GL_NONE);
    }
}

static bool make(WalkTargets *t, WalkTarget which, Error *error) {
    if (which != WALK_TARGET_FINE) make_texture(t, which);
    glGenFramebuffers(1, &t->frame[which]);
    glBindFramebuffer(GL_FRAMEBUFFER, t->frame[which]);
    attach(t, which);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
        return gl_check("making a frame", error);
    error_set(error, "OpenGL: no frame of %d x %d pixels", t->width, t->height);
    // The frame must not pass for a complete one the next time.
    walk_targets_free(t);
    return false;
}

bool walk_targets_bind(WalkTargets *t, WalkTarget which, Error *error) {
    if (!t->frame[which] && !make(t, which, error)) return false;
    bool is_coarse = kind_of(which)->coarse;
    glBindFramebuffer(GL_FRAMEBUFFER, t->frame[which]);
    glViewport(0, 0, is_coarse ? coarse(t->width) : t->width, is_coarse ? coarse(t->height) : t->height);
    return true;
}
