// plan_textures.c - pictures of materials, and how they lie on walls, floors, ceilings and models.
//
// A picture lies on a surface as paper would that is seen from the surface's front: its own right is to the right, up is up; on floors
// and ceilings its right is +x. The grid of pictures begins at x 0, y 0 and the floor of the storey, so that it goes on from wall to wall
// of one direction and from room to room; on a model it begins where the model stands. Curved shapes have the mean colour.
#include <stdlib.h>

#include "maps/building/texture.h"
#include "maps/plan/plan_file.h"

// Directions of walls are kept apart by a list: beyond so many materials for them, walls have the mean colour.
enum { MOST_LAID = 2000 };

// In Plan.pictures, by ascending material.
typedef struct PlanPicture {
    int material;
    double width, height, angle;  // metres, radians
    Vec2 at;  // of its lower left corner from the beginning of the grid, to the right and up
} PlanPicture;

// The picture in the file, or 0 with a note: of a missing or broken picture the colour that the plan states stays.
static int read_picture(Plan *plan, const char *file) {
    PlanLine *line = &plan->line;
    Bytes bytes;
    Error why = {""};
    Arena scratch = {0};
    int texture = 0;
    for (int i = 1; i < plan->b->texture_count; i++)
        if (strcmp(plan->b->textures[i].name, file) == 0) return i;
    if (soup_read_beside(&plan->beside, file, &scratch, &bytes, &why))
        texture = texture_add(plan->arena, plan->b, file, bytes, &plan->pixels);
    if (texture == 0)
        building_note(plan->arena, plan->b, NOTE_CHANGED, vec3(0, 0, 0),
                      "%s:%d: the texture `%.100s` is left out: %.200s", line->path, line->number, file,
                      *why.text ? why.text : "no PNG, JPEG, BMP or WebP image, or too large or damaged");
    arena_free(&scratch);
    return texture;
}

bool plan_add_picture(Plan *plan, const PlanPaper *paper, Material *material) {
    if (!paper->file) return true;
    if (!(paper->width > 0))
        return plan_fail(&plan->line, "a texture without a width (allowed: width, in metres)");
    int texture = read_picture(plan, paper->file);
    if (texture == 0) return true;
    const Texture *t = &plan->b->textures[texture];
    double height = paper->height > 0 ? paper->height : paper->width * t->height / t->width;
    material->texture = texture;
    material->reflectance = t->mean;
    if (t->opacity < 1) material->alpha *= t->opacity;
    *ARENA_PUSH(plan->arena, plan->pictures, plan->picture_count, plan->picture_capacity) =
        (PlanPicture){-1, paper->width, height, paper->angle, paper->at};
    return true;
}

void plan_name_picture(Plan *plan, int material) {
    if (plan->b->materials[material].texture > 0) plan->pictures[plan->picture_count - 1].material = material;
}

// ---- how they lie

static int by_material(const void *key, const void *picture) {
    return *(const int *)key - ((const PlanPicture *)picture)->material;
}

static const PlanPicture *picture_of(const Plan *plan, int material) {
    if (material < 0 || plan->b->materials[material].texture == 0) return NULL;
    return bsearch(&material, plan->pictures, (size_t)plan->picture_count, sizeof *plan->pictures,
                   by_material);
}

// The map of a picture on surfaces with the normal `n`, whose grid begins at height `floor`.
static TextureMap lie_on(const PlanPicture *p, Vec3 n, double floor) {
    static const double STEEP = 0.7;
    bool level = fabs(n.z) > STEEP;
    Vec3 right = vec3_normalize(level ? vec3_sub(vec3(1, 0, 0), vec3_scale(n, n.x)) : vec3(-n.y, n.x, 0)),
         up = vec3_cross(n, right);
    double c = cos(p->angle), s = sin(p->angle);
    Vec3 along = vec3_add(vec3_scale(right, c), vec3_scale(up, s)),
         across = vec3_sub(vec3_scale(up, c), vec3_scale(right, s));
    TextureMap map = {.u = vec3_scale(along, 1 / p->width), .v = vec3_scale(across, -1 / p->height)};
    map.u0 = -(c * p->at.x + s * p->at.y) / p->width - floor * map.u.z;
    map.v0 = (c * p->at.y - s * p->at.x) / p->height - floor * map.v.z;
    return map;
}

void plan_lay_on_polygons(Plan *plan, Building *of, int first, double floor) {
    if (plan->picture_count == 0) return;
    Arena scratch = {0};
    bool *curved = ARENA_ARRAY(&scratch, bool, of->polygon_count + 1);
    for (int i = 0; i < of->shape_count; i++)
        for (int k = 0; k < of->shapes[i].polygon_count; k++) curved[of->shapes[i].first_polygon + k] = true;
    for (int i = first; i < of->polygon_count; i++) {
        Polygon *polygon = &of->polygons[i];
        const PlanPicture *p = picture_of(plan, polygon->material);
        if (!p || polygon->texture_map > 0 || curved[i]) continue;
        Vec3 n = plane_of_polygon(of->vertices + polygon->first_vertex, polygon->vertex_count).n;
        polygon->texture_map = building_add_texture_map(plan->arena, of, lie_on(p, n, floor));
    }
    arena_free(&scratch);
}

// The material with this picture laid on surfaces of one direction; as many as there are of those. `map` was found by lie_on.
static int laid_material(Plan *plan, int material, Vec3 n, double floor) {
    const PlanPicture *p = picture_of(plan, material);
    if (!p) return material;
    Building *b = plan->b;
    TextureMap map = lie_on(p, n, floor);
    for (int i = 0; i < plan->laid_count; i++) {
        const Material *m = &b->materials[plan->laid[i].material];
        const TextureMap *known = &b->texture_maps[m->texture_map];
        if (plan->laid[i].of == material && memcmp(known, &map, sizeof map) == 0)
            return plan->laid[i].material;
    }
    if (plan->laid_count == MOST_LAID) return material;
    Material made = b->materials[material];
    made.texture_map = building_add_texture_map(plan->arena, b, map);
    int index = b->material_count;
    *ARENA_PUSH(plan->arena, b->materials, b->material_count, b->material_capacity) = made;
    *ARENA_PUSH(plan->arena, plan->laid, plan->laid_count, plan->laid_capacity) = (PlanLaid){material, index};
    return index;
}

static double floor_under(const Plan *plan, int storey) {
    return storey >= 0 ? plan->b->storeys[storey].floor : plan->sketch.ground;
}

void plan_lay_textures(Plan *plan) {
    Building *b = plan->b;
    if (plan->picture_count == 0) return;
    for (int i = 0; i < b->region_count; i++) {
        Region *r = &b->regions[i];
        double floor = floor_under(plan, r->storey);
        r->floor_material = laid_material(plan, r->floor_material, vec3(0, 0, 1), floor);
        r->ceiling_material = laid_material(plan, r->ceiling_material, vec3(0, 0, -1), floor);
        for (int k = 0; k < r->ring_count; k++) {
            const Ring *ring = &b->rings[r->first_ring + k];
            for (int e = 0; e < ring->point_count; e++) {
                int at = ring->first_point + e, next = ring->first_point + (e + 1) % ring->point_count;
                Vec2 d = vec2_sub(b->points[next], b->points[at]);
                double length = vec2_length(d);
                if (length > 0)
                    b->edge_material[at] = laid_material(plan, b->edge_material[at],
                                                         vec3(-d.y / length, d.x / length, 0), floor);
            }
        }
    }
    for (int i = 0; i < b->inlay_count; i++)
        b->inlays[i].material = laid_material(plan, b->inlays[i].material, vec3(0, 0, 1), 0);
    plan_lay_on_polygons(plan, b, 0, 0);
}
