// test_layers.c - the layers of the project: a file includes its own folder and those that the folder's README says it may,
// all of which come before it in the Makefile's `layers`. So order and leave are each said once, where people read them.
#include <criterion/criterion.h>
#include <dirent.h>
#include <stdio.h>
#include <sys/stat.h>

#include "tests/support/support.h"

enum { MOST_LAYERS = 64 };

typedef struct Layers {
    const char *name[MOST_LAYERS];
    bool may[MOST_LAYERS][MOST_LAYERS];  // [from][to]
    int count;
} Layers;

// The layer of a file: its folder, or -1. The program that generates samples counts as `maps`; all folders of tests are one layer.
static int layer_of(const Layers *layers, const char *path) {
    static const char SAMPLES[] = "maps/buildings/", TESTS[] = "tests/";
    if (strncmp(path, SAMPLES, sizeof SAMPLES - 1) == 0) path = "maps/";
    if (strncmp(path, TESTS, sizeof TESTS - 1) == 0) path = TESTS;
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) : 0;
    for (int i = 0; i < layers->count; i++)
        if (strlen(layers->name[i]) == length && strncmp(path, layers->name[i], length) == 0) return i;
    return -1;
}

// Reads `May include ...` of a README, up to the end of the sentence: folders in backquotes, or everything.
static void read_leave(Arena *arena, Layers *layers, int from) {
    static const char WORDS[] = "May include ", ALL[] = "everything";
    const char *readme = arena_format(arena, "%s/README.md", layers->name[from]);
    const char *at = strstr((const char *)support_read(arena, readme).data, WORDS);
    layers->may[from][from] = true;
    cr_assert(at, "%s does not say what it may include", readme);
    at += sizeof WORDS - 1;
    bool all = strncmp(at, ALL, sizeof ALL - 1) == 0;
    for (int to = 0; to < from && all; to++) layers->may[from][to] = true;
    const char *end = at + strcspn(at, ".");
    while ((at = memchr(at, '`', (size_t)(end - at)))) {
        int length = (int)strcspn(++at, "`");
        int to = layer_of(layers, arena_format(arena, "%.*s/", length, at));
        cr_expect(to >= 0 && to < from, "%s may include %.*s, which is no layer before it", readme, length,
                  at);
        if (to >= 0) layers->may[from][to] = true;
        at += length + 1;
    }
}

static Layers read_layers(Arena *arena) {
    Layers layers = {0};
    char *at = strstr((char *)support_read(arena, "Makefile").data, "\nlayers := ");
    cr_assert(at, "the Makefile names no layers");
    at += strlen("\nlayers := ");
    for (char *rest = at; *rest; rest++) {
        if (rest[0] == '\\' && rest[1] == '\n') rest[0] = rest[1] = ' ';
        if (rest[0] == '\n') rest[0] = rest[1] = 0;
    }
    for (char *word = strtok(at, " "); word; word = strtok(NULL, " ")) {
        cr_assert_lt(layers.count, MOST_LAYERS - 1);
        layers.name[layers.count++] = word;
    }
    layers.name[layers.count++] = "tests";
    for (int i = 0; i < layers.count; i++) read_leave(arena, &layers, i);
    return layers;
}

// The fault of an include of `name` in quotes by `path`; NULL when nothing is.
static const char *fault_of(Arena *arena, const Layers *layers, const char *path, const char *name) {
    int from = layer_of(layers, path), to = layer_of(layers, name);
    if (from < 0) return arena_format(arena, "%s lies in no layer", path);
    if (to < 0) return arena_format(arena, "%s includes \"%s\", which names no layer", path, name);
    if (!layers->may[from][to])
        return arena_format(arena, "%s includes \"%s\", which its README does not allow", path, name);
    return NULL;
}

// Names every wrong include in the text of a file; returns how many there are. What stands in angle brackets is another
// project's, unless it begins as a layer does.
static int check_text(Arena *arena, const Layers *layers, const char *path, const char *text,
                      const char **last) {
    int faults = 0;
    for (const char *line = text; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
        char bracket, name[256];
        if (sscanf(line, " # include %c%255[^\">\n]", &bracket, name) != 2) continue;
        if (bracket == '<' && layer_of(layers, name) < 0) continue;
        const char *fault = bracket == '<'
                                ? arena_format(arena, "%s includes <%s> in angle brackets", path, name)
                                : fault_of(arena, layers, path, name);
        if (!fault) continue;
        faults++;
        *last = fault;
    }
    return faults;
}

static bool is_source(const char *name) {
    const char *dot = strrchr(name, '.');
    return dot && (strcmp(dot, ".c") == 0 || strcmp(dot, ".h") == 0 || strcmp(dot, ".cpp") == 0);
}

// All below a folder, but what is built and what is hidden.
static void check_folder(Arena *arena, const Layers *layers, const char *folder, int *files) {
    DIR *directory = opendir(folder);
    if (!directory) return;
    for (struct dirent *entry; (entry = readdir(directory));) {
        const char *name = entry->d_name, *fault = "";
        char *path = strcmp(folder, ".") == 0 ? arena_format(arena, "%s", name)
                                              : arena_format(arena, "%s/%s", folder, name);
        struct stat status;
        if (name[0] == '.' || strcmp(path, "build") == 0 || stat(path, &status) != 0) continue;
        if (S_ISDIR(status.st_mode)) check_folder(arena, layers, path, files);
        if (!S_ISREG(status.st_mode) || !is_source(name)) continue;
        ++*files;
        cr_expect(layer_of(layers, path) >= 0, "%s lies in no layer", path);
        int found = check_text(arena, layers, path, (const char *)support_read(arena, path).data, &fault);
        cr_expect_eq(found, 0, "%s", fault);
    }
    closedir(directory);
}

// No file of the project, in whatever folder, includes what its own may not.
Test(layers, includes_go_down) {
    Arena arena = {0};
    Layers layers = read_layers(&arena);
    int files = 0;
    check_folder(&arena, &layers, ".", &files);
    cr_expect_gt(files, 20, "only %d files found: run from the top level", files);
    arena_free(&arena);
}

// The check itself: a wrong include is found, whatever its spacing, and right ones are not.
Test(layers, a_wrong_include_is_found) {
    static const struct {
        const char *path, *text;
        int faults;
    } CASES[] = {{"maps/plan/plan.c",
                  "#include \"maps/building/reader.h\"\n#include \"engine/core/vec.h\"\n#include <math.h>\n",
                  0},
                 {"maps/plan/plan.c", "#include \"maps/maps.h\"\n", 1},
                 {"maps/plan/plan.c", "#include <math.h>\n#include \"visibility/vis.h\"\n", 1},
                 {"maps/buildings/generate.c", "#include \"engine/core/random.h\"\n", 0},
                 {"engine/core/vec.c",
                  "  #  include \"maps/building/building.h\"\n#include \"engine/draw/view.h\"\n", 2},
                 {"visibility/query/query.c", "#include \"visibility/hidden/hidden.h\"\n", 1},
                 {"visibility/rays/ray_grid.c", "#include \"visibility/vis.h\"\n", 1},
                 {"visibility/pairs/flow.c", "#include \"visibility/vis.h\"\n", 0},
                 {"visibility/new/flow.c", "#include \"visibility/vis.h\"\n", 1},
                 {"maps/plan/plan.c", "#include \"plan_words.h\"\n", 1},
                 {"maps/plan/plan.c", "#include <visibility/vis.h>\n", 1},
                 {"engine/other.c", "#include \"engine/core/vec.h\"\n", 1},
                 {"engine/app/main.c", "#include \"tests/support/support.h\"", 1}};
    Arena arena = {0};
    Layers layers = read_layers(&arena);
    for (int i = 0; i < (int)(sizeof CASES / sizeof CASES[0]); i++) {
        const char *fault = "";
        int found = check_text(&arena, &layers, CASES[i].path, CASES[i].text, &fault);
        cr_expect_eq(found, CASES[i].faults, "case %d: %d faults, %s", i, found, fault);
    }
    arena_free(&arena);
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

// Whether the README of the folder above leads to the layer's.
static bool is_linked(Arena *arena, const char *layer) {
    const char *slash = strchr(layer, '/');
    const char *above =
        slash ? arena_format(arena, "%.*s/README.md", (int)(slash - layer), layer) : "README.md";
    const char *text = (const char *)support_read(arena, above).data;
    return strstr(text, arena_format(arena, "](%s/README.md)", slash ? slash + 1 : layer)) != NULL;
}

// Proves that each folder has a README of its own, which names it (the folders that it may include are read above), that the README above
// leads there, and that no README leads to a file that is not there.
Test(layers, each_folder_has_a_readme) {
    Arena arena = {0};
    Layers layers = read_layers(&arena);
    const char *top = (const char *)support_read(&arena, "README.md").data;
    check_links(&arena, "README.md", top);
    check_links(&arena, "engine/LIMITS.md", (const char *)support_read(&arena, "engine/LIMITS.md").data);
    for (int i = 0; i < layers.count; i++) {
        char *readme = arena_format(&arena, "%s/README.md", layers.name[i]);
        const char *text = (const char *)support_read(&arena, readme).data;
        check_links(&arena, readme, text);
        cr_expect(is_linked(&arena, layers.name[i]), "the README above does not lead to %s", readme);
        if (strcmp(layers.name[i], "tests") == 0) continue;
        char *title = arena_format(&arena, "# %s: ", layers.name[i]);
        cr_expect_eq(strncmp(text, title, strlen(title)), 0, "%s does not begin with `%s`", readme, title);
        cr_expect(strstr(text, "tart reading"), "%s does not say where to start reading", readme);
    }
    arena_free(&arena);
}
