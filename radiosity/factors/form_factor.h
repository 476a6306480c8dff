// form_factor.h - the row of form factors of a point: which share of the light that leaves the point diffusely arrives at which
// element.
//
// A projective method is a set of directions with weights that sum to 1 and the face seen along each direction (its item); the
// element is the one at the point where the direction meets the face. Other methods make rows in ways of their own.
#ifndef RADIOSITY_FORM_FACTOR_H
#define RADIOSITY_FORM_FACTOR_H

#include "radiosity/daylight/daylight.h"
#include "radiosity/factors/sky_parts.h"
#include "radiosity/factors/view.h"

enum { FORM_FACTOR_FINEST = 2000 };

typedef struct FaceLines FaceLines;  // lines.h

// How fine the samples of a method are.
typedef struct FormFactorOptions {
    int resolution;  // pixels across the hemicube's top or the hemisphere's base, 8 .. FORM_FACTOR_FINEST; lines of scan-line
        // methods; rays across for the method `ray`
    double edge_threshold;  // of hemisphere-polyline: an edge is cut until its parts span less, radians
    const char *hidden;     // of hemicube: the hidden-surface method that fills its sides; NULL: its own
    // From lines_of_mesh, for callers with several methods on one mesh; NULL: the method finds them
    const FaceLines *lines;
    const Daylight *day;  // whose sky Row.sky_light is of; NULL: an even one
    const Panes *panes;   // of glass, which weaken Row.sky_light and Row.ground_light; NULL: none
    bool sky_parts;       // rows tell Row.sky_part
    // Rows may be asked for with shifted samples; rad_shoot gives neighbours different ones. Errors of many patches cancel, as at
    // points of a room. One row errs more: where few patches light all, as in a slit of a centimetre, shown light is farther off.
    bool shifts;
} FormFactorOptions;
// A resolution of 100, edges cut at one degree.
FormFactorOptions form_factor_default_options(void);

// One row. All numbers are shares of the light that leaves the point: `back` falls on the backs of faces, `escaped` meets nothing.
typedef struct Row {
    int count;
    int *element;   // [count] increasing
    float *factor;  // [count] above 0; their sum plus `back` plus `escaped` is 1
    double back, escaped;
    // The part of `escaped` that goes upwards in building space, to the sky. Projective methods, `ray` and `analytic` compute it;
    // in the rows of other methods it is 0.
    double sky;
    // The same part, each share times the radiance that the sky of the options' day has along it, over that overhead; and the other part
    // of `escaped`, which goes to the ground. Both as the options' panes let them through. Projective methods compute them; in the rows of
    // other methods they are 0.
    double sky_light, ground_light;
    // [sky_part_count] what `sky_light` comes from, about, where the options ask for it: their shares are right but for one factor
    // (sky_parts_fit)
    const SkyPart *sky_part;
    int sky_part_count;
} Row;

// The work done, for tables.
typedef struct FormFactorWork {
    long long faces_drawn, elements_drawn;  // faces in the views; the elements of these faces (Oki's count)
    long long samples, tests;               // samples or crossings found; edge, box or ray tests made
} FormFactorWork;

// The directions of a projective method.
typedef struct FormFactorSamples {
    int count;
    float *x, *y, *z;  // [count] unit directions in the view's axes
    float *weight;     // [count] sum 1 (to rounding)
} FormFactorSamples;

typedef struct RowSum RowSum;  // row.h

// Among faces in one place, the one of least rank is seen: fronts before backs, then the lower index in the mesh. A wall without
// thickness, which is two faces, is therefore lit on both sides, and neither face takes light from the other.
static inline int form_factor_rank(const ViewFace *face) {
    const int back = 1 << 30;  // above all faces
    return face->d > 0 ? face->face + back : face->face;
}

// The tables and buffers of a method in use. Only one thread at a time may use one.
typedef struct FormFactor FormFactor;

// A method: an entry of FORM_FACTOR_METHODS.
typedef struct FormFactorMethod {
    const char *name, *summary;
    // A method's promise about the faces that it sees along a direction.
    enum {
        FORM_FACTOR_EXACT,  // the nearest face, edges and depth decided in doubles
        FORM_FACTOR_FLOAT,  // the same within the rounding of floats
        FORM_FACTOR_GUESS   // wrong where its rule fails
    } truth;
    bool projective;
    // Sees all faces of the mesh through a tree of its own: it uses only the eye and the axes of a view
    bool whole_mesh;
    bool clusters;  // opens those clusters of a view that its samples may see, and no others
    bool mended;    // the shares of faces close by are corrected (near_faces.h)
    // Makes the tables for the options. The pointer returned, which may be NULL, is the `self` of the other functions. All memory
    // is taken here.
    void *(*start)(const Mesh *mesh, const FormFactorOptions *options, Arena *arena);
    void (*stop)(void *self);  // frees the memory outside the arena; NULL: there is no such memory
    // For projective methods. Items are indices of view->faces, -1 where nothing is seen; of faces in one place the one of least
    // form_factor_rank is seen, so that the result does not depend on the order of view->faces.
    const FormFactorSamples *(*samples)(void *self);
    void (*items)(void *self, const View *view, int32_t *item, FormFactorWork *work);
    // Adds shares to `sum` (row.h). Projective methods may have NULL here, or a faster way to the same shares as from their items.
    void (*row)(void *self, const View *view, RowSum *sum, FormFactorWork *work);
} FormFactorMethod;

extern const FormFactorMethod *const FORM_FACTOR_METHODS[];  // ends with NULL
// The method of that name; NULL: there is none.
const FormFactorMethod *form_factor_method(const char *name);

// All memory is taken here; `method`, `mesh` and the data that `options` points to must outlive the result.
FormFactor *form_factor_new(const FormFactorMethod *method, const Mesh *mesh,
                            const FormFactorOptions *options, Arena *arena);
// Frees the memory outside the arena.
void form_factor_end(FormFactor *self);
// The view of a point for the method's rows, which may leave clusters closed.
const View *form_factor_look(const FormFactor *self, Viewer *viewer, const ViewPoint *from, Culling culling);
// The row of a view; valid until the next call.
const Row *form_factor_row(FormFactor *self, const View *view);
// The same with samples shifted by a part of their distance, 0 .. FORM_FACTOR_SHIFTS - 1. Neighbours whose shifts differ err each in its
// own way, so that their sum errs as a much finer method does (interleaved sampling; A. Keller & W. Heidrich 2001). Where the method has no
// shifts, or samples are so fine that they need none, all shifts are alike.
enum { FORM_FACTOR_SHIFTS = 16 };
const Row *form_factor_row_shifted(FormFactor *self, const View *view, int shift);
// The directions and weights of a projective method's samples: for tests and pictures.
const FormFactorSamples *form_factor_samples(FormFactor *self);
// The face that each sample sees, [count of samples] as for FormFactorMethod.items; valid until the next call.
const int32_t *form_factor_items(FormFactor *self, const View *view);
FormFactorWork form_factor_work(const FormFactor *self);  // of all rows so far

#endif
