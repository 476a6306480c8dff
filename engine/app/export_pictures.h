// export_pictures.h - pictures of textures in an exported model: PNG images in its binary part, and places of vertices in them.
#ifndef APP_EXPORT_PICTURES_H
#define APP_EXPORT_PICTURES_H

#include <jansson.h>

#include "maps/building/building.h"

typedef struct ExportPictures {
    const Building *building;
    json_t *images, *textures;  // arrays of the document
    int *texture;               // [texture_count] in `textures`, -1: not yet there
    unsigned char *bytes;       // of all images, each from a multiple of four on
    size_t *end;                // [image count] where each image ends in `bytes`
    size_t size;
    int end_count, end_capacity;
    int first_view;  // the view of image 0
    Arena arena;
} ExportPictures;

// `first_view`: images have views first_view, first_view + 1, ... of the document.
ExportPictures export_pictures(const Building *building, int first_view);
void export_pictures_free(ExportPictures *pictures);

// Does a polygon show a picture? As in a walk, one that emits light does not.
bool export_pictured(const Building *building, const Polygon *polygon);
// The picture of a material as index in the document; the first time it is added.
int export_picture(ExportPictures *pictures, int material);
// The factor from a material's light to that which its picture, as glTF reads it, has to be multiplied by: 1 / mean, each channel.
void export_picture_factor(const Building *building, int material, double out[3]);
// The place of a point in a polygon's picture; `first` is its first corner, near which places are small. Of leaves as when closed.
void export_picture_place(const Building *building, const Polygon *polygon, Vec3 first, Vec3 p, float out[2]);

#endif
