// budget.h - how much memory a building may take: while it is opened as much as fits its file, then a share of the machine's, or
// as much as the user gives.
#ifndef SCENE_BUDGET_H
#define SCENE_BUDGET_H

#include <stdbool.h>
#include <stddef.h>

// While a building is opened, from here on. `given`: bytes, 0: none were given. `gentle`: more is left to memory_within, for
// there is a building to go back to. `file` lasts.
void budget_open(const char *file, size_t given, bool gentle);
// While something is done with the building (`work`: "baking"), from here on.
void budget_work(const char *file, size_t given, const char *work);

#endif
