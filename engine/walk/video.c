// video.c - raw frames piped to ffmpeg, started without a shell. The pipe is a socket, whose write can be told not to
// raise SIGPIPE when ffmpeg dies.
#include "engine/walk/video.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

struct Video {
    const char *path, *temporary;
    int socket, log;  // ffmpeg's input; what it says, for the error message
    pid_t process;
    size_t frame_size;
};

static bool start(Video *video, int input, int width, int height, int frames_per_second, Arena *arena) {
    char *size = arena_format(arena, "%dx%d", width, height),
         *rate = arena_format(arena, "%d", frames_per_second);
    char *arguments[] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-f", "rawvideo",
                         "-pix_fmt", "rgb24", "-s", size, "-r", rate, "-i", "pipe:0", "-an",
                         // The codec's colours are stored two by two: odd sizes get a border.
                         "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast",
                         "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", "-y",
                         (char *)(uintptr_t)video->temporary, NULL};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, 0);
    posix_spawn_file_actions_adddup2(&actions, video->log, 1);
    posix_spawn_file_actions_adddup2(&actions, video->log, 2);
    int failure = posix_spawnp(&video->process, "ffmpeg", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    errno = failure;
    return failure == 0;
}

Video *video_begin(const char *path, int width, int height, int frames_per_second, Arena *arena,
                   Error *error) {
    Video *video = ARENA_ARRAY(arena, Video, 1);
    video->path = arena_string(arena, path);
    video->temporary = arena_format(arena, "%s.%ld.part", path, (long)getpid());
    video->frame_size = (size_t)width * (size_t)height * 3;
    int pair[2];
    video->log = memfd_create("ffmpeg", MFD_CLOEXEC);
    if (video->log < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) {
        error_set(error, "%s: no pipe to ffmpeg: %s", path, strerror(errno));
        if (video->log >= 0) close(video->log);
        return NULL;
    }
    bool started = start(video, pair[1], width, height, frames_per_second, arena);
    int failure = errno;
    close(pair[1]);
    video->socket = pair[0];
    if (started) return video;
    error_set(error, "%s: ffmpeg cannot be started: %s (the Debian package ffmpeg has it)", path,
              strerror(failure));
    close(pair[0]);
    close(video->log);
    return NULL;
}

// Closes all and waits; the last line ffmpeg said in `said`. Returns whether it ended well.
static bool finish(Video *video, char *said, size_t size) {
    close(video->socket);
    int status = 0;
    while (waitpid(video->process, &status, 0) < 0 && errno == EINTR) continue;
    char text[512];
    ssize_t length = pread(video->log, text, sizeof text - 1, 0);
    close(video->log);
    text[length > 0 ? length : 0] = 0;
    char *end = text + strlen(text);
    while (end > text && end[-1] == '\n') *--end = 0;
    char *line = strrchr(text, '\n');
    snprintf(said, size, "%s", line ? line + 1 : text);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool video_add(Video *video, const uint8_t *rgb, Error *error) {
    for (size_t sent = 0; sent < video->frame_size;) {
        ssize_t n = send(video->socket, rgb + sent, video->frame_size - sent, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        // Why, ffmpeg says at its end.
        if (n < 0)
            return error_set(error, "%s: ffmpeg takes no more frames: %s", video->path, strerror(errno));
        sent += (size_t)n;
    }
    return true;
}

bool video_end(Video *video, Error *error) {
    char said[512];
    if (!finish(video, said, sizeof said)) {
        unlink(video->temporary);
        return error_set(error, "%s: ffmpeg failed: %s", video->path, said[0] ? said : "it does not say why");
    }
    if (rename(video->temporary, video->path) == 0) return true;
    error_set(error, "%s: cannot be written: %s", video->path, strerror(errno));
    unlink(video->temporary);
    return false;
}

void video_abandon(Video *video) {
    if (!video) return;
    char said[512];
    finish(video, said, sizeof said);
    unlink(video->temporary);
}
