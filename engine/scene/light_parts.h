// light_parts.h - light that is stored in parts of a building (parts.h): a small .rad file, and beside it a folder with the .rad file of
// each part (kept_parts.h), which has the light on all that is seen from the part's cells.
#ifndef SCENE_LIGHT_PARTS_H
#define SCENE_LIGHT_PARTS_H

#include "engine/core/error.h"
#include "maps/building/building.h"
#include "radiosity/daylight/daylight.h"

typedef struct LightParts {
    int cells;       // of a part at most
    int parts, set;  // the number of parts, and which files of the folder these are
    double level;    // of the whole (light_level.h)
    Daylight day;
} LightParts;

bool light_parts_save(const char *path, const Building *building, const LightParts *parts, Error *error);
// Is it such a file? One that cannot be read is none.
bool light_parts_is(const char *path);
// Fails, with a message in `error`, where the file is damaged or of another building.
bool light_parts_load(const char *path, const Building *building, LightParts *out, Error *error);
// The day under which the light of a .rad file was made, be it in parts or not; all zeros: by night.
bool light_stored_day(const char *path, const Building *building, Daylight *out, Error *error);

#endif
