// texture.h - the mean colour of an image, which is all that light and display take from a texture.
#ifndef MAPS_TEXTURE_H
#define MAPS_TEXTURE_H

#include "engine/core/file.h"
#include "maps/building.h"

// Pixels of an image, width times height: beyond it decoding takes longer than a texture is worth.
#define TEXTURE_MAX_PIXELS (32 << 20)

// Width times height as the image's head tells, for budgets; 0 for what texture_mean refuses by its head.
int texture_pixels(Bytes image);

// The mean of a PNG, JPEG or BMP image in linear light, weighted by its opacity, as a reflectance. False for
// anything else, a damaged image, one above TEXTURE_MAX_PIXELS or one that is transparent throughout.
bool texture_mean(Bytes image, Rgb *mean);

#endif
