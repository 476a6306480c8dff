// row.h - how methods sum a row: the shares of elements are added in any order.
#ifndef RADIOSITY_ROW_H
#define RADIOSITY_ROW_H

#include "radiosity/factors/form_factor.h"

struct RowSum {
    const Mesh *mesh;
    double *share;  // [element_count] 0 but for the elements in `touched`
    int *touched;   // [element_count + 1] indices of elements
    int touched_count;
    double back, escaped, sky, sky_light, ground_light;  // as in Row, before they are scaled
    const Daylight *day;                                 // NULL: an even sky
    const Panes *panes;                                  // NULL: none
    SkyCollector *collector;                             // of the sky; NULL: its parts are not asked for
    SkyPart *sky_part;                                   // [SKY_PARTS_MOST]
    int shift;                                           // of the samples, as in form_factor_row_shifted
    Row row;
    uint64_t *marked;       // [word_count] scratch: a bit for each element
    struct RowFace *faces;  // [face_count] scratch: the faces of the view
    int word_count;
    unsigned stamp;
};

void row_start(RowSum *sum, const Mesh *mesh, Arena *arena);
// The sky of rows is that of the options.
void row_start_sky(RowSum *sum, const FormFactorOptions *options, Arena *arena);
static inline void row_add(RowSum *sum, int element, double share) {
    // Written without a branch, because a branch would wait for the share to come from far memory.
    sum->touched[sum->touched_count] = element;
    sum->touched_count += sum->share[element] == 0;
    sum->share[element] += share;
}
// The direction of a sample, a unit vector of the building.
Vec3 row_direction(const View *view, const FormFactorSamples *samples, int i);
// A share that meets nothing along a unit direction from the view's eye.
void row_escape(RowSum *sum, const View *view, double share, Vec3 direction);
// Returns the row, with its elements in increasing order, and empties the sum. Shares are divided by their total, so that they
// sum to 1.
const Row *row_finish(RowSum *sum);

// Adds the weight of each sample to the element that it meets. `item` [samples->count] is the face that each sample sees, as an
// index of view->faces; -1: none, and the weight escapes.
void row_of_items(RowSum *sum, const View *view, const FormFactorSamples *samples, const int32_t *item);

// The element that each sample meets, into `out` [samples->count]; -1: it meets a back, or nothing.
void row_elements(RowSum *sum, const View *view, const FormFactorSamples *samples, const int32_t *item,
                  int *out);

#endif
