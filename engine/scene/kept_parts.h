// kept_parts.h - the light that a bake in parts has found so far, in a folder, so that a bake that was ended goes on from there.
//
// A set has a .rad file of each part, all of one moment, and a number that grows. It is whole where all of its files are there, since each
// file is written whole or not at all. A file that goes with that of a part has its name and more after it.
#ifndef SCENE_KEPT_PARTS_H
#define SCENE_KEPT_PARTS_H

#include "engine/core/arena.h"
#include "engine/core/error.h"

// The folder for the light that is going to be stored in `rad`.
const char *kept_folder(const char *rad, Arena *arena);
// The file of a part.
const char *kept_file(const char *folder, int set, int part, int parts, Arena *arena);

// The greatest number of any file there, 0: there is none.
int kept_last(const char *folder);
// The newest whole set of so many parts. Fails where there is none, and names the parts that there are.
bool kept_find(const char *folder, int parts, int *set, Error *error);

// Removes the files of all sets before `set`, but for one that is spared, 0: none, and the folder where it is empty then.
void kept_remove(const char *folder, int set, int spared);

#endif
