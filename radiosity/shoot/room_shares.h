// room_shares.h - how much of its light each room still lacks. What is left is measured against all light of a building, and a room that
// gets a ten-thousandth of it would be left with half of its own light unshot.
#ifndef RADIOSITY_ROOM_SHARES_H
#define RADIOSITY_ROOM_SHARES_H

#include "radiosity/shoot/shoot.h"

// The regions of a building, the outdoors without patches. In a building without regions, all cells indoors are one room.
typedef struct RoomShares {
    int room_count;
    int *of;               // [patch_count] the room of a patch, or -1
    int *first, *patches;  // the patches of room r are patches[first[r]] .. patches[first[r + 1] - 1]
    double *left, *light;  // [room_count] unshot power, and the power that leaves its surfaces, W
    double least;          // rooms with less light than this are dark, W
} RoomShares;

RoomShares room_shares_new(const Mesh *mesh, Arena *arena);
// From the solution alone; `emitted`: in all, W. Faces that others own do not count.
void room_shares_measure(RoomShares *shares, const Mesh *mesh, const RadSolution *solution, double emitted);
// Is more than this share of the room's light unshot?
static inline bool room_shares_lacks(const RoomShares *shares, int room, double residual) {
    double light = shares->light[room];
    return light > shares->least && shares->left[room] > residual * light;
}
// The first room that lacks more than this share; -1: none.
int room_shares_first(const RoomShares *shares, double residual);

#endif
