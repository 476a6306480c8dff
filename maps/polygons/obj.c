// obj.c - Wavefront OBJ and MTL text (the subset that furniture uses): v, vt, f, g, o, usemtl, mtllib; newmtl, Kd, Ke,
// Ks, Ns, illum, d, Tr, map_Kd and map_d with -s and -o. Departures: normals, lines, points, curves and smoothing are not
// read; Kd is taken as sRGB, as the programs that write such models show it; a picture replaces Kd; pictures repeat, whatever
// -clamp says; map_d cuts holes into map_Kd, or into a picture of Kd alone; Ke is taken as radiant exitance, for which MTL
// has no unit; of Ks only whether it is black.
#include "maps/polygons/obj.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "maps/building/scan.h"
#include "maps/building/texture.h"

static const float GLASS_ALPHA = 0.3f;       // of an unknown material that is called glass
static const unsigned UNPAINTED = 0xFFFFFF;  // sRGB, of a library's material without Kd: Java 3D's
static const double MAX_EMISSION = 1e9;      // W/m^2: the sun's surface is at 6e7

// Open addressing by hash; slots hold an index + 1, 0 where they are free.
enum { NAME_SLOTS = 2 * OBJ_MAX_NAMES };
typedef struct Names {
    int group[NAME_SLOTS], material[NAME_SLOTS];
} Names;

// Pictures that were asked for: each is decoded once, however many materials and libraries name it.
typedef struct Picture {
    const char *name, *mask;  // files of the colours and of the opacity; NULL: none
    Rgb colour;               // of a picture without a file of colours
    int texture;              // 0: not usable
} Picture;

typedef struct Pictures {
    Picture *list;
    int count, capacity;
} Pictures;

typedef struct Reader {
    const char *at, *end;
    const ObjFiles *files;
    Arena *arena;
    ObjModel *model;
    Names *names;
    Pictures *pictures;
    Error *error;
    const char *path;
    int line;
    bool failed;
} Reader;

static bool blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

static void skip_blanks(Reader *r) {
    for (;;) {
        while (r->at < r->end && blank(*r->at)) r->at++;
        // A backslash joins the next line to this one.
        const char *p = r->at;
        if (p == r->end || *p != '\\') return;
        for (p++; p < r->end && *p == '\r';) p++;
        if (p == r->end || *p != '\n') return;
        r->at = p + 1;
        r->line++;
    }
}

static bool line_ends(Reader *r) {
    skip_blanks(r);
    return r->at == r->end || *r->at == '\n' || *r->at == '#' || *r->at == '\0';
}

static void next_line(Reader *r) {
    while (r->at < r->end && *r->at != '\n') r->at++;
    if (r->at < r->end) r->at++;
    r->line++;
}

static bool read_number(Reader *r, double *out) {
    if (line_ends(r)) return false;
    char *stop;
    *out = strtod(r->at, &stop);
    if (stop == r->at) return false;
    r->at = stop;
    return isfinite(*out);
}

static bool word_is(Reader *r, const char *word) {
    size_t length = strlen(word);
    if ((size_t)(r->end - r->at) <= length || memcmp(r->at, word, length) != 0 || !blank(r->at[length]))
        return false;
    r->at += length;
    return true;
}

// The rest of the line without the blanks around it.
static char *read_name(Reader *r) {
    while (r->at < r->end && blank(*r->at)) r->at++;
    const char *start = r->at;
    while (r->at < r->end && *r->at != '\n' && *r->at != '\0') r->at++;
    const char *stop = r->at;
    while (stop > start && blank(stop[-1])) stop--;
    char *name = ARENA_ARRAY(r->arena, char, stop - start + 1);
    memcpy(name, start, (size_t)(stop - start));
    return name;
}

static void fail(Reader *r, const char *what, int limit) {
    if (!r->failed) error_set(r->error, "%s: the model has more than %d %s", r->path, limit, what);
    r->failed = true;
}

// Counts a vertex or face that cannot be used; the first one is kept for readers that refuse such models.
static void skip(Reader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void skip(Reader *r, const char *format, ...) {
    ObjModel *m = r->model;
    m->skipped++;
    if (m->fault) return;
    va_list args;
    va_start(args, format);
    m->fault = arena_format(r->arena, "%d: %s", r->line, arena_format_list(r->arena, format, args));
    va_end(args);
}

static void skip_file(Reader *r, const char *name) {
    r->model->skipped++;
    if (!r->model->absent) r->model->absent = name;
}

// The place of `name` in a table, or of the free slot where it belongs; `name_of` gives the names by index.
static int *find_name(const Reader *r, int *table, const char *name,
                      const char *(*name_of)(const ObjModel *, int)) {
    size_t at = file_hash(name, strlen(name), 0) % NAME_SLOTS;
    while (table[at] > 0 && strcmp(name_of(r->model, table[at] - 1), name) != 0) at = (at + 1) % NAME_SLOTS;
    return &table[at];
}

static const char *group_name(const ObjModel *m, int i) { return m->groups[i]; }
static const char *material_name(const ObjModel *m, int i) { return m->materials[i].name; }

static int find_group(Reader *r, const char *name) {
    ObjModel *m = r->model;
    int *slot = find_name(r, r->names->group, name, group_name);
    if (*slot > 0) return *slot - 1;
    if (m->group_count == OBJ_MAX_NAMES) {
        m->nameless++;
        return 0;
    }
    *ARENA_PUSH(r->arena, m->groups, m->group_count, m->group_capacity) = name;
    *slot = m->group_count;
    return m->group_count - 1;
}

static Rgb screen_colour(const double c[3]) {
    int code[3];
    for (int i = 0; i < 3; i++) code[i] = (int)lrint(255 * fmin(fmax(c[i], 0), 1));
    return (Rgb){maps_linear(code[0]), maps_linear(code[1]), maps_linear(code[2])};
}

// The material of a name without a library. An unknown name, and none, has the colour of `default`; it is matt, and
// opaque unless it is called glass.
static ObjMaterial name_material(const char *name) {
    const ObjNamed *named = obj_named(name), *shown = named ? named : obj_named("default");
    ObjMaterial m = {.name = name,
                     .colour = screen_colour(shown->diffuse),
                     .alpha = 1,
                     .scale = {1, 1},
                     .known = named || !*name};
    if (named) {
        m.alpha = (float)named->alpha;
        m.shininess = (float)(named->exponent / OBJ_MAX_SHININESS);
    } else if (strcasestr(name, "glass")) {
        m.alpha = GLASS_ALPHA;
    }
    return m;
}

static int find_material(Reader *r, const char *name) {
    ObjModel *m = r->model;
    int *slot = find_name(r, r->names->material, name, material_name);
    if (*slot > 0) return *slot - 1;
    if (m->material_count == OBJ_MAX_NAMES) {
        m->nameless++;
        return 0;
    }
    *ARENA_PUSH(r->arena, m->materials, m->material_count, m->material_capacity) = name_material(name);
    *slot = m->material_count;
    return m->material_count - 1;
}

static void read_vertex(Reader *r) {
    ObjModel *m = r->model;
    if (m->vertex_count == OBJ_MAX_VERTICES) {
        fail(r, "vertices", OBJ_MAX_VERTICES);
        return;
    }
    Vec3 v;
    bool whole = read_number(r, &v.x) && read_number(r, &v.y) && read_number(r, &v.z);
    // A bad vertex keeps its number, or all later faces would refer to the wrong ones; faces that use it go.
    if (!whole) {
        v = vec3(NAN, NAN, NAN);
        skip(r, "the coordinates of vertex %d are not three numbers", m->vertex_count + 1);
    }
    *ARENA_PUSH(r->arena, m->vertices, m->vertex_count, m->vertex_capacity) = v;
}

// Unusable texture coordinates keep their number; a face that uses them has no picture.
static void read_place(Reader *r) {
    ObjModel *m = r->model;
    Vec2 p = {0, 0};
    if (m->place_count == OBJ_MAX_VERTICES) return;
    if (!read_number(r, &p.x)) p.x = NAN;
    if (!read_number(r, &p.y)) p.y = 0;
    *ARENA_PUSH(r->arena, m->places, m->place_count, m->place_capacity) = p;
}

// The texture coordinates of a corner, as in `7/1/3`, from its slash on; -1: none or bad ones.
static int corner_place(const ObjModel *m, const char *slash) {
    if (*slash != '/' || !(slash[1] == '-' || (slash[1] >= '0' && slash[1] <= '9'))) return -1;
    long index = strtol(slash + 1, NULL, 10);
    if (index == 0 || index > m->place_count || index < -(long)m->place_count) return -1;
    return (int)(index > 0 ? index - 1 : m->place_count + index);
}

// `7`, `7/1`, `7//3`, `7/1/3`; negative counts back from the last vertex so far. Yields -1 for a bad one.
static int read_corner(Reader *r, int *place) {
    char *stop;
    long index = strtol(r->at, &stop, 10);
    bool number = stop != r->at && (stop == r->end || strchr("/ \t\r\v\f\n\\#", *stop));
    *place = number && stop < r->end ? corner_place(r->model, stop) : -1;
    while (stop < r->end && !blank(*stop) && *stop != '\n' && *stop != '\0' && *stop != '#') stop++;
    r->at = stop;
    const ObjModel *m = r->model;
    if (!number || index == 0 || index > m->vertex_count || index < -(long)m->vertex_count) return -1;
    int vertex = (int)(index > 0 ? index - 1 : m->vertex_count + index);
    return isfinite(m->vertices[vertex].x) ? vertex : -1;
}

static void read_face(Reader *r, int group, int material) {
    ObjModel *m = r->model;
    int first = m->corner_count;
    const char *bad = NULL;
    while (!line_ends(r)) {
        if (m->corner_count == OBJ_MAX_CORNERS) {
            fail(r, "corners", OBJ_MAX_CORNERS);
            return;
        }
        const char *word = r->at;
        int place, places = m->corner_count, corner = read_corner(r, &place);
        if (corner < 0 && !bad) bad = word;
        *ARENA_PUSH(r->arena, m->corner_places, places, m->corner_place_capacity) = place;
        *ARENA_PUSH(r->arena, m->corners, m->corner_count, m->corner_capacity) = corner;
    }
    int count = m->corner_count - first;
    if (bad || count < 3) {
        m->corner_count = first;
        char quote[SCAN_QUOTE];
        if (bad)
            skip(r, "a corner of a face is `%s` (allowed: 1 to %d or -1 to -%d, of sound vertices)",
                 scan_quote(&(Scan){.at = bad, .end = r->end}, quote), m->vertex_count, m->vertex_count);
        else
            skip(r, "a face has %d corners (allowed: 3 or more)", count);
        return;
    }
    for (int i = first; i < m->corner_count; i++) m->box = box_add(m->box, m->vertices[m->corners[i]]);
    *ARENA_PUSH(r->arena, m->faces, m->face_count, m->face_capacity) =
        (ObjFace){first, count, group, material, r->line};
}

// One value stands for all three.
static bool read_channels(Reader *r, double c[3]) {
    if (!read_number(r, &c[0])) return false;
    if (!read_number(r, &c[1]) || !read_number(r, &c[2])) c[1] = c[2] = c[0];
    return true;
}

static void read_emission(Reader *r, ObjMaterial *material) {
    double c[3];
    if (!read_channels(r, c)) return;
    for (int i = 0; i < 3; i++) c[i] = fmin(fmax(c[i], 0), MAX_EMISSION);
    material->emission = (Rgb){(float)c[0], (float)c[1], (float)c[2]};
}

static void read_colour(Reader *r, ObjMaterial *material) {
    double c[3];
    if (!read_channels(r, c)) return;
    material->colour = screen_colour(c);
}

// ---- pictures

// A material of a library while it is read: the order of its lines does not matter.
typedef struct Drawn {
    ObjMaterial *material;
    char *colours, *mask;  // names of files; NULL: none
    bool matt, reflects;
    double exponent, specular;  // `specular`: the mean Ks
} Drawn;

static bool same_name(const char *a, const char *b) { return a && b ? strcmp(a, b) == 0 : a == b; }

static bool same_colour(Rgb a, Rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

static Bytes read_image(Reader *r, const char *name) {
    Bytes image = {NULL, 0};
    if (!name || !r->files || !r->files->read) return image;
    if (!r->files->read(r->files->context, name, r->arena, &image)) image = (Bytes){NULL, 0};
    return image;
}

// The picture of a material; 0: it is not usable, or there are more pictures than there may be materials.
static int find_picture(Reader *r, const Drawn *d) {
    Pictures *p = r->pictures;
    Rgb colour = d->material->colour;
    for (int i = 0; i < p->count; i++)
        if (same_name(p->list[i].name, d->colours) && same_name(p->list[i].mask, d->mask) &&
            (d->colours || same_colour(p->list[i].colour, colour)))
            return p->list[i].texture;
    if (p->count == OBJ_MAX_NAMES) return 0;
    Picture *picture = ARENA_PUSH(r->arena, p->list, p->count, p->capacity);
    *picture = (Picture){d->colours, d->mask, colour, 0};
    Bytes image = read_image(r, d->colours),
          mask = same_name(d->colours, d->mask) ? (Bytes){NULL, 0} : read_image(r, d->mask);
    if (d->mask && !mask.data && !same_name(d->colours, d->mask)) skip_file(r, d->mask);
    picture->texture = texture_add_masked(r->arena, r->files->b, d->colours ? d->colours : d->mask, image,
                                          mask, colour, r->files->pixels);
    return picture->texture;
}

// A word that is a number and nothing else.
static bool read_number_word(Reader *r, double *out) {
    const char *at = r->at;
    if (read_number(r, out) && (r->at == r->end || blank(*r->at) || *r->at == '\n')) return true;
    r->at = at;
    return false;
}

static void skip_word(Reader *r) {
    skip_blanks(r);
    while (r->at < r->end && !blank(*r->at) && *r->at != '\n' && *r->at != '\0') r->at++;
}

// The name of an image after its options, of which -s and -o count: up to three numbers each. The name may have blanks.
static char *read_map(Reader *r, Vec2 *scale, Vec2 *offset) {
    *scale = vec2(1, 1);
    *offset = vec2(0, 0);
    while (!line_ends(r) && *r->at == '-') {
        const char *option = r->at;
        skip_word(r);
        size_t length = (size_t)(r->at - option);
        bool scales = length == 2 && option[1] == 's', offsets = length == 2 && option[1] == 'o',
             turbulence = length == 2 && option[1] == 't', two = length == 3 && memcmp(option, "-mm", 3) == 0;
        double number[3] = {scales ? 1 : 0, scales ? 1 : 0, 0}, ignored;
        if (scales || offsets || turbulence) {
            for (int i = 0; i < 3 && read_number_word(r, &number[i]); i++) {
            }
            if (scales) *scale = vec2(number[0], number[1]);
            if (offsets) *offset = vec2(number[0], number[1]);
        } else if (two) {
            for (int i = 0; i < 2 && read_number_word(r, &ignored); i++) {
            }
        } else {
            skip_word(r);
        }
    }
    char *name = read_name(r);
    return *name ? name : NULL;
}

static void finish_material(Reader *r, const Drawn *d) {
    ObjMaterial *m = d->material;
    if (!m) return;
    // Illumination models 0 and 1 have no highlights, in whatever order the lines come.
    m->shininess = d->matt ? 0 : (float)(fmin(fmax(d->exponent, 0), OBJ_MAX_SHININESS) / OBJ_MAX_SHININESS);
    if (d->reflects && d->exponent >= OBJ_MIRROR_SHININESS) m->mirror = (float)d->specular;
    if ((!d->colours && !d->mask) || !r->files || !r->files->b) return;
    m->texture = find_picture(r, d);
    if (m->texture > 0)
        m->colour = r->files->b->textures[m->texture].mean;
    else
        skip_file(r, d->colours ? d->colours : d->mask);
}

// A library's material is all that the library says of it: nothing of its name's own colour remains.
static ObjMaterial *define_material(Reader *r) {
    ObjMaterial *m = &r->model->materials[find_material(r, read_name(r))];
    *m = (ObjMaterial){
        .name = m->name, .colour = maps_colour(UNPAINTED), .alpha = 1, .scale = {1, 1}, .known = true};
    return m;
}

static void read_library(Reader *outer, Bytes content) {
    Reader r = *outer;
    r.at = (const char *)content.data;
    r.end = r.at + content.size;
    Drawn d = {0};
    for (; r.at < r.end; next_line(&r)) {
        double number, specular[3];
        Vec2 ignored[2];
        skip_blanks(&r);
        if (word_is(&r, "newmtl")) {
            finish_material(&r, &d);
            d = (Drawn){.material = define_material(&r)};
            continue;
        }
        ObjMaterial *m = d.material;
        if (!m) continue;
        if (word_is(&r, "Kd"))
            read_colour(&r, m);
        else if (word_is(&r, "Ke"))
            read_emission(&r, m);
        else if (word_is(&r, "Ks") && read_channels(&r, specular))
            d.matt = d.matt || fmax(specular[0], fmax(specular[1], specular[2])) <= 0,
            d.specular = fmin(fmax((specular[0] + specular[1] + specular[2]) / 3, 0), 1);
        else if (word_is(&r, "illum") && read_number(&r, &number))
            d.matt = d.matt || number < 2, d.reflects = number == 3 || number == 5;
        else if (word_is(&r, "Ns") && read_number(&r, &number))
            d.exponent = number;
        else if (word_is(&r, "d") && read_number(&r, &number))
            m->alpha = (float)fmin(fmax(number, 0), 1);
        else if (word_is(&r, "Tr") && read_number(&r, &number))
            m->alpha = 1 - (float)fmin(fmax(number, 0), 1);
        else if (word_is(&r, "map_Kd"))
            d.colours = read_map(&r, &m->scale, &m->offset);
        else if (word_is(&r, "map_d"))
            d.mask = read_map(&r, &ignored[0], &ignored[1]);
    }
    finish_material(&r, &d);
}

static void read_libraries(Reader *r) {
    char *name = read_name(r);
    Bytes content;
    if (r->files && r->files->read && r->files->read(r->files->context, name, r->arena, &content))
        read_library(r, content);
    else
        skip_file(r, name);
}

bool obj_read(Bytes content, const char *path, const ObjFiles *files, Arena *arena, ObjModel *out,
              Error *error) {
    memset(out, 0, sizeof *out);
    out->box = box_empty();
    const char *text = (const char *)content.data;
    Reader r = {.at = text,
                .end = text + content.size,
                .files = files,
                .arena = arena,
                .model = out,
                .names = ARENA_ARRAY(arena, Names, 1),
                .pictures = ARENA_ARRAY(arena, Pictures, 1),
                .error = error,
                .path = path,
                .line = 1};
    int group = find_group(&r, ""), material = find_material(&r, "");
    for (; r.at < r.end && !r.failed; next_line(&r)) {
        skip_blanks(&r);
        if (word_is(&r, "v"))
            read_vertex(&r);
        else if (word_is(&r, "vt"))
            read_place(&r);
        else if (word_is(&r, "f"))
            read_face(&r, group, material);
        else if (word_is(&r, "g") || word_is(&r, "o"))
            group = find_group(&r, read_name(&r));
        else if (word_is(&r, "usemtl"))
            material = find_material(&r, read_name(&r));
        else if (word_is(&r, "mtllib"))
            read_libraries(&r);
    }
    if (r.failed) return false;
    if (out->face_count == 0) return error_set(error, "%s: no usable face in the model", path);
    return true;
}

bool obj_places(const ObjModel *model, const ObjFace *face, Vec2 *out) {
    for (int i = 0; i < face->corner_count; i++) {
        int place = model->corner_places ? model->corner_places[face->first_corner + i] : -1;
        if (place < 0) return false;
        out[i] = model->places[place];
    }
    return true;
}

ObjModel obj_box(Arena *arena) {
    static const int QUAD[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                   {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    ObjModel m = {0};
    for (int i = 0; i < 8; i++)
        *ARENA_PUSH(arena, m.vertices, m.vertex_count, m.vertex_capacity) = vec3(i >> 2, i >> 1 & 1, i & 1);
    for (int i = 0; i < 6; i++) {
        *ARENA_PUSH(arena, m.faces, m.face_count, m.face_capacity) = (ObjFace){m.corner_count, 4, 0, 0, 0};
        for (int j = 0; j < 4; j++)
            *ARENA_PUSH(arena, m.corners, m.corner_count, m.corner_capacity) = QUAD[i][j];
    }
    *ARENA_PUSH(arena, m.groups, m.group_count, m.group_capacity) = "";
    *ARENA_PUSH(arena, m.materials, m.material_count, m.material_capacity) = name_material("");
    m.box = (Box){vec3(0, 0, 0), vec3(1, 1, 1)};
    m.fixed_box = true;
    return m;
}
