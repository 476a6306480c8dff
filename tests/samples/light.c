// light.c - a building is lit by radiosity, and the light on its floor sampled: light BUILDING
#include <enfilade/enfilade_light.h>
#include <stdio.h>

int main(int argc, char **argv) {
    EnfArena arena = {0};
    EnfError error = {"usage: light BUILDING"};
    EnfBuilding building;
    EnfVisPrepared ready;
    EnfMesh mesh;
    EnfRadSolution light;
    EnfVisPrepareOptions options = enf_vis_prepare_default_options();
    EnfMeshOptions elements = enf_mesh_default_options();
    EnfRadOptions shooting = enf_rad_default_options();
    if (argc < 2 || !enf_maps_read(argv[1], &arena, &building, &error)) goto failed;
    // Lamps without a face that emits get one.
    enf_lamp_faces_add(&arena, &building);
    if (!enf_vis_prepare(&building, &options, NULL, &arena, &ready, &error)) goto failed;
    // Doors as drawn: NULL.
    if (!enf_mesh_build(&ready.graph, NULL, &elements, &arena, &mesh, &error)) goto failed;
    if (!enf_rad_start(&mesh, &arena, &light, &error)) goto failed;
    EnfRadReport report = enf_rad_shoot(&mesh, &ready.forest, NULL, &shooting, NULL, &light);
    printf("light: %d elements, %lld shots, %.1f W of %.1f W absorbed\n", mesh.element_count, report.shots,
           light.absorbed[0], light.emitted[0]);

    // The light that arrives at points on the floor, W/m^2, red, green and blue: along a line from the start.
    EnfGatherOptions how = enf_gather_default_options();
    EnfGatherScene scene = {&mesh, &ready.forest, NULL, &light, NULL};
    EnfGatherer *gatherer = enf_gatherer_new(&scene, &how, &arena);
    const EnfVec3 up = {0, 0, 1};
    for (int i = 0; i < 4; i++) {
        EnfVec3 at =
            enf_vec3(building.start.x + 0.3 * i, building.start.y, building.start.z - ENF_BODY_EYE + 1e-3);
        EnfViewPoint from = {at, up, enf_gather_cell(&ready.graph, at, up, -1)};
        double arrives[3];
        enf_gather(gatherer, &from, arrives);
        printf("at %.2f,%.2f: %.3f %.3f %.3f\n", at.x, at.y, arrives[0], arrives[1], arrives[2]);
    }
    enf_gatherer_end(gatherer);
    enf_arena_free(&arena);
    return 0;

failed:
    fprintf(stderr, "%s\n", error.text);
    enf_arena_free(&arena);
    return 1;
}
