// plan.c - reads .plan, the line-based text format of maps/PLAN.md, into a sketch and a building.
//
// Each statement is one row of STATEMENTS and one function, here, in plan_statements.c or in plan_model.c; its optional words are a table
// inside it.
#include "engine/core/memory.h"
#include "maps/building/reader.h"
#include "maps/building/texture.h"
#include "maps/plan/plan_file.h"

static const char MARK[] = "\xEF\xBB\xBF";  // of UTF-8, with which some editors begin a file
static const char PLAIN[] = "plain";        // the material of things that name none
static const unsigned PLAIN_COLOUR = 0xC8C8C8;

// ---- statements

static bool read_header(Plan *plan) {
    int version;
    if (plan->begun) return plan_fail(&plan->line, "a second 'plan' (allowed: once, as the first statement)");
    plan->begun = true;
    return plan_whole(&plan->line, "the format's version", 1, 1, &version) && plan_end(&plan->line);
}

// ---- blocks

static bool read_model(Plan *plan) {
    static const ObjectKind KINDS[] = {OBJECT_FURNITURE, OBJECT_LAMP, OBJECT_STAIR, OBJECT_FRAME,
                                       OBJECT_LOW_WALL};
    PlanLine *line = &plan->line;
    const char *name;
    int kind = 0;
    PlanOption options[] = {
        {.word = "kind", .kind = PLAN_CHOICE, .out = &kind, .words = "furniture lamp stair frame low-wall"}};
    if (!plan_name(line, "the model's name", &name) || !plan_options(line, options, 1)) return false;
    int object = building_add_object(plan->arena, &plan->models, KINDS[kind], name);
    plan->block = BLOCK_MODEL;
    plan->block_line = line->number;
    return plan_declare(line, &plan->model_names, "model", name, object);
}

static bool read_end(Plan *plan) {
    const Building *b = plan->b, *shapes = &plan->models;
    int held = plan->block == BLOCK_TOUR ? b->tours[b->tour_count - 1].viewpoint_count
                                         : shapes->objects[shapes->object_count - 1].polygon_count;
    if (held == 0)
        return plan_fail(&plan->line, "the block of line %d is empty (allowed: at least one %s)",
                         plan->block_line, plan->block == BLOCK_TOUR ? "eye" : "shape with an area");
    if (plan->block == BLOCK_MODEL) {
        Building *models = &plan->models;
        plan_lay_on_polygons(plan, models, models->objects[models->object_count - 1].first_polygon, 0);
    }
    plan->block = BLOCK_NONE;
    return plan_end(&plan->line);
}

// ---- the file

typedef struct Statement {
    const char *word;
    int block;  // the block in which it stands
    bool needs_storey;
    bool (*read)(Plan *plan);  // one of these two
    bool (*read_shape)(PlanLine *line, Building *models);
} Statement;

static const Statement STATEMENTS[] = {{"plan", BLOCK_NONE, false, read_header, NULL},
                                       {"storey", BLOCK_NONE, false, plan_read_storey, NULL},
                                       {"material", BLOCK_NONE, false, plan_read_material, NULL},
                                       {"ground", BLOCK_NONE, false, plan_read_ground, NULL},
                                       {"facade", BLOCK_NONE, false, plan_read_facade, NULL},
                                       {"slabs", BLOCK_NONE, false, plan_read_slabs, NULL},
                                       {"room", BLOCK_NONE, true, plan_read_room, NULL},
                                       {"wall", BLOCK_NONE, true, plan_read_wall, NULL},
                                       {"door", BLOCK_NONE, true, plan_read_door, NULL},
                                       {"passage", BLOCK_NONE, true, plan_read_passage, NULL},
                                       {"window", BLOCK_NONE, true, plan_read_window, NULL},
                                       {"stairwell", BLOCK_NONE, true, plan_read_stairwell, NULL},
                                       {"stair", BLOCK_NONE, true, plan_read_stair, NULL},
                                       {"light", BLOCK_NONE, true, plan_read_light, NULL},
                                       {"inlay", BLOCK_NONE, true, plan_read_inlay, NULL},
                                       {"model", BLOCK_NONE, false, read_model, NULL},
                                       {"place", BLOCK_NONE, true, plan_read_place, NULL},
                                       {"view", BLOCK_NONE, true, plan_read_view, NULL},
                                       {"tour", BLOCK_NONE, true, plan_read_tour, NULL},
                                       {"start", BLOCK_NONE, true, plan_read_start, NULL},
                                       {"box", BLOCK_MODEL, false, NULL, plan_read_box},
                                       {"prism", BLOCK_MODEL, false, NULL, plan_read_prism},
                                       {"cylinder", BLOCK_MODEL, false, NULL, plan_read_cylinder},
                                       {"poly", BLOCK_MODEL, false, NULL, plan_read_poly},
                                       {"sphere", BLOCK_MODEL, false, NULL, plan_read_sphere},
                                       {"ellipsoid", BLOCK_MODEL, false, NULL, plan_read_ellipsoid},
                                       {"cone", BLOCK_MODEL, false, NULL, plan_read_cone},
                                       {"lathe", BLOCK_MODEL, false, NULL, plan_read_lathe},
                                       {"patch", BLOCK_MODEL, false, NULL, plan_read_patch},
                                       {"trim", BLOCK_MODEL, false, NULL, plan_read_trim},
                                       {"metaballs", BLOCK_MODEL, false, NULL, plan_read_metaballs},
                                       {"ball", BLOCK_MODEL, false, NULL, plan_read_ball},
                                       {"light", BLOCK_MODEL, false, NULL, plan_read_model_light},
                                       {"end", BLOCK_MODEL, false, read_end, NULL},
                                       {"eye", BLOCK_TOUR, true, plan_read_tour_eye, NULL},
                                       {"end", BLOCK_TOUR, false, read_end, NULL}};
enum { STATEMENT_COUNT = sizeof STATEMENTS / sizeof STATEMENTS[0] };

static bool unknown_statement(Plan *plan, const char *word) {
    static const char *const WHERE[] = {"", " in a model", " in a tour"};
    const char *list = "";
    for (int i = 0; i < STATEMENT_COUNT; i++)
        if (STATEMENTS[i].block == plan->block)
            list = arena_format(plan->arena, "%s%s%s", list, *list ? ", " : "", STATEMENTS[i].word);
    return plan_fail(&plan->line, "unknown statement '%.60s'%s (allowed: %s)", word, WHERE[plan->block],
                     list);
}

// Whether lines of this statement add to the shape of the lines above.
static bool adds_to_shape(const Statement *s) {
    return s->read_shape == plan_read_trim || s->read_shape == plan_read_ball;
}

static bool read_statement(Plan *plan) {
    PlanLine *line = &plan->line;
    if (line->count == 0) return true;
    const char *word = line->words[line->next++];
    if (!plan->begun && strcmp(word, "plan") != 0)
        return plan_fail(line, "the file begins with '%.60s' (allowed: plan 1)", word);
    for (int i = 0; i < STATEMENT_COUNT; i++) {
        const Statement *statement = &STATEMENTS[i];
        if (statement->block != plan->block || strcmp(statement->word, word) != 0) continue;
        if (statement->needs_storey && plan->storey < 0)
            return plan_fail(line, "'%s' stands before any storey (allowed: after one)", word);
        if (!adds_to_shape(statement) && !plan_close_shape(line, &plan->models)) return false;
        return statement->read ? statement->read(plan) : statement->read_shape(line, &plan->models);
    }
    return unknown_statement(plan, word);
}

// `scratch` holds the words of one line: statements copy what they keep of them.
static bool read_lines(Plan *plan, Bytes content, Arena *scratch) {
    const unsigned char *end = content.data + content.size;
    unsigned char *c = content.data;
    if (content.size >= strlen(MARK) && memcmp(c, MARK, strlen(MARK)) == 0) c += strlen(MARK);
    while (c < end) {
        plan->line.number++;
        unsigned char *newline = memchr(c, '\n', (size_t)(end - c)),
                      *stop = newline ? newline : c + (end - c);
        const unsigned char *zero = memchr(c, 0, (size_t)(stop - c));
        if (zero)
            return plan_fail(&plan->line, "a zero byte at column %d (allowed: text)", (int)(zero - c) + 1);
        size_t length = (size_t)(stop - c);
        if (length > 0 && c[length - 1] == '\r') length--;
        arena_reset(scratch);
        char *text = arena_alloc(scratch, length + 1, 1);
        memcpy(text, c, length);
        if (!plan_split(&plan->line, text) || !read_statement(plan)) return false;
        c = stop + 1;
        if (!newline) break;
    }
    if (plan->block != BLOCK_NONE)
        return plan_fail(&plan->line, "the file ends inside the block of line %d (allowed: after its 'end')",
                         plan->block_line);
    if (!plan->begun)
        return plan_fail(&plan->line, "the file holds nothing (allowed: plan 1 and at least one room)");
    if (plan->sketch.room_count == 0)
        return plan_fail(&plan->line, "no room in the file (allowed: at least one)");
    return true;
}

static bool read_plan(const char *path, Bytes content, Arena *arena, Building *out, Error *error) {
    Plan *plan = ARENA_ARRAY(arena, Plan, 1);
    plan->line = (PlanLine){.path = path, .materials = &plan->materials, .arena = arena, .error = error};
    plan->arena = arena;
    plan->b = out;
    plan->models.file_size = out->file_size;
    plan->storey = -1;
    plan->beside = (SoupReader){.path = path, .arena = arena, .b = out};
    plan->pixels = TEXTURE_FREE_PIXELS;
    Material plain = {.name = PLAIN, .reflectance = maps_colour(PLAIN_COLOUR), .alpha = 1};
    int index = building_add_material(arena, out, plain);
    if (!plan_declare(&plan->line, &plan->materials, "material", PLAIN, index)) return false;
    Arena scratch = {0};
    bool good = read_lines(plan, content, &scratch);
    arena_free(&scratch);
    if (!good) return false;
    plan_note_ramps(plan);
    if (!plan_fit_openings(plan)) return false;
    Error why = {""};
    if (!maps_enclose(&plan->sketch, out, arena, &why))
        return memory_within(error) && error_set(error, "%s: %.900s", path, why.text);
    plan_lay_textures(plan);
    // Nobody reads them any more, and of a campus they are many.
    arena_release(arena, plan->sketch.openings);
    plan->sketch.openings = NULL;
    out->hash = plan->beside.hash;
    return plan_set_start(plan);
}

// A .plan file's first statement is `plan` and a version.
static bool recognise_plan(Bytes content) {
    const char *c = (const char *)content.data;
    if (strncmp(c, MARK, strlen(MARK)) == 0) c += strlen(MARK);
    while (*c == '#' || strchr(" \t\r\n", *c)) {
        if (!*c) return false;
        c += *c == '#' ? strcspn(c, "\n") : 1;
    }
    return strncmp(c, "plan ", 5) == 0;
}

const MapsReader MAPS_READER_PLAN = {
    .name = "plan",
    .suffixes = ".plan",
    .summary = "Enfilade's own text format (maps/PLAN.md)",
    .recognise = recognise_plan,
    .read = read_plan,
};
