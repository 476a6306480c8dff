// lit_look.c - programs, their uniforms, and the scale of false colours as a texture.
#include "engine/draw/lit_look.h"

#include <glad/gl.h>
#include <math.h>

#include "engine/draw/walk_mesh.h"
#include "engine/draw/walk_shaders.h"
#include "engine/gl/gl_context.h"

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

bool lit_look_new(LitLook *out, Error *error) {
    *out = (LitLook){.lit = gl_program(WALK_LIT_VERTEX, WALK_LIT_FRAGMENT, error)};
    if (out->lit) out->numbers = gl_program(WALK_FALSE_VERTEX, WALK_FALSE_FRAGMENT, error);
    if (!out->numbers) return false;
    glUseProgram(out->numbers);
    glUniform1i(glGetUniformLocation(out->numbers, "materials"), WALK_UNIT_LAMPS);
    glUniform1i(glGetUniformLocation(out->numbers, "scale"), WALK_UNIT_FREE);
    out->scale = make_scale();
    return true;
}

void lit_look_free(LitLook *look) {
    glDeleteProgram(look->lit);
    glDeleteProgram(look->numbers);
    glDeleteTextures(1, &look->scale);
}

static void set_number(unsigned program, const char *name, double x) {
    glUniform1f(glGetUniformLocation(program, name), (float)x);
}

static void set_vector(unsigned program, const char *name, double x, double y, double z) {
    glUniform3f(glGetUniformLocation(program, name), (float)x, (float)y, (float)z);
}

void lit_look_use(const LitLook *look, const LitTone *tone, LightRange range, const float *clip, Vec3 eye,
                  double fade) {
    bool numbers = tone->quantity != FALSE_COLOUR_OFF;
    unsigned program = numbers ? look->numbers : look->lit;
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip"), 1, GL_FALSE, clip);
    set_vector(program, "eye", eye.x, eye.y, eye.z);
    set_number(program, "fade", fade);
    if (!numbers) {
        set_number(program, "exposure", tone->exposure);
        return;
    }
    double weights[3];
    false_colour_weights(tone->quantity, weights);
    set_vector(program, "weights", weights[0], weights[1], weights[2]);
    glUniform1i(glGetUniformLocation(program, "arriving"), tone->quantity != FALSE_COLOUR_RADIOSITY);
    set_number(program, "low", range.low);
    set_number(program, "octaves", log2(range.high / range.low));
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_FREE);
    glBindTexture(GL_TEXTURE_2D, look->scale);
}
