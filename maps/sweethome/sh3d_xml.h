// sh3d_xml.h - an XML file as a tree of elements; text between elements is not kept.
#ifndef MAPS_SH3D_XML_H
#define MAPS_SH3D_XML_H

#include "engine/core/file.h"

// The most elements in one file, and their deepest nesting (furniture groups may nest). Real homes have below 10,000
// elements, nested below 6 deep.
#define XML_MAX_ELEMENTS (2 << 20)
#define XML_MAX_DEPTH 64

typedef struct XmlNode XmlNode;
struct XmlNode {
    const char *name;
    const char **attributes;  // [2 * attribute_count] name and value in turn
    int attribute_count;
    int line;
    XmlNode *parent, *first, *last, *next;  // first and last child; next sibling
};

// `where` names the file in messages. Document types and entities are refused: homes have none, XML bombs need them.
bool xml_parse(Bytes content, const char *where, Arena *arena, const XmlNode **root, Error *error);

const char *xml_get(const XmlNode *node, const char *name);  // NULL: no such attribute
bool xml_is(const XmlNode *node, const char *name);

#endif
