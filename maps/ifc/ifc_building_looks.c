// ifc_building_looks.c - the names of products, for sentences and for what is shown; and styles as materials.
#include <math.h>
#include <string.h>

#include "maps/ifc/ifc_building.h"

// Glass whose style is opaque, and a share below which nothing is seen of a polygon.
static const float GLASS_ALPHA = 0.3f, CLEAREST = 0.05f;

const char *ifc_name(const IfcPlan *p, int product) {
    const IfcProduct *it = &p->model->products[product];
    const char *number = it->name, *name = it->long_name;
    if (it->kind != IFC_SPACE || !*name || strcmp(name, number) == 0) return *number ? number : name;
    return *number ? arena_format(p->arena, "%s %s", number, name) : name;
}

const char *ifc_place(const IfcPlan *p, int product) {
    const IfcProduct *it = &p->model->products[product];
    const char *kind = it->kind == IFC_OTHER || it->kind == IFC_UNBUILT ? it->type : ifc_kind_name(it->kind),
               *name = ifc_name(p, product);
    return *name ? arena_format(p->arena, "#%d %s `%.80s`", it->entity, kind, name)
                 : arena_format(p->arena, "#%d %s", it->entity, kind);
}

// ---- materials

static int channel(float c) { return (int)lrintf(fminf(fmaxf(c, 0), 1) * 255); }

static bool is_glass(const char *name) {
    static const char *const WORDS[] = {"glas", "verre", "vetro", "vidrio", "cristal", NULL};
    for (int i = 0; WORDS[i]; i++)
        if (strcasestr(name, WORDS[i])) return true;
    return false;
}

int ifc_material(IfcPlan *p, int material, int otherwise) {
    if (material <= 0) return otherwise;
    if (p->material[material] >= 0) return p->material[material];
    const IfcMaterial *m = &p->model->materials[material];
    unsigned rgb = 0;
    for (int i = 0; i < 3; i++) rgb = rgb << 8 | (unsigned)channel(m->colour[i]);
    Material out = {.name = arena_string(p->arena, m->name),
                    .reflectance = maps_colour(rgb),
                    .alpha = fminf(fmaxf(m->alpha, CLEAREST), 1)};
    if (out.alpha > 0.99f) out.alpha = 1;
    if (out.alpha == 1 && is_glass(m->name)) out.alpha = GLASS_ALPHA;
    return p->material[material] = building_add_material(p->arena, p->b, out);
}
