// film_light.h - the light of frames that are drawn without a window: it follows the doors, and the hour, from frame to frame.
#ifndef FILM_LIGHT_H
#define FILM_LIGHT_H

#include "engine/draw/walk_renderer.h"
#include "engine/lit/lit_parts.h"
#include "engine/scene/light.h"

// The light of a walk, which outlives it.
typedef struct FilmLightSource {
    const WalkLight *light;
    // Or it is stored in parts, and each frame has that of the part about its eye, which does not follow; NULL: it is not.
    const LightOfParts *parts;
    // Bakes light that follows the doors, where `light` does not and the doors of a frame stand elsewhere; NULL: then it stays as it is.
    const LightBaker *anew;
    const Rgb *lit;  // [count of the lamps] the state that is shown
    Arena *room;     // [2] of light of other hours, which must outlive `light`
} FilmLightSource;

// Bakes light that follows the doors (light_end), or, where there is not enough memory for that, light that does not. It lives in `room`,
// which is empty. False where that fails, or progress asks to stop.
bool film_light_bake(const LightBaker *baker, const Progress *progress, Arena *room, WalkLight *out,
                     Error *error);

typedef struct FilmLight FilmLight;

// Uploads the light, for WALK_BAKED; NULL and an error where that fails. Lives in the arena, but for what film_light_end frees once the
// renderer is gone.
FilmLight *film_light_new(const FilmLightSource *source, WalkRenderer *renderer, Arena *arena, Error *error);
void film_light_end(FilmLight *light);  // NULL is allowed

// Where light is in parts: shows that of all that is seen from a cell (-1: none, then the light stays). Fails where it cannot be read.
bool film_light_come(FilmLight *light, int cell, Error *error);
// Is there light on all that is seen from the cell?
bool film_light_covers(const FilmLight *light, int cell);

// Shows the light with the doors `door_open` [opening_count]. While a door moves its light follows in steps of a tenth of its way; a door
// that has not moved since the frame before has its own. `day`: the light is that of this day, which shines; NULL: of the day that it has.
// Fails where progress asks to stop, the light cannot be baked, or a day is asked for of light that was found by night or does not follow.
bool film_light_follow(FilmLight *light, const float *door_open, const Daylight *day,
                       const Progress *progress, Error *error);
// Have doors stood elsewhere than their light has them, and nobody could find theirs?
bool film_light_stayed(const FilmLight *light);
LitPartsCount film_light_parts(const FilmLight *light);  // zeros where light is not in parts; NULL is allowed

#endif
