// test_kills.c - the program killed while it writes, before or after any system call that may change a file: the file is the earlier
// one or the new one, whole, and the next run leaves nothing beside it. Each kind of file that it writes; walks, which need a window,
// are in test_session.c. 1,000 kills each at soak.
#include <criterion/criterion.h>
#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "tests/support/support.h"

typedef struct Killing {
    Arena arena;
    const char *folder, *home, *cache;  // of the file; of all; where the cache is
    const char *command;
} Killing;

enum { MOST_WORDS = 32 };

// As a program does after `exec`, with the words of the command.
static void become(void *context) {
    const Killing *k = context;
    char *words[MOST_WORDS + 1] = {0};
    int count = 0;
    for (char *word = strtok(arena_string(&(Arena){0}, k->command), " "); word; word = strtok(NULL, " ")) {
        cr_assert_lt(count, MOST_WORDS);
        words[count++] = word;
    }
    setenv("XDG_CACHE_HOME", k->cache, 1);
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // it cannot tell them while it is traced
    int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (int fd = 0; fd < 3; fd++) dup2(null, fd);
    execv(words[0], words);
    _exit(127);
}

static const char *command_of(Killing *k, const char *pattern) {
    char *text = arena_format(&k->arena, "%s/enfilade ", support_build());
    for (const char *out; (out = strstr(pattern, "OUT")); pattern = out + 3)
        text = arena_format(&k->arena, "%s%.*s%s", text, (int)(out - pattern), pattern, k->home);
    return arena_format(&k->arena, "%s%s", text, pattern);
}

static void run(Killing *k, const char *command) {
    char *output;
    int code = support_run(&k->arena, &output, "XDG_CACHE_HOME=%s %s </dev/null", k->cache, command);
    cr_assert_eq(code, 0, "%s: %s", command, output);
}

// The file whose name ends so, or NULL; `others`: how many there are under names that a file has on its way.
static const char *find_file(Killing *k, const char *suffix, int *others) {
    DIR *dir = opendir(k->folder);
    const char *found = NULL;
    *others = 0;
    cr_assert(dir);
    for (const struct dirent *entry; (entry = readdir(dir));) {
        size_t length = strlen(entry->d_name), end = strlen(suffix);
        if (length > end && strcmp(entry->d_name + length - end, suffix) == 0 && !found)
            found = arena_format(&k->arena, "%s/%s", k->folder, entry->d_name);
        else
            *others += strstr(entry->d_name, ".enfilade-") != NULL;
    }
    closedir(dir);
    return found;
}

static int lines_of(Bytes text) {
    int lines = 0;
    for (size_t i = 0; i < text.size; i++) lines += text.data[i] == '\n';
    return lines;
}

static bool same(Bytes a, Bytes b, bool measures) {
    if (measures && a.size > 0 && a.data[a.size - 1] == '\n') return lines_of(a) == lines_of(b);
    return a.size == b.size && memcmp(a.data, b.data, a.size) == 0;
}

// `file`: folder, below the test's own, and ending of the name, with a star between. `earlier`, `later`: what writes it, OUT: the
// test's folder. Times differ from run to run: of a .csv file lines are counted.
static void check(const char *file, const char *earlier_words, const char *later_words) {
    const char *suffix = strchr(file, '*') + 1;
    bool measures = strcmp(suffix, ".csv") == 0;
    Killing k = {.arena = {0}};
    Error error;
    int others, kills = 0, new = 0, left = 0, wanted = support_count(2, 1000);
    k.home = support_folder(&k.arena);
    k.folder = arena_format(&k.arena, "%s/%.*s", k.home, (int)(suffix - file - 2), file);
    k.cache = arena_format(&k.arena, "%s/cache", k.home);
    cr_assert(file_make_folder(k.folder, &error), "%s", error.text);
    const char *earlier_command = command_of(&k, earlier_words), *later_command = command_of(&k, later_words);
    run(&k, earlier_command);
    const char *path = find_file(&k, suffix, &others);
    cr_assert(path, "%s: no file", file);
    Bytes earlier = support_read(&k.arena, path);
    run(&k, later_command);
    Bytes later = support_read(&k.arena, path);
    cr_assert(!same(earlier, later, measures), "%s: both are the same: nothing would show", file);
    k.command = later_command;
    int moments = support_kill(-1, become, &k);
    cr_assert_gt(moments, 8, "%s has %d moments", file, moments);
    for (int i = 0; i < wanted; i++) {
        Arena kept = k.arena;
        k.arena = (Arena){0};
        cr_assert(file_write(path, earlier.data, earlier.size, &error), "%s", error.text);
        // Few kills are near the end, where a file gets its name; many are at every moment.
        int moment = wanted < moments ? moments - 1 - (5 * i + 1) % 16 : i % moments;
        kills += support_kill(moment, become, &k) < 0;
        Bytes now = support_read(&k.arena, path);
        bool is_new = same(now, later, measures);
        cr_assert(is_new || same(now, earlier, false), "%s: killed at %d of %d: a broken file", file, moment,
                  moments);
        new += is_new;
        find_file(&k, suffix, &others);
        left += others > 0;
        if (others > 0 || i % 50 == 0) {
            run(&k, later_command);
            cr_assert(same(support_read(&k.arena, path), later, measures),
                      "%s: killed at %d: the next run fails", file, moment);
            find_file(&k, suffix, &others);
            cr_assert_eq(others, 0, "%s: killed at %d: the next run leaves what was left", file, moment);
        }
        arena_free(&k.arena);
        k.arena = kept;
    }
    if (support_soak())
        fprintf(stderr, "kills: %s: %d of %d at %d moments: %d new, %d left something, which went\n", file,
                kills, wanted, moments, new, left);
    arena_free(&k.arena);
}

#define TWO "build/maps/two-rooms.plan"
#define ROUGH " --element 1 --close 0 --reach 0 --refine 0 --resolution 50 --threads 1"

// Each proves what stands at the head of this file, of one kind of file.
Test(kills, trees, .timeout = 7200) {
    check("out/*.vis", "vis " TWO " -o OUT/out/a.vis --max-nodes 1", "vis " TWO " -o OUT/out/a.vis");
}

Test(kills, trees_in_the_cache, .timeout = 7200) {
    check("cache/enfilade/*.vis", "vis " TWO " --max-nodes 1", "vis " TWO);
}

Test(kills, pairs, .timeout = 7200) {
    check("out/*.seen", "vis maps/buildings/house.plan --pairs-method flood --pairs OUT/out/a.seen",
          "vis " TWO " --pairs OUT/out/a.seen");
}

Test(kills, light, .timeout = 7200) {
    check("out/*.rad", "bake " TWO ROUGH " --shots 10 -o OUT/out/a.rad",
          "bake " TWO ROUGH " --shots 20 -o OUT/out/a.rad");
}

Test(kills, light_in_the_cache, .timeout = 7200) {
    check("cache/enfilade/*.rad", "bake " TWO ROUGH " --shots 10", "bake " TWO ROUGH " --shots 20");
}

Test(kills, models, .timeout = 7200) {
    check("out/*.glb", "bake " TWO ROUGH " --shots 10 -o OUT/out/a.glb",
          "bake " TWO ROUGH " --shots 20 -o OUT/out/a.glb");
}

Test(kills, drawings, .timeout = 7200) {
    check("out/*.svg", "plan " TWO " -o OUT/out/a.svg", "plan " TWO " -o OUT/out/a.svg --from 1,1,1.5");
}

Test(kills, stills, .timeout = 7200) {
    check("out/*.png", "render " TWO " --direct baked --size 16x16 --samples 1 -o OUT/out/a.png",
          "render " TWO " --direct baked --size 20x16 --samples 1 -o OUT/out/a.png");
}

Test(kills, frames, .timeout = 7200) {
    check("frames/*.png", "walk " TWO " --tour window --size 32x18 --offscreen OUT/frames",
          "walk " TWO " --tour window --size 48x27 --offscreen OUT/frames");
}

Test(kills, statistics, .timeout = 7200) {
    check("out/*.csv",
          "walk " TWO " --step 10 --turn 60 --size 32x18 --offscreen OUT/frames --stats OUT/out/a.csv",
          "walk " TWO " --tour window --size 32x18 --offscreen OUT/frames --stats OUT/out/a.csv");
}

Test(kills, videos, .timeout = 7200) {
    char *output;
    Arena arena = {0};
    if (support_run(&arena, &output, "command -v ffmpeg >/dev/null") != 0) cr_skip_test("ffmpeg is not here");
    check("out/*.mp4", "walk " TWO " --tour window --size 32x18 --offscreen OUT/frames --video OUT/out/a.mp4",
          "walk " TWO " --tour window --size 48x28 --offscreen OUT/frames --video OUT/out/a.mp4");
}
