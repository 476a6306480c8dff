// form_factor.h - the row of form factors of a point: which share of the light that leaves it diffusely arrives where.
//
// A projective method is a set of directions with weights that sum to 1 and the face seen along each (its items); the
// element is where the direction meets the face. Others make rows in ways of their own.
#ifndef RADIOSITY_FORM_FACTOR_H
#define RADIOSITY_FORM_FACTOR_H

#include "radiosity/factors/view.h"

enum { FORM_FACTOR_FINEST = 2000 };

typedef struct FaceLines FaceLines;  // lines.h

// How finely a method looks.
typedef struct FormFactorOptions {
    int resolution;  // pixels across the hemicube's top or the hemisphere's base, 8 .. FORM_FACTOR_FINEST; lines of scan-line
        // methods, rays across of `ray`
    double edge_threshold;  // of hemisphere-polyline: an edge is cut until its parts span less, radians
    const char *hidden;     // of hemicube: the hidden-surface method that fills its sides; NULL: its own
    const FaceLines
        *lines;  // lines_of_mesh of the mesh, for those who draw it many times; NULL: they are found
} FormFactorOptions;
// A resolution of 100, edges cut at one degree.
FormFactorOptions form_factor_default_options(void);

// One row. Shares: of all that leaves the point, `back` falls on the backs of faces and `escaped` meets nothing.
typedef struct Row {
    int count;
    int *element;   // [count] increasing
    float *factor;  // [count] above 0; their sum, back and escaped make 1
    double back, escaped;
    // The part of `escaped` that goes upwards in building space: the sky's. Told by projective methods, rays and
    // `analytic`; others say 0.
    double sky;
} Row;

// The work done, for tables.
typedef struct FormFactorWork {
    long long faces_drawn, elements_drawn;  // faces given; the elements they have (Oki's count)
    long long samples, tests;               // samples or crossings found; edge, box or ray tests made
} FormFactorWork;

// The directions of a projective method.
typedef struct FormFactorSamples {
    int count;
    float *x, *y, *z;  // [count] unit directions in the view's axes
    float *weight;     // [count] sum 1 (to rounding)
} FormFactorSamples;

typedef struct RowSum RowSum;  // row.h

// Among faces in one place the one that turns its front to the eye is seen, then the lower in the mesh: a wall without thickness,
// which is two faces, is lit on both sides, and neither swallows light of the other.
static inline int form_factor_rank(const ViewFace *face) {
    const int back = 1 << 30;  // above all faces
    return face->d > 0 ? face->face + back : face->face;
}

// A method at work: its tables and buffers. One thread's at a time; form_factor_end frees the memory outside the arena.
typedef struct FormFactor FormFactor;

// A method: a row of the table.
typedef struct FormFactorMethod {
    const char *name, *summary;
    // A method's promise about the faces that it sees along a direction.
    enum {
        FORM_FACTOR_EXACT,  // the nearest face, edges and depth decided in doubles
        FORM_FACTOR_FLOAT,  // the same within the rounding of floats
        FORM_FACTOR_GUESS   // wrong where its rule fails
    } truth;
    bool projective;
    bool
        whole_mesh;  // sees all faces of the mesh, by a tree of its own: of a view it needs the eye and the axes
    bool mended;     // of faces close by the shares are put right (near_faces.h)
    // Tables for the options; `self` is the method's own, NULL allowed. All memory is taken here.
    void *(*start)(const Mesh *mesh, const FormFactorOptions *options, Arena *arena);
    void (*stop)(void *self);  // frees memory outside the arena; NULL: there is none
    // For projective methods. Items are indices of view->faces, -1 where nothing is seen; of faces in one place that of the
    // least form_factor_rank is seen, so that the order of the list does not show.
    const FormFactorSamples *(*samples)(void *self);
    void (*items)(void *self, const View *view, int32_t *item, FormFactorWork *work);
    // Adds shares with row_add and friends (row.h). Of projective methods NULL, or a faster way to what the items give.
    void (*row)(void *self, const View *view, RowSum *sum, FormFactorWork *work);
} FormFactorMethod;

extern const FormFactorMethod *const FORM_FACTOR_METHODS[];  // ends with NULL
// The row of that name; NULL: there is none.
const FormFactorMethod *form_factor_method(const char *name);

// All memory is taken here; `method`, `mesh` and all that `options` points to must outlive it.
FormFactor *form_factor_new(const FormFactorMethod *method, const Mesh *mesh,
                            const FormFactorOptions *options, Arena *arena);
// Frees the memory outside the arena.
void form_factor_end(FormFactor *self);
// The row of a view; valid until the next one.
const Row *form_factor_row(FormFactor *self, const View *view);
// The face that each sample of a projective method sees, and where to look for the samples: for tests and pictures.
const FormFactorSamples *form_factor_samples(FormFactor *self);
// The items of a view, [samples] as FormFactorMethod.items; valid until the next one.
const int32_t *form_factor_items(FormFactor *self, const View *view);
FormFactorWork form_factor_work(const FormFactor *self);  // of all rows so far

#endif
