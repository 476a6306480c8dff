// lamp_spread.c - lamps by candela tables: their light at a point by quadrature over the parts in sight (three points of each triangle,
// exact for quadratics; Strang & Fix 1973), and rows of their patches.
//
// Rows take the samples of a hemicube, whose pixels are evenly fine down to the horizon, where tables may send light but Lambert's cosine
// sends none. Pixels of a hemisphere's base have no bound on their solid angle there.
#include "radiosity/factors/lamp_spread.h"

#include "engine/core/polygon.h"
#include "radiosity/factors/row.h"

// ---- light at a point

// So many parts wait at most: each halving leaves one.
enum { DEPTH = 40 };
// No part is halved that is shorter than this share of the piece.
static const double LEAST_PART = 1.0 / 64;
// Parts are halved that span more than this, as an angle's tangent, and those whose halves together send other light; none that span less
// than a step of the table.
static const double MOST_SPAN = 0.18;

typedef struct Part {
    Vec3 v[3];
    double area, light;  // m^2; s(w) cos / d^2 over the area, -1: not known yet
} Part;

static double square(Vec3 v) { return vec3_dot(v, v); }

// s(w) cos / d^2 for the light of a point of the lamp at `p`.
static double light_from(const SpreadSight *s, Vec3 p) {
    double d2 = square(p);
    if (!(p.z > 0)) return 0;
    double d = sqrt(d2);
    Vec3 to = vec3_add(vec3_scale(s->x, p.x), vec3_add(vec3_scale(s->y, p.y), vec3_scale(s->z, p.z)));
    return spread_share(s->spread, vec3_scale(to, -1 / d)) * p.z / (d2 * d);
}

static double light_of_part(const SpreadSight *s, const Part *p) {
    Vec3 sum = vec3_add(p->v[0], vec3_add(p->v[1], p->v[2]));
    double light = 0;
    for (int i = 0; i < 3; i++)
        light += light_from(s, vec3_scale(vec3_add(sum, vec3_scale(p->v[i], 3)), 1.0 / 6));
    return light * p->area / 3;
}

// The square of the tangent of a step of the table, whose steps are even in most; of 1 to 5 degrees.
static double step_of(const Photometry *t) {
    static const double LEAST = 0.018, MOST = 0.09, DEGREE = M_PI / 180;
    double step = (t->gamma[t->gamma_count - 1] - t->gamma[0]) / (t->gamma_count - 1) * DEGREE;
    step = fmin(fmax(step, LEAST), MOST);
    return step * step;
}

// Halves a part across its longest edge, of which it returns the square.
static double halve(const Part *p, Part half[2]) {
    int longest = 0;
    double edge = 0;
    for (int i = 0; i < 3; i++) {
        double e = square(vec3_sub(p->v[(i + 1) % 3], p->v[i]));
        if (e > edge) edge = e, longest = i;
    }
    Vec3 a = p->v[longest], b = p->v[(longest + 1) % 3], c = p->v[(longest + 2) % 3],
         middle = vec3_lerp(a, b, 0.5);
    half[0] = (Part){{a, middle, c}, p->area / 2, -1};
    half[1] = (Part){{middle, b, c}, p->area / 2, -1};
    return edge;
}

static void add_parts(SpreadSight *s, Part whole, double step, double least) {
    Part waiting[DEPTH], half[2];
    int count = 0;
    waiting[count++] = whole;
    while (count > 0) {
        Part p = waiting[--count];
        double edge = halve(&p, half);
        double d2 = square(vec3_add(p.v[0], vec3_add(p.v[1], p.v[2]))) / 9;
        bool last = edge <= least || count + 2 > DEPTH;
        if (last || edge <= MOST_SPAN * MOST_SPAN * d2) {
            if (p.light < 0) p.light = light_of_part(s, &p);
            double halves = p.light;
            if (!last && edge > step * d2) {
                for (int i = 0; i < 2; i++) half[i].light = light_of_part(s, &half[i]);
                halves = half[0].light + half[1].light;
            }
            if (fabs(halves - p.light) <= s->off * halves) {
                s->sight.share += halves;
                continue;
            }
        }
        waiting[count++] = half[1];
        waiting[count++] = half[0];
    }
}

void spread_sight_add(void *context, const Vec3 *polygon, int count) {
    SpreadSight *s = context;
    double size = 0, step = step_of(s->spread->table);
    for (int i = 1; i < count; i++) size = fmax(size, square(vec3_sub(polygon[i], polygon[0])));
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = polygon[0], b = polygon[i], c = polygon[i + 1];
        double area = vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a))) / 2;
        s->sight.area += area;
        s->sight.moment = vec3_add(s->sight.moment, vec3_scale(vec3_add(a, vec3_add(b, c)), area / 3));
        if (area > 0) add_parts(s, (Part){{a, b, c}, area, -1}, step, LEAST_PART * LEAST_PART * size);
    }
}

// ---- rows

// Finer is in vain, since steps of tables are not.
enum { FINEST = 400 };
// A patch of more elements than this is looked from at so many of them.
enum { MOST_LOOKS = 16 };
// How far in front of its face an element is looked for among the cells, metres: as patches are (mesh.c).
static const double IN_FRONT = 1e-6;

struct SpreadRows {
    const Mesh *mesh;
    FormFactor *form_factor;
    RowSum sum;
    FormFactorSamples samples;  // those along which `spread` sends light, and how much
    int *of;                    // [samples.count] which of the method's samples each is
    int32_t *item;              // [samples.count]
    const LampSpread *spread;   // NULL: none yet
    Vec3 normal;                // of the views that the weights are for
};

SpreadRows *spread_rows_new(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SpreadRows *self = ARENA_ARRAY(arena, SpreadRows, 1);
    FormFactorOptions own = *options;
    if (own.resolution > FINEST) own.resolution = FINEST;
    own.hidden = NULL;
    self->mesh = mesh;
    self->form_factor = form_factor_new(form_factor_method("hemicube"), mesh, &own, arena);
    int count = form_factor_samples(self->form_factor)->count;
    self->samples = (FormFactorSamples){0, ARENA_ARRAY(arena, float, count), ARENA_ARRAY(arena, float, count),
                                        ARENA_ARRAY(arena, float, count), ARENA_ARRAY(arena, float, count)};
    self->of = ARENA_ARRAY(arena, int, count);
    self->item = ARENA_ARRAY(arena, int32_t, count);
    row_start(&self->sum, mesh, arena);
    row_start_sky(&self->sum, options, arena);
    return self;
}

void spread_rows_end(SpreadRows *self) { form_factor_end(self->form_factor); }

static void weigh_samples(SpreadRows *self, const View *view, const LampSpread *spread) {
    const FormFactorSamples *all = form_factor_samples(self->form_factor);
    FormFactorSamples *own = &self->samples;
    if (self->spread == spread && vec3_equal(self->normal, view->z)) return;
    self->spread = spread;
    self->normal = view->z;
    own->count = 0;
    for (int i = 0; i < all->count; i++) {
        double ratio = spread_ratio(spread, view->z, row_direction(view, all, i));
        float weight = (float)((double)all->weight[i] * ratio);
        if (!(weight > 0)) continue;
        int k = own->count++;
        own->x[k] = all->x[i];
        own->y[k] = all->y[i];
        own->z[k] = all->z[i];
        own->weight[k] = weight;
        self->of[k] = i;
    }
}

// The faces that the samples see.
static const int32_t *find_items(SpreadRows *self, const View *view) {
    const int32_t *item = form_factor_items(self->form_factor, view);
    for (int k = 0; k < self->samples.count; k++) self->item[k] = item[self->of[k]];
    return self->item;
}

const Row *spread_row(SpreadRows *self, Viewer *viewer, Culling culling, int index) {
    const Mesh *mesh = self->mesh;
    const Patch *patch = &mesh->patches[index];
    Vec3 n = mesh->faces[patch->face].plane.n;
    int step = (patch->element_count + MOST_LOOKS - 1) / MOST_LOOKS;
    for (int i = 0; i < patch->element_count; i += step) {
        ViewPoint from = {element_centroid(mesh, patch->first_element + i), n, -1};
        from.cell = vis_locate(mesh->graph, vec3_add(from.eye, vec3_scale(n, IN_FRONT)), patch->cell);
        // A part inside a wall sends its light from the middle of the rest.
        if (from.cell < 0) from = (ViewPoint){patch->centre, n, patch->cell};
        const View *view = viewer_look(viewer, &from, culling);
        weigh_samples(self, view, mesh_spread(mesh, patch->face));
        row_of_items(&self->sum, view, &self->samples, find_items(self, view));
    }
    return row_finish(&self->sum);
}
