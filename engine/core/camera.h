// camera.h - a pinhole camera: where it stands, where it looks, and the ray through each pixel.
#ifndef CORE_CAMERA_H
#define CORE_CAMERA_H

#include "engine/core/vec.h"

// A pinhole camera. Pixel (i, j) looks through x = (2(i + 0.5)/width - 1) * tan_x along `right`,
// y = (1 - 2(j + 0.5)/height) * tan_y along `up`, 1 along `forward`: row 0 is the top.
typedef struct Camera {
    Vec3 eye, forward, right, up;  // unit, orthogonal, right-handed: right x up = -forward
    double tan_x, tan_y;           // half the view's extent at distance 1
    int width, height;             // pixels
} Camera;

// A camera at `eye` that looks along yaw (radians, counter-clockwise from +x) and pitch (radians, up from the horizon), with the
// horizontal field of view `fov`, radians.
Camera camera_look(Vec3 eye, double yaw, double pitch, double fov, int width, int height);
// The direction through pixel coordinates (i, j). Its component along `forward` is 1, so it is not a unit vector.
Vec3 camera_ray(const Camera *camera, double i, double j);

#endif
