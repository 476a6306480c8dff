// hemisphere_scanline.c - form factors by lines over the hemisphere's base: visible lengths along scan lines
// (Doi & Itoh, eq. 8; Nusselt's analogue).
//
// Departs from the paper in that nothing is cut into chords: an edge crosses a line where a quadratic says, faces hide
// each other by their exact distances, and elements begin where the line crosses the face's grid. The only error left is
// that of the strips between lines. How many lines there are, and which ways: hemisphere_scanline_methods.c.
//
// Lines run at 45 degrees to the view's axes: what is built is mostly aligned with these, and a line that runs along an
// edge sees it all or not at all. It halves the error in an office.
//
// Lines are taken in bands, so that the crossings of a face with several lines are found together and memory does not grow
// with their number.
#include "radiosity/methods/hemisphere_scanline.h"

#include "engine/core/error.h"
#include "engine/core/polygon.h"

// Visible spans of less than this length are rounding where edges meet, and count to the span before them.
#define SCAN_SLIVER 1e-12
enum { SCAN_BAND = 16 };

struct Scanner {
    const Mesh *mesh;
    const View *view;
    bool across;          // corners are turned to the lines the other way
    ScanLattice lattice;  // whose lines are under way
    int corners;          // most vertices of a face
    ScanFace *faces;      // [mesh face_count] of the view
    ScanCorner *corner;   // [outline_count + mesh face_count] of the view, the same for both ways
    int *first_corner;    // [mesh face_count + 1] of each of view->faces
    ScanArc *arcs;        // [arc_capacity] of the view
    int face_count, arc_capacity;
    Vec3 *clipped;        // [corners + 1]
    ScanPoint *crossing;  // [SCAN_BAND][2 * corners + 2]
    int *crossings;       // [most lines + 1] of a line with all faces
    ScanSpan *span;  // [span_capacity] of the lines of a band one after the other, faces in the view's order
    int span_first[SCAN_BAND], span_count[SCAN_BAND], span_capacity;
    ScanList list;
};

Scanner *scanner_new(const Mesh *mesh, int most_lines, Arena *arena) {
    Scanner *self = ARENA_ARRAY(arena, Scanner, 1);
    self->mesh = mesh;
    for (int i = 0; i < mesh->face_count; i++)
        if (mesh->faces[i].vertex_count > self->corners) self->corners = mesh->faces[i].vertex_count;
    self->faces = ARENA_ARRAY(arena, ScanFace, mesh->face_count);
    self->corner = ARENA_ARRAY(arena, ScanCorner, mesh->outline_count + mesh->face_count);
    self->first_corner = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    self->arc_capacity = 2 * (mesh->outline_count + mesh->face_count);
    self->arcs = ARENA_ARRAY(arena, ScanArc, self->arc_capacity);
    self->clipped = ARENA_ARRAY(arena, Vec3, self->corners + 1);
    self->crossing = ARENA_ARRAY(arena, ScanPoint, SCAN_BAND * (2 * self->corners + 2));
    self->crossings = ARENA_ARRAY(arena, int, most_lines + 1);
    // A line crosses an edge twice at most.
    self->span_capacity = self->arc_capacity / 2;
    self->span = ARENA_ARRAY(arena, ScanSpan, self->span_capacity);
    self->list.capacity = 4 * self->span_capacity + 64;
    self->list.span = ARENA_ARRAY(arena, ScanSpan, self->list.capacity);
    self->list.next = ARENA_ARRAY(arena, int, self->list.capacity);
    return self;
}

// From the view's axes to those of the lines.
static Vec3 to_lines(Vec3 v) { return vec3((v.x - v.y) * M_SQRT1_2, (v.x + v.y) * M_SQRT1_2, v.z); }

// The corners of a face's part above the horizon.
static int find_corners(Scanner *self, const ViewFace *face, ScanCorner *out) {
    const Vec3 *v = self->view->vertices + face->first_vertex;
    int count = face->vertex_count;
    bool below = false;
    for (int i = 0; i < count; i++) below |= v[i].z < 0;
    if (below) {
        count = polygon_clip(v, count, (Plane){vec3(0, 0, 1), 0}, 0, self->clipped);
        v = self->clipped;
    }
    for (int i = 0; i < count; i++) out[i] = (ScanCorner){to_lines(v[i]), 1 / vec3_length(v[i]), 0};
    return count;
}

void scanner_look(Scanner *self, const View *view) {
    int corners = 0;
    self->view = view;
    self->across = false;
    for (int i = 0; i < view->face_count; i++) {
        self->first_corner[i] = corners;
        corners += find_corners(self, &view->faces[i], self->corner + corners);
    }
    self->first_corner[view->face_count] = corners;
}

static int find_arcs(const Scanner *self, int face, ScanArc *out) {
    int first = self->first_corner[face], end = self->first_corner[face + 1], arcs = 0;
    for (int i = first, last = end - 1; i < end; last = i++)
        arcs += scan_arcs_of_edge(&self->corner[last], &self->corner[i], &self->lattice, out + arcs);
    return arcs;
}

// Turns all corners to the lines the other way, or back.
static void turn_corners(Scanner *self, int count) {
    for (int i = 0; i < count; i++) {
        Vec3 p = self->corner[i].at;
        self->corner[i].at = vec3(p.y, p.x, p.z);
    }
}

static void find_lines(Scanner *self, int count) {
    for (ScanCorner *c = self->corner; c < self->corner + count; c++)
        c->line = scan_line_above(c->at.y * c->inverse, &self->lattice);
}

// The same, of lines the other way.
static Vec3 turned(Vec3 v, bool turn) {
    Vec3 w = to_lines(v);
    return turn ? vec3(w.y, w.x, w.z) : w;
}

static void find_faces(Scanner *self) {
    const View *view = self->view;
    int arcs = 0;
    find_lines(self, self->first_corner[view->face_count]);
    self->face_count = 0;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *face = &view->faces[i];
        ScanFace *f = &self->faces[self->face_count];
        int count = find_arcs(self, i, self->arcs + arcs);
        if (count == 0) continue;
        f->face = face->face;
        f->rank = form_factor_rank(face);
        f->first_arc = arcs, f->arc_count = count;
        f->first_line = self->lattice.count, f->end_line = 0;
        f->has_grid = false;
        arcs += count;
        f->inverse = vec3_scale(turned(face->n, self->across), 1 / face->d);
        f->back = face->d > 0;
        for (int k = f->first_arc; k < arcs; k++) {
            if (self->arcs[k].first < f->first_line) f->first_line = self->arcs[k].first;
            if (self->arcs[k].end > f->end_line) f->end_line = self->arcs[k].end;
        }
        self->face_count++;
    }
    CORE_ASSERT(arcs <= self->arc_capacity);
    int *crossings = self->crossings;
    for (int k = 0; k <= self->lattice.count; k++) crossings[k] = 0;
    for (int i = 0; i < arcs; i++) crossings[self->arcs[i].first]++, crossings[self->arcs[i].end]--;
    for (int k = 1; k <= self->lattice.count; k++) crossings[k] += crossings[k - 1];
}

// Lines from k0 on whose spans there is room for; returns the end.
static int next_band(Scanner *self, int k0) {
    int spans = 0, k = k0;
    for (; k < self->lattice.count && k < k0 + SCAN_BAND; k++) {
        if (spans + self->crossings[k] / 2 > self->span_capacity) break;
        self->span_first[k - k0] = spans;
        self->span_count[k - k0] = 0;
        spans += self->crossings[k] / 2;
    }
    CORE_ASSERT(k > k0);
    return k;
}

static void sort_points(ScanPoint *p, int count) {
    for (int i = 1; i < count; i++)
        for (int j = i; j > 0 && p[j].x < p[j - 1].x; j--) {
            ScanPoint q = p[j];
            p[j] = p[j - 1];
            p[j - 1] = q;
        }
}

// Where a face is on the lines of a band, which begins with line k0; of these, first .. end - 1.
static void cross_face(Scanner *self, int face, int k0, int first, int end) {
    const ScanFace *f = &self->faces[face];
    int stride = 2 * self->corners + 2, found[SCAN_BAND];
    for (int k = first; k < end; k++) found[k - k0] = 0;
    for (const ScanArc *a = self->arcs + f->first_arc; a < self->arcs + f->first_arc + f->arc_count; a++) {
        int a_first = a->first > first ? a->first : first, a_end = a->end < end ? a->end : end;
        for (int k = a_first; k < a_end; k++) {
            double y = self->lattice.line[k].y, s2 = a->h2 - a->e2 * y * y, s = s2 > 0 ? sqrt(s2) : 0;
            self->crossing[(k - k0) * stride + found[k - k0]++] =
                (ScanPoint){a->a * y + a->b * s, a->c * y + a->e * s};
        }
    }
    for (int line = first - k0; line < end - k0; line++) {
        ScanPoint *p = self->crossing + line * stride;
        sort_points(p, found[line]);
        for (int i = 0; i + 1 < found[line]; i += 2)
            if (p[i].x < p[i + 1].x)
                self->span[self->span_first[line] + self->span_count[line]++] =
                    (ScanSpan){p[i], p[i + 1], face};
    }
}

// Adds a visible span, or a gap (face -1).
static void add_span(Scanner *self, const ScanLine *line, const ScanSpan *span, RowSum *sum,
                     FormFactorWork *work) {
    double share = (span->to.x - span->from.x) * line->weight;
    ScanFace *f = span->face >= 0 ? &self->faces[span->face] : NULL;
    work->samples++;
    if (!f) {
        sum->escaped += share;
        return;
    }
    if (f->back) {
        sum->back += share;
        return;
    }
    if (!f->has_grid) {
        f->has_grid = true;
        f->grid = face_grid(self->mesh, self->view, f->face);
        f->axis[0] = scan_axis(turned(f->grid.gx, self->across), f->grid.x0, f->grid.nx, f->inverse);
        f->axis[1] = scan_axis(turned(f->grid.gy, self->across), f->grid.y0, f->grid.ny, f->inverse);
    }
    work->samples += scan_elements(f, line, span, sum);
}

// The next stretch of one face, or of none, from `at` on; slivers are left out and leave no gap.
static ScanSpan next_stretch(const ScanList *list, int *next, ScanPoint at, ScanPoint rim) {
    ScanSpan stretch = {at, at, -2};
    while (stretch.to.x < rim.x) {
        int s = *next;
        const ScanSpan *span = s >= 0 ? &list->span[s] : NULL;
        bool gap = !span || span->from.x > stretch.to.x;
        ScanPoint end = !gap ? span->to : span ? span->from : rim;
        int face = gap ? -1 : span->face;
        bool sliver = end.x - stretch.to.x < SCAN_SLIVER;
        if (stretch.face != -2 && face != stretch.face && !sliver) break;
        if (stretch.face == -2 && !sliver) stretch.face = face;
        if (end.x > stretch.to.x) stretch.to = end;
        if (!gap) *next = list->next[s];
    }
    return stretch;
}

static void see_line(Scanner *self, int k, const ScanSpan *span, int count, RowSum *sum,
                     FormFactorWork *work) {
    const ScanLine *line = &self->lattice.line[k];
    self->list.first = -1;
    self->list.free = -1;
    self->list.count = 0;
    self->list.tests = 0;
    for (int i = 0; i < count; i++) scan_list_add(&self->list, self->faces, line, &span[i]);
    ScanPoint at = {-line->radius, 0}, rim = {line->radius, 0};
    for (int next = self->list.first; at.x < rim.x;) {
        ScanSpan stretch = next_stretch(&self->list, &next, at, rim);
        if (rim.x - stretch.to.x < SCAN_SLIVER) stretch.to = rim;
        add_span(self, line, &stretch, sum, work);
        at = stretch.to;
    }
    work->tests += self->list.tests;
}

void scanner_see(Scanner *self, const ScanLattice *lattice, bool across, RowSum *sum, FormFactorWork *work) {
    self->lattice = *lattice;
    if (across != self->across) turn_corners(self, self->first_corner[self->view->face_count]);
    self->across = across;
    find_faces(self);
    for (int k0 = 0, k1; k0 < lattice->count; k0 = k1) {
        k1 = next_band(self, k0);
        for (int f = 0; f < self->face_count; f++) {
            const ScanFace *face = &self->faces[f];
            int first = face->first_line > k0 ? face->first_line : k0;
            int end = face->end_line < k1 ? face->end_line : k1;
            if (first < end) cross_face(self, f, k0, first, end);
        }
        for (int k = k0; k < k1; k++)
            see_line(self, k, self->span + self->span_first[k - k0], self->span_count[k - k0], sum, work);
    }
}
