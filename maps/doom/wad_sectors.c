// wad_sectors.c - which sector of a Doom map each convex piece of its plan belongs to, and fewer and larger pieces.
//
// The lines along a piece's edges say it: a line's side names the sector that it faces. A piece without lines belongs
// with its neighbours. What hangs together with the border of the plan, and no line faces it, is outside; where such a
// piece meets one of a sector with no line between, the sector is not closed.
#include <stdlib.h>

#include "maps/doom/wad.h"

// The sector of a piece while it is not known.
enum { UNKNOWN = -2 };
// Stretches shorter than this are rounding, map units; corners of whole numbers are not nearer to a line.
static const double SHORT = 1e-6;

// ---- lines along their axes

// A line's stretch of its axis.
typedef struct WadSpan {
    double low, high;  // along the axis
    int line;
    bool against;  // the line runs against the axis
} WadSpan;

static int by_axis_and_place(const void *p, const void *q) {
    const WadSpan *a = p, *b = q;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    return (a->line > b->line) - (a->line < b->line);
}

void wad_index_lines(const WadMap *map, WadPieces *pieces, Arena *arena) {
    WadSpan *spans = pieces->spans = ARENA_ARRAY(arena, WadSpan, map->line_count + 1);
    int *first_span = pieces->first_span = ARENA_ARRAY(arena, int, pieces->axis_count + 1);
    Arena scratch = {0};
    int *fill = ARENA_ARRAY(&scratch, int, pieces->axis_count + 1);
    for (int i = 0; i < map->line_count; i++) {
        if (pieces->line_axis[i] >= 0) first_span[pieces->line_axis[i] + 1]++;
    }
    for (int i = 0; i < pieces->axis_count; i++) first_span[i + 1] += first_span[i];
    memcpy(fill, first_span, (size_t)pieces->axis_count * sizeof *fill);
    for (int i = 0; i < map->line_count; i++) {
        int axis = pieces->line_axis[i];
        if (axis < 0) continue;
        WadPoint v[2] = {map->vertices[map->lines[i].v[0]], map->vertices[map->lines[i].v[1]]};
        double from = wad_along(&pieces->axes[axis], v[0]);
        double to = wad_along(&pieces->axes[axis], v[1]);
        spans[fill[axis]++] = (WadSpan){fmin(from, to), fmax(from, to), i, from > to};
    }
    for (int i = 0; i < pieces->axis_count; i++) {
        int first = first_span[i], count = first_span[i + 1] - first;
        if (count > 1) qsort(spans + first, (size_t)count, sizeof *spans, by_axis_and_place);
    }
    arena_free(&scratch);
}

// A line's front lies to its right, which is the other side of an axis that runs as it does.
static int facing_side(const WadSpan *span, int side) { return (side > 0) != span->against; }

int wad_line_at(const WadMap *map, const WadPieces *pieces, const WadEdge *edge, double along, int *facing) {
    for (int i = pieces->first_span[edge->axis]; i < pieces->first_span[edge->axis + 1]; i++) {
        const WadSpan *span = &pieces->spans[i];
        if (span->low > along || span->high < along) continue;
        *facing = facing_side(span, edge->side);
        if (map->lines[span->line].side[*facing] >= 0) return span->line;
    }
    return -1;
}

// ---- where pieces meet

typedef struct EdgeSpan {
    int axis, side, piece, edge;
    double low, high;
} EdgeSpan;

static int by_axis_side_place(const void *p, const void *q) {
    const EdgeSpan *a = p, *b = q;
    if (a->axis != b->axis) return a->axis < b->axis ? -1 : 1;
    if (a->side != b->side) return a->side < b->side ? 1 : -1;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    return (a->edge > b->edge) - (a->edge < b->edge);
}

static EdgeSpan span_of(const WadPieces *pieces, int piece, int k) {
    const WadPiece *p = &pieces->pieces[piece];
    const WadEdge *e = &pieces->edges[p->first_edge + k],
                  *next = &pieces->edges[p->first_edge + (k + 1) % p->edge_count];
    double from = wad_along(&pieces->axes[e->axis], e->from),
           to = wad_along(&pieces->axes[e->axis], next->from);
    return (EdgeSpan){e->axis, e->side, piece, p->first_edge + k, fmin(from, to), fmax(from, to)};
}

static bool is_open(const WadPieces *pieces, int axis, double low, double high) {
    double covered = 0;
    for (int i = pieces->first_span[axis]; i < pieces->first_span[axis + 1] && pieces->spans[i].low < high;
         i++)
        covered += fmax(0, fmin(high, pieces->spans[i].high) - fmax(low, pieces->spans[i].low));
    return covered < high - low - SHORT;
}

typedef struct ContactList {
    WadContact *contacts;
    int count, capacity;
} ContactList;

// The contacts of one axis: its edges on the positive side are first, both sides in order along it.
static void find_contacts_of_axis(const WadPieces *pieces, const EdgeSpan *spans, int count, Arena *arena,
                                  ContactList *out) {
    int positive = 0;
    while (positive < count && spans[positive].side > 0) positive++;
    int other = positive;
    for (int i = 0; i < positive; i++) {
        while (other < count && spans[other].high <= spans[i].low) other++;
        for (int k = other; k < count && spans[k].low < spans[i].high; k++) {
            double low = fmax(spans[i].low, spans[k].low), high = fmin(spans[i].high, spans[k].high);
            *ARENA_PUSH(arena, out->contacts, out->count, out->capacity) = (WadContact){
                spans[i].axis, {spans[i].piece, spans[k].piece},         {spans[i].edge, spans[k].edge}, low,
                high,          is_open(pieces, spans[i].axis, low, high)};
        }
    }
}

int wad_find_contacts(const WadPieces *pieces, Arena *arena, WadContact **out) {
    ContactList list = {0};
    Arena scratch = {0};
    int count = 0;
    EdgeSpan *spans = ARENA_ARRAY(&scratch, EdgeSpan, pieces->edge_count + 1);
    for (int i = 0; i < pieces->piece_count; i++) {
        for (int k = 0; k < pieces->pieces[i].edge_count; k++) spans[count++] = span_of(pieces, i, k);
    }
    qsort(spans, (size_t)count, sizeof *spans, by_axis_side_place);
    for (int first = 0, end = 0; first < count; first = end) {
        while (end < count && spans[end].axis == spans[first].axis) end++;
        find_contacts_of_axis(pieces, spans + first, end - first, arena, &list);
    }
    arena_free(&scratch);
    *out = list.contacts;
    return list.count;
}

// ---- sectors

typedef struct Finder {
    const WadMap *map;
    WadPieces *pieces;
    Arena *arena;
    Building *building;
    bool *noted;     // [sector_count] as not closed
    double *facing;  // [sector_count] how much of a piece's edges they face, map units
} Finder;

static void note_unclosed(Finder *f, int sector, WadPoint at, const char *what) {
    if (f->noted[sector]) return;
    f->noted[sector] = true;
    double x = WAD_METRE * wad_x(at), y = WAD_METRE * wad_y(at),
           z = WAD_METRE * f->map->sectors[sector].floor;
    building_note(f->arena, f->building, NOTE_LEAK, vec3(x, y, z),
                  "%s: %s, sector %d is not closed near (%.0f, %.0f), or (%.2f, %.2f) m: %s", f->map->path,
                  f->map->name, sector, wad_x(at), wad_y(at), x, y, what);
}

// Adds the lines' share of edge k of a piece; returns the sector that is faced most so far.
static int look_along(Finder *f, int piece, int k, int best) {
    EdgeSpan e = span_of(f->pieces, piece, k);
    for (int i = f->pieces->first_span[e.axis]; i < f->pieces->first_span[e.axis + 1]; i++) {
        const WadSpan *span = &f->pieces->spans[i];
        double shared = fmin(e.high, span->high) - fmax(e.low, span->low);
        int sector = f->map->lines[span->line].sector[facing_side(span, e.side)];
        if (shared <= SHORT || sector < 0) continue;
        f->facing[sector] += shared;
        if (best < 0 || f->facing[sector] > f->facing[best]) best = sector;
    }
    return best;
}

// The sector that the lines along a piece's edges name, UNKNOWN without any. Two of them are no closed sectors.
static int named_sector(Finder *f, int piece) {
    const WadPiece *p = &f->pieces->pieces[piece];
    int best = -1;
    for (int k = 0; k < p->edge_count; k++) best = look_along(f, piece, k, best);
    if (best < 0) return UNKNOWN;
    for (int k = 0; k < p->edge_count; k++) {
        EdgeSpan e = span_of(f->pieces, piece, k);
        for (int i = f->pieces->first_span[e.axis]; i < f->pieces->first_span[e.axis + 1]; i++) {
            const WadSpan *span = &f->pieces->spans[i];
            int sector = f->map->lines[span->line].sector[facing_side(span, e.side)];
            bool shared = fmin(e.high, span->high) - fmax(e.low, span->low) > SHORT;
            if (sector < 0 || !shared) continue;
            f->facing[sector] = 0;
            if (sector != best)
                note_unclosed(f, sector, f->pieces->edges[p->first_edge + k].from,
                              "lines of another sector face the same place");
        }
    }
    return best;
}

// From all pieces outside, or from all with a sector, through open contacts to those UNKNOWN.
static void spread(WadPieces *pieces, const WadContact *contacts, int contact_count, bool outside) {
    Arena scratch = {0};
    int *first = ARENA_ARRAY(&scratch, int, pieces->piece_count + 2);
    int *next = ARENA_ARRAY(&scratch, int, 2 * (size_t)contact_count + 1);
    int *queue = ARENA_ARRAY(&scratch, int, pieces->piece_count + 1), count = 0;
    for (int i = 0; i < contact_count; i++) {
        for (int k = 0; contacts[i].open && k < 2; k++) first[contacts[i].piece[k] + 2]++;
    }
    for (int i = 0; i < pieces->piece_count; i++) first[i + 2] += first[i + 1];
    for (int i = 0; i < contact_count; i++) {
        const WadContact *c = &contacts[i];
        for (int k = 0; c->open && k < 2; k++) next[first[c->piece[k] + 1]++] = c->piece[1 - k];
    }
    for (int i = 0; i < pieces->piece_count; i++) {
        int sector = pieces->pieces[i].sector;
        if (outside ? sector == -1 : sector >= 0) queue[count++] = i;
    }
    for (int i = 0; i < count; i++) {
        for (int k = first[queue[i]]; k < first[queue[i] + 1]; k++) {
            WadPiece *to = &pieces->pieces[next[k]];
            if (to->sector != UNKNOWN) continue;
            to->sector = pieces->pieces[queue[i]].sector;
            queue[count++] = next[k];
        }
    }
    arena_free(&scratch);
}

static bool at_border(const WadPieces *pieces, const WadPiece *piece) {
    for (int k = 0; k < piece->edge_count; k++) {
        if (pieces->edges[piece->first_edge + k].axis >= pieces->axis_count - 4) return true;
    }
    return false;
}

// No line between two sectors runs along a contact of theirs, only lines with one side, back to back.
static bool is_thin_wall(const Finder *f, const WadContact *c) {
    if (c->open || f->pieces->pieces[c->piece[0]].sector < 0 || f->pieces->pieces[c->piece[1]].sector < 0)
        return false;
    for (int i = f->pieces->first_span[c->axis]; i < f->pieces->first_span[c->axis + 1]; i++) {
        const WadSpan *span = &f->pieces->spans[i];
        const WadLine *line = &f->map->lines[span->line];
        bool here = span->low < c->high - SHORT && span->high > c->low + SHORT;
        if (here && line->sector[0] >= 0 && line->sector[1] >= 0) return false;
    }
    return true;
}

// Regions that touch see each other, so such a wall cannot stand.
static void note_thin_walls(Finder *f, const WadContact *contacts, int contact_count) {
    int thin = 0;
    for (int i = 0; i < contact_count; i++) thin += is_thin_wall(f, &contacts[i]);
    if (thin > 0)
        building_note(f->arena, f->building, NOTE_CHANGED, vec3(0, 0, 0),
                      "%s: %s, %d walls have no thickness and are open", f->map->path, f->map->name, thin);
}

void wad_find_sectors(const WadMap *map, WadPieces *pieces, Arena *arena, Building *b) {
    Arena scratch = {0};
    Finder f = {.map = map,
                .pieces = pieces,
                .arena = arena,
                .building = b,
                .noted = ARENA_ARRAY(&scratch, bool, map->sector_count + 1),
                .facing = ARENA_ARRAY(&scratch, double, map->sector_count + 1)};
    WadContact *contacts;
    int contact_count = wad_find_contacts(pieces, &scratch, &contacts);
    for (int i = 0; i < pieces->piece_count; i++) {
        WadPiece *piece = &pieces->pieces[i];
        piece->sector = named_sector(&f, i);
        if (piece->sector == UNKNOWN && at_border(pieces, piece)) piece->sector = -1;
    }
    spread(pieces, contacts, contact_count, true);
    spread(pieces, contacts, contact_count, false);
    for (int i = 0; i < contact_count; i++) {
        const WadContact *c = &contacts[i];
        int side = pieces->pieces[c->piece[0]].sector >= 0 ? 0 : 1;
        int sector = pieces->pieces[c->piece[side]].sector;
        if (c->open && sector >= 0 && pieces->pieces[c->piece[1 - side]].sector == -1)
            note_unclosed(&f, sector, pieces->edges[c->edge[side]].from,
                          "a line is missing; a wall stands there");
    }
    for (int i = 0; i < pieces->piece_count; i++) {
        if (pieces->pieces[i].sector == UNKNOWN) pieces->pieces[i].sector = -1;
    }
    note_thin_walls(&f, contacts, contact_count);
    arena_free(&scratch);
}

// ---- fewer and larger pieces: neighbours of one sector are joined where their union is convex, longest common edge first, until no
// two are left. A partition cuts farther than it must, since every axis runs on to the next one.

// Does the boundary turn left from edge `from` to edge `to` (+1), right (-1), or go straight on (0)?
static int turn_at_corner(const WadPieces *p, const WadEdge *from, const WadEdge *to) {
    const WadAxis *a = &p->axes[from->axis], *b = &p->axes[to->axis];
    long long cross = from->side * to->side * (a->a * b->b - a->b * b->a);
    return (cross > 0) - (cross < 0);
}

static bool same_point(WadPoint a, WadPoint b) { return a.x == b.x && a.y == b.y && a.w == b.w; }

static const WadEdge *edge_of(const WadPieces *p, int piece, int k) {
    const WadPiece *it = &p->pieces[piece];
    int place = (k - it->first_edge + it->edge_count) % it->edge_count;
    return &p->edges[it->first_edge + place];
}

// Whether two pieces have the whole edge in common and make one convex piece without it.
static bool may_join(const WadPieces *p, const WadContact *c) {
    if (!c->open || p->pieces[c->piece[0]].sector != p->pieces[c->piece[1]].sector) return false;
    if (p->pieces[c->piece[0]].sector < 0) return false;
    for (int k = 0; k < 2; k++) {
        const WadEdge *start = edge_of(p, c->piece[k], c->edge[k]);
        const WadEdge *end = edge_of(p, c->piece[1 - k], c->edge[1 - k] + 1);
        if (!same_point(start->from, end->from)) return false;
        if (turn_at_corner(p, edge_of(p, c->piece[k], c->edge[k] - 1), end) < 0) return false;
    }
    return true;
}

static int longest_first(const void *p, const void *q) {
    const WadContact *a = p, *b = q;
    double x = a->high - a->low, y = b->high - b->low;
    if (x != y) return x < y ? 1 : -1;
    for (int k = 0; k < 2; k++) {
        if (a->edge[k] != b->edge[k]) return a->edge[k] < b->edge[k] ? -1 : 1;
    }
    return 0;
}

static void copy_piece(const WadPieces *from, int piece, Arena *arena, WadPieces *to) {
    const WadPiece *p = &from->pieces[piece];
    *ARENA_PUSH(arena, to->pieces, to->piece_count, to->piece_capacity) =
        (WadPiece){to->edge_count, p->edge_count, p->sector};
    for (int k = 0; k < p->edge_count; k++)
        *ARENA_PUSH(arena, to->edges, to->edge_count, to->edge_capacity) = from->edges[p->first_edge + k];
}

// All edges of both but the common one; where one goes straight on into the next, the corner between is left out.
static void join_pieces(const WadPieces *from, const WadContact *c, Arena *arena, WadPieces *to) {
    int first = to->edge_count;
    for (int k = 0; k < 2; k++) {
        int count = from->pieces[c->piece[k]].edge_count;
        const WadEdge *before = edge_of(from, c->piece[1 - k], c->edge[1 - k] - 1);
        for (int i = 1; i < count; i++) {
            const WadEdge *e = edge_of(from, c->piece[k], c->edge[k] + i);
            if (i == 1 && turn_at_corner(from, before, e) == 0) continue;
            *ARENA_PUSH(arena, to->edges, to->edge_count, to->edge_capacity) = *e;
        }
    }
    *ARENA_PUSH(arena, to->pieces, to->piece_count, to->piece_capacity) =
        (WadPiece){first, to->edge_count - first, from->pieces[c->piece[0]].sector};
}

// The axes and the lines along them alone.
static WadPieces without_pieces(const WadPieces *p) {
    return (WadPieces){.axes = p->axes,
                       .line_axis = p->line_axis,
                       .spans = p->spans,
                       .first_span = p->first_span,
                       .axis_count = p->axis_count};
}

// Joins as many pairs as there are, each piece once; whether there were any.
static bool join_pairs(const WadPieces *from, Arena *arena, WadPieces *to) {
    Arena scratch = {0};
    WadContact *contacts;
    int contact_count = wad_find_contacts(from, &scratch, &contacts);
    bool *joined = ARENA_ARRAY(&scratch, bool, from->piece_count + 1), any = false;
    if (contact_count > 0) qsort(contacts, (size_t)contact_count, sizeof *contacts, longest_first);
    *to = without_pieces(from);
    for (int i = 0; i < contact_count; i++) {
        const WadContact *c = &contacts[i];
        if (joined[c->piece[0]] || joined[c->piece[1]] || !may_join(from, c)) continue;
        join_pieces(from, c, arena, to);
        joined[c->piece[0]] = joined[c->piece[1]] = any = true;
    }
    for (int i = 0; i < from->piece_count; i++) {
        if (!joined[i]) copy_piece(from, i, arena, to);
    }
    arena_free(&scratch);
    return any;
}

void wad_merge(WadPieces *pieces, Arena *arena) {
    Arena scratch[2] = {{0}, {0}};
    WadPieces now = *pieces, next;
    int turns = 0;
    while (join_pairs(&now, &scratch[turns % 2], &next)) {
        now = next;
        turns++;
        arena_reset(&scratch[turns % 2]);
    }
    WadPieces out = without_pieces(&now);
    for (int i = 0; i < now.piece_count; i++) copy_piece(&now, i, arena, &out);
    *pieces = out;
    arena_free(&scratch[0]);
    arena_free(&scratch[1]);
}
