// foreign.h - models of 3DS and COLLADA, turned into Wavefront OBJ text by assimp.
#ifndef MAPS_FOREIGN_H
#define MAPS_FOREIGN_H

#include "engine/core/error.h"
#include "engine/core/file.h"

// The largest file, and the most text it may become, bytes.
#define FOREIGN_MAX_BYTES ((size_t)64 << 20)
#define FOREIGN_MAX_TEXT ((size_t)256 << 20)
// Converting one may take so much memory beyond what the program already has, and so much time of a processor.
#define FOREIGN_MAX_MEMORY ((size_t)1 << 30)  // bytes
#define FOREIGN_MAX_SECONDS 20

// Whether the file is of 3DS or COLLADA.
bool foreign_recognise(Bytes content);

// Whether an OBJ text means a library of materials by this name.
bool foreign_is_library(const char *name);

// Writes the model as OBJ, y up and in metres where the file states its unit, and its materials as the library that the OBJ refers to by
// some name ending in `.mtl`. Images are referred to as in the file. Nothing but `content` is read.
// assimp reads in a process of its own, which may open no files and has the limits above: a file that breaks it or takes too long costs
// one sentence.
bool foreign_as_obj(const char *path, Bytes content, Arena *arena, Bytes *obj, Bytes *library, Error *error);

#endif
