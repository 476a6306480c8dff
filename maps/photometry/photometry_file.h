// photometry_file.h - photometric files, and which lamps of a building they are for.
#ifndef MAPS_PHOTOMETRY_FILE_H
#define MAPS_PHOTOMETRY_FILE_H

#include "engine/core/file.h"
#include "maps/building/building.h"
#include "maps/building/scan.h"

// The most bytes of a file, angles of each kind, and intensity of a direction, cd.
enum { PHOTOMETRY_MAX_BYTES = 4 << 20, PHOTOMETRY_MAX_ANGLES = 1441 };
#define PHOTOMETRY_MAX_CANDELA 1e9

// Reads an IES file (LM-63) or a EULUMDAT file (.ldt): `TILT=` at the beginning of a line tells the first. The table and its name lie
// in the arena.
bool photometry_read(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error);

// Gives lamps the files that their own statements name, in the folder of the building's file `path` or below, and all other lamps
// the file NAME.ies or NAME.ldt beside it, if there is one for the lamp's name. A file that a statement names must be sound; another
// one that is not is passed over with a note. The files count into the building's hash.
bool photometry_of_lamps(const char *path, Arena *arena, Building *building, Error *error);

// `NAME=FILE`: gives all lamps of that name the file, in place of what they had. A lamp is a light, or an object that glows.
bool photometry_for_name(const char *name_and_file, Arena *arena, Building *building, Error *error);

// ---- shared by the readers

// How the planes that a file lists stand for all planes.
typedef enum PhotometryAround {
    PHOTOMETRY_ROUND,    // one plane is all
    PHOTOMETRY_WHOLE,    // all are listed, from C0 on
    PHOTOMETRY_HALF,     // C0 to C180; the other half is the mirror image
    PHOTOMETRY_SIDE,     // from C90 by C180 to C270, or from C270 by C0 to C90 with angles from -90; mirrored
    PHOTOMETRY_QUARTER,  // C0 to C90; mirrored twice
} PhotometryAround;

// A table as a file has it: planes as listed, in `table`.
bool photometry_finish(const char *path, PhotometryAround around, Arena *arena, Photometry *table,
                       Error *error);

bool photometry_read_ies(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error);
bool photometry_read_ldt(const char *path, Bytes content, Arena *arena, Photometry *out, Error *error);

// A number of the file at the scan, or a sentence; `what` names it.
bool photometry_number(Scan *scan, const char *what, double low, double high, double *out, Error *error);
bool photometry_whole(Scan *scan, const char *what, int low, int high, int *out, Error *error);

#endif
