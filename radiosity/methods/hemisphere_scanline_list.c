// hemisphere_scanline_list.c - what is visible along a scan line: spans in the order of x, each with the face that is
// nearest there.
//
// Two faces compare by the inverse distances of their planes, whose difference along a line, with z = sqrt(R^2 - x^2), is
// alpha x + gamma z + t: exact, with at most two changes of sign. Where a line runs along the one where two faces meet, the
// difference is 0 all along: a line counts for what lies just above it (scan_line_above), and so it is compared there.

#include "engine/core/error.h"
#include "radiosity/methods/hemisphere_scanline.h"

// Two inverse distances that differ by less, as a share, are the same: above the noise of doubles, below sheets 2e-7 m
// apart in a room of many metres.
#define SCAN_SAME 1e-12

static int new_span(ScanList *list, ScanSpan span, int next) {
    int at = list->free;
    if (at >= 0)
        list->free = list->next[at];
    else
        at = list->count++;
    CORE_ASSERT(at < list->capacity);
    list->span[at] = span;
    list->next[at] = next;
    return at;
}

// Joins what faces that pass through each other have cut and left in one. What remains is no more than the outline of all
// spans, about as many as there are ends; an addition cuts each of them into a few.
static void join_spans(ScanList *list) {
    for (int s = list->first; s >= 0; s = list->next[s])
        for (int n; (n = list->next[s]) >= 0 && list->span[n].face == list->span[s].face &&
                    list->span[n].from.x == list->span[s].to.x;) {
            list->span[s].to = list->span[n].to;
            list->next[s] = list->next[n];
            list->next[n] = list->free;
            list->free = n;
        }
}

static ScanPoint between(const ScanLine *line, ScanPoint a, ScanPoint b) {
    double x = (a.x + b.x) / 2, z2 = line->radius2 - x * x;
    return (ScanPoint){x, z2 > 0 ? sqrt(z2) : 0};
}

// Two faces along a line: the first is nearer where alpha x + gamma z + t > 0.
typedef struct Order {
    double alpha, beta, gamma, t, noise;  // t: beta times the line's y
    bool first_of_same;
} Order;

static double order_at(const Order *o, ScanPoint p) {
    double d = o->alpha * p.x + o->gamma * p.z + o->t;
    return fabs(d) <= o->noise ? 0 : d;
}

static Order order_of(const ScanFace *a, const ScanFace *b, const ScanLine *line, ScanPoint at) {
    Vec3 p = a->inverse, q = b->inverse;
    double inverse = fabs(p.x * at.x + p.y * line->y + p.z * at.z);
    double beta = p.y - q.y;
    return (Order){p.x - q.x, beta, p.z - q.z, beta * line->y, SCAN_SAME * inverse, a->rank < b->rank};
}

// Is the first face nearer all along (1), the second (-1), or does that change or need a closer look (0)?
static int nearer_all_along(const Order *o, ScanPoint from, ScanPoint to) {
    double d0 = order_at(o, from), d1 = order_at(o, to);
    if (d0 * d1 < 0 || (d0 == 0 && d1 == 0)) return 0;
    int sign = d0 + d1 > 0 ? 1 : -1;
    // Between ends of one sign it may dip to the other: towards 0 at both ends.
    double slope0 = sign * (o->alpha * from.z - o->gamma * from.x);
    double slope1 = sign * (o->alpha * to.z - o->gamma * to.x);
    return slope0 < 0 && slope1 > 0 ? 0 : sign;
}

static bool nearer_between(const Order *o, const ScanLine *line, ScanPoint from, ScanPoint to) {
    ScanPoint middle = between(line, from, to);
    double d = order_at(o, middle);
    if (d != 0) return d > 0;
    // How the difference grows with y, times z: dz / dy = -y / z.
    double above = o->beta * middle.z - o->gamma * line->y;
    return fabs(above) <= o->noise ? o->first_of_same : above > 0;
}

// Puts `face` on the part from .. to of span s.
static void overwrite(ScanList *list, int s, int *link, ScanPoint from, ScanPoint to, int face) {
    ScanSpan *old = &list->span[s];
    if (to.x < old->to.x) {
        int tail = new_span(list, (ScanSpan){to, old->to, old->face}, list->next[s]);
        list->next[s] = tail;
        old->to = to;
    }
    if (from.x > old->from.x) {
        int head = new_span(list, (ScanSpan){old->from, from, old->face}, s);
        *link = head;
        old->from = from;
    }
    old->face = face;
}

// Settles the part from .. to that a new face shares with span s.
static void share(ScanList *list, const ScanFace *faces, const ScanLine *line, int s, int *link,
                  ScanPoint from, ScanPoint to, int face) {
    Order o = order_of(&faces[face], &faces[list->span[s].face], line, from);
    list->tests++;
    int sign = nearer_all_along(&o, from, to);
    if (sign > 0) overwrite(list, s, link, from, to, face);
    if (sign != 0) return;
    ScanPoint cut[4] = {from};
    int count = 1 + scan_roots(o.alpha, o.gamma, o.t, line, from, to, cut + 1);
    cut[count] = to;
    bool wins[3];
    for (int i = 0; i < count; i++) wins[i] = nearer_between(&o, line, cut[i], cut[i + 1]);
    // From the right, so that what is still to be settled stays in span s.
    for (int i = count - 1; i >= 0; i--) {
        if (!wins[i]) continue;
        if (i == 0) {
            overwrite(list, s, link, from, cut[1], face);
            continue;
        }
        int tail = new_span(list, (ScanSpan){cut[i], list->span[s].to, list->span[s].face}, list->next[s]);
        list->span[s].to = cut[i];
        list->next[s] = tail;
        overwrite(list, tail, &list->next[s], cut[i], cut[i + 1], face);
    }
}

void scan_list_add(ScanList *list, const ScanFace *faces, const ScanLine *line, const ScanSpan *added) {
    ScanPoint from = added->from, to = added->to;
    int *link = &list->first;
    if (list->count > list->capacity / 4) join_spans(list);
    while (*link >= 0 && list->span[*link].to.x <= from.x) link = &list->next[*link];
    while (from.x < to.x) {
        int s = *link;
        if (s < 0 || list->span[s].from.x >= to.x) {
            *link = new_span(list, (ScanSpan){from, to, added->face}, s);
            return;
        }
        if (from.x < list->span[s].from.x) {
            ScanPoint gap_end = list->span[s].from;
            *link = new_span(list, (ScanSpan){from, gap_end, added->face}, s);
            link = &list->next[*link];
            from = gap_end;
        }
        ScanPoint end = list->span[s].to.x < to.x ? list->span[s].to : to;
        share(list, faces, line, s, link, from, end, added->face);
        while (*link >= 0 && list->span[*link].to.x <= end.x) link = &list->next[*link];
        from = end;
    }
}
