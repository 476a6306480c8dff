// texture.h - the mean colour of an image: light and display use nothing else of a texture.
#ifndef MAPS_TEXTURE_H
#define MAPS_TEXTURE_H

#include "engine/core/file.h"
#include "maps/building/building.h"

// The most pixels of an image, width times height: beyond this, decoding takes longer than a texture is worth.
#define TEXTURE_MAX_PIXELS (32 << 20)

// A few bytes can unpack to millions of pixels, so all images of a building together may have TEXTURE_FREE_PIXELS, and
// TEXTURE_PIXELS_A_BYTE more for each byte of the images. Photographs have 1 to 20 pixels a byte.
#define TEXTURE_FREE_PIXELS (32 << 20)
#define TEXTURE_PIXELS_A_BYTE 64

// Width times height as the image's header states, for budgets; 0 for an image that texture_mean refuses by its header.
int texture_pixels(Bytes image);

// The mean of a PNG, JPEG or BMP image in linear light, weighted by its opacity, as a reflectance. False for
// anything else, a damaged image, one above TEXTURE_MAX_PIXELS or one that is transparent throughout.
// `left`: how many pixels may still be decoded; grows by TEXTURE_PIXELS_A_BYTE for each byte of this image and shrinks by the
// image's pixels; NULL: no limit. An image with more pixels than `left` is refused. A JPEG's pixels count once for every few of its
// scans, since each scan goes over all pixels.
bool texture_mean(Bytes image, double *left, Rgb *mean);

#endif
