// test_walk_light.c - what was baked for another building is passed over or refused.
#include <criterion/criterion.h>

#include "tests/support/support.h"

Test(walk_light, light_of_another_building_is_passed_over_or_refused, .timeout = 120) {
    Arena arena = {0};
    char *folder = support_folder(&arena), *output;
    const char *build = support_build();
    cr_assert_eq(support_run(&arena, NULL,
                             "export XDG_CACHE_HOME=%s && cp build/maps/two-rooms.plan %s/a.plan && "
                             "%s/enfilade bake %s/a.plan -o %s/a.rad --shots 50",
                             folder, folder, build, folder, folder),
                 0);
    const char *walk =
        "export XDG_CACHE_HOME=%s && %s/enfilade walk %s/a.plan --offscreen %s/frames --every 1000 "
        "--size 64x48 %s";
    int code = support_run(&arena, &output, walk, folder, build, folder, folder, "");
    cr_expect(code == 0 && !strstr(output, "passed over"), "%s", output);
    cr_expect_eq(support_run(&arena, NULL, "echo '# other' >> %s/a.plan", folder), 0);
    code = support_run(&arena, &output, walk, folder, build, folder, folder, "");
    cr_expect(code == 0 && strstr(output, "passed over"), "%s", output);
    code = support_run(&arena, &output, walk, folder, build, folder, folder,
                       arena_format(&arena, "--light %s/a.rad", folder));
    cr_expect(code == 1 && strstr(output, "a.rad"), "%s", output);
    code = support_run(&arena, &output, walk, folder, build, folder, folder, "--look baked");
    cr_expect(code == 1 && strstr(output, "no light"), "%s", output);
    arena_free(&arena);
}
