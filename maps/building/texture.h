// texture.h - the mean colour of an image: light and display take nothing else from a texture.
#ifndef MAPS_TEXTURE_H
#define MAPS_TEXTURE_H

#include "engine/core/file.h"
#include "maps/building/building.h"

// Pixels of an image, width times height: beyond it decoding takes longer than a texture is worth.
#define TEXTURE_MAX_PIXELS (32 << 20)

// A few bytes unpack to millions of pixels: all images of a building may have TEXTURE_FREE_PIXELS, and so many more for each of their
// bytes. Photographs have 1 to 20 a byte.
#define TEXTURE_FREE_PIXELS (32 << 20)
#define TEXTURE_PIXELS_A_BYTE 64

// Width times height as the image's head tells, for budgets; 0 for an image that texture_mean refuses by its head.
int texture_pixels(Bytes image);

// The mean of a PNG, JPEG or BMP image in linear light, weighted by its opacity, as a reflectance. False for
// anything else, a damaged image, one above TEXTURE_MAX_PIXELS or one that is transparent throughout.
// `left`: how many pixels may still be decoded, less those of this image afterwards; NULL: any number. An image beyond that is
// refused. A JPEG counts once for every few of its scans, since each goes over all pixels.
bool texture_mean(Bytes image, double *left, Rgb *mean);

#endif
