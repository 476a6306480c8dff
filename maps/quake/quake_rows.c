// quake_rows.c - the visibility lump of a level: rows of bits in which a run of zero bytes is a zero and its length.
#include <strings.h>

#include "maps/quake/quake.h"

enum { LONGEST_RUN = 255, SOUNDS = 4, PICTURE_NAME = 16, FACE_PICTURE = 32 };
// BSPX, extensions that some compilers append to a level, has a head, and an entry for each.
enum { BSPX_HEAD = 8, BSPX_ENTRY = 32, BSPX_PLACE = 24, BSPX_MOST = 1 << 16 };

static int row_bytes(const QuakeLevel *level) { return (level->cluster_count + 7) / 8; }

// ---- reading

// Unpacks the row that begins at byte `at` of the lump.
static bool unpack(const QuakeLevel *level, int cluster, int at, uint64_t *row, Error *error) {
    Bytes lump = level->lumps[QUAKE_VISIBILITY];
    int bytes = row_bytes(level), done = 0;
    for (size_t from = (size_t)at; done < bytes;) {
        int run = 1;
        if (from >= lump.size || (lump.data[from] == 0 && from + 1 >= lump.size)) {
            return error_set(
                error, "%s: row %d of the visibility lump, from byte %d on, leaves the lump of %zu bytes",
                level->path, cluster, at, lump.size);
        }
        if (lump.data[from] == 0) {
            run = lump.data[from + 1];
            if (run == 0 || run > bytes - done) {
                return error_set(
                    error, "%s: row %d of the visibility lump: a run of %d zero bytes (allowed 1 to %d)",
                    level->path, cluster, run, bytes - done);
            }
            from += 2;
        } else {
            row[done / 8] |= (uint64_t)lump.data[from++] << (done % 8 * 8);
        }
        done += run;
    }
    if (level->cluster_count % 64)
        row[level->cluster_count / 64] &= ((uint64_t)1 << level->cluster_count % 64) - 1;
    return true;
}

static void fill(const QuakeLevel *level, uint64_t *row) {
    for (int i = 0; i < level->cluster_count; i++) row[i / 64] |= (uint64_t)1 << (i % 64);
}

// Where the row of a cluster of Quake II begins; -1: it has none.
static bool place_of_cluster(const QuakeLevel *level, int cluster, int *at, Error *error) {
    Bytes lump = level->lumps[QUAKE_VISIBILITY];
    *at = -1;
    if (lump.size == 0) return true;
    int count = lump.size >= 4 ? quake_i32(lump.data) : -1;
    if (count != level->cluster_count || lump.size < 4 + 8 * (size_t)count) {
        return error_set(error, "%s: its visibility lump of %zu bytes is for %d clusters (expected %d)",
                         level->path, lump.size, count, level->cluster_count);
    }
    *at = quake_i32(lump.data + 4 + 8 * (size_t)cluster);
    if (*at >= 0) return true;
    return error_set(error, "%s: row %d of the visibility lump begins at byte %d (allowed: 0 and more)",
                     level->path, cluster, *at);
}

bool quake_rows(const QuakeLevel *level, int words, uint64_t *rows, Error *error) {
    bool two = level->format == QUAKE_IBSP38, none = level->lumps[QUAKE_VISIBILITY].size == 0;
    memset(rows, 0, (size_t)level->cluster_count * (size_t)words * sizeof *rows);
    for (int i = 0; i < level->cluster_count; i++) {
        uint64_t *row = rows + (size_t)i * (size_t)words;
        int at = two ? -1 : level->leaves[i + 1].row;
        if (two && !place_of_cluster(level, i, &at, error)) return false;
        if (at < 0 || none) {
            fill(level, row);
        } else if (!unpack(level, i, at, row, error)) {
            return false;
        }
    }
    return true;
}

// ---- from cells

void quake_rows_of_cells(const QuakeLevel *level, const QuakeCells *cells, const uint64_t *seen,
                         int cell_words, int words, uint64_t *rows) {
    memset(rows, 0, (size_t)level->cluster_count * (size_t)words * sizeof *rows);
    // The leaves of a cluster see together what each of them sees.
    for (int i = 0; i < level->leaf_count; i++) {
        int from = level->leaves[i].cluster;
        if (from < 0) continue;
        uint64_t *row = rows + (size_t)from * (size_t)words;
        const uint64_t *sees = seen + (size_t)cells->cell_of_leaf[i] * (size_t)cell_words;
        row[from / 64] |= (uint64_t)1 << (from % 64);
        for (int k = 0; k < level->leaf_count; k++) {
            int to = level->leaves[k].cluster, cell = cells->cell_of_leaf[k];
            if (to >= 0 && sees[cell / 64] >> (cell % 64) & 1) row[to / 64] |= (uint64_t)1 << (to % 64);
        }
    }
}

// ---- packing

typedef struct Lump {
    Arena *arena;
    unsigned char *data;
    int count, capacity;
    bool too_long;
} Lump;

static void put(Lump *lump, int byte) {
    static const int MOST = 1 << 30;
    lump->too_long |= lump->count >= MOST;
    if (!lump->too_long)
        *ARENA_PUSH(lump->arena, lump->data, lump->count, lump->capacity) = (unsigned char)byte;
}

static int byte_of(const uint64_t *row, int i) { return (int)(row[i / 8] >> (i % 8 * 8) & 255); }

// Packs a row and returns where it begins.
static int pack(Lump *lump, const QuakeLevel *level, const uint64_t *row) {
    int bytes = row_bytes(level), begin = lump->count;
    for (int i = 0; i < bytes;) {
        put(lump, byte_of(row, i));
        if (byte_of(row, i++)) continue;
        int run = 1;
        for (; i < bytes && run < LONGEST_RUN && !byte_of(row, i); i++) run++;
        put(lump, run);
    }
    return begin;
}

static void set_i32(unsigned char *p, long long value) {
    for (int i = 0; i < 4; i++) p[i] = (unsigned char)(value >> (8 * i) & 255);
}

// Quake: a row for each leaf; leaves that see the same, as those of one cell do, share theirs if they follow each other.
static void pack_leaves(const QuakeLevel *level, const uint64_t *rows, int words, Lump *lump, int *places) {
    for (int i = 0; i < level->cluster_count; i++) {
        const uint64_t *row = rows + (size_t)i * (size_t)words;
        bool same = i > 0 && memcmp(row, row - words, (size_t)words * sizeof *row) == 0;
        places[i] = same ? places[i - 1] : pack(lump, level, row);
    }
}

// Quake II: places of two rows for each cluster, what is seen and what is heard, then the rows.
static void pack_clusters(const QuakeLevel *level, const uint64_t *rows, int words, Lump *lump) {
    int clusters = level->cluster_count;
    for (int i = 0; i < 4 + 8 * clusters; i++) put(lump, 0);
    set_i32(lump->data, clusters);
    uint64_t *heard = ARENA_ARRAY(lump->arena, uint64_t, words);
    for (int i = 0; i < clusters; i++) {
        const uint64_t *row = rows + (size_t)i * (size_t)words;
        int at = pack(lump, level, row);
        set_i32(lump->data + 4 + 8 * (size_t)i, at);
        memset(heard, 0, (size_t)words * sizeof *heard);
        for (int k = 0; k < clusters; k++) {
            if (!(row[k / 64] >> (k % 64) & 1)) continue;
            for (int w = 0; w < words; w++) heard[w] |= rows[(size_t)k * (size_t)words + (size_t)w];
        }
        at = pack(lump, level, heard);
        set_i32(lump->data + 8 + 8 * (size_t)i, at);
    }
}

// ---- sounds: a leaf of Quake that may see water, sky or lava is given its sound at full strength

static int sound_of_picture(const char *name) {
    static const struct {
        const char *begins;
        int sound;
    } SOUND[] = {{"*water", 0}, {"*04water", 0}, {"*slime", 0}, {"sky", 1}, {"*lava", 3}};
    for (size_t i = 0; i < sizeof SOUND / sizeof *SOUND; i++) {
        if (strncasecmp(name, SOUND[i].begins, strlen(SOUND[i].begins)) == 0) return SOUND[i].sound;
    }
    return -1;
}

// The sound that the picture of a face makes, -1 for none. Levels come without pictures, and with pictures that are missing.
static int sound_of_face(const QuakeLevel *level, int face) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    const unsigned char *p = quake_record(level, QUAKE_FACES, face) + layout->face_texture;
    int texture = layout->face_number == 2 ? quake_u16(p) : quake_i32(p);
    if (texture < 0 || texture >= quake_count(level, QUAKE_TEXTURES)) return -1;
    int picture = quake_i32(quake_record(level, QUAKE_TEXTURES, texture) + FACE_PICTURE);
    Bytes pictures = level->lumps[QUAKE_PICTURES];
    if (pictures.size < 4 || picture < 0 || picture >= quake_i32(pictures.data) ||
        (size_t)picture >= (pictures.size - 4) / 4)
        return -1;
    int at = quake_i32(pictures.data + 4 + 4 * (size_t)picture);
    if (at < 0 || (size_t)at > pictures.size || pictures.size - (size_t)at < PICTURE_NAME) return -1;
    char name[PICTURE_NAME + 1] = "";
    memcpy(name, pictures.data + at, PICTURE_NAME);
    return sound_of_picture(name);
}

// Bit s of sounds[i]: leaf i has a face of sound s.
static void sounds_of_leaves(const QuakeLevel *level, unsigned char *sounds) {
    bool narrow = QUAKE_LAYOUTS[level->format].leaf_face == 2;
    for (int i = 0; i < level->leaf_count; i++) {
        const QuakeLeaf *leaf = &level->leaves[i];
        for (int k = 0; k < leaf->face_count; k++) {
            const unsigned char *p = quake_record(level, QUAKE_LEAF_FACES, leaf->first_face + k);
            int face = narrow ? quake_u16(p) : quake_i32(p);
            int sound = face >= 0 && face < quake_count(level, QUAKE_FACES) ? sound_of_face(level, face) : -1;
            if (sound >= 0) sounds[i] |= (unsigned char)(1 << sound);
        }
    }
}

// Writes rows' places and sounds into the leaves of a copy of the level.
static void set_leaves(const QuakeLevel *level, const uint64_t *rows, int words, const int *places,
                       unsigned char *leaves, Arena *arena) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    unsigned char *sounds = ARENA_ARRAY(arena, unsigned char, level->leaf_count);
    sounds_of_leaves(level, sounds);
    for (int i = 0; i < level->cluster_count; i++) {
        const uint64_t *row = rows + (size_t)i * (size_t)words;
        unsigned char *leaf = leaves + (size_t)(i + 1) * (size_t)layout->record[QUAKE_LEAVES], all = 0;
        set_i32(leaf + 4, places[i]);
        for (int k = 0; k < level->cluster_count; k++) {
            if (row[k / 64] >> (k % 64) & 1) all |= sounds[k + 1];
        }
        for (int s = 0; s < SOUNDS; s++) leaf[layout->sounds + s] = all >> s & 1 ? 255 : 0;
    }
}

// ---- the whole file

// The part of the file that the new lump replaces: the old one, and the padding behind.
typedef struct Gap {
    long long at, end;  // of the old file
} Gap;

static const unsigned char *entry_of(const QuakeLevel *level, int lump) {
    return level->content.data + QUAKE_LAYOUTS[level->format].header + 8 * lump;
}

static long long padded(long long at) { return (at + 3) / 4 * 4; }

// A lump that is written anew may not be part of anything else.
static bool stands_alone(const QuakeLevel *level, QuakeLump lump, Error *error) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    int own = layout->lump[lump];
    long long begin = quake_i32(entry_of(level, own)), end = begin + quake_i32(entry_of(level, own) + 4);
    for (int i = 0; i < layout->lump_count && end > begin; i++) {
        long long at = quake_i32(entry_of(level, i)), bytes = quake_i32(entry_of(level, i) + 4);
        if (i == own || bytes == 0 || at + bytes <= begin || at >= end) continue;
        return error_set(error, "%s: its lump of %s shares bytes with lump %d (allowed: each has its own)",
                         level->path, QUAKE_LUMP_NAMES[lump], i);
    }
    return true;
}

static bool find_gap(const QuakeLevel *level, Gap *gap, Error *error) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    const unsigned char *own = entry_of(level, layout->lump[QUAKE_VISIBILITY]);
    long long size = quake_i32(own + 4), all = (long long)level->content.size;
    long long header = layout->header + 8 * layout->lump_count, last = header;
    for (int i = 0; i < layout->lump_count; i++) {
        long long at = quake_i32(entry_of(level, i)), bytes = quake_i32(entry_of(level, i) + 4);
        if (at < 0 || bytes < 0 || at > all || bytes > all - at || (bytes > 0 && at < header)) {
            return error_set(
                error, "%s: its lump %d, %lld bytes at byte %lld, does not lie within the file of %lld bytes",
                level->path, i, bytes, at, all);
        }
        if (bytes > 0 && at + bytes > last) last = at + bytes;
    }
    // Where there is none it stands behind all others: what some compilers append follows them.
    gap->at = size > 0 ? quake_i32(own) : padded(last);
    gap->end = gap->at + size < all ? gap->at + size : all;
    if (!stands_alone(level, QUAKE_VISIBILITY, error) || !stands_alone(level, QUAKE_LEAVES, error))
        return false;
    if (size == 0) return true;
    // The padding behind goes with the lump, where it is padding.
    long long end = padded(gap->end);
    bool blank = end <= all;
    for (long long i = gap->end; i < end && blank; i++) blank = level->content.data[i] == 0;
    for (int i = 0; i < layout->lump_count; i++) {
        long long at = quake_i32(entry_of(level, i)), bytes = quake_i32(entry_of(level, i) + 4);
        if (bytes > 0 && at >= gap->end && at < end) blank = false;
    }
    if (blank) gap->end = end;
    return true;
}

// Places behind the lump move by `by` bytes: those of other lumps, and of what stands in an appended BSPX.
static void move_places(const QuakeLevel *level, const Gap *gap, long long by, Bytes file) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    long long last = 0;
    for (int i = 0; i < layout->lump_count; i++) {
        long long at = quake_i32(entry_of(level, i)), bytes = quake_i32(entry_of(level, i) + 4);
        if (bytes > 0 && at + bytes > last) last = at + bytes;
        if (i != layout->lump[QUAKE_VISIBILITY] && at >= gap->end)
            set_i32(file.data + layout->header + 8 * i, at + by);
    }
    long long head = padded(last), all = (long long)level->content.size;
    const unsigned char *old = level->content.data + head;
    if (head > all - BSPX_HEAD || memcmp(old, "BSPX", 4) != 0) return;
    long long count = quake_i32(old + 4);
    if (count < 0 || count > BSPX_MOST || count > (all - head - BSPX_HEAD) / BSPX_ENTRY) return;
    for (long long i = 0; i < count; i++) {
        long long entry = head + BSPX_HEAD + i * BSPX_ENTRY + BSPX_PLACE;
        long long at = quake_i32(level->content.data + entry);
        if (at >= gap->end) set_i32(file.data + (entry >= gap->end ? entry + by : entry), at + by);
    }
}

bool quake_with_rows(const QuakeLevel *level, const uint64_t *rows, int words, Arena *arena, Bytes *out,
                     Error *error) {
    const QuakeLayout *layout = &QUAKE_LAYOUTS[level->format];
    static const long long MOST = INT32_MAX;
    Gap gap = {0, 0};
    if (!find_gap(level, &gap, error)) return false;
    Lump lump = {.arena = arena};
    int *places = ARENA_ARRAY(arena, int, level->cluster_count);
    if (level->format == QUAKE_IBSP38) {
        pack_clusters(level, rows, words, &lump);
    } else {
        pack_leaves(level, rows, words, &lump, places);
    }
    long long all = (long long)level->content.size, size = lump.count, by = gap.at + size - gap.end;
    if (gap.end < all) by = by > 0 ? padded(by) : -(-by / 4 * 4);  // what stands behind keeps its alignment
    if (lump.too_long || all + by > MOST) {
        return error_set(
            error,
            "%s: would have more than %lld bytes with its visibility (the most that its places can tell)",
            level->path, MOST);
    }
    *out = (Bytes){ARENA_ARRAY(arena, unsigned char, all + by + 1), (size_t)(all + by)};
    memcpy(out->data, level->content.data, (size_t)(gap.at < all ? gap.at : all));
    memcpy(out->data + gap.at, lump.data, (size_t)size);
    memcpy(out->data + gap.end + by, level->content.data + gap.end, (size_t)(all - gap.end));
    move_places(level, &gap, by, *out);
    unsigned char *entry = out->data + layout->header + 8 * layout->lump[QUAKE_VISIBILITY];
    set_i32(entry, gap.at);
    set_i32(entry + 4, size);
    if (level->format == QUAKE_IBSP38) return true;
    long long leaves = quake_i32(out->data + layout->header + 8 * layout->lump[QUAKE_LEAVES]);
    set_leaves(level, rows, words, places, out->data + leaves, arena);
    return true;
}
