// walk_programs.c - compiles the shaders, asks for the places of their uniforms, and makes the scale of false colours as a texture.
#include "engine/draw/walk_programs.h"

#include <glad/gl.h>
#include <math.h>

#include "engine/draw/walk_mesh.h"
#include "engine/draw/walk_shaders.h"
#include "engine/gl/gl_context.h"
#include "engine/lit/false_colour.h"

static unsigned make_scale(void) {
    enum { COLOURS = 256 };
    uint8_t texels[COLOURS][4];
    unsigned texture;
    for (int i = 0; i < COLOURS; i++) {
        Rgb c = false_colour_at((i + 0.5) / COLOURS);
        texels[i][0] = (uint8_t)lrintf(255 * c.r);
        texels[i][1] = (uint8_t)lrintf(255 * c.g);
        texels[i][2] = (uint8_t)lrintf(255 * c.b);
        texels[i][3] = 255;
    }
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, COLOURS, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

// `flags` as for walk_program, of programs without pictures.
static bool make_lit_look(LitLook *out, bool pictures, int flags, Error *error) {
    *out = (LitLook){.lit = walk_program(WALK_LIT_VERTEX, WALK_LIT_FRAGMENT, flags, error)};
    if (out->lit) out->numbers = walk_program(WALK_FALSE_VERTEX, WALK_FALSE_FRAGMENT, flags, error);
    if (out->numbers && pictures)
        out->pictured = walk_program(WALK_LIT_VERTEX, WALK_LIT_FRAGMENT, flags | SHADER_PICTURES, error);
    if (!out->numbers || (pictures && !out->pictured)) return false;
    glUseProgram(out->numbers);
    glUniform1i(glGetUniformLocation(out->numbers, "materials"), WALK_UNIT_LAMPS);
    glUniform1i(glGetUniformLocation(out->numbers, "scale"), WALK_UNIT_FREE);
    out->scale = make_scale();
    return true;
}

static void free_lit_look(LitLook *look) {
    glDeleteProgram(look->lit);
    glDeleteProgram(look->numbers);
    glDeleteProgram(look->pictured);
    glDeleteTextures(1, &look->scale);
}

static bool make_scene_program(SceneProgram *out, unsigned program) {
    if (program == 0) return false;
    *out = (SceneProgram){program,
                          glGetUniformLocation(program, "clip"),
                          glGetUniformLocation(program, "eye"),
                          glGetUniformLocation(program, "size"),
                          glGetUniformLocation(program, "colour"),
                          glGetUniformLocation(program, "day"),
                          glGetUniformLocation(program, "mirror"),
                          glGetUniformLocation(program, "share")};
    glUseProgram(program);
    glUniform1i(glGetUniformLocation(program, "lamps"), WALK_UNIT_LAMPS);
    glUniform1i(glGetUniformLocation(program, "atlas"), WALK_UNIT_ATLAS);
    glUniform1i(glGetUniformLocation(program, "occlusion"), WALK_UNIT_FREE);
    glUniform1i(glGetUniformLocation(program, "image"), WALK_UNIT_FREE);
    return true;
}

static bool make_scene_programs(bool pictures, WalkPrograms *out, Error *error) {
    static const struct {
        const char *vertex, *fragment;
    } SHADERS[SCENE_SHADERS] = {
        [SCENE_THINGS] = {WALK_THING_VERTEX, WALK_THING_FRAGMENT},
        [SCENE_SURFACES] = {WALK_BAKED_VERTEX, WALK_BAKED_FRAGMENT},
        [SCENE_PANES] = {WALK_THING_VERTEX, WALK_PANE_FRAGMENT},
        [SCENE_DEPTH] = {WALK_LINE_VERTEX, WALK_DEPTH_FRAGMENT},
        [SCENE_FINE] = {WALK_FINE_VERTEX, WALK_FINE_FRAGMENT},
        [SCENE_FINE_PANES] = {WALK_FINE_VERTEX, WALK_FINE_FRAGMENT},
        [SCENE_LINES] = {WALK_LINE_VERTEX, WALK_LINE_FRAGMENT},
        [SCENE_MIRROR] = {WALK_LINE_VERTEX, WALK_MIRROR_FRAGMENT},
    };
    for (int i = 0; i < SCENE_SHADERS; i++) {
        const char *vertex = SHADERS[i].vertex, *fragment = SHADERS[i].fragment;
        if (i == SCENE_MIRROR && !(out->flags & SHADER_MIRRORS)) continue;
        if (!make_scene_program(&out->scene[i], walk_program(vertex, fragment, out->flags, error)))
            return false;
    }
    // The programs of polygons with pictures. Pictures with holes are among the panes.
    static const struct {
        SceneShader shader;
        const char *vertex, *fragment;
        bool cut_out;
    } PICTURED[] = {{SCENE_THINGS, WALK_THING_VERTEX, WALK_THING_FRAGMENT, false},
                    {SCENE_SURFACES, WALK_BAKED_VERTEX, WALK_BAKED_FRAGMENT, false},
                    {SCENE_PANES, WALK_THING_VERTEX, WALK_THING_FRAGMENT, true},
                    {SCENE_FINE, WALK_FINE_VERTEX, WALK_FINE_FRAGMENT, false},
                    {SCENE_FINE_PANES, WALK_FINE_VERTEX, WALK_FINE_FRAGMENT, true}};
    for (size_t i = 0; i < sizeof PICTURED / sizeof *PICTURED && pictures; i++) {
        int flags = out->flags | SHADER_PICTURES | (PICTURED[i].cut_out ? SHADER_CUT_OUT : 0);
        unsigned program = walk_program(PICTURED[i].vertex, PICTURED[i].fragment, flags, error);
        if (!make_scene_program(&out->pictured[PICTURED[i].shader], program)) return false;
    }
    return true;
}

static bool make_sky_program(SkyProgram *out, unsigned program) {
    static const char *const LIT[SKY_PLACES] = {"lit",       "sun",        "lit_ground", "overhead",
                                                "gradation", "indicatrix", "sun_shines"};
    *out = (SkyProgram){.program = program,
                        .forward = glGetUniformLocation(program, "forward"),
                        .right = glGetUniformLocation(program, "right"),
                        .up = glGetUniformLocation(program, "up"),
                        .day = glGetUniformLocation(program, "day"),
                        .strength = glGetUniformLocation(program, "strength"),
                        .start = glGetUniformLocation(program, "start")};
    for (int i = 0; i < SKY_PLACES; i++) out->lit[i] = glGetUniformLocation(program, LIT[i]);
    return program != 0;
}

bool walk_programs_new(int flags, bool sky, WalkPrograms *out, Error *error) {
    bool pictures = flags & SHADER_PICTURES;
    *out = (WalkPrograms){.flags = flags & ~SHADER_PICTURES};
    if (!make_scene_programs(pictures, out, error)) return false;
    unsigned program = gl_program(WALK_SCREEN_VERTEX, WALK_SKY_FRAGMENT, error);
    if (!program || !make_sky_program(&out->sky, program)) return false;
    if (sky) {
        program = walk_program(WALK_SCREEN_VERTEX, WALK_SKY_FRAGMENT, SHADER_PICTURES, error);
        if (!program || !make_sky_program(&out->pictured_sky, program)) return false;
    }
    out->occlusion = gl_program(WALK_SCREEN_VERTEX, WALK_OCCLUSION_FRAGMENT, error);
    out->blur = out->occlusion ? gl_program(WALK_SCREEN_VERTEX, WALK_BLUR_FRAGMENT, error) : 0;
    if (!out->blur) return false;
    out->occlusion_tangents = glGetUniformLocation(out->occlusion, "tangents");
    glUseProgram(out->occlusion);
    glUniform1i(glGetUniformLocation(out->occlusion, "depth"), WALK_UNIT_FREE);
    glUniform1f(glGetUniformLocation(out->occlusion, "near"), (float)WALK_NEAR);
    glUseProgram(out->blur);
    glUniform1i(glGetUniformLocation(out->blur, "source"), WALK_UNIT_FREE);
    return make_lit_look(&out->lit, pictures, out->flags, error);
}

void walk_programs_free(WalkPrograms *p) {
    unsigned programs[] = {p->sky.program, p->pictured_sky.program, p->occlusion, p->blur};
    for (int i = 0; i < 4; i++) glDeleteProgram(programs[i]);
    for (int i = 0; i < SCENE_SHADERS; i++) {
        glDeleteProgram(p->scene[i].program);
        glDeleteProgram(p->pictured[i].program);
    }
    free_lit_look(&p->lit);
}
