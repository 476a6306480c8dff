// sh3d_xml.c - builds a tree of elements from an XML file by expat's events.
#include "maps/sweethome/sh3d_xml.h"

#include <expat.h>
#include <limits.h>
#include <string.h>

#include "engine/core/memory.h"

typedef struct Parser {
    XML_Parser expat;
    Arena *arena;
    const char *where;
    XmlNode *root, *open;
    int count, depth;
    Error *error;
    bool failed;
} Parser;

static void refuse(Parser *p, const char *what, int limit) {
    if (p->failed) return;
    p->failed = true;
    error_set(p->error, "%s:%lu: the file has %s (at most %d allowed)", p->where,
              (unsigned long)XML_GetCurrentLineNumber(p->expat), what, limit);
    XML_StopParser(p->expat, XML_FALSE);
}

static void XMLCALL doctype(void *context, const XML_Char *name, const XML_Char *system,
                            const XML_Char *public, int internal) {
    (void)name, (void)system, (void)public, (void)internal;
    refuse(context, "a document type, which no Sweet Home 3D file has", 0);
}

static void XMLCALL start_element(void *context, const XML_Char *name, const XML_Char **attributes) {
    Parser *p = context;
    if (p->failed) return;
    if (++p->count > XML_MAX_ELEMENTS) {
        refuse(p, "too many elements", XML_MAX_ELEMENTS);
        return;
    }
    if (++p->depth > XML_MAX_DEPTH) {
        refuse(p, "elements nested too deep", XML_MAX_DEPTH);
        return;
    }
    XmlNode *node = ARENA_ARRAY(p->arena, XmlNode, 1);
    node->name = arena_string(p->arena, name);
    node->line = (int)XML_GetCurrentLineNumber(p->expat);
    node->parent = p->open;
    while (attributes[2 * node->attribute_count]) node->attribute_count++;
    node->attributes = ARENA_ARRAY(p->arena, const char *, 2 * node->attribute_count);
    for (int i = 0; i < 2 * node->attribute_count; i++)
        node->attributes[i] = arena_string(p->arena, attributes[i]);
    if (!p->open)
        p->root = node;
    else if (p->open->last)
        p->open->last = p->open->last->next = node;
    else
        p->open->first = p->open->last = node;
    p->open = node;
}

static void XMLCALL end(void *context, const XML_Char *name) {
    (void)name;
    Parser *p = context;
    if (p->failed || !p->open) return;
    p->open = p->open->parent;
    p->depth--;
}

bool xml_parse(Bytes content, const char *where, Arena *arena, const XmlNode **root, Error *error) {
    if (content.size > INT_MAX) return error_set(error, "%s: the file is larger than 2 GB", where);
    static const XML_Memory_Handling_Suite memory = {memory_new, memory_grow, memory_free};
    Parser p = {XML_ParserCreate_MM(NULL, &memory, NULL), arena, where, NULL, NULL, 0, 0, error, false};
    CORE_ASSERT(p.expat);
    XML_SetUserData(p.expat, &p);
    XML_SetElementHandler(p.expat, start_element, end);
    XML_SetStartDoctypeDeclHandler(p.expat, doctype);
    enum XML_Status status = XML_Parse(p.expat, (const char *)content.data, (int)content.size, 1);
    if (status != XML_STATUS_OK && !p.failed) {
        enum XML_Error code = XML_GetErrorCode(p.expat);
        error_set(error, "%s:%lu: not well-formed XML (%s)", where,
                  (unsigned long)XML_GetCurrentLineNumber(p.expat), XML_ErrorString(code));
        p.failed = true;
    }
    XML_ParserFree(p.expat);
    *root = p.root;
    return !p.failed;
}

const char *xml_get(const XmlNode *node, const char *name) {
    for (int i = 0; i < node->attribute_count; i++)
        if (strcmp(node->attributes[2 * i], name) == 0) return node->attributes[2 * i + 1];
    return NULL;
}

bool xml_is(const XmlNode *node, const char *name) { return strcmp(node->name, name) == 0; }
