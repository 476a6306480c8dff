// scan.h - reading lines of words and numbers that lie in memory, with the place for messages.
#ifndef MAPS_SCAN_H
#define MAPS_SCAN_H

#include "engine/core/file.h"

typedef struct Scan {
    const char *path, *at, *end;
    int line;  // counted from 1
} Scan;

Scan scan_begin(const char *path, Bytes content);
// Skips blanks, but not line ends.
void scan_blanks(Scan *scan);
// Skips blanks, comments and line ends up to the next word; false at the end of the content. `comment` begins a comment
// that reaches to the end of its line; 0: there are no comments.
bool scan_next_line(Scan *scan, char comment);
// Whether nothing but blanks and a comment is left of the line.
bool scan_line_ends(Scan *scan, char comment);

enum { SCAN_QUOTE = 32 };  // bytes of a quotation in a message
const char *scan_quote(const Scan *scan, char quote[SCAN_QUOTE]);

// A word that is a plain decimal from low to high and nothing else. Words end at blanks, parentheses and line ends. On
// failure the scan stays before the word.
bool scan_number(Scan *scan, double low, double high, double *out);
// The next word in `arena`, at most `longest` bytes; NULL where the line ends or the word is longer.
char *scan_word(Scan *scan, int longest, Arena *arena);

#endif
