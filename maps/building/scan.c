// scan.c - words and numbers of a text that need not end with a zero byte.
#include "maps/building/scan.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

Scan scan_begin(const char *path, Bytes content) {
    const char *data = (const char *)content.data;
    return (Scan){.path = path, .at = data, .end = data + content.size, .line = 1};
}

void scan_blanks(Scan *scan) {
    while (scan->at < scan->end && blank(*scan->at)) scan->at++;
}

bool scan_line_ends(Scan *scan, char comment) {
    scan_blanks(scan);
    return scan->at >= scan->end || *scan->at == '\n' || (comment && *scan->at == comment);
}

bool scan_next_line(Scan *scan, char comment) {
    for (;;) {
        scan_blanks(scan);
        if (comment && scan->at < scan->end && *scan->at == comment)
            while (scan->at < scan->end && *scan->at != '\n') scan->at++;
        if (scan->at >= scan->end) return false;
        if (*scan->at != '\n') return true;
        scan->at++;
        scan->line++;
    }
}

const char *scan_quote(const Scan *scan, char quote[SCAN_QUOTE]) {
    int length = 0, most = SCAN_QUOTE - 1;
    const char *c = scan->at;
    while (c < scan->end && blank(*c)) c++;
    for (; c < scan->end && length < most && *c != '\n' && !blank(*c); c++)
        quote[length++] = isprint((unsigned char)*c) ? *c : '?';
    quote[length] = 0;
    return length > 0 ? quote : "the end of the line";
}

bool scan_number(Scan *scan, double low, double high, double *out) {
    scan_blanks(scan);
    char word[64];
    int length = 0;
    const char *c = scan->at;
    for (; c < scan->end && !blank(*c) && *c != '\n' && *c != '(' && *c != ')'; c++) {
        if (length == (int)sizeof word - 1 || !memchr("+-.0123456789eE", *c, 15)) return false;
        word[length++] = *c;
    }
    word[length] = 0;
    char *rest;
    *out = strtod(word, &rest);
    if (length == 0 || *rest || !(*out >= low && *out <= high)) return false;
    scan->at = c;
    return true;
}

char *scan_word(Scan *scan, int longest, Arena *arena) {
    scan_blanks(scan);
    const char *c = scan->at;
    while (c < scan->end && !blank(*c) && *c != '\n') c++;
    size_t length = (size_t)(c - scan->at);
    if (length == 0 || length > (size_t)longest) return NULL;
    char *word = ARENA_ARRAY(arena, char, length + 1);
    memcpy(word, scan->at, length);
    scan->at = c;
    return word;
}
