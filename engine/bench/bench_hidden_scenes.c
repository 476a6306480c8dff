// bench_hidden_scenes.c - the scenes of `bench hidden`.
#include "engine/bench/bench_hidden_scenes.h"

#include <stdio.h>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/draw/view.h"
#include "engine/sim/tour.h"
#include "visibility/hidden/curved_scene.h"

// Random polygons lie so far before the eye, metres; half the picture's extent at 1 m.
static const double NEAR = 4, FAR = 12, TAN = 0.5;

static Camera ahead(int width, int height) {
    Camera camera = camera_look(vec3(0, 0, 0), 0, 0, 2 * atan(TAN), width, height);
    camera.tan_y = TAN;
    return camera;
}

typedef struct Soup {
    Polygon *polygons;
    Vec3 *vertices;
    int count;
} Soup;

static Soup soup_new(Arena *arena, int polygons, int corners) {
    Soup soup = {ARENA_ARRAY(arena, Polygon, polygons), ARENA_ARRAY(arena, Vec3, polygons * corners),
                 polygons};
    for (int i = 0; i < polygons; i++) soup.polygons[i] = (Polygon){i * corners, corners, 0};
    return soup;
}

static Vec3 direction(Random *random) {
    double z = random_between(random, -1, 1), a = random_between(random, 0, 2 * M_PI), s = sqrt(1 - z * z);
    return vec3(s * cos(a), s * sin(a), z);
}

// Anywhere in the picture, at any of the depths.
static Vec3 somewhere(Random *random) {
    double x = random_between(random, NEAR, FAR);
    return vec3(x, x * TAN * random_between(random, -1, 1), x * TAN * random_between(random, -1, 1));
}

// A square of area 1 about the origin, turned any way.
static void add_square(Vec3 v[4], Random *random, Vec3 centre, double size) {
    Vec3 n = direction(random), u = vec3_normalize(vec3_cross(n, direction(random))), w = vec3_cross(n, u);
    for (int k = 0; k < 4; k++) {
        Vec3 along = vec3_scale(u, k == 1 || k == 2 ? size / 2 : -size / 2);
        v[k] = vec3_add(centre, vec3_add(along, vec3_scale(w, k >= 2 ? size / 2 : -size / 2)));
    }
}

HiddenViews hidden_views_random(int polygons, double depth, int width, int height, int scenes, uint64_t seed,
                                Arena *arena) {
    HiddenViews views = {ARENA_ARRAY(arena, HiddenView, scenes), scenes};
    for (int s = 0; s < scenes; s++) {
        Random random = {seed + (uint64_t)s};
        Soup soup = soup_new(arena, polygons, 4);
        for (int i = 0; i < polygons; i++) {
            Vec3 centre = somewhere(&random);
            // Seen from a random side a square shows half of its area.
            double size = 2 * TAN * centre.x * sqrt(2 * depth / polygons);
            add_square(soup.vertices + 4 * (size_t)i, &random, centre, size);
        }
        views.views[s] =
            (HiddenView){{soup.polygons, soup.vertices, NULL, polygons}, ahead(width, height), false};
    }
    return views;
}

HiddenViews hidden_views_triangles(int triangles, int width, int height, uint64_t seed, Arena *arena) {
    HiddenViews views = {ARENA_ARRAY(arena, HiddenView, 1), 1};
    Random random = {seed};
    Soup soup = soup_new(arena, triangles, 3);
    for (int i = 0; i < triangles; i++) {
        Vec3 centre = somewhere(&random);
        double area = random_between(&random, 2, 20), pixel = 2 * TAN * centre.x / width;
        // Half base and height of an isosceles one of that area, turned in the picture and leaning up to 45 degrees.
        double half = sqrt(area / 2) * pixel * random_between(&random, 0.7, 1.4),
               high = area * pixel * pixel / half, a = random_between(&random, 0, 2 * M_PI),
               lean = random_between(&random, -1, 1);
        const double at[3][2] = {{-half, -high / 3}, {half, -high / 3}, {0, 2 * high / 3}};
        for (int k = 0; k < 3; k++) {
            double y = cos(a) * at[k][0] - sin(a) * at[k][1], z = sin(a) * at[k][0] + cos(a) * at[k][1];
            soup.vertices[3 * i + k] = vec3_add(centre, vec3(lean * y, y, z));
        }
    }
    views.views[0] =
        (HiddenView){{soup.polygons, soup.vertices, NULL, triangles}, ahead(width, height), false};
    return views;
}

// The polygons of objects, in their order.
static Scene scene_of(const CellGraph *graph, const VisResult *seen, Arena *arena) {
    int *list = ARENA_ARRAY(arena, int, seen->polygon_count + 1), count = 0;
    for (int i = 0; i < seen->object_count; i++) {
        const Object *object = &graph->objects[seen->objects[i]];
        for (int k = 0; k < object->polygon_count; k++) list[count++] = object->first_polygon + k;
    }
    return (Scene){graph->polygons, graph->vertices, list, count};
}

// A scene of the view's own where the building has curved shapes: they are subdivided for it. Adds to `polygons` and `seconds`.
static Scene subdivided(const CellGraph *graph, Scene scene, const Camera *camera, Arena *arena,
                        long *polygons, double *seconds) {
    CurvedScene curved;
    double start = clock_thread_seconds();
    curved_scene_new(graph->building, &scene, graph->polygon_count, graph->vertex_count, camera,
                     CURVED_SCENE_PIXELS, arena, &curved);
    *seconds += clock_thread_seconds() - start;
    *polygons += curved.subdivided;
    return curved.scene;
}

bool hidden_views_building(const char *file, const BenchArguments *a, int frames, Arena *arena,
                           HiddenViews *whole, HiddenViews *culled, Error *error) {
    LoadedScene *scene = ARENA_ARRAY(arena, LoadedScene, 1);
    SceneOptions load = a->load;
    TourOptions options = tour_default_options();
    TourPath path;
    if (!app_load(file, &load, arena, scene, error) || !scene_has_walls(scene, error) ||
        !tour_make(&scene->graph, "auto", &options, arena, &path, error))
        return false;
    VisQuery *query = vis_query_new(&scene->graph, &scene->forest, arena);
    if (frames > path.frame_count) frames = path.frame_count;
    HiddenViews *out[2] = {whole, culled};
    bool curved = scene->building.shape_count > 0;
    long polygons = 0;
    double seconds = 0;
    for (int k = 0; k < 2; k++) {
        *out[k] = (HiddenViews){ARENA_ARRAY(arena, HiddenView, frames), frames};
        for (int i = 0; i < frames; i++) {
            const TourFrame *at = &path.frames[(long)i * path.frame_count / frames];
            Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, a->size[0], a->size[1]);
            Eye eye = walk_eye(&camera);
            bool same = k == 0 && i > 0 && !curved;
            Scene list = same ? whole->views[0].scene : (Scene){0};
            if (!same) {
                int cell = vis_locate(&scene->graph, at->eye, -1);
                VisResult seen = vis_query(query, &eye, cell, NULL, k == 0 ? VIS_NONE : VIS_STAB);
                list = scene_of(&scene->graph, &seen, arena);
            }
            if (curved) list = subdivided(&scene->graph, list, &camera, arena, &polygons, &seconds);
            out[k]->views[i] = (HiddenView){list, camera, same};
        }
    }
    if (curved)
        fprintf(stderr, "%s: curved shapes become %.0f polygons a view, within %g pixels, in %.3f ms\n", file,
                (double)polygons / (2 * frames), CURVED_SCENE_PIXELS, 1e3 * seconds / (2 * frames));
    return true;
}
