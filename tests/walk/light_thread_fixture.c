// light_thread_fixture.c - see the header.
#include "tests/walk/light_thread_fixture.h"

#include <criterion/criterion.h>
#include <unistd.h>

#include "engine/scene/light.h"
#include "tests/support/support.h"

void light_thread_check_nap(void) { usleep(500); }
