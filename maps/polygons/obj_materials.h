// obj_materials.h - the materials that models of Sweet Home 3D call by name and no library describes.
#ifndef MAPS_OBJ_MATERIALS_H
#define MAPS_OBJ_MATERIALS_H

// The largest exponent of shininess that Sweet Home 3D takes; it counts as a shininess of 1.
#define OBJ_MAX_SHININESS 128.0

typedef struct ObjNamed {
    const char *name;
    double diffuse[3];  // Kd, 0 .. 1, as on a screen
    double alpha;       // d; 1 opaque
    double exponent;    // Ns, 0 (matt) .. OBJ_MAX_SHININESS
} ObjNamed;

// All of them, in the order of strcmp.
#define OBJ_NAMED_COUNT 134
extern const ObjNamed OBJ_NAMED[OBJ_NAMED_COUNT];

// The material of that name, spelled exactly so, or NULL.
const ObjNamed *obj_named(const char *name);

#endif
