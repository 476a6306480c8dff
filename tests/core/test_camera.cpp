// test_camera.cpp - the camera's matrices against GLM's, the C++ library that cglm, which we use, is made after.
//
// The C headers are read as C++ here: it has another word for functions that do not return, and compound literals are an
// extension that g++ and clang++ know.
#define _Noreturn [[noreturn]]
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
extern "C" {
#include "engine/core/random.h"
#include "engine/gl/gl_math.h"
}
#pragma GCC diagnostic pop

#include <algorithm>
#include <cmath>

#include <criterion/criterion.h>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/glm.hpp>

namespace {

// A float has 24 bits; the entries are products and sums of up to three numbers rounded to it, each at most 1/tan of
// half the field of view: within 2 * 2^-24 of the greatest. 1e-6 leaves room for eight of them.
const double TOLERANCE = 1e-6;

struct Case {
    double yaw, pitch, fov, near;
    int width, height;
};

Case random_case(Random *random) {
    const double steepest = M_PI / 2 - 1e-3;
    Case c;
    c.yaw = random_between(random, -2 * M_PI, 2 * M_PI);
    c.pitch = random_between(random, -steepest, steepest);
    c.fov = random_between(random, 0.2, 2.6);
    c.near = random_between(random, 0.01, 0.5);
    c.width = 1 + random_index(random, 4000);
    c.height = 1 + random_index(random, 4000);
    // Every tenth looks almost straight up or down, where a view made from an up vector breaks first.
    if (random_index(random, 10) == 0) c.pitch = random_index(random, 2) ? steepest : -steepest;
    return c;
}

Camera camera_of(const Case &c) {
    return camera_look(vec3(1, 2, 3), c.yaw, c.pitch, c.fov, c.width, c.height);
}

// What GLM makes of the same camera, in doubles; relative to the eye, as ours.
glm::dmat4 view_of(const Case &c) {
    glm::dvec3 forward(std::cos(c.yaw) * std::cos(c.pitch), std::sin(c.yaw) * std::cos(c.pitch),
                       std::sin(c.pitch));
    return glm::lookAt(glm::dvec3(0), forward, glm::dvec3(0, 0, 1));
}

glm::dmat4 projection_of(const Case &c) {
    double aspect = (double)c.width / c.height, tan_y = std::tan(c.fov / 2) / aspect;
    return glm::infinitePerspective(2 * std::atan(tan_y), aspect, c.near);
}

}  // namespace

// right, up and forward are the rows of glm::lookAt, forward being its -z.
Test(camera, looks_as_glm_does) {
    for (uint64_t seed = 0; seed < 1000; seed++) {
        Random random = {seed};
        Case c = random_case(&random);
        Camera camera = camera_of(c);
        glm::dmat4 view = view_of(c);
        const Vec3 rows[3] = {camera.right, camera.up, vec3_scale(camera.forward, -1)};
        for (int row = 0; row < 3; row++) {
            const double ours[3] = {rows[row].x, rows[row].y, rows[row].z};
            for (int column = 0; column < 3; column++) {
                cr_assert(std::fabs(ours[column] - view[column][row]) <= TOLERANCE,
                          "seed %d: row %d, column %d of the view is %.9g, GLM has %.9g", (int)seed, row,
                          column, ours[column], view[column][row]);
            }
        }
    }
}

// The matrix that goes to OpenGL is glm::infinitePerspective * glm::lookAt; flipped, its second row is turned round.
Test(camera, clips_as_glm_does) {
    for (uint64_t seed = 0; seed < 1000; seed++) {
        Random random = {seed};
        Case c = random_case(&random);
        Camera camera = camera_of(c);
        glm::dmat4 theirs = projection_of(c) * view_of(c);
        for (int flip = 0; flip < 2; flip++) {
            mat4 ours;
            gl_clip_matrix(&camera, c.near, flip, ours);
            double greatest = std::max(1.0, std::max(1 / camera.tan_x, 1 / camera.tan_y));
            for (int i = 0; i < 16; i++) {
                int column = i / 4, row = i % 4;
                double expected = flip && row == 1 ? -theirs[column][row] : theirs[column][row];
                cr_assert(std::fabs((double)ours[column][row] - expected) <= TOLERANCE * greatest,
                          "seed %d, flip %d: row %d, column %d is %.9g, GLM has %.9g", (int)seed, flip, row,
                          column, (double)ours[column][row], expected);
            }
        }
    }
}
