// still_lamps_seen.c - which lamps a side of an element sees, by some rays when it is first looked at: the others are hidden from it, or
// turn away, and are seldom asked for.
#include "engine/stills/still_lamps_parts.h"
#include "radiosity/show/gather.h"

// On curved shapes facets say little of what lies around them: of all that may be seen something is taken to be.
static const float CURVED_SEEN = 0.2f;

// Uniform over its triangles.
static Vec3 point_of_element(const Mesh *mesh, const Element *e, double u, double v) {
    const int *corner = mesh->corners + e->first_corner;
    int i = 1 + (int)(u * (e->corner_count - 2));
    double along = lamp_fraction(u * (e->corner_count - 2)), out = sqrt(v);
    Vec3 far = vec3_lerp(mesh->vertices[corner[i]], mesh->vertices[corner[i + 1]], along);
    return vec3_lerp(mesh->vertices[corner[0]], far, out);
}

// One of a group's lamps that turns its front to a point, from one of them on; NULL: none does.
static const Lamp *facing_of(const StillLamps *lamps, int group, Vec3 point, double u) {
    int first = lamps->group_first[group], count = lamps->group_first[group + 1] - first,
        start = (int)(u * count);
    for (int i = 0; i < count; i++) {
        const Lamp *lamp = &lamps->lamps[first + (start + i) % count];
        if (lamp->corner_count == 0 || vec3_dot(lamp->normal, vec3_sub(lamp->centre, point)) < 0) return lamp;
    }
    return NULL;
}

// The share of looks from an element that meet nothing before the lamps of a group.
static float seen_share(const StillLamps *lamps, const Element *element, Vec3 normal, int group) {
    int seen = 0;
    StillNumbers numbers = {.shift = {0.5, 0.5, 0.5}};
    for (int k = 0; k < lamps->looks; k++) {
        double u[3], w[3];
        lamp_numbers_next(&numbers, u);
        lamp_numbers_next(&numbers, w);
        LampFrame f = {.n = normal, .point = point_of_element(lamps->scene->mesh, element, u[0], u[1])};
        const Lamp *lamp = facing_of(lamps, group, f.point, u[2]);
        seen += lamp && lamp_sees(lamps, lamp, &f, w, w[2]);
    }
    return (float)seen / (float)lamps->looks;
}

// Is any of an element before a lamp? What lies around one on a curved shape is elsewhere.
static bool may_matter(const StillLamps *lamps, const Element *element, const Lamp *lamp, bool curved) {
    const Mesh *mesh = lamps->scene->mesh;
    if (curved || lamp->corner_count == 0) return true;
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 to = vec3_sub(mesh->vertices[mesh->corners[element->first_corner + i]], lamp->centre);
        if (vec3_dot(lamp->normal, to) > 0) return true;
    }
    return false;
}

// The cells into which a side of an element looks; count 0: not known.
enum { MOST_CELLS = 4 };
typedef struct Cells {
    int cell[MOST_CELLS], count;
} Cells;

// Of a wall all is in one cell; what stands in rooms may reach into several.
static Cells cells_of(const StillLamps *lamps, const Element *element, bool front) {
    static const double INWARDS = 1e-3;  // of the way: a corner lies on walls
    const Mesh *mesh = lamps->scene->mesh;
    const Face *face = &mesh->faces[element->face];
    const Patch *patch = &mesh->patches[element->patch];
    Cells out = {.cell = {patch->cell}, .count = patch->cell >= 0};
    if (front && mesh->graph->objects[face->object].kind == OBJECT_SURFACE) return out;
    Vec3 normal = vec3_scale(face->plane.n, front ? 1 : -1);
    out.count = 0;
    for (int i = 0; i < element->corner_count; i++) {
        Vec3 at = vec3_lerp(mesh->vertices[mesh->corners[element->first_corner + i]], patch->centre, INWARDS);
        int cell = gather_cell(mesh->graph, at, normal, patch->cell), k = 0;
        while (k < out.count && out.cell[k] != cell) k++;
        if (k < out.count) continue;
        if (cell < 0 || out.count == MOST_CELLS) return (Cells){.count = 0};
        out.cell[out.count++] = cell;
    }
    return out;
}

static bool any_sees(const StillLamps *lamps, const Cells *cells, const Lamp *lamp) {
    if (cells->count == 0 || lamp->cell < 0 || !lamps->forest) return true;
    for (int i = 0; i < cells->count; i++)
        if (vis_sees(lamps->forest, cells->cell[i], lamp->cell)) return true;
    return false;
}

// Does any of a lamp rise above the plane of a face?
static bool rises(const StillLamps *lamps, const Lamp *lamp, Vec3 n, double d) {
    if (lamp->corner_count == 0) return vec3_dot(n, lamp->centre) + lamp->radius > d;
    for (int i = 0; i < lamp->corner_count; i++)
        if (vec3_dot(n, lamps->corners[lamp->first_corner + i]) > d) return true;
    return false;
}

static Candidates *find_candidates(const StillLamps *lamps, int index, bool front, Arena *arena) {
    const Mesh *mesh = lamps->scene->mesh;
    const Element *element = &mesh->elements[index];
    const Face *face = &mesh->faces[element->face];
    Vec3 normal = vec3_scale(face->plane.n, front ? 1 : -1);
    double d = front ? face->plane.d : -face->plane.d;
    bool curved = lamp_shape_of(lamps->scene, face) != NULL;
    Cells cells = cells_of(lamps, element, front);
    Candidates *out = arena_alloc(arena, 1, sizeof *out + (size_t)lamps->count * sizeof *out->lamp);
    int hidden = lamps->count;  // from there on, for now
    float seen = -1;            // of the group, -1: not looked for
    for (int i = 0; i < lamps->count; i++) {
        const Lamp *lamp = &lamps->lamps[i];
        if (i == lamps->group_first[lamp->group]) seen = -1;
        if (!any_sees(lamps, &cells, lamp) || !may_matter(lamps, element, lamp, curved) ||
            (!curved && !rises(lamps, lamp, normal, d)))
            continue;
        if (seen < 0) seen = seen_share(lamps, element, normal, lamp->group);
        if (seen > 0 || curved)
            out->lamp[out->seen_count++] = (Candidate){i, fmaxf(seen, curved ? CURVED_SEEN : 0)};
        else
            out->lamp[--hidden] = (Candidate){i, 0};
    }
    out->count = out->seen_count + lamps->count - hidden;
    memmove(out->lamp + out->seen_count, out->lamp + hidden,
            (size_t)(lamps->count - hidden) * sizeof *out->lamp);
    return out;
}

// Whoever comes first looks; two that look at once find the same.
const Candidates *lamp_candidates(StillLamps *lamps, int element, bool front) {
    _Atomic(Candidates *) *place = &lamps->of_element[2 * element + !front];
    Candidates *found = atomic_load(place);
    if (found) return found;
    Arena scratch = {0};
    Candidates *made = find_candidates(lamps, element, front, &scratch);
    size_t size = sizeof *made + (size_t)made->count * sizeof *made->lamp;
    pthread_mutex_lock(&lamps->lock);
    found = atomic_load(place);
    if (!found) {
        found = arena_alloc(&lamps->found, 1, size);
        memcpy(found, made, size);
        atomic_store(place, found);
    }
    pthread_mutex_unlock(&lamps->lock);
    arena_free(&scratch);
    return found;
}
