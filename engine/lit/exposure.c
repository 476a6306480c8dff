// exposure.c - an exposure by the logarithmic mean (Reinhard, Stark, Shirley & Ferwerda 2002, equation 1) of the elements in
// view, weighted by solid angle and the root of their light: by solid angle alone, a dark garden behind a window would make a room
// too bright; by solid angle and all of their light, the spot above a lamp would make it too dark. By day an eye in a room adapts to rooms:
// a sunny garden behind a window would make them too dark.
// The exposure comes from the elements, not from the frame before: no pixels are read back, and the same view has the same exposure.
#include "engine/lit/exposure.h"

#include "engine/shade/walk_shade.h"

// A place of middling brightness gets this value before the curve of the screen; it is high because rooms are mostly light paint.
static const double MIDDLE = 0.65;
// The share of the difference between view and whole building that the eye makes up for: dark rooms stay a little darker.
static const double ADAPTATION = 0.85;
// An eye adapts to views at most by this factor darker or brighter than the building's level, so that the dark stays dark.
static const double REACH = 1000;
// The time in which the difference falls to 1/e, seconds: too short to wait for, too long to flicker.
static const double ADAPTATION_SECONDS = 0.4;
// Light that differs by this share looks the same: a third of a step of the screen's 255.
static const double ADAPTED = 0.003;

// Things outdoors reflect about so much. Where that would be brighter than FULL, half as bright again as an eye outdoors sees it, ten times
// the light is shown as twice as much: the sharp edge between a room and the day allows it, as local adaptation does (Reinhard, Stark,
// Shirley & Ferwerda 2002, on dodging and burning).
static const double OUTDOORS_REFLECTANCE = 0.25, OUTDOORS_FULL = 1, OUTDOORS_SLOPE = 0.3;

typedef struct Sum {
    double weight, logs;
} Sum;

static void add_element_exposure(const LitMesh *lit, const LitLight *light, const Camera *camera, Vec3 eye,
                                 Vec3 n, int element, Sum *sum) {
    const float *spot = lit->spot[element];
    double b = (double)light->luminous[element];
    if (!(b > 0)) return;
    Vec3 way = vec3_sub(vec3((double)spot[0], (double)spot[1], (double)spot[2]), eye);
    double ahead = vec3_dot(way, camera->forward);
    if (ahead <= 0 || fabs(vec3_dot(way, camera->right)) > camera->tan_x * ahead ||
        fabs(vec3_dot(way, camera->up)) > camera->tan_y * ahead)
        return;
    // The solid angle of a disc seen from its axis, nearly exact; it stays bounded where the eye is near.
    double r2 = vec3_dot(way, way), area = (double)spot[3];
    double angle = area * fabs(vec3_dot(way, n)) / (sqrt(r2) * (r2 + area));
    double weight = angle * sqrt(b);
    sum->weight += weight;
    sum->logs += weight * log(b);
}

double exposure_meter(const LitMesh *lit, const LitLight *light, const Camera *camera, const int *objects,
                      int object_count) {
    const CellGraph *graph = lit->graph;
    // Walls, floors and ceilings are enough to meter; the graph of a polygon soup has no surfaces of cells, only objects.
    bool surfaces_only = graph->surface_first[graph->cell_count] > graph->surface_first[0];
    int cell = daylight_shines(&light->day) ? vis_locate(graph, camera->eye, -1) : -1;
    bool in_room = cell >= 0 && vis_region(graph, cell)->kind != REGION_OUTDOORS;
    Vec3 eye = vec3_sub(camera->eye, lit->origin);
    Sum sum = {0};
    for (int k = 0; k < object_count; k++) {
        const Object *o = &graph->objects[objects[k]];
        if (surfaces_only && o->kind != OBJECT_SURFACE) continue;
        for (const LitFace *face = lit_object_begin(lit, o); face < lit_object_end(lit, o); face++) {
            if (surfaces_only && plane_distance(face->plane, camera->eye) <= 0) continue;
            if (in_room && face->outdoors) continue;
            for (int e = face->first_element; e < face->first_element + face->element_count; e++)
                add_element_exposure(lit, light, camera, eye, face->plane.n, e, &sum);
        }
    }
    return sum.weight > 0 ? exp(sum.logs / sum.weight) : 0;
}

bool exposure_adapt(Exposure *e, double seen, double usual, double seconds) {
    if (!(usual > 0) || (e->level > 0 && (e->fixed || !(seen > 0)))) return false;
    if (!(seen > 0)) seen = usual;
    double wanted = usual * pow(fmin(fmax(seen / usual, 1 / REACH), REACH), ADAPTATION);
    if (e->level > 0)
        e->level = wanted * pow(e->level / wanted, exp(-seconds / ADAPTATION_SECONDS));
    else
        e->level = wanted;
    return fabs(log(e->level / wanted)) > ADAPTED;
}

double exposure_scale(const Exposure *e) { return e->level > 0 ? MIDDLE / e->level * exp2(e->stops) : 1; }

double exposure_outdoors(double scale, const Daylight *day) {
    double level[3];
    daylight_horizontal(day, level);
    double usual = scale * OUTDOORS_REFLECTANCE * light_luminous(level);
    return usual > OUTDOORS_FULL ? scale * pow(usual / OUTDOORS_FULL, OUTDOORS_SLOPE - 1) : scale;
}

double exposure_on_screen(double light) {
    double x = fmin(fmax(light, 0), WALK_WHITE);
    x = fmin(WALK_CURVE(x), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}
