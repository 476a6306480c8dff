// light_thread_fixture.h - bakes beside a walk.
#ifndef TESTS_LIGHT_THREAD_FIXTURE_H
#define TESTS_LIGHT_THREAD_FIXTURE_H

#include "engine/scene/light.h"
#include "tests/support/support.h"

void light_thread_check_nap(void);

#endif
