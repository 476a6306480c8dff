// fuzz_ifc.c - libFuzzer on the reader of building models: whatever the bytes, it refuses with a sentence, or its meshes are sound.
#include <math.h>
#include <stdlib.h>

#include "maps/ifc/ifc.h"
#include "tests/fuzz/target.h"

enum { LONG_REFUSAL = 500 };

static void check_mesh(const IfcModel *model, const IfcMesh *mesh) {
    for (int i = 0; i < mesh->polygon_count; i++) {
        const IfcPolygon *p = &mesh->polygons[i];
        if (p->corner_count < 3 || p->first_corner < 0 ||
            p->first_corner > mesh->corner_count - p->corner_count)
            abort();
        if (p->material < 0 || p->material >= model->material_count) abort();
    }
    for (int i = 0; i < mesh->corner_count; i++) {
        Vec3 c = mesh->corners[i];
        if (!isfinite(c.x) || !isfinite(c.y) || !isfinite(c.z)) abort();
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    // Few chords: mistakes with rounds show in eight of them, and a sphere of as many as a large radius has takes a second.
    IfcOptions options = {.threads = 1, .circle_chords = size % 16 ? 8 : 24};
    IfcModel model;
    Error error = {""};
    if (!ifc_read("fuzz.ifc", target_bytes(arena, "", data, size), &options, arena, &model, &error)) {
        if (!error.text[0]) abort();
        // A longer text that is refused would mostly stay refused: no shape is ever made of what comes of it.
        if (size > LONG_REFUSAL) target_forget();
        return 0;
    }
    target_count(TARGET_PASSED);
    for (int i = 0; i < model.product_count; i++) {
        const IfcProduct *p = &model.products[i];
        check_mesh(&model, &p->mesh);
        check_mesh(&model, &p->whole_mesh);
        if (p->storey >= model.storey_count || p->space >= model.product_count ||
            p->host >= model.product_count)
            abort();
        if (p->first_footprint < 0 || p->first_footprint + p->footprint_count > model.footprint_count)
            abort();
    }
    return 0;
}
