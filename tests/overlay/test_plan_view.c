// test_plan_view.c - the plan of the storey about the eye.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "tests/overlay/overlay_fixture.h"
#include "visibility/prepare/figure.h"

// ---- the plan

// Draws the plan over the whole canvas, ten points to the metre, with the eye in the middle.
static void draw_plan(Canvas *c, const PlanView *view) {
    double x = c->width / 20.0, y = c->height / 20.0;
    Vec3 reach = {x, y, 0};
    Box area = {vec3_sub(view->eye, reach), vec3_add(view->eye, reach)};
    Arena scratch = {0};
    overlay_check_canvas_begin(c, 1);
    OverlayMap map = overlay_map(c->overlay, area, 0, 0, c->width, c->height);
    Draw draw = overlay_map_draw(&map);
    plan_view_draw(view, area, 1 / map.scale, &scratch, &draw);
    overlay_check_canvas_end(c);
    arena_free(&scratch);
}

// The wedge points along yaw, north up: 22 points ahead of the eye it is drawn, to the side and behind it is not.
Test(plan_view, wedge_points_along_yaw) {
    Canvas c;
    overlay_check_canvas_open(&c, 160, 160);
    Home h;
    overlay_check_open_home(&h, &c.arena, "build/maps/house.plan");
    for (int i = 0; i < 12; i++) {
        double yaw = i * M_PI / 6;
        PlanView view = overlay_check_view_from(&h, vec3(3, 3, 1.6), yaw), blind = view;
        blind.fov = 0;  // nothing but rays along yaw
        blind.yaw = yaw + M_PI;
        uint8_t *ahead = ARENA_ARRAY(&c.arena, uint8_t, 160 * 160 * 4);
        draw_plan(&c, &view);
        memcpy(ahead, c.rgba, 160 * 160 * 4);
        draw_plan(&c, &blind);
        for (int turn = 0; turn < 4; turn++) {
            double angle = yaw + turn * M_PI / 2, x = 80 + 22 * cos(angle), y = 80 - 22 * sin(angle);
            const uint8_t *plain = overlay_check_pixel(&c, x, y), *p = ahead + (plain - c.rgba);
            if (turn == 2) continue;  // there lie the rays of the other
            bool changed = abs(p[0] - plain[0]) + abs(p[1] - plain[1]) + abs(p[2] - plain[2]) > 20;
            cr_expect_eq(changed, turn == 0, "yaw %g, %d quarters from ahead: %d,%d,%d for %d,%d,%d", yaw,
                         turn, p[0], p[1], p[2], plain[0], plain[1], plain[2]);
        }
    }
    overlay_check_canvas_close(&c);
}

// Cells in view are blue and others are not; the eye's cell is orange; leaves are where doors stand, in their colours.
Test(plan_view, shows_cells_and_doors) {
    Canvas c;
    overlay_check_canvas_open(&c, 260, 260);
    Home h;
    overlay_check_open_home(&h, &c.arena, "build/maps/two-rooms.plan");
    const Building *b = &h.building;
    int door = 0;
    while (door < b->opening_count && b->openings[door].kind != OPENING_DOOR) door++;
    cr_assert_lt(door, b->opening_count);
    float *open = ARENA_ARRAY(&c.arena, float, b->opening_count);
    int other = -1;
    Vec3 eye = vec3(1, 1, 1.5);
    PlanView view = overlay_check_view_from(&h, eye, 4);
    for (int i = 0; i < h.graph.cell_count; i++) {
        if (i != view.cell && b->regions[h.graph.cells[i].region].kind == REGION_ROOM) other = i;
    }
    cr_assert(other >= 0);
    VisibleCell seen = {.cell = other, .distance = 1};
    VisResult visible = {.cells = &seen, .cell_count = 1};
    Box box = h.graph.cells[other].box;
    // A corner of the other room, away from names; and one beside the eye, outside its wedge.
    Vec2 there = {box.min.x + 0.25 - eye.x, box.min.y + 0.25 - eye.y};
    for (int i = 0; i < 2; i++) {
        view.visible = i ? &visible : NULL;
        draw_plan(&c, &view);
        const uint8_t *p = overlay_check_pixel(&c, 130 + 10 * there.x, 130 - 10 * there.y),
                      *mine = overlay_check_pixel(&c, 136, 124);
        cr_expect_eq(p[2] > p[0] + 80, i == 1, "the other room is %d,%d,%d", p[0], p[1], p[2]);
        cr_expect(mine[0] > mine[2] + 80, "the eye's cell is %d,%d,%d", mine[0], mine[1], mine[2]);
    }
    view.door_open = open;
    const Leaf *leaf = &b->leaves[b->openings[door].first_leaf];
    for (int i = 0; i < 3; i++) {
        open[door] = (float)(i * 0.5);
        draw_plan(&c, &view);
        Vec2 corner[4];
        leaf_box(leaf, open[door], corner);
        Vec2 at = vec2_sub(vec2_scale(vec2_add(corner[1], corner[3]), 0.5), vec2(eye.x, eye.y));
        const uint8_t *p = overlay_check_pixel(&c, 130 + 10 * at.x, 130 - 10 * at.y);
        bool red = p[0] > 180 && p[1]<130, amber = p[0]> 180 && p[1] >= 130, green = p[1] > 150 && p[0] < 160;
        cr_expect(i == 0   ? red
                  : i == 1 ? amber
                           : green,
                  "open by %g: %d,%d,%d", (double)open[door], p[0], p[1], p[2]);
    }
    overlay_check_canvas_close(&c);
}

// The tree is drawn from the eye on, through the middles of the portals of its first level.
Test(plan_view, shows_the_tree) {
    Canvas c;
    overlay_check_canvas_open(&c, 300, 300);
    Home h;
    overlay_check_open_home(&h, &c.arena, "build/maps/house.plan");
    PlanView view = overlay_check_view_from(&h, vec3(3, 3, 1.6), 0);
    int checked = 0, root = h.forest.root[view.cell];
    view.forest = &h.forest;
    draw_plan(&c, &view);
    for (int child = root + 1; child >= 0 && child < h.forest.root[view.cell + 1];
         child = h.forest.nodes[child].next) {
        const Portal *portal = &h.graph.portals[h.forest.nodes[child].portal];
        const Vec3 *v = h.graph.portal_vertices + portal->first_vertex;
        if (portal->horizontal || v[0].z > 1.2 || v[1].z < 1.2) continue;
        Vec2 middle = vec2_scale(vec2_add(portal->left, portal->right), 0.5);
        Vec2 at =
            vec2_scale(vec2_sub(middle, vec2(view.eye.x, view.eye.y)), 0.8 * 10);  // past the wedge's tip
        const uint8_t *p = overlay_check_pixel(&c, 150 + at.x, 150 - at.y);
        cr_expect(p[0] > 180 && p[1] > 150 && p[2] < 140, "on the way to portal %d: %d,%d,%d",
                  h.forest.nodes[child].portal, p[0], p[1], p[2]);
        checked++;
    }
    cr_expect_gt(checked, 2);
    overlay_check_canvas_close(&c);
}

// The storey is that of the room, and outdoors that at the height of the eye. The area holds the eye, the rooms of the
// storey and no more than asked for.
Test(plan_view, shows_the_storey_around_the_eye) {
    Arena arena = {0};
    Home h;
    overlay_check_open_home(&h, &arena, "build/maps/house.plan");
    cr_expect_eq(overlay_check_view_from(&h, vec3(3, 3, 1.6), 0).storey, 0);
    cr_expect_eq(overlay_check_view_from(&h, vec3(3, 3, 4.5), 0).storey, 1);
    cr_expect_eq(overlay_check_view_from(&h, vec3(3, -5, 1.6), 0).storey, 0);
    cr_expect_eq(overlay_check_view_from(&h, vec3(3, -5, 4.5), 0).storey, 1);
    cr_expect_eq(overlay_check_view_from(&h, vec3(3, -5, -0.1), 0).storey, 0);
    PlanView view = overlay_check_view_from(&h, vec3(3, 3, 1.6), 0);
    Box whole = plan_view_area(&view, 1000);
    cr_expect(whole.min.x < 0 && whole.max.x > 13 && whole.min.y < 0 && whole.max.y > 10.6);
    cr_expect(whole.max.x - whole.min.x < 17 && whole.max.y - whole.min.y < 15, "the garden is not wanted");
    Random random = {8};
    for (int i = 0; i < 200; i++) {
        view.eye = vec3(40 * random_unit(&random) - 12, 40 * random_unit(&random) - 12, 1.6);
        double most = 4 + 12 * random_unit(&random);
        Box area = plan_view_area(&view, most);
        cr_expect(area.max.x - area.min.x <= most + 1e-9 && area.max.y - area.min.y <= most + 1e-9);
        cr_expect(area.min.x <= view.eye.x && view.eye.x <= area.max.x && area.min.y <= view.eye.y &&
                  view.eye.y <= area.max.y);
    }
    arena_free(&arena);
}

// A place for a name is inside the region and the area with all its outline; and one is found where there is room.
Test(figure, names_stay_in_their_rooms) {
    Arena arena = {0};
    Home h;
    overlay_check_open_home(&h, &arena, "build/maps/house.plan");
    Random random = {2};
    int found = 0;
    for (int i = 0; i < 4000; i++) {
        int r = random_index(&random, h.building.region_count);
        if (h.building.regions[r].kind != REGION_ROOM) continue;
        double width = 0.2 + 3 * random_unit(&random), height = 0.1 + 2 * random_unit(&random);
        double left = -5 + 17 * random_unit(&random), low = -5 + 14 * random_unit(&random);
        Box area = {{left, low, 0}, {left + 9, low + 9, 0}};
        Vec2 at;
        if (!figure_name_place(&h.building, r, area, width, height, &at)) continue;
        found++;
        double z = (h.building.regions[r].z0 + h.building.regions[r].z1) / 2;
        for (int k = 0; k < 9; k++) {
            // A millimetre within, where all is decided.
            Vec3 p = {at.x + (k % 3 - 1) * (width / 2 - 0.001), at.y + (k / 3 - 1) * (height / 2 - 0.001), z};
            int cell = vis_locate(&h.graph, p, -1);
            cr_assert(cell >= 0 && h.graph.cells[cell].region == r, "region %d: (%g, %g) is outside", r, p.x,
                      p.y);
            cr_assert(p.x >= area.min.x && p.x <= area.max.x && p.y >= area.min.y && p.y <= area.max.y);
        }
    }
    cr_expect_gt(found, 100, "%d places found", found);
    arena_free(&arena);
}

// The same of a room with a corner cut out, where a rectangle can lie across the cut with its middle inside.
Test(figure, names_stay_in_crooked_rooms) {
    Vec2 points[] = {{0, 0}, {4, 0}, {4, 1.5}, {1.5, 1.5}, {1.5, 4}, {0, 4}};
    Ring ring = {.first_point = 0, .point_count = 6};
    Region region = {.kind = REGION_ROOM, .ring_count = 1};
    Building building = {.regions = &region, .rings = &ring, .points = points};
    Random random = {4};
    int found = 0;
    for (int i = 0; i < 5000; i++) {
        double width = 0.1 + 2 * random_unit(&random), height = 0.1 + 2 * random_unit(&random);
        Vec2 low = {3 * random_unit(&random) - 1, 3 * random_unit(&random) - 1};
        Box area = {{low.x, low.y, 0}, {low.x + 3.5, low.y + 3.5, 0}};
        Vec2 at;
        if (!figure_name_place(&building, 0, area, width, height, &at)) continue;
        found++;
        Vec2 far = {at.x + width / 2 - 1e-9, at.y + height / 2 - 1e-9};
        bool inside = at.x - width / 2 > -1e-9 && at.y - height / 2 > -1e-9 && far.x < 4 && far.y < 4;
        cr_assert(inside && (far.x < 1.5 || far.y < 1.5), "%g x %g m at (%g, %g)", width, height, at.x, at.y);
    }
    cr_expect_gt(found, 1000, "%d places found", found);
}
