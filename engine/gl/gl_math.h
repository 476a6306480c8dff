// gl_math.h - cglm (float matrices for OpenGL) beside our own vectors, which have the same names: in files that include this
// header, cglm's vec2 and vec3 are called glm_vec2_type and glm_vec3_type.
#ifndef ENGINE_GL_MATH_H
#define ENGINE_GL_MATH_H

#include "engine/core/camera.h"

#define vec2 glm_vec2_type
#define vec3 glm_vec3_type
#include <cglm/cglm.h>
#undef vec2
#undef vec3

// The view without translation (from world axes relative to the eye to right, up and forward), times the projection whose clip
// coordinates are x, y (`flip`: downwards, so that row 0 of an image is its top), z = w - 2 near, and w = the component along
// `forward`. The projection clips at the near plane and has no far plane: depth is left to the drawing code.
static inline void gl_clip_matrix(const Camera *camera, double near, bool flip, mat4 out) {
    Vec3 r = camera->right, u = camera->up, f = camera->forward;
    mat4 turn = {{(float)r.x, (float)u.x, (float)f.x, 0},
                 {(float)r.y, (float)u.y, (float)f.y, 0},
                 {(float)r.z, (float)u.z, (float)f.z, 0},
                 {0, 0, 0, 1}};
    mat4 project = GLM_MAT4_ZERO_INIT;
    project[0][0] = (float)(1 / camera->tan_x);
    project[1][1] = (float)((flip ? -1 : 1) / camera->tan_y);
    project[2][2] = project[2][3] = 1;
    project[3][2] = (float)(-2 * near);
    glm_mat4_mul(project, turn, out);
}

#endif
