// video.h - writes frames to an MP4 file, through the program ffmpeg.
#ifndef WALK_VIDEO_H
#define WALK_VIDEO_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"

typedef struct Video Video;

// The film shows `frames` frames in `seconds` seconds.
// The file appears when video_end has completed it: an earlier file of the name survives any failure.
Video *video_begin(const char *path, int width, int height, int frames, int seconds, Arena *arena,
                   Error *error);
bool video_add(Video *video, const uint8_t *rgb,
               Error *error);  // [height * width * 3] sRGB, rows from the top
bool video_end(Video *video, Error *error);
void video_abandon(Video *video);  // after a failure elsewhere; NULL is allowed

#endif
