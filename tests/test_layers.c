// test_layers.c - the layers of the project: a file includes its own folder and those to the left, nothing else.
#include <criterion/criterion.h>
#include <dirent.h>
#include <stdio.h>
#include <sys/stat.h>

#include "tests/support.h"

static const char *const LAYERS[] = {
    "engine/core",     "maps",      "visibility",     "visibility/hidden", "visibility/pairs",
    "visibility/rays", "radiosity", "engine/library", "engine/walk",       "engine/stills",
    "engine/app",      "tests"};
enum { LAYER_COUNT = sizeof LAYERS / sizeof LAYERS[0] };

// The layer of a path below the top level: the longest folder that holds it, or -1.
static int layer_of(const char *path) {
    int best = -1;
    for (int i = 0; i < LAYER_COUNT; i++) {
        size_t length = strlen(LAYERS[i]);
        if (strncmp(path, LAYERS[i], length) != 0 || path[length] != '/') continue;
        if (best < 0 || length > strlen(LAYERS[best])) best = i;
    }
    return best;
}

// What is wrong with an include of `name` in quotes by `path`; NULL when nothing is.
static const char *fault_of(Arena *arena, const char *path, const char *name) {
    int from = layer_of(path), to = layer_of(name);
    if (from < 0) return arena_format(arena, "%s lies in no layer", path);
    if (to < 0) return arena_format(arena, "%s includes \"%s\", which names no layer", path, name);
    if (to > from) return arena_format(arena, "%s includes \"%s\" from a layer above it", path, name);
    return NULL;
}

// Names every wrong include in the text of a file; returns how many there are.
static int check_text(Arena *arena, const char *path, const char *text, const char **last) {
    int faults = 0;
    for (const char *line = text; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
        char name[256];
        if (sscanf(line, " # include \"%255[^\"\n]\"", name) != 1) continue;
        // stb's fonts and images come as headers in angle brackets; only ours stand in quotes.
        const char *fault = fault_of(arena, path, name);
        if (!fault) continue;
        faults++;
        *last = fault;
    }
    return faults;
}

static int check_folder(Arena *arena, const char *folder, int *files) {
    int faults = 0;
    DIR *directory = opendir(folder);
    if (!directory) return 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        char *path = arena_format(arena, "%s/%s", folder, entry->d_name);
        struct stat status;
        if (entry->d_name[0] == '.' || stat(path, &status) != 0) continue;
        const char *dot = strrchr(path, '.'), *fault = "";
        if (S_ISDIR(status.st_mode)) {
            faults += check_folder(arena, path, files);
        } else if (dot && (strcmp(dot, ".c") == 0 || strcmp(dot, ".h") == 0)) {
            ++*files;
            int found = check_text(arena, path, (const char *)support_read(arena, path).data, &fault);
            cr_expect_eq(found, 0, "%s", fault);
            faults += found;
        }
    }
    closedir(directory);
    return faults;
}

// No file of the project includes one of a layer above its own.
Test(layers, includes_go_down) {
    static const char *const TOPS[] = {"engine", "maps", "visibility", "radiosity", "tests"};
    Arena arena = {0};
    int files = 0;
    for (int i = 0; i < 5; i++) check_folder(&arena, TOPS[i], &files);
    cr_expect_gt(files, 20, "only %d files found: run from the top level", files);
    arena_free(&arena);
}

// The check itself: a wrong include is found, whatever its spacing, and right ones are not.
Test(layers, a_wrong_include_is_found) {
    static const struct {
        const char *path, *text;
        int faults;
    } CASES[] = {
        {"maps/plan.c", "#include \"maps/maps.h\"\n#include \"engine/core/vec.h\"\n#include <math.h>\n", 0},
        {"maps/plan.c", "#include <math.h>\n#include \"visibility/vis.h\"\n", 1},
        {"engine/core/vec.c", "  #  include \"maps/building.h\"\n#include \"engine/walk/view.h\"\n", 2},
        {"visibility/query.c", "#include \"visibility/hidden/hidden.h\"\n", 1},
        {"visibility/hidden/osmesa.c", "#include \"visibility/vis.h\"\n", 0},
        {"maps/plan.c", "#include \"plan_words.h\"\n", 1},
        {"engine/other.c", "#include \"engine/core/vec.h\"\n", 1},
        {"engine/app/main.c", "#include \"tests/support.h\"", 1}};
    for (int i = 0; i < (int)(sizeof CASES / sizeof CASES[0]); i++) {
        Arena arena = {0};
        const char *fault = "";
        int found = check_text(&arena, CASES[i].path, CASES[i].text, &fault);
        cr_expect_eq(found, CASES[i].faults, "case %d: %d faults, %s", i, found, fault);
        arena_free(&arena);
    }
}

// Whether `](path` in the text of a README leads to something in the project; what is outside, or an anchor, counts as right.
static void check_links(Arena *arena, const char *readme, const char *text) {
    const char *slash = strrchr(readme, '/');
    for (const char *at = text; (at = strstr(at, "]("));) {
        at += 2;
        int length = (int)strcspn(at, ")#\n");
        if (length == 0 || memchr(at, ':', (size_t)length)) continue;
        char *path =
            arena_format(arena, "%.*s%.*s", slash ? (int)(slash - readme + 1) : 0, readme, length, at);
        struct stat status;
        cr_expect(stat(path, &status) == 0, "%s leads to %.*s, which is not there", readme, length, at);
    }
}

// Proves that each folder has a README of its own, which names it and says what it may include, that the table of the project's README
// leads there, and that no README leads to what is not there.
Test(layers, each_folder_has_a_readme) {
    Arena arena = {0};
    const char *top = (const char *)support_read(&arena, "README.md").data;
    check_links(&arena, "README.md", top);
    check_links(&arena, "engine/LIMITS.md", (const char *)support_read(&arena, "engine/LIMITS.md").data);
    for (int i = 0; i < LAYER_COUNT; i++) {
        char *readme = arena_format(&arena, "%s/README.md", LAYERS[i]);
        const char *text = (const char *)support_read(&arena, readme).data;
        check_links(&arena, readme, text);
        cr_expect(strstr(top, arena_format(&arena, "| [`%s`](%s)", LAYERS[i], readme)),
                  "README.md does not lead to %s", readme);
        if (strcmp(LAYERS[i], "tests") == 0) continue;
        char *title = arena_format(&arena, "# %s: ", LAYERS[i]);
        cr_expect_eq(strncmp(text, title, strlen(title)), 0, "%s does not begin with `%s`", readme, title);
        cr_expect(strstr(text, "May include") || strstr(text, "may include") || strstr(text, "It includes") ||
                      strstr(text, "No code:"),
                  "%s does not say what it may include", readme);
        cr_expect(strstr(text, "tart reading"), "%s does not say where to start reading", readme);
    }
    arena_free(&arena);
}
