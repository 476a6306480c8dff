// ifc_building_looks.c - the names of products, for sentences and for what is shown; and styles as materials.
#include <math.h>
#include <string.h>

#include "maps/building/texture.h"
#include "maps/ifc_building/ifc_building.h"

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

// The building's texture of a picture, decoded once; 0: it cannot be used, which is noted.
static int picture_of(IfcPlan *p, int texture) {
    const IfcTexture *t = &p->model->textures[texture];
    if (p->texture[texture] >= 0) return p->texture[texture];
    const char *name = t->file ? arena_string(p->arena, t->file) : arena_format(p->arena, "#%d", t->entity);
    Bytes image = t->image;
    Error why = {""};
    int made = 0;
    if (t->file && !soup_read_beside(&p->beside, t->file, &p->scratch, &image, &why)) {
        building_note(p->arena, p->b, NOTE_DROPPED, vec3(0, 0, 0),
                      "#%d: its picture `%.80s` cannot be read: %.200s", t->entity, t->file, why.text);
    } else {
        made = t->pixels ? texture_add_pixels(p->arena, p->b, name, t->width, t->height, t->pixels)
                         : texture_add(p->arena, p->b, name, image, &p->pixels);
        if (!made)
            building_note(
                p->arena, p->b, NOTE_DROPPED, vec3(0, 0, 0),
                "#%d: its picture is damaged, too large, or none that is read (PNG, JPEG, BMP, WebP)",
                t->entity);
    }
    p->b->hash = p->beside.hash;
    return p->texture[texture] = made;
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
    if (m->texture > 0) {
        int texture = picture_of(p, m->texture);
        if (texture > 0) texture_put(p->b, texture, &out);
        p->pictured[material] = building_add_material(p->arena, p->b, out);
        // Where no picture lies on a polygon, its mean shows.
        out.texture = 0;
    }
    return p->material[material] = building_add_material(p->arena, p->b, out);
}

int ifc_pictured(IfcPlan *p, int material, int otherwise) {
    int plain = ifc_material(p, material, otherwise);
    return material > 0 && p->pictured[material] >= 0 ? p->pictured[material] : plain;
}
