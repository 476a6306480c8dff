// video.c - raw frames piped to ffmpeg, which is started without a shell. The pipe is a socket, because a write to a socket can be told
// not to raise SIGPIPE when ffmpeg dies. ffmpeg writes to a draft that it inherits open: it opens no name, which others could have made a
// link, and a draft without a name vanishes with the last of both programs.
#include "engine/walk/video.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/memory.h"

extern char **environ;

struct Video {
    const char *path;
    FileDraft draft;
    int socket, log;  // ffmpeg's input; ffmpeg's messages
    pid_t process;
    size_t frame_size;
    MemoryEnd end;
    bool ended;      // all is closed, `said` is set
    char said[512];  // the last line of the log
};

// The descriptor of the draft in ffmpeg. It is opened as a file, since ffmpeg seeks in its output and reads it again only in files.
enum { DRAFT = 3 };
#define DRAFT_PATH "/proc/self/fd/3"

// Called when the walk ends for lack of memory: leaves no film rather than half of one.
static void undo(void *context) {
    const Video *video = context;
    if (video->process > 0) kill(video->process, SIGKILL);
    if (*video->draft.beside) unlink(video->draft.beside);
}

static bool start_ffmpeg(Video *video, int input, int width, int height, int frames, int seconds,
                         Arena *arena) {
    char *size = arena_format(arena, "%dx%d", width, height),
         *rate = arena_format(arena, "%d/%d", frames, seconds);
    // Without /proc the draft has a name, which file_begin gave it.
    bool inherits = access("/proc/self/fd", F_OK) == 0;
    char *out = arena_format(arena, "file:%s", inherits ? DRAFT_PATH : video->draft.beside);
    char *arguments[] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-f", "rawvideo",
                         "-pix_fmt", "rgb24", "-s", size, "-r", rate, "-i", "pipe:0", "-an",
                         // The codec stores colours for two by two pixels: odd sizes get a border.
                         "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast",
                         "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", "-y",
                         out, NULL};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, 0);
    posix_spawn_file_actions_adddup2(&actions, video->log, 1);
    posix_spawn_file_actions_adddup2(&actions, video->log, 2);
    posix_spawn_file_actions_adddup2(&actions, video->draft.fd, DRAFT);
    int failure = posix_spawnp(&video->process, "ffmpeg", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    errno = failure;
    return failure == 0;
}

Video *video_begin(const char *path, int width, int height, int frames, int seconds, Arena *arena,
                   Error *error) {
    Video *video = ARENA_ARRAY(arena, Video, 1);
    video->path = arena_string(arena, path);
    video->frame_size = (size_t)width * (size_t)height * 3;
    if (!file_begin(video->path, &video->draft, error)) return NULL;
    int pair[2];
    video->log = memfd_create("ffmpeg", MFD_CLOEXEC);
    if (video->log < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) {
        error_set(error, "%s: no pipe to ffmpeg: %s", path, strerror(errno));
        if (video->log >= 0) close(video->log);
        file_drop(&video->draft);
        return NULL;
    }
    memory_hold_end();
    bool started = start_ffmpeg(video, pair[1], width, height, frames, seconds, arena);
    int failure = errno;
    video->end = (MemoryEnd){.undo = undo, .context = video};
    if (started) memory_add_end(&video->end);
    memory_release_end();
    close(pair[1]);
    video->socket = pair[0];
    if (started) return video;
    error_set(error, "%s: ffmpeg cannot be started: %s (the Debian package ffmpeg has it)", path,
              strerror(failure));
    close(pair[0]);
    close(video->log);
    file_drop(&video->draft);
    return NULL;
}

// Closes everything and waits for ffmpeg. Returns whether ffmpeg ended well; false if it had been waited for before.
static bool finish(Video *video) {
    if (video->ended) return false;
    video->ended = true;
    close(video->socket);
    int status = 0;
    siginfo_t ended;
    while (waitid(P_PID, (id_t)video->process, &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) continue;
    memory_hold_end();  // from here on the number may be that of another process
    while (waitpid(video->process, &status, 0) < 0 && errno == EINTR) continue;
    video->process = 0;
    memory_release_end();
    char text[sizeof video->said];
    off_t told = lseek(video->log, 0, SEEK_END), room = sizeof text - 1;
    ssize_t length = pread(video->log, text, sizeof text - 1, told > room ? told - room : 0);
    close(video->log);
    text[length > 0 ? length : 0] = 0;
    char *end = text + strlen(text);
    while (end > text && end[-1] == '\n') *--end = 0;
    char *line = strrchr(text, '\n');
    snprintf(video->said, sizeof video->said, "%s", line ? line + 1 : text);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool video_add(Video *video, const uint8_t *rgb, Error *error) {
    for (size_t sent = 0; sent < video->frame_size;) {
        ssize_t n = send(video->socket, rgb + sent, video->frame_size - sent, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            int reason = errno;
            finish(video);
            return error_set(error, "%s: ffmpeg takes no more frames: %s", video->path,
                             video->said[0] ? video->said : strerror(reason));
        }
        sent += (size_t)n;
    }
    return true;
}

bool video_end(Video *video, Error *error) {
    bool good = finish(video);
    memory_remove_end(&video->end);
    if (good) return file_keep(&video->draft, error);
    file_drop(&video->draft);
    return error_set(error, "%s: ffmpeg failed: %s", video->path,
                     video->said[0] ? video->said : "it does not say why");
}

void video_abandon(Video *video) {
    if (!video) return;
    finish(video);
    memory_remove_end(&video->end);
    file_drop(&video->draft);
}
