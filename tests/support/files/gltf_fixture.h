// gltf_fixture.h - glTF documents of the room of soups.h, of parts that a test can replace.
#ifndef TESTS_GLTF_FIXTURE_H
#define TESTS_GLTF_FIXTURE_H

#include "tests/support/files/soups.h"

// The room of soups.h, y up: 8 positions in single precision, then 36 indices of u16.
enum { GLTF_POSITIONS = 96, GLTF_INDICES = 72, GLTF_BYTES = GLTF_POSITIONS + GLTF_INDICES };

// The parts of a document of the room; a test replaces those that it is about.
typedef struct GltfDocument {
    const char *asset, *head, *scene, *nodes, *mesh, *accessors, *views, *buffer;
} GltfDocument;

void gltf_room_bytes(unsigned char out[GLTF_BYTES]);
char *gltf_base64(Arena *arena, const unsigned char *data, size_t size);
// The room as most exporters would write it.
GltfDocument gltf_usual(void);
// The whole document as JSON.
char *gltf_document(Arena *arena, const GltfDocument *d);
// The document is read, or refused with a message that holds what is expected; else the test fails.
void gltf_accept(Arena *arena, const GltfDocument *d, Building *b);
void gltf_refuse(const GltfDocument *d, const char *expected);
void gltf_put_word(unsigned char *at, size_t value);
// A .glb of the text and the room's bytes.
Bytes gltf_binary(Arena *arena, const char *json);

#endif
