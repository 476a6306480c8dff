// camera.c - the axes of a camera that looks along two angles, and the rays through its pixels.
#include "engine/core/camera.h"

#include <math.h>

Camera camera_look(Vec3 eye, double yaw, double pitch, double fov, int width, int height) {
    Camera camera = {.eye = eye, .width = width, .height = height};
    camera.forward = vec3(cos(yaw) * cos(pitch), sin(yaw) * cos(pitch), sin(pitch));
    // `right` depends on the yaw alone, so that it is defined even when the view is straight up or down.
    camera.right = vec3(sin(yaw), -cos(yaw), 0);
    camera.up = vec3_cross(camera.right, camera.forward);
    camera.tan_x = tan(fov / 2);
    camera.tan_y = camera.tan_x * height / width;
    return camera;
}

Vec3 camera_ray(const Camera *camera, double i, double j) {
    double x = (2 * i / camera->width - 1) * camera->tan_x;
    double y = (1 - 2 * j / camera->height) * camera->tan_y;
    Vec3 across = vec3_add(vec3_scale(camera->right, x), vec3_scale(camera->up, y));
    return vec3_add(camera->forward, across);
}
