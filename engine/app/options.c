// options.c - getopt_long driven by a table, and the help that the table tells.
#include "engine/app/options.h"

#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/core/vec.h"

// Columns of the help.
enum { WIDTH = 110, MOST_ROWS = 64 };

// ---- messages

static void print_sentence(const char *format, va_list args) {
    fputs("enfilade: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
}

int app_fail(int code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_sentence(format, args);
    va_end(args);
    return code;
}

int app_misuse(const char *command, const char *format, ...) {
    va_list args;
    va_start(args, format);
    print_sentence(format, args);
    va_end(args);
    fprintf(stderr, "Try `enfilade %s --help`.\n", command);
    return APP_BAD_USE;
}

// ---- values

// The whole text must be a number, `low` and `high` included.
static bool read_number(const char *text, double low, double high, double *out) {
    char *end;
    *out = strtod(text, &end);
    return end != text && *end == 0 && *out >= low && *out <= high;
}

static bool read_whole(const char *text, double low, double high, double *out) {
    char *end;
    long value = strtol(text, &end, 10);
    *out = (double)value;
    return end != text && *end == 0 && *out >= low && *out <= high;
}

static bool read_sky(const char *text, const Option *row, double radiance[3]) {
    char number[64];
    int count = 0;
    for (const char *at = text;; at++) {
        int length = (int)strcspn(at, ",");
        snprintf(number, sizeof number, "%.*s", length, at);
        if (count == 3 || !read_number(number, row->low, row->high, &radiance[count++])) return false;
        at += length;
        if (*at == 0) break;
    }
    if (count == 1) radiance[1] = radiance[2] = radiance[0];
    return count != 2;
}

static int days_of(int year, int month) {
    static const int DAYS[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    return DAYS[month - 1] + (month == 2 && leap);
}

static bool read_date(const char *text, const Option *row, int date[3]) {
    char extra;
    int read[3];
    if (sscanf(text, "%4d-%2d-%2d%c", &read[0], &read[1], &read[2], &extra) != 3 || read[0] < row->low ||
        read[0] > row->high || read[1] < 1 || read[1] > 12 || read[2] < 1 ||
        read[2] > days_of(read[0], read[1]))
        return false;
    memcpy(date, read, sizeof read);
    return true;
}

// `HH:MM`, and how many characters it has.
static bool read_clock(const char *text, int *length, double *hours) {
    int hour, minute;
    if (*text < '0' || *text > '9' || sscanf(text, "%2d:%2d%n", &hour, &minute, length) != 2) return false;
    *hours = hour + minute / 60.0;
    return hour < 24 && minute >= 0 && minute < 60;
}

static bool read_time(const char *text, const Option *row, double time[2]) {
    double hours, ahead = NAN;
    int length;
    if (!read_clock(text, &length, &hours)) return false;
    const char *zone = text + length;
    if (*zone && ((*zone != '+' && *zone != '-') || !read_number(zone, row->low, row->high, &ahead)))
        return false;
    time[0] = hours;
    time[1] = ahead;
    return true;
}

static bool read_place(const char *text, double place[2]) {
    char extra;
    double read[2];
    if (sscanf(text, "%lf,%lf%c", &read[0], &read[1], &extra) != 2 || !(fabs(read[0]) <= 90) ||
        !(fabs(read[1]) <= 180))
        return false;
    memcpy(place, read, sizeof read);
    return true;
}

static bool read_point(const char *text, Vec3 *out) {
    char extra;
    return sscanf(text, "%lf,%lf,%lf%c", &out->x, &out->y, &out->z, &extra) == 3 && isfinite(out->x) &&
           isfinite(out->y) && isfinite(out->z);
}

static bool read_size(const char *text, const Option *row, int size[2]) {
    char extra;
    return sscanf(text, "%dx%d%c", &size[0], &size[1], &extra) == 2 && size[0] >= row->low &&
           size[0] <= row->high && size[1] >= row->low && size[1] <= row->high;
}

static bool add_text(const char *text, TextList *list) {
    if (list->count == TEXT_LIST) return false;
    list->text[list->count++] = text;
    return true;
}

static bool read_choice(const char *text, const Option *row, int *out) {
    for (int i = 0; i < row->name_count; i++) {
        if (strcmp(row->names[i], text) != 0) continue;
        *out = i;
        return true;
    }
    return false;
}

int options_ending(const char *path, const char *const *endings, int count) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    if (!dot || dot == name || !dot[1]) return count;
    for (int i = 0; i < count; i++)
        if (strcasecmp(dot + 1, endings[i]) == 0) return i;
    return -1;
}

static bool take_value(const Option *row, const char *text, void *at) {
    double number = 0;
    bool whole = row->type == OPTION_INT || row->type == OPTION_SEED || row->type == OPTION_MEGABYTES;
    bool good = whole ? read_whole(text, row->low, row->high, &number)
                      : read_number(text, row->low, row->high, &number);
    switch (row->type) {
    case OPTION_INT:
        if (good) *(int *)at = (int)number;
        return good;
    case OPTION_SEED:
        if (good) *(uint64_t *)at = (uint64_t)number;
        return good;
    case OPTION_MEGABYTES:
        if (good) *(size_t *)at = (size_t)number << 20;
        return good;
    case OPTION_NUMBER:
        if (good) *(double *)at = number;
        return good;
    case OPTION_DEGREES:
        if (good) *(double *)at = number * (M_PI / 180);
        return good;
    case OPTION_SIZE:
        return read_size(text, row, at);
    case OPTION_POINT:
        return read_point(text, at);
    case OPTION_SKY:
        return read_sky(text, row, at);
    case OPTION_DATE:
        return read_date(text, row, at);
    case OPTION_TIME:
        return read_time(text, row, at);
    case OPTION_PLACE:
        return read_place(text, at);
    case OPTION_NAME:
        return read_choice(text, row, at);
    case OPTION_TEXTS:
        return add_text(text, at);
    case OPTION_OUTPUT:
        *(const char **)at = text;
        return options_ending(text, row->names, row->name_count) >= 0;
    default:
        *(const char **)at = text;
        return true;
    }
}

// The values that a row allows, as the help and the messages have them.
static void print_allowed(const Option *row, char *out, size_t size) {
    int used = 0;
    switch (row->type) {
    case OPTION_TEXTS:
        snprintf(out, size, "up to %d", TEXT_LIST);
        break;
    case OPTION_SIZE:
        snprintf(out, size, "WxH, %.10g to %.10g each", row->low, row->high);
        break;
    case OPTION_POINT:
        snprintf(out, size, "X,Y,Z in metres");
        break;
    case OPTION_SKY:
        snprintf(out, size, "L or R,G,B, %.10g to %.10g each", row->low, row->high);
        break;
    case OPTION_DATE:
        snprintf(out, size, "YYYY-MM-DD, years %.10g to %.10g", row->low, row->high);
        break;
    case OPTION_TIME:
        snprintf(out, size, "HH:MM, or HH:MM+H of a clock H hours ahead of UTC, %.10g to %.10g", row->low,
                 row->high);
        break;
    case OPTION_PLACE:
        snprintf(out, size, "degrees north and east, -90 to 90 and -180 to 180");
        break;
    case OPTION_NAME:
        *out = 0;
        for (int i = 0; i < row->name_count && used < (int)size; i++)
            used += snprintf(out + used, size - (size_t)used, "%s%s", i ? ", " : "", row->names[i]);
        break;
    case OPTION_OUTPUT:
        used = snprintf(out, size, "names that end in ");
        for (int i = 0; i < row->name_count && used < (int)size; i++)
            used += snprintf(out + used, size - (size_t)used, "%s.%s", i ? " or " : "", row->names[i]);
        if (used < (int)size) snprintf(out + used, size - (size_t)used, ", or have no ending");
        break;
    default:
        snprintf(out, size, "%.10g to %.10g", row->low, row->high);
    }
}

// ---- parsing

static int take_row(const OptionTable *table, const Option *row, const char *text, void *arguments) {
    if (row->type == OPTION_FLAG) {
        *(bool *)((char *)arguments + row->at) = true;
        return APP_GOOD;
    }
    Error error = {""};
    char allowed[256];
    if (row->type == OPTION_OTHER) {
        int code = row->take(text, arguments, &error);
        if (code == APP_GOOD || !*error.text) return code;
        snprintf(allowed, sizeof allowed, "%.250s", error.text);
    } else {
        if (take_value(row, text, (char *)arguments + row->at)) return APP_GOOD;
        print_allowed(row, allowed, sizeof allowed);
    }
    return app_misuse(table->command, "%s: %s%s is `%s` (allowed %s)", table->command,
                      row->name[1] ? "--" : "-", row->name, text, allowed);
}

int options_parse(const OptionTable *table, int argc, char **argv, void *arguments, bool *given, int *first,
                  bool *help) {
    enum { LONG = 256 };
    struct option all[MOST_ROWS + 2] = {{"help", no_argument, NULL, 'h'}};
    char letters[2 * MOST_ROWS + 4] = ":h";
    int count = 1;
    CORE_ASSERT(table->count <= MOST_ROWS);
    for (int i = 0; i < table->count; i++) {
        const Option *row = &table->rows[i];
        if (row->type == OPTION_HEADING) continue;
        if (row->name[1])
            all[count++] =
                (struct option){row->name, row->value ? required_argument : no_argument, NULL, LONG + i};
        else
            strcat(strcat(letters, row->name), row->value ? ":" : "");
    }
    opterr = 0;
    optind = 0;
    for (int c; (c = getopt_long(argc, argv, letters, all, NULL)) != -1;) {
        int i = c >= LONG ? c - LONG : 0;
        if (c == 'h') {
            *help = true;
            return APP_GOOD;
        }
        if (c == ':')
            return app_misuse(table->command, "%s: option `%s` needs a value", table->command,
                              argv[optind - 1]);
        if (c == '?')
            return app_misuse(table->command, "%s: there is no option `%s`", table->command,
                              argv[optind - 1]);
        if (c < LONG)
            while (table->rows[i].type == OPTION_HEADING || table->rows[i].name[1] ||
                   table->rows[i].name[0] != c)
                i++;
        int code = take_row(table, &table->rows[i], optarg, arguments);
        if (code != APP_GOOD) return code;
        if (given) given[i] = true;
    }
    *first = optind;
    return APP_GOOD;
}

int options_parse_file(const OptionTable *table, int argc, char **argv, void *arguments, bool *given,
                       const char **file, bool *help) {
    int first = 0;
    int code = options_parse(table, argc, argv, arguments, given, &first, help);
    if (code != APP_GOOD || *help) return code;
    if (argc - first != 1)
        return app_misuse(table->command, "%s: one building file is needed, %d were given", table->command,
                          argc - first);
    *file = argv[first];
    return APP_GOOD;
}

bool options_given(const OptionTable *table, const bool *given, const char *name) {
    for (int i = 0; i < table->count; i++)
        if (given[i] && strcmp(table->rows[i].name, name) == 0) return true;
    return false;
}

// ---- help

// Words fill lines from column `at` on, of which all but the first are indented; ends the last line.
static void fill_lines(const char *text, int at, int indent) {
    for (bool begun = false; *text;) {
        if (*text == '\n') {
            printf(text[1] == '\n' ? "\n\n%*s" : "\n%*s", indent, "");
            text += text[1] == '\n' ? 2 : 1;
            at = indent;
            begun = false;
        }
        int length = (int)strcspn(text, " \n");
        if (begun && at + 1 + length > WIDTH) {
            printf("\n%*s", indent, "");
            at = indent;
            begun = false;
        }
        at += printf(begun ? " %.*s" : "%.*s", length, text);
        begun = true;
        text += length;
        text += *text == ' ';
    }
    putchar('\n');
}

void options_print_paragraph(const char *text, int at, int indent) {
    if (at < indent) printf("%*s", indent - at, "");
    fill_lines(text, at < indent ? indent : at, indent);
}

// The row's help with the values allowed in place of `@`.
static void print_row_help(const Option *row, int column) {
    char text[1024], allowed[256];
    const bool any = row->type == OPTION_TEXT || row->type == OPTION_TEXTS;
    const char *at = any ? NULL : strchr(row->help, '@');
    print_allowed(row, allowed, sizeof allowed);
    if (at)
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - row->help), row->help, allowed, at + 1);
    else
        snprintf(text, sizeof text, "%s", row->help);
    fill_lines(text, column, column);
}

void options_print_rows(const Option *rows, int count, int indent) {
    int widest = 0;
    for (int i = 0; i < count; i++) {
        if (rows[i].type == OPTION_HEADING) continue;
        int width = (int)strlen(rows[i].name) + 2 + (rows[i].value ? 1 + (int)strlen(rows[i].value) : 0);
        if (width > widest) widest = width;
    }
    for (int i = 0; i < count; i++) {
        const Option *row = &rows[i];
        if (row->type == OPTION_HEADING) {
            printf("\n%*s", indent - 2, "");
            fill_lines(row->help, indent - 2, indent - 2);
            continue;
        }
        int used = printf("%*s%s%s%s%s", indent, "", row->name[1] ? "--" : "-", row->name,
                          row->value ? " " : "", row->value ? row->value : "");
        printf("%*s", indent + widest + 2 - used, "");
        print_row_help(row, indent + widest + 2);
    }
}

void options_print_help(const OptionTable *table) {
    const char *line = table->usage;
    for (int i = 0; *line; i++) {
        int length = (int)strcspn(line, "\n");
        printf("%s enfilade %s ", i == 0 ? "usage:" : "      ", table->command);
        char text[1024];
        int indent = 17 + (int)strlen(table->command);
        snprintf(text, sizeof text, "%.*s", length, line);
        fill_lines(text, indent, indent);
        line += length + (line[length] == '\n');
    }
    putchar('\n');
    if (table->about) options_print_paragraph(table->about, 0, 0);
    if (table->count > 0 && table->rows[0].type != OPTION_HEADING) putchar('\n');
    options_print_rows(table->rows, table->count, 2);
}
