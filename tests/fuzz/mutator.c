// mutator.c - damage that most readers survive. Bytes flipped at random in a text are refused at once and try the same few lines
// again and again; so mostly whole numbers, words and statements of a text are changed, put twice, swapped or left out. Of several
// files in one input (tests/fuzz/fuzz_pipeline.c) each is a part of the text. libFuzzer calls this by its name, try_fuzz.c as well.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/random.h"

// Flips bytes: libFuzzer's own, or that of try_fuzz.c.
size_t LLVMFuzzerMutate(unsigned char *data, size_t size, size_t room);
size_t LLVMFuzzerCustomMutator(unsigned char *data, size_t size, size_t room, unsigned seed);

typedef struct Text {
    char *data;
    size_t size, room;
    Random random;
} Text;

typedef struct Span {
    size_t from, to;
} Span;

static size_t below(Text *t, size_t count) { return (size_t)(random_next(&t->random) % (count ? count : 1)); }

// Puts other bytes, which may lie in the text, where the span is; nothing happens where they do not fit.
static void put(Text *t, Span span, const char *with, size_t size) {
    enum { LARGEST = 4096 };
    char copy[LARGEST];
    size_t rest = t->size - span.to;
    if (size > LARGEST || span.from + size + rest > t->room) return;
    if (size > 0) memcpy(copy, with, size);
    memmove(t->data + span.from + size, t->data + span.to, rest);
    if (size > 0) memcpy(t->data + span.from, copy, size);
    t->size = span.from + size + rest;
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }
static bool in_number(char c) { return is_digit(c) || c == '.' || c == '-'; }
static bool in_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

// The first run of such characters behind a place chosen at random; empty where there is none.
static Span find(Text *t, bool (*in)(char)) {
    size_t at = below(t, t->size);
    while (at > 0 && in(t->data[at]) && in(t->data[at - 1])) at--;
    while (at < t->size && !in(t->data[at])) at++;
    Span span = {at, at};
    while (span.to < t->size && in(t->data[span.to])) span.to++;
    return span;
}

// A line, or an element of XML with what stands up to the next.
static Span find_statement(Text *t) {
    size_t at = below(t, t->size);
    Span span = {at, at};
    while (span.from > 0 && t->data[span.from - 1] != '\n' && t->data[span.from] != '<') span.from--;
    while (span.to < t->size && t->data[span.to] != '\n' && (span.to == at || t->data[span.to] != '<'))
        span.to++;
    if (span.to < t->size && t->data[span.to] == '\n') span.to++;
    return span;
}

static void change_number(Text *t) {
    static const char *const TELLING[] = {"0",     "1",    "-1",        "0.001",       "1e-9", "0.0004",
                                          "32768", "1e20", "199999999", "-2147483648", "90",   "2"};
    enum { COUNT = sizeof TELLING / sizeof *TELLING, LONGEST = 40 };
    Span span = find(t, in_number);
    size_t length = span.to - span.from;
    char text[LONGEST] = "";
    if (length == 0 || length >= LONGEST) return;
    memcpy(text, t->data + span.from, length);
    double value = strtod(text, NULL);
    switch (below(t, 7)) {
    case 0:
        snprintf(text, sizeof text, "%s", TELLING[below(t, COUNT)]);
        break;
    case 1:
        snprintf(text, sizeof text, "%.9g", -value);
        break;
    case 2:
        snprintf(text, sizeof text, "%.9g", value * random_between(&t->random, 0, 2));
        break;
    case 3: {
        Span other = find(t, in_number);
        put(t, span, t->data + other.from, other.to - other.from);
        return;
    }
    case 4:
        snprintf(text, sizeof text, "%.9g", value + (below(t, 2) ? 0.001 : -0.001));
        break;
    default:
        snprintf(text, sizeof text, "%.9g", value + (below(t, 2) ? 1 : -1));
        break;
    }
    put(t, span, text, strlen(text));
}

static void change_word(Text *t) {
    Span span = find(t, in_word), other = find(t, in_word);
    if (other.to > other.from) put(t, span, t->data + other.from, other.to - other.from);
}

// Adds a statement that the format knows and the text perhaps lacks.
static void add_statement(Text *t) {
    static const char *const PLAN[] = {
        "ground m height -0.2\n",
        "facade m\n",
        "slabs m\n",
        "storey u floor 3 height 2.5 slab 0.3\n",
        "room r 0,0 4,0 4,3 2,1 0,3 wall 0.2 foot 0.1 height 2.2\n",
        "wall 1,1 3,1 3,2 thickness 0.1 height 1\n",
        "wall 0,0 4,0 4,3 0,3 0,0 thickness 0.2\n",
        "door d 2,-0.1 width 0.8 height 2 hinge both swing -80 open 0.5\n",
        "door d 2,-0.1 width 0.8 height 2 slide 0.7 glazed\n",
        "passage p 2,-0.1 width 0.8 height 2 depth 0.4\n",
        "window w 2,-0.1 width 1 height 1 sill 0.9 shape 0,0 1,0 1,0.5 0.5,1 0,0.5\n",
        "stairwell s 1,1 2,1 2,2 1,2\n",
        "stair s 1,1 width 0.8 depth 2 height 2.5 steps 5\n",
        "inlay m floor 1,1 2,1 2,2\n",
        "light l 2,2,2 flux 12\n",
        "view v 1,1,1.6 yaw 20\n",
        "start 1,1 yaw 40\n",
        "tour t\neye 1,1,1.6 yaw 1\neye 2,1,1.6 yaw 90\nend\n",
        "model k kind lamp\nbox 0,0,0 1,1,1 m without top\nlight 0,0,1 flux 3\nend\n",
        "model k\nprism m 0 1 0,0 1,0 1,1 sides 3\nend\n",
        "place k 1,1 angle 20 mirror\n",
        "poly m 1,1,1 2,1,1 2,2,1\n",
        "sphere m 1,1,1 radius 0.3 tolerance 0.05\n",
        "cylinder m 0 1 1,1 radius 0.2 round tolerance 0.05\n"};
    static const char *const HOME[] = {
        "<level id='u' name='u' elevation='250' floorThickness='12' height='250' elevationIndex='1'/>",
        "<wall id='w' level='g' xStart='100' yStart='0' xEnd='100' yEnd='300' height='250' thickness='8'/>",
        "<wall id='w' level='u' xStart='0' yStart='0' xEnd='200' yEnd='300' thickness='8' arcExtent='1'/>",
        "<doorOrWindow name='w' x='100' y='2' elevation='90' width='90' depth='10' height='100'/>",
        "<doorOrWindow name='d' x='100' y='2' width='90' depth='10' height='200' cutOutShape='M0,0 h1 v1 "
        "z'/>",
        "<pieceOfFurniture name='t' x='60' y='60' width='50' depth='40' height='70' model='0'/>",
        "<pieceOfFurniture name='t' x='60' y='60' width='50' depth='40' height='70' model='0' "
        "shininess='0.5'>"
        "<material name='red' key='red' color='FF204060' shininess='1'/></pieceOfFurniture>",
        "<furnitureGroup name='g' x='60' y='60' width='50' depth='40' height='70'><pieceOfFurniture name='t' "
        "x='60' y='60' width='9' depth='9' height='9'/></furnitureGroup>",
        "<room floorVisible='false'><point x='0' y='0'/><point x='90' y='0'/><point x='90' y='90'/></room>",
        "<light name='l' x='90' y='90' elevation='200' width='20' depth='20' height='20' power='0.5'/>"};
    static const char *const SOUP[] = {"f 1 2 3\n",
                                       "f 1 3 4 2\n",
                                       "g Door\n",
                                       "usemtl glass\n",
                                       "v 1 1 1\n",
                                       "# unit cm\n",
                                       "mtllib a.mtl\n",
                                       "quad q 0.5 1 0 0 1 1 0 1 1 1 1 0 1 1\n",
                                       "3 0 1 (0 0 0 ) (0 0 9 ) (0 9 9 )\n",
                                       "newmtl glass\nKd 1 1 1\nd 0.2\n",
                                       "Ks 0 0 1\nNs 60\nillum 2\n",
                                       "usemtl flbrown\n",
                                       "Ke 1 2 3\n",
                                       "map_Kd a.png\n"};
    enum {
        PLANS = sizeof PLAN / sizeof *PLAN,
        HOMES = sizeof HOME / sizeof *HOME,
        SOUPS = sizeof SOUP / sizeof *SOUP
    };
    Span here = find_statement(t);
    const char *statement = SOUP[below(t, SOUPS)];
    if (memmem(t->data, t->size, "storey", 6)) statement = PLAN[below(t, PLANS)];
    if (memmem(t->data, t->size, "<home", 5)) statement = HOME[below(t, HOMES)];
    put(t, (Span){here.to, here.to}, statement, strlen(statement));
}

static void edit(Text *t) {
    Span span, other;
    switch (below(t, 12)) {
    case 0:
        change_word(t);
        break;
    case 1:
        put(t, find_statement(t), "", 0);
        break;
    case 2:  // twice, or over another
        span = find_statement(t);
        other = find_statement(t);
        if (below(t, 2)) other.to = other.from;
        put(t, other, t->data + span.from, span.to - span.from);
        break;
    case 3:
        add_statement(t);
        break;
    default:
        change_number(t);
        break;
    }
}

// Mostly of characters that one can read.
static bool is_text(const unsigned char *data, size_t size) {
    size_t plain = 0, seen = size < 512 ? size : 512;
    for (size_t i = 0; i < seen; i++) plain += (data[i] >= ' ' && data[i] < 127) || data[i] == '\n';
    return size > 8 && plain * 10 > seen * 9;
}

size_t LLVMFuzzerCustomMutator(unsigned char *data, size_t size, size_t room, unsigned seed) {
    Text t = {(char *)data, size, room, {seed}};
    if (!is_text(data, size) || below(&t, 8) == 0) return LLVMFuzzerMutate(data, size, room);
    for (size_t n = 1 + below(&t, 4); n > 0 && t.size > 8; n--) edit(&t);
    return t.size;
}
