// texture.h - pictures of textures: decoded, kept small, and read.
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

// A picture is kept with at most this many texels along a side, about 2 mm on a wall of two metres: larger ones are halved.
#define TEXTURE_SIDE 1024
// All pictures of a building together are kept in this many texels (and a third more, of their smaller levels): 171 MB. A picture may
// take a quarter of what is left, so many pictures are kept smaller, and none is refused.
#define TEXTURE_MOST_TEXELS (32 << 20)

// Decodes a PNG, JPEG, BMP or WebP image and appends it to the building's pictures. Returns its index there; 0 for anything else, a damaged
// image, one above TEXTURE_MAX_PIXELS or one that is transparent throughout.
// `left`: how many pixels may still be decoded; grows by TEXTURE_PIXELS_A_BYTE for each byte of this image and shrinks by the
// image's pixels; NULL: no limit. An image with more pixels than `left` is refused. A JPEG's pixels count once for every few of its
// scans, since each scan goes over all pixels.
int texture_add(Arena *arena, Building *b, const char *name, Bytes image, double *left);
// The same of an image whose opacity does not count.
int texture_add_opaque(Arena *arena, Building *b, const char *name, Bytes image, double *left);
// The same of an image whose opacity is another image's, nearest to each pixel: `mask`'s own opacity where that is below 1 anywhere, else
// its mean channel. Without pixels in `image` (NULL) the picture has the mask's size and one colour; without a mask it is texture_add.
int texture_add_masked(Arena *arena, Building *b, const char *name, Bytes image, Bytes mask, Rgb colour,
                       double *left);
// Puts a picture on a material: its mean is the material's reflectance, and its holes count into the material's alpha.
void texture_put(const Building *b, int texture, Material *material);
// The mean alone, of an image that is not kept.
bool texture_mean(Bytes image, double *left, Rgb *mean);
// As texture_add, of pixels that are there, [height * width * 4] as in Texture.texels.
int texture_add_pixels(Arena *arena, Building *b, const char *name, int width, int height,
                       const uint8_t *pixels);

// The texels of a level, 0 the finest, and its sides. Levels beyond the last, of one texel, are the last.
const uint8_t *texture_level(const Texture *texture, int level, int *width, int *height);

// A colour in linear light, and how opaque it is, 0 .. 1.
typedef struct Texel {
    Rgb colour;
    float opacity;
} Texel;
// The picture at (u, v), averaged over about `texels` texels of the finest level each way: between the two levels and the four texels
// nearest (Williams 1983). Colours are reflectances as of maps_linear.
Texel texture_read(const Texture *texture, double u, double v, double texels);

// The reflectance of a material at a point of a polygon of this map (Polygon.texture_map), averaged over about `width` metres:
// Material.reflectance, in proportion to the picture's colour there and its mean. For leaves of doors `p` is the point as when closed.
// Opacity is the share of the material's alpha. Without a picture it is the material's own reflectance and opacity 1.
Texel texture_at(const Building *b, int material, int texture_map, Vec3 p, double width);

#endif
