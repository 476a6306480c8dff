// view.c - the view volume of a camera as planes, for the visibility query.
#include "engine/draw/view.h"

static Plane side(const Camera *camera, Vec3 across, double tangent) {
    Vec3 n = vec3_normalize(vec3_add(vec3_scale(camera->forward, tangent), across));
    return (Plane){n, vec3_dot(n, camera->eye)};
}

Eye walk_eye(const Camera *camera) {
    Eye eye = {.position = camera->eye, .frustum_count = 4};
    eye.frustum[0] = side(camera, camera->right, camera->tan_x);
    eye.frustum[1] = side(camera, vec3_scale(camera->right, -1), camera->tan_x);
    eye.frustum[2] = side(camera, camera->up, camera->tan_y);
    eye.frustum[3] = side(camera, vec3_scale(camera->up, -1), camera->tan_y);
    return eye;
}
