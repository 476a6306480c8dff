// wad_sectors.c - which sector of a Doom map each convex piece of its plan belongs to.
//
// The lines along a piece's edges say it: a line's side names the sector that it faces. A piece without lines belongs
// with its neighbours. What hangs together with the border of the plan, and no line faces it, is outside; where such a
// piece meets one of a sector with no line between, the sector is not closed.
#include <stdlib.h>

#include "maps/doom/wad.h"

// Of a piece whose sector is not known yet.
enum { UNKNOWN = -2 };
// Stretches shorter than this are rounding, map units; corners of whole numbers are not nearer to a line.
static const double SHORT = 1e-6;

// ---- lines along their axes

static int by_axis_and_place(const void *p, const void *q) {
    const WadSpan *a = p, *b = q;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    return (a->line > b->line) - (a->line < b->line);
}

WadLineIndex wad_index_lines(const WadMap *map, const WadPieces *pieces, Arena *arena) {
    WadLineIndex index = {ARENA_ARRAY(arena, WadSpan, map->line_count + 1),
                          ARENA_ARRAY(arena, int, pieces->axis_count + 1)};
    Arena scratch = {0};
    int *fill = ARENA_ARRAY(&scratch, int, pieces->axis_count + 1);
    for (int i = 0; i < map->line_count; i++) {
        if (pieces->line_axis[i] >= 0) index.first[pieces->line_axis[i] + 1]++;
    }
    for (int i = 0; i < pieces->axis_count; i++) index.first[i + 1] += index.first[i];
    memcpy(fill, index.first, (size_t)pieces->axis_count * sizeof *fill);
    for (int i = 0; i < map->line_count; i++) {
        int axis = pieces->line_axis[i];
        if (axis < 0) continue;
        WadVertex v[2] = {map->vertices[map->lines[i].v[0]], map->vertices[map->lines[i].v[1]]};
        double from = wad_along(&pieces->axes[axis], (WadPoint){v[0].x, v[0].y, 1});
        double to = wad_along(&pieces->axes[axis], (WadPoint){v[1].x, v[1].y, 1});
        index.spans[fill[axis]++] = (WadSpan){fmin(from, to), fmax(from, to), i, from > to};
    }
    for (int i = 0; i < pieces->axis_count; i++) {
        int first = index.first[i], count = index.first[i + 1] - first;
        if (count > 1) qsort(index.spans + first, (size_t)count, sizeof *index.spans, by_axis_and_place);
    }
    arena_free(&scratch);
    return index;
}

// A line's front lies to its right, which is the other side of an axis that runs as it does.
int wad_facing(const WadSpan *span, int side) { return (side > 0) != span->against; }

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

static bool is_open(const WadLineIndex *index, int axis, double low, double high) {
    double covered = 0;
    for (int i = index->first[axis]; i < index->first[axis + 1] && index->spans[i].low < high; i++)
        covered += fmax(0, fmin(high, index->spans[i].high) - fmax(low, index->spans[i].low));
    return covered < high - low - SHORT;
}

// The contacts of one axis: its edges on the positive side are first, both sides in order along it.
static void find_contacts_of_axis(const EdgeSpan *spans, int count, const WadLineIndex *index, Arena *arena,
                                  WadContacts *out) {
    int positive = 0;
    while (positive < count && spans[positive].side > 0) positive++;
    int other = positive;
    for (int i = 0; i < positive; i++) {
        while (other < count && spans[other].high <= spans[i].low) other++;
        for (int k = other; k < count && spans[k].low < spans[i].high; k++) {
            double low = fmax(spans[i].low, spans[k].low), high = fmin(spans[i].high, spans[k].high);
            *ARENA_PUSH(arena, out->contacts, out->count, out->capacity) = (WadContact){
                spans[i].axis, {spans[i].piece, spans[k].piece},        {spans[i].edge, spans[k].edge}, low,
                high,          is_open(index, spans[i].axis, low, high)};
        }
    }
}

WadContacts wad_find_contacts(const WadPieces *pieces, const WadLineIndex *index, Arena *arena) {
    WadContacts out = {0};
    Arena scratch = {0};
    int count = 0;
    EdgeSpan *spans = ARENA_ARRAY(&scratch, EdgeSpan, pieces->edge_count + 1);
    for (int i = 0; i < pieces->piece_count; i++) {
        for (int k = 0; k < pieces->pieces[i].edge_count; k++) spans[count++] = span_of(pieces, i, k);
    }
    qsort(spans, (size_t)count, sizeof *spans, by_axis_side_place);
    for (int first = 0, end = 0; first < count; first = end) {
        while (end < count && spans[end].axis == spans[first].axis) end++;
        find_contacts_of_axis(spans + first, end - first, index, arena, &out);
    }
    arena_free(&scratch);
    return out;
}

// ---- sectors

typedef struct Finder {
    const WadMap *map;
    const WadLineIndex *index;
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
    for (int i = f->index->first[e.axis]; i < f->index->first[e.axis + 1]; i++) {
        const WadSpan *span = &f->index->spans[i];
        double shared = fmin(e.high, span->high) - fmax(e.low, span->low);
        int sector = f->map->lines[span->line].sector[wad_facing(span, e.side)];
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
        for (int i = f->index->first[e.axis]; i < f->index->first[e.axis + 1]; i++) {
            const WadSpan *span = &f->index->spans[i];
            int sector = f->map->lines[span->line].sector[wad_facing(span, e.side)];
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
static void spread(WadPieces *pieces, const WadContacts *contacts, bool outside) {
    Arena scratch = {0};
    int *first = ARENA_ARRAY(&scratch, int, pieces->piece_count + 2);
    int *next = ARENA_ARRAY(&scratch, int, 2 * (size_t)contacts->count + 1);
    int *queue = ARENA_ARRAY(&scratch, int, pieces->piece_count + 1), count = 0;
    for (int i = 0; i < contacts->count; i++) {
        for (int k = 0; contacts->contacts[i].open && k < 2; k++) first[contacts->contacts[i].piece[k] + 2]++;
    }
    for (int i = 0; i < pieces->piece_count; i++) first[i + 2] += first[i + 1];
    for (int i = 0; i < contacts->count; i++) {
        const WadContact *c = &contacts->contacts[i];
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
    for (int i = f->index->first[c->axis]; i < f->index->first[c->axis + 1]; i++) {
        const WadSpan *span = &f->index->spans[i];
        const WadLine *line = &f->map->lines[span->line];
        bool here = span->low < c->high - SHORT && span->high > c->low + SHORT;
        if (here && line->sector[0] >= 0 && line->sector[1] >= 0) return false;
    }
    return true;
}

// Regions that touch see each other, so such a wall cannot stand.
static void note_thin_walls(Finder *f, const WadContacts *contacts) {
    int thin = 0;
    for (int i = 0; i < contacts->count; i++) thin += is_thin_wall(f, &contacts->contacts[i]);
    if (thin > 0)
        building_note(f->arena, f->building, NOTE_CHANGED, vec3(0, 0, 0),
                      "%s: %s, %d walls have no thickness and are open", f->map->path, f->map->name, thin);
}

void wad_find_sectors(const WadMap *map, const WadLineIndex *index, WadPieces *pieces, Arena *arena,
                      Building *b) {
    Arena scratch = {0};
    Finder f = {.map = map,
                .index = index,
                .pieces = pieces,
                .arena = arena,
                .building = b,
                .noted = ARENA_ARRAY(&scratch, bool, map->sector_count + 1),
                .facing = ARENA_ARRAY(&scratch, double, map->sector_count + 1)};
    WadContacts contacts = wad_find_contacts(pieces, index, &scratch);
    for (int i = 0; i < pieces->piece_count; i++) {
        WadPiece *piece = &pieces->pieces[i];
        piece->sector = named_sector(&f, i);
        if (piece->sector == UNKNOWN && at_border(pieces, piece)) piece->sector = -1;
    }
    spread(pieces, &contacts, true);
    spread(pieces, &contacts, false);
    for (int i = 0; i < contacts.count; i++) {
        const WadContact *c = &contacts.contacts[i];
        int side = pieces->pieces[c->piece[0]].sector >= 0 ? 0 : 1;
        int sector = pieces->pieces[c->piece[side]].sector;
        if (c->open && sector >= 0 && pieces->pieces[c->piece[1 - side]].sector == -1)
            note_unclosed(&f, sector, pieces->edges[c->edge[side]].from,
                          "a line is missing; a wall stands there");
    }
    for (int i = 0; i < pieces->piece_count; i++) {
        if (pieces->pieces[i].sector == UNKNOWN) pieces->pieces[i].sector = -1;
    }
    note_thin_walls(&f, &contacts);
    arena_free(&scratch);
}
