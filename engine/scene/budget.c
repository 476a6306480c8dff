// budget.c - see the header; the constants stand here.
#include "engine/scene/budget.h"

#include <stdio.h>
#include <unistd.h>

#include "engine/core/memory.h"

// The memory that opening a building may take: OPENING_BASE for OPENING_COVERED bytes of files, all files that the building refers
// to included, so that the program stays below a gigabyte together with the memory of libraries; and OPENING_PER_BYTE for each byte
// beyond. The sets of visible cells grow fastest, with the square of their number: a plan of 2.6 MB, 60,000 rooms, takes 2.8 GB.
static const size_t OPENING_BASE = (size_t)768 << 20, OPENING_COVERED = (size_t)1 << 20;
enum { OPENING_PER_BYTE = 2048 };
// Share of the machine's memory for work with the building.
static const double SHARE = 0.75;

// The lesser of the machine's memory and of the memory that this process may use (cgroups 2 and 1).
static size_t machine_memory(void) {
    size_t least = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE);
    const char *const groups[] = {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"};
    for (int i = 0; i < 2; i++) {
        unsigned long long limit;
        FILE *file = fopen(groups[i], "re");
        if (file && fscanf(file, "%llu", &limit) == 1 && limit < least) least = (size_t)limit;
        if (file) fclose(file);
    }
    return least;
}

static size_t working_limit(size_t given) {
    return given > 0 ? given : (size_t)(SHARE * (double)machine_memory());
}

static void set_budget(const char *file, const MemoryBudget *limits, const char *stage) {
    MemoryBudget budget = *limits;
    budget.file = file;
    budget.remedy = "--memory MB allows more";
    memory_set_budget(&budget);
    memory_set_stage(stage);
}

void budget_open(const char *file, size_t given, bool gentle) {
    size_t most = working_limit(given);
    MemoryBudget budget = {.base = given, .most = most, .granted = given, .gentle = gentle, .fence = !gentle};
    if (given == 0) {
        budget.base = memory_used() + OPENING_BASE;
        budget.covered = OPENING_COVERED;
        budget.per_byte = OPENING_PER_BYTE;
    } else if (gentle) {
        budget.base = most / 4 * 3;
    }
    set_budget(file, &budget, "reading");
}

void budget_work(const char *file, size_t given, const char *work) {
    size_t most = working_limit(given);
    set_budget(file, &(MemoryBudget){.base = most, .most = most}, work);
}
