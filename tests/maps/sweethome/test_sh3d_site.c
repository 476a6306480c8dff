// test_sh3d_site.c - the place of a home, its north, its hour, and the zone of its clock.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "tests/support/files/home_fixture.h"

#define COMPASS(attributes) "<compass x='0' y='0' diameter='100' " attributes "/>"
#define CAMERA(time)                                                                                         \
    "<observerCamera attribute='observerCamera' x='0' y='0' z='170' yaw='0' pitch='0' " time "/>"

// Proves that place, north and hour are those of the file, in radians and hours: 1492171200000 ms after 1970 began is noon on 2017-04-14,
// and -1 ms is a moment before midnight.
Test(sh3d, reads_place_and_hour) {
    Home h = home_of(
        HOME_ROOM COMPASS("northDirection='3.5' longitude='0.0407' latitude='0.8529' timeZone='none/such'")
            CAMERA("time='1492171200000'"));
    cr_assert(h.good, "%s", h.error.text);
    const Site *site = &h.b.site;
    cr_expect(site->placed && site->latitude == 0.8529 && site->longitude == 0.0407 && site->north == 3.5);
    cr_expect(site->date[0] == 2017 && site->date[1] == 4 && site->date[2] == 14);
    cr_expect_float_eq(site->hour, 12, 1e-9);
    cr_expect_not(site->zoned, "a zone that there is not");
    home_free(&h);
    h = home_of(HOME_ROOM CAMERA("time='-1'") COMPASS("northDirection='1'"));
    cr_expect(h.good && !h.b.site.placed && h.b.site.north == 1 && h.b.site.date[0] == 1969 &&
              h.b.site.date[2] == 31);
    cr_expect(h.b.site.hour > 23.99 && h.b.site.hour < 24);
    home_free(&h);
    h = home_of(HOME_ROOM CAMERA(""));
    cr_expect(h.good && !h.b.site.placed && h.b.site.date[0] == 0, "nothing is known");
    home_free(&h);
}

// Proves that places and hours out of range are named.
Test(sh3d, names_faults_of_the_site) {
    static const char *const CASES[][2] = {
        {COMPASS("latitude='2' longitude='0'"),
         "compass has latitude='2' (a number from -1.5708 to 1.5708 is allowed)"},
        {COMPASS("latitude='0' longitude='x'"), "compass has longitude='x'"},
        {COMPASS("northDirection='inf'"), "compass has northDirection='inf'"},
        {CAMERA("time='1e300'"), "observerCamera has time='1e300'"}};
    for (int i = 0; i < 4; i++) {
        Home h = home_of(HOME_ROOM "%s", CASES[i][0]);
        cr_expect_not(h.good);
        cr_expect(strstr(h.error.text, CASES[i][1]), "%s", h.error.text);
        home_free(&h);
    }
}

// ---- zones

static int put(unsigned char *at, long long value, int bytes) {
    for (int i = 0; i < bytes; i++) at[i] = (unsigned char)(value >> (8 * (bytes - 1 - i)));
    return bytes;
}

// A zone of an hour, in summer (from 1000 h to 2000 h after 1970 began) of two hours, with this footer: an empty old block, then ours.
static size_t make_zone(unsigned char *out, const char *footer) {
    size_t size = 0;
    for (int block = 0; block < 2; block++) {
        memset(out + size, 0, 44);
        memcpy(out + size, "TZif2", 5);
        if (block) put(out + size + 32, 2, 4), put(out + size + 36, 2, 4);
        size += 44;
    }
    size += (size_t)put(out + size, 1000 * 3600, 8);
    size += (size_t)put(out + size, 2000 * 3600, 8);
    out[size++] = 1, out[size++] = 0;
    for (int summer = 0; summer < 2; summer++) {
        size += (size_t)put(out + size, 3600 * (1 + summer), 4);
        size += (size_t)put(out + size, summer << 8, 2);
    }
    return size + (size_t)sprintf((char *)out + size, "\n%s\n", footer);
}

// Proves that the hour shown by the clock, not that of UTC, chooses between winter and summer; that after the last change a zone without
// rules stays as it is, and one with rules is not known; and that no damaged file is read beyond its end (the sanitizers watch).
Test(sh3d, zones) {
    unsigned char file[256];
    double hours = 0;
    Bytes zone = {file, make_zone(file, "X-1")};
    cr_expect(sh3d_zone_ahead(zone, 900 * 3600, &hours) && hours == 1);
    cr_expect(sh3d_zone_ahead(zone, 1500 * 3600, &hours) && hours == 2);
    cr_expect(sh3d_zone_ahead(zone, 1000.5 * 3600, &hours) && hours == 1,
              "half an hour before summer begins");
    cr_expect(sh3d_zone_ahead(zone, 2500 * 3600, &hours) && hours == 1);
    cr_expect(sh3d_zone_ahead(zone, -5e9, &hours) && hours == 1);
    for (size_t size = 0; size < zone.size - 5; size++) {
        Arena arena = {0};
        Bytes part = {memcpy(arena_alloc(&arena, size + 1, 1), file, size), size};
        sh3d_zone_ahead(part, 900 * 3600, &hours);
        arena_free(&arena);
    }
    file[44 + 36 + 3] = 1;
    cr_expect_not(sh3d_zone_ahead(zone, 1500 * 3600, &hours), "a kind of hour that the file does not have");
    zone.size = make_zone(file, "X-1Y,M3.5.0,M10.5.0");
    cr_expect(sh3d_zone_ahead(zone, 1500 * 3600, &hours) && hours == 2);
    cr_expect_not(sh3d_zone_ahead(zone, 2500 * 3600, &hours));
}

// Proves that the system's zones are found where there are any, and that a name leads nowhere else: noon of 14 April 2017 in Paris is ten
// o'clock UTC.
Test(sh3d, zones_of_the_system) {
    double hours = 0, noon = 1492171200;
    cr_expect_not(sh3d_zone_find("../../../etc/passwd", noon, &hours));
    cr_expect_not(sh3d_zone_find("/etc/localtime", noon, &hours));
    cr_expect_not(sh3d_zone_find("", noon, &hours));
    if (access("/usr/share/zoneinfo/Europe/Paris", R_OK) != 0) cr_skip_test("there are no zones here");
    cr_expect(sh3d_zone_find("Europe/Paris", noon, &hours) && hours == 2, "%g", hours);
    cr_expect(sh3d_zone_find("Europe/Paris", noon + 250 * 86400.0, &hours) && hours == 1, "%g", hours);
}
