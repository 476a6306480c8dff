// surface.c - faces on curved surfaces.
#include "maps/ifc/ifc_file.h"

bool ifc_curved_face(Reader *r, int surface, const FaceRings *rings, bool same_sense, Shape *out) {
    (void)r, (void)surface, (void)rings, (void)same_sense, (void)out;
    return false;
}
