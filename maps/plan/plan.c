// plan.c - reads .plan, the line-based text format of maps/README.md, into a sketch and a building.
//
// Each statement is one row of STATEMENTS and one function, here, in plan_statements.c or in plan_model.c; its optional words are a table
// inside it.
#include "maps/building/reader.h"
#include "maps/plan/plan_file.h"

static const char MARK[] = "\xEF\xBB\xBF";  // of UTF-8, with which some editors begin a file
static const char PLAIN[] = "plain";        // the material of what names none
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
    int object = building_add_object(plan->arena, &plan->models.shapes, KINDS[kind], name);
    plan->block = BLOCK_MODEL;
    plan->block_line = line->number;
    return plan_declare(line, &plan->models.names, "model", name, object);
}

static bool read_box(Plan *plan) { return plan_read_box(&plan->line, &plan->models); }
static bool read_prism(Plan *plan) { return plan_read_prism(&plan->line, &plan->models); }
static bool read_cylinder(Plan *plan) { return plan_read_cylinder(&plan->line, &plan->models); }
static bool read_poly(Plan *plan) { return plan_read_poly(&plan->line, &plan->models); }
static bool read_sphere(Plan *plan) { return plan_read_sphere(&plan->line, &plan->models); }
static bool read_ellipsoid(Plan *plan) { return plan_read_ellipsoid(&plan->line, &plan->models); }
static bool read_cone(Plan *plan) { return plan_read_cone(&plan->line, &plan->models); }
static bool read_lathe(Plan *plan) { return plan_read_lathe(&plan->line, &plan->models); }
static bool read_patch(Plan *plan) { return plan_read_patch(&plan->line, &plan->models); }
static bool read_trim(Plan *plan) { return plan_read_trim(&plan->line, &plan->models); }
static bool read_metaballs(Plan *plan) { return plan_read_metaballs(&plan->line, &plan->models); }
static bool read_ball(Plan *plan) { return plan_read_ball(&plan->line, &plan->models); }
static bool read_model_light(Plan *plan) { return plan_read_model_light(&plan->line, &plan->models); }

static bool read_end(Plan *plan) {
    const Building *b = plan->b, *shapes = &plan->models.shapes;
    int held = plan->block == BLOCK_TOUR ? b->tours[b->tour_count - 1].viewpoint_count
                                         : shapes->objects[shapes->object_count - 1].polygon_count;
    if (held == 0)
        return plan_fail(&plan->line, "the block of line %d is empty (allowed: at least one %s)",
                         plan->block_line, plan->block == BLOCK_TOUR ? "eye" : "shape with an area");
    plan->block = BLOCK_NONE;
    return plan_end(&plan->line);
}

// ---- the file

typedef struct Statement {
    const char *word;
    int block;  // the block in which it stands
    bool needs_storey;
    bool (*read)(Plan *plan);
} Statement;

static const Statement STATEMENTS[] = {{"plan", BLOCK_NONE, false, read_header},
                                       {"storey", BLOCK_NONE, false, plan_read_storey},
                                       {"material", BLOCK_NONE, false, plan_read_material},
                                       {"ground", BLOCK_NONE, false, plan_read_ground},
                                       {"facade", BLOCK_NONE, false, plan_read_facade},
                                       {"slabs", BLOCK_NONE, false, plan_read_slabs},
                                       {"room", BLOCK_NONE, true, plan_read_room},
                                       {"wall", BLOCK_NONE, true, plan_read_wall},
                                       {"door", BLOCK_NONE, true, plan_read_door},
                                       {"passage", BLOCK_NONE, true, plan_read_passage},
                                       {"window", BLOCK_NONE, true, plan_read_window},
                                       {"stairwell", BLOCK_NONE, true, plan_read_stairwell},
                                       {"stair", BLOCK_NONE, true, plan_read_stair},
                                       {"light", BLOCK_NONE, true, plan_read_light},
                                       {"inlay", BLOCK_NONE, true, plan_read_inlay},
                                       {"model", BLOCK_NONE, false, read_model},
                                       {"place", BLOCK_NONE, true, plan_read_place},
                                       {"view", BLOCK_NONE, true, plan_read_view},
                                       {"tour", BLOCK_NONE, true, plan_read_tour},
                                       {"start", BLOCK_NONE, true, plan_read_start},
                                       {"box", BLOCK_MODEL, false, read_box},
                                       {"prism", BLOCK_MODEL, false, read_prism},
                                       {"cylinder", BLOCK_MODEL, false, read_cylinder},
                                       {"poly", BLOCK_MODEL, false, read_poly},
                                       {"sphere", BLOCK_MODEL, false, read_sphere},
                                       {"ellipsoid", BLOCK_MODEL, false, read_ellipsoid},
                                       {"cone", BLOCK_MODEL, false, read_cone},
                                       {"lathe", BLOCK_MODEL, false, read_lathe},
                                       {"patch", BLOCK_MODEL, false, read_patch},
                                       {"trim", BLOCK_MODEL, false, read_trim},
                                       {"metaballs", BLOCK_MODEL, false, read_metaballs},
                                       {"ball", BLOCK_MODEL, false, read_ball},
                                       {"light", BLOCK_MODEL, false, read_model_light},
                                       {"end", BLOCK_MODEL, false, read_end},
                                       {"eye", BLOCK_TOUR, true, plan_read_tour_eye},
                                       {"end", BLOCK_TOUR, false, read_end}};
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

// Lines that go on with the shape of the line above.
static bool adds_to_shape(const Statement *s) { return s->read == read_trim || s->read == read_ball; }

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
        return statement->read(plan);
    }
    return unknown_statement(plan, word);
}

static bool read_lines(Plan *plan, Bytes content) {
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
        char *text = arena_alloc(plan->arena, length + 1, 1);
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
    plan->models.shapes.file_size = out->file_size;
    plan->storey = -1;
    Material plain = {.name = PLAIN, .reflectance = maps_colour(PLAIN_COLOUR), .alpha = 1};
    int index = building_add_material(arena, out, plain);
    if (!plan_declare(&plan->line, &plan->materials, "material", PLAIN, index)) return false;
    if (!read_lines(plan, content)) return false;
    plan_note_ramps(plan);
    if (!plan_fit_openings(plan)) return false;
    Error why = {""};
    if (!maps_enclose(&plan->sketch, out, arena, &why)) return error_set(error, "%s: %.900s", path, why.text);
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
    .summary = "Enfilade's own text format (maps/README.md)",
    .recognise = recognise_plan,
    .read = read_plan,
};
