// progress.h - how a long stage tells its caller how far it is. Stages never print.
#ifndef CORE_PROGRESS_H
#define CORE_PROGRESS_H

#include <stdbool.h>

// The receiver of progress reports. With a NULL Progress or a NULL `report` nothing is reported and no stage is asked to stop.
typedef struct Progress {
    // Called now and then, from one thread at a time; `done` in [0, 1]. Returns false to ask the stage to stop.
    bool (*report)(void *context, const char *stage, double done);
    void *context;
} Progress;

// Reports to the caller of a stage; returns false if the stage is to stop.
static inline bool progress_report(const Progress *progress, const char *stage, double done) {
    return !progress || !progress->report || progress->report(progress->context, stage, done);
}

#endif
