// font.c - glyphs by stb_truetype, packed on shelves: from left to right, each shelf as high as its highest glyph.
//
// Outlines are not hinted. Instead the vertical scale is the one nearest to that asked for at which small letters are a whole
// number of pixels high, as in FreeType's light hinting: their tops and feet are sharp, their widths are true.
#include "engine/overlay/font.h"

#include "engine/core/error.h"

// stb_truetype frees each block by itself; here its memory for a glyph comes from an arena, which is freed after the glyph.
#define STBTT_malloc(size, arena) arena_alloc((arena), (size), 1)
#define STBTT_free(memory, arena) ((void)(memory), (void)(arena))
#define STBTT_assert(condition) CORE_ASSERT(condition)
#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <stb/stb_truetype.h>
#pragma GCC diagnostic pop

// The assembler copies the font file into the program; the Makefile gives it the folder.
__asm__(".pushsection .rodata\n"
        ".globl font_file\n"
        "font_file: .incbin \"DejaVuSans.ttf\"\n"
        ".popsection\n");
extern const unsigned char font_file[];

enum {
    IMAGE_WIDTH = 1024,
    FIRST_HEIGHT = 128,
    MOST_HEIGHT = 4096,  // 4 MB: several times the glyphs that a window shows at the highest scale
    FIRST_SLOTS = 1024,  // of the table of glyphs; a power of two
    NOT_UTF8 = 0xfffd,
};

typedef struct Slot {
    bool used;
    int character, size, step;
    Glyph glyph;
} Slot;

struct Font {
    Arena *arena, scratch;
    stbtt_fontinfo info;
    double small_letter;  // height of an x, font units
    Slot *slots;          // [slot_count] open addressing
    int slot_count, glyph_count;
    uint8_t *coverage;
    int height, first_row, end_row;
    int shelf_x, shelf_y, shelf_height;
    bool full;
};

Font *font_new(Arena *arena) {
    Font *font = ARENA_ARRAY(arena, Font, 1);
    font->arena = arena;
    // The file was read when the program was built: this could fail only for another file than DejaVuSans.ttf.
    CORE_ASSERT(stbtt_InitFont(&font->info, font_file, 0));
    font->info.userdata = &font->scratch;
    int x0, y0, x1, y1;
    stbtt_GetCodepointBox(&font->info, 'x', &x0, &y0, &x1, &y1);
    font->small_letter = y1;
    font->slot_count = FIRST_SLOTS;
    font->slots = ARENA_ARRAY(arena, Slot, font->slot_count);
    font->height = FIRST_HEIGHT;
    font->coverage = arena_alloc(arena, FIRST_HEIGHT, IMAGE_WIDTH);
    return font;
}

// ---- UTF-8

// Returns how many bytes follow the first byte of a character, and the least character that needs so many bytes; -1: no character starts
// with this byte.
static int tail_length(unsigned char first, int *character, int *least) {
    static const struct {
        int mask, lead, least;
    } FORMS[] = {{0x80, 0x00, 0}, {0xe0, 0xc0, 0x80}, {0xf0, 0xe0, 0x800}, {0xf8, 0xf0, 0x10000}};
    for (int i = 0; i < 4; i++) {
        if ((first & FORMS[i].mask) != FORMS[i].lead) continue;
        *character = first & ~FORMS[i].mask;
        *least = FORMS[i].least;
        return i;
    }
    return -1;
}

int font_decode(const char **utf8) {
    const unsigned char *text = (const unsigned char *)*utf8;
    if (!*text) return 0;
    int character = 0, least = 0, tail = tail_length(*text, &character, &least);
    bool good = tail >= 0;
    for (int i = 1; good && i <= tail; i++) {
        good = (text[i] & 0xc0) == 0x80;  // the final zero fails this test, so nothing is read beyond it
        character = character << 6 | (text[i] & 0x3f);
    }
    good =
        good && character >= least && character <= 0x10ffff && !(character >= 0xd800 && character < 0xe000);
    *utf8 += good ? tail + 1 : 1;
    return good ? character : NOT_UTF8;
}

// ---- the image

static bool make_shelf_room(Font *font, int bottom) {
    if (bottom > MOST_HEIGHT) return false;
    int height = font->height;
    while (height < bottom) height *= 2;
    if (height == font->height) return true;
    uint8_t *larger = arena_alloc(font->arena, (size_t)height, IMAGE_WIDTH);
    memcpy(larger, font->coverage, (size_t)font->height * IMAGE_WIDTH);
    font->coverage = larger;
    font->height = height;
    font->first_row = 0;
    font->end_row = height;
    return true;
}

static bool find_place(Font *font, Glyph *glyph) {
    if (font->shelf_x + glyph->width > IMAGE_WIDTH) {
        font->shelf_y += font->shelf_height;
        font->shelf_x = font->shelf_height = 0;
    }
    if (!make_shelf_room(font, font->shelf_y + glyph->height)) return false;
    if (glyph->height > font->shelf_height) font->shelf_height = glyph->height;
    glyph->x = font->shelf_x;
    glyph->y = font->shelf_y;
    font->shelf_x += glyph->width;
    if (font->first_row == font->end_row) font->first_row = font->end_row = glyph->y;
    if (glyph->y < font->first_row) font->first_row = glyph->y;
    if (glyph->y + glyph->height > font->end_row) font->end_row = glyph->y + glyph->height;
    return true;
}

static Glyph rasterise(Font *font, int character, int size, int step) {
    const stbtt_fontinfo *info = &font->info;
    float across = stbtt_ScaleForMappingEmToPixels(info, (float)size), shift = (float)step / FONT_STEPS;
    float up = (float)(fmax(1, round(font->small_letter * across)) / font->small_letter);
    Glyph glyph = {.index = stbtt_FindGlyphIndex(info, character)};
    int advance, bearing, x1, y1;
    stbtt_GetGlyphHMetrics(info, glyph.index, &advance, &bearing);
    glyph.advance = (float)advance * across;
    // A control character is invisible and takes up no room.
    if (character < ' ') return (Glyph){.index = glyph.index};
    stbtt_GetGlyphBitmapBoxSubpixel(info, glyph.index, across, up, shift, 0, &glyph.left, &glyph.top, &x1,
                                    &y1);
    glyph.width = x1 - glyph.left;
    glyph.height = y1 - glyph.top;
    if (glyph.width == 0 || glyph.height == 0) return glyph;
    if (!find_place(font, &glyph)) {
        font->full = true;
        glyph.width = glyph.height = 0;
        return glyph;
    }
    stbtt_MakeGlyphBitmapSubpixel(info, font->coverage + (size_t)glyph.y * IMAGE_WIDTH + glyph.x, glyph.width,
                                  glyph.height, IMAGE_WIDTH, across, up, shift, 0, glyph.index);
    arena_free(&font->scratch);  // not reset: nobody frees a font, which lives as long as its arena
    return glyph;
}

// ---- the table

static Slot *find_slot(Slot *slots, int slot_count, int character, int size, int step) {
    // Knuth's multiplier spreads neighbouring characters over the table.
    uint32_t key = (uint32_t)character * FONT_STEPS + (uint32_t)step + ((uint32_t)size << 24);
    uint32_t at = key * 2654435761u >> 8;
    for (;; at++) {
        Slot *slot = &slots[at & (uint32_t)(slot_count - 1)];
        if (!slot->used || (slot->character == character && slot->size == size && slot->step == step)) {
            return slot;
        }
    }
}

static void grow_table(Font *font) {
    Slot *old = font->slots;
    int old_count = font->slot_count;
    font->slot_count *= 2;
    font->slots = ARENA_ARRAY(font->arena, Slot, font->slot_count);
    for (int i = 0; i < old_count; i++) {
        if (!old[i].used) continue;
        *find_slot(font->slots, font->slot_count, old[i].character, old[i].size, old[i].step) = old[i];
    }
}

Glyph font_glyph(Font *font, int character, int size, int step) {
    CORE_ASSERT(step >= 0 && step < FONT_STEPS);
    size = size < FONT_SMALLEST ? FONT_SMALLEST : size > FONT_LARGEST ? FONT_LARGEST : size;
    Slot *slot = find_slot(font->slots, font->slot_count, character, size, step);
    if (slot->used) return slot->glyph;
    Glyph glyph = rasterise(font, character, size, step);
    *slot = (Slot){true, character, size, step, glyph};
    if (++font->glyph_count > font->slot_count / 2) grow_table(font);
    return glyph;
}

double font_kerning(const Font *font, const Glyph *a, const Glyph *b, int size) {
    return stbtt_GetGlyphKernAdvance(&font->info, a->index, b->index) *
           (double)stbtt_ScaleForMappingEmToPixels(&font->info, (float)size);
}

void font_trim(Font *font) {
    if (!font->full) return;
    memset(font->slots, 0, (size_t)font->slot_count * sizeof *font->slots);
    memset(font->coverage, 0, (size_t)font->height * IMAGE_WIDTH);
    font->glyph_count = font->shelf_x = font->shelf_y = font->shelf_height = 0;
    font->full = false;
}

FontImage font_image(Font *font) {
    FontImage image = {font->coverage, IMAGE_WIDTH, font->height, font->first_row,
                       font->end_row - font->first_row};
    font->first_row = font->end_row = 0;
    return image;
}
