// walk_light.c - radiosities to colours: constant elements become linear by the mean at each corner (Cohen & Greenberg 1985,
// section 7: nodal radiosities), an exposure by the mean brightness (Reinhard, Stark, Shirley & Ferwerda 2002), the curve of
// the screen.
#include "engine/walk/walk_light.h"

#include "engine/walk/walk_shade.h"

// What a wall of middling brightness becomes, before the shoulder: rooms are mostly light paint.
static const double MIDDLE = 0.55;
// Planes are one where their normals are this near, 1 - cosine.
static const double SAME_PLANE = 1e-6;

static bool emits(const Material *m) { return m->emission.r + m->emission.g + m->emission.b > 0; }
static double brightness(const double b[3]) { return 0.2126 * b[0] + 0.7152 * b[1] + 0.0722 * b[2]; }

// The logarithmic mean of what does not emit, made MIDDLE. Each place counts by the light that leaves it: a dark garden
// or a sealed cupboard would make all rooms too bright.
static double find_exposure(const WalkLight *light) {
    const Mesh *mesh = light->mesh;
    double power = 0, logs = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        double b = brightness(light->solution->radiosity[e]);
        if (emits(mesh_material(mesh, element->face)) || !(b > 0)) continue;
        logs += element->area * b * log(b);
        power += element->area * b;
    }
    return power > 0 ? MIDDLE / exp(logs / power) : 1;
}

static uint8_t to_screen(double b) {
    double x = b * (double)WALK_EXPOSURE;
    x *= (1 + x * (double)WALK_SHOULDER_TOP) / (1 + x * (double)WALK_SHOULDER_BOTTOM);
    return walk_byte((float)(x <= 0.0031308 ? 12.92 * x : 1.055 * pow(fmin(x, 1), 1 / 2.4) - 0.055));
}

static Rgba8 shade(const double b[3], double scale) {
    return (Rgba8){to_screen(scale * b[0]), to_screen(scale * b[1]), to_screen(scale * b[2]), 255};
}

// What meets at a place in one plane, of one material.
typedef struct Meeting {
    Vec3 n;
    int material, next;
    double sum[3], area;
} Meeting;

static int find_meeting(const Meeting *meetings, int first, const Face *face) {
    for (int i = first; i >= 0; i = meetings[i].next) {
        if (meetings[i].material == face->material && vec3_dot(meetings[i].n, face->plane.n) > 1 - SAME_PLANE)
            return i;
    }
    return -1;
}

static void fill_corners(const WalkLight *light, WalkShades *out) {
    const Mesh *mesh = light->mesh;
    Arena scratch = {0};
    Meeting *meetings = ARENA_ARRAY(&scratch, Meeting, mesh->corner_count);
    int *first = ARENA_ARRAY(&scratch, int, mesh->vertex_count),
        *meeting = ARENA_ARRAY(&scratch, int, mesh->corner_count);
    int count = 0;
    for (int v = 0; v < mesh->vertex_count; v++) first[v] = -1;
    for (int e = 0; e < mesh->element_count; e++) {
        const Element *element = &mesh->elements[e];
        const Face *face = &mesh->faces[element->face];
        for (int i = element->first_corner; i < element->first_corner + element->corner_count; i++) {
            int v = mesh->corners[i], at = find_meeting(meetings, first[v], face);
            if (at < 0) {
                at = count++;
                meetings[at] = (Meeting){.n = face->plane.n, .material = face->material, .next = first[v]};
                first[v] = at;
            }
            for (int c = 0; c < 3; c++)
                meetings[at].sum[c] += element->area * light->solution->radiosity[e][c];
            meetings[at].area += element->area;
            meeting[i] = at;
        }
    }
    for (int i = 0; i < mesh->corner_count; i++)
        out->corner[i] = shade(meetings[meeting[i]].sum, out->exposure / meetings[meeting[i]].area);
    arena_free(&scratch);
}

WalkShades walk_light_shades(const WalkLight *light, Arena *arena) {
    const Mesh *mesh = light->mesh;
    WalkShades out = {ARENA_ARRAY(arena, Rgba8, mesh->corner_count),
                      ARENA_ARRAY(arena, Rgba8, mesh->face_count), find_exposure(light)};
    fill_corners(light, &out);
    for (int f = 0; f < mesh->face_count; f++) {
        const Face *face = &mesh->faces[f];
        double sum[3] = {0}, area = 0;
        for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
            for (int c = 0; c < 3; c++) sum[c] += mesh->elements[e].area * light->solution->radiosity[e][c];
            area += mesh->elements[e].area;
        }
        out.face[f] = shade(sum, out.exposure / area);
    }
    return out;
}
