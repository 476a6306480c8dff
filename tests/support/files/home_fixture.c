// home_fixture.c - see home_fixture.h.
#include "tests/support/files/home_fixture.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

Home home_of_bytes(Bytes xml, Archive *archive) {
    Home h = {0};
    h.good = sh3d_sketch(xml, archive, "Home.xml", &h.arena, &h.b, &h.sketch, &h.error);
    return h;
}

Home home_of(const char *format, ...) {
    static char text[1 << 16];
    int used = snprintf(text, sizeof text, "<?xml version='1.0'?>\n<home version='7000' wallHeight='250'>\n");
    va_list args;
    va_start(args, format);
    used += vsnprintf(text + used, sizeof text - (size_t)used, format, args);
    va_end(args);
    used += snprintf(text + used, sizeof text - (size_t)used, "\n</home>\n");
    return home_of_bytes((Bytes){(unsigned char *)text, (size_t)used}, NULL);
}

Bytes home_zip(Arena *arena, const HomeEntry *entries, int count) {
    zip_error_t reason;
    zip_error_init(&reason);
    zip_source_t *store = zip_source_buffer_create(NULL, 0, 0, &reason);
    zip_t *zip = zip_open_from_source(store, ZIP_TRUNCATE, &reason);
    CORE_ASSERT(zip);
    zip_source_keep(store);
    for (int i = 0; i < count; i++) {
        zip_source_t *source = zip_source_buffer(zip, entries[i].data, entries[i].size, 0);
        CORE_ASSERT(zip_file_add(zip, entries[i].name, source, ZIP_FL_ENC_UTF_8) >= 0);
    }
    CORE_ASSERT(zip_close(zip) == 0);
    zip_stat_t stat;
    CORE_ASSERT(zip_source_stat(store, &stat) == 0);
    Bytes out = {ARENA_ARRAY(arena, unsigned char, stat.size + 1), stat.size};
    CORE_ASSERT(zip_source_open(store) == 0);
    CORE_ASSERT(zip_source_read(store, out.data, out.size) == (zip_int64_t)out.size);
    zip_source_close(store);
    zip_source_free(store);
    return out;
}

Home home_of_zip(const HomeEntry *entries, int count) {
    Home h = {0};
    Archive *archive = NULL;
    Bytes content = home_zip(&h.arena, entries, count), xml;
    CORE_ASSERT(archive_open(content, "home.sh3d", &h.arena, &archive, &h.error));
    h.good = archive_read(archive, "Home.xml", SH3D_MAX_XML, &h.arena, &xml, &h.error) &&
             sh3d_sketch(xml, archive, "Home.xml", &h.arena, &h.b, &h.sketch, &h.error);
    archive_close(archive);
    return h;
}

void home_free(Home *h) { arena_free(&h->arena); }

int home_note(const Home *h, const char *words) {
    for (int i = 0; i < h->b.note_count; i++)
        if (strstr(h->b.notes[i].text, words)) return i;
    return -1;
}
