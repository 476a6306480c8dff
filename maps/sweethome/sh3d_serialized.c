// sh3d_serialized.c - homes of Sweet Home 3D before version 5.3, whose one entry `Home` is a stream of Java objects: makes the tree of
// elements that the program would write as Home.xml. Each element's `line` is the number of its object in the stream.
//
// Fields become attributes of their own names, since the program's XML uses the same ones; objects of the classes below become children.
// Where the program's own XML says something else than the fields, finish_texture and add_environment tell it.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "maps/sweethome/java_stream.h"
#include "maps/sweethome/sh3d.h"

#define MODEL "com.eteks.sweethome3d.model."
static const char URL_CONTENT[] = "com.eteks.sweethome3d.tools.URLContent";
static const char SAVED[] = "file:temp!/";  // begins the address of an entry of the same archive

// Classes that become elements, each before its superclass.
static const struct {
    const char *class, *element;
} ELEMENTS[] = {
    {MODEL "Level", "level"},
    {MODEL "Wall", "wall"},
    {MODEL "Room", "room"},
    {MODEL "HomeFurnitureGroup", "furnitureGroup"},
    {MODEL "HomeDoorOrWindow", "doorOrWindow"},
    {MODEL "HomeLight", "light"},
    {MODEL "HomeShelfUnit", "shelfUnit"},
    {MODEL "HomePieceOfFurniture", "pieceOfFurniture"},
    {MODEL "HomeMaterial", "material"},
    {MODEL "HomeTexture", "texture"},
    {MODEL "Baseboard", "baseboard"},
    {MODEL "LightSource", "lightSource"},
    {MODEL "Sash", "sash"},
    {MODEL "ObserverCamera", "observerCamera"},
    {MODEL "Camera", "camera"},
    {MODEL "Compass", "compass"},
    {MODEL "HomeEnvironment", "environment"},
};
enum { ELEMENT_COUNT = sizeof ELEMENTS / sizeof *ELEMENTS, OWN_ATTRIBUTES = 4 };

// OWN_ATTRIBUTES: those that an element may have beside its object's fields: attribute, id, and what was not a field once.
typedef struct Tree {
    const char *where;
    Arena *arena;
    int count, depth;  // elements so far; of the element that is open
    Error *error;
    bool failed;
} Tree;

static const char *element_of(const JavaObject *object) {
    for (int i = 0; i < ELEMENT_COUNT; i++)
        if (java_is(object, ELEMENTS[i].class)) return ELEMENTS[i].element;
    return NULL;
}

// `most`: attributes that may be set.
static XmlNode *add_element(Tree *t, XmlNode *parent, const char *name, const JavaObject *object, int most) {
    if (!t->failed && (++t->count > XML_MAX_ELEMENTS || t->depth > XML_MAX_DEPTH)) {
        t->failed = true;
        error_set(t->error,
                  "%s: object %d: the home has too many pieces, or groups nested too deep (at most %d and %d "
                  "allowed)",
                  t->where, object->number, XML_MAX_ELEMENTS, XML_MAX_DEPTH);
    }
    XmlNode *node = ARENA_ARRAY(t->arena, XmlNode, 1);
    node->name = name;
    node->line = object->number;
    node->parent = parent;
    node->attributes = ARENA_ARRAY(t->arena, const char *, 2 * most);
    if (parent && parent->last)
        parent->last = parent->last->next = node;
    else if (parent)
        parent->first = parent->last = node;
    return node;
}

static void set(XmlNode *node, const char *name, const char *value) {
    if (!value) return;
    node->attributes[2 * node->attribute_count] = name;
    node->attributes[2 * node->attribute_count + 1] = value;
    node->attribute_count++;
}

// ---- values

// The shortest decimal that reads back as the same single-precision number.
static const char *number_text(Tree *t, double value) {
    char word[40];
    for (int digits = 6; digits <= 9; digits++) {
        snprintf(word, sizeof word, "%.*g", digits, value);
        if (strtof(word, NULL) == (float)value) break;
    }
    return arena_string(t->arena, word);
}

static bool ends_with(const char *text, const char *end) {
    size_t length = strlen(text), tail = strlen(end);
    return length >= tail && strcmp(text + length - tail, end) == 0;
}

static const char *primitive_text(Tree *t, const char *name, JavaValue value) {
    switch (value.type) {
    case 'Z':
        return value.number != 0 ? "true" : "false";
    case 'F':
    case 'D':
        return number_text(t, value.number);
    default:
        if (value.type == 'I' && (ends_with(name, "Color") || strcmp(name, "color") == 0))
            return arena_format(t->arena, "%08X", (unsigned)(int)value.number);
        return arena_format(t->arena, "%.0f", value.number);
    }
}

// Other elements refer to levels and walls by their names, which objects had not before version 6.4.
static bool is_named(const JavaObject *object) {
    return java_is(object, MODEL "Level") || java_is(object, MODEL "Wall");
}

static const char *id_of(Tree *t, const JavaObject *object) {
    const char *id = java_text(object, "id");
    return id ? id : arena_format(t->arena, "%s-%d", element_of(object), object->number);
}

// The archive's entry, or an address that no entry has.
static const char *content_text(const JavaObject *content) {
    const char *file = java_text(java_object(content, "url"), "file");
    if (!file) return NULL;
    const char *saved = strstr(file, SAVED);
    return saved ? saved + strlen(SAVED) : file;
}

// The numbers of an array of arrays, all rows in one.
static const char *matrix_text(Tree *t, const JavaObject *rows) {
    const char *out = NULL;
    for (int i = 0; i < rows->value_count && i < 4; i++) {
        const JavaObject *row = rows->values[i].object;
        for (int k = 0; row && k < row->value_count && k < 4; k++) {
            const char *number = number_text(t, row->values[k].number);
            out = out ? arena_format(t->arena, "%s %s", out, number) : number;
        }
    }
    return out;
}

static const char *object_text(Tree *t, const char *name, const JavaObject *object) {
    // Numbers and truth values as objects.
    const JavaValue *boxed = java_field(object, "value");
    if (!object->class) return object->text;
    if (strncmp(object->class->name, "java.lang.", 10) == 0)
        return boxed && !boxed->object ? primitive_text(t, name, *boxed) : NULL;
    if (is_named(object)) return id_of(t, object);
    if (java_is(object, URL_CONTENT)) return content_text(object);
    if (java_is(object, "java.util.TimeZone")) return java_text(object, "ID");
    if (strcmp(name, "modelRotation") == 0) return matrix_text(t, object);
    return NULL;
}

// ---- elements

static XmlNode *put_object(Tree *t, XmlNode *parent, const JavaObject *object, const char *attribute);

// The members of a list that become elements. Others, and holes of arrays, are passed over.
static void add_members(Tree *t, XmlNode *parent, const JavaObject *list, const char *attribute) {
    const JavaValue *items;
    int count = java_items(list, &items);
    for (int i = 0; i < count && !t->failed; i++)
        if (items[i].object && element_of(items[i].object)) put_object(t, parent, items[i].object, attribute);
}

static void add_points(Tree *t, XmlNode *parent, const JavaObject *points) {
    for (int i = 0; i < points->value_count && !t->failed; i++) {
        const JavaObject *point = points->values[i].object;
        if (!point || point->value_count < 2) continue;
        XmlNode *node = add_element(t, parent, "point", point, 2);
        set(node, "x", number_text(t, point->values[0].number));
        set(node, "y", number_text(t, point->values[1].number));
    }
}

static void add_field(Tree *t, XmlNode *node, const char *name, JavaValue value) {
    const JavaObject *object = value.object;
    if (value.type != 'L' && value.type != '[') {
        set(node, name, primitive_text(t, name, value));
        return;
    }
    if (!object) return;
    const char *text = object_text(t, name, object);
    bool is_own = strcmp(name, "texture") == 0, of_group = xml_is(node, "furnitureGroup");
    if (text)
        set(node, name, text);
    else if (of_group && strcmp(name, "furniture") != 0)
        return;  // a group has pictures and materials as its class has them, but shows those of its members
    else if (java_is(object, MODEL "HomeTexture") || java_is(object, MODEL "Baseboard"))
        put_object(t, node, object, is_own ? NULL : name);
    else if (strcmp(name, "points") == 0)
        add_points(t, node, object);
    else
        add_members(t, node, object, strcmp(name, "cameraPath") == 0 ? name : NULL);
}

// A field that the class did not have yet is false in the program, which takes true where its XML lacks the attribute.
static void finish_texture(XmlNode *node, const JavaObject *object) {
    if (!java_field(object, "leftToRightOriented")) set(node, "leftToRightOriented", "false");
}

static XmlNode *put_object(Tree *t, XmlNode *parent, const JavaObject *object, const char *attribute) {
    t->depth++;
    XmlNode *node = add_element(t, parent, element_of(object), object, object->value_count + OWN_ATTRIBUTES);
    set(node, "attribute", attribute);
    for (const JavaClass *c = object->class; c && !t->failed; c = c->super)
        // An array or a constant of an enumeration has no fields, whatever its class is called.
        for (int i = 0; i < c->field_count && c->first_field + i < object->value_count && !t->failed; i++)
            add_field(t, node, c->fields[i].name, object->values[c->first_field + i]);
    if (!xml_get(node, "id") && is_named(object)) set(node, "id", id_of(t, object));
    if (xml_is(node, "texture")) finish_texture(node, object);
    t->depth--;
    return node;
}

// The ground's colour and picture are fields of the home itself. Those up to version 3.4 show three quarters of the colour.
static void add_environment(Tree *t, XmlNode *node, const JavaObject *home) {
    static const char GROUND[] = "groundColor", PICTURE[] = "groundTexture";
    enum { DARKENED = 3400 };
    const JavaObject *environment = java_object(home, "environment");
    const JavaValue *colour = java_field(home, GROUND), *version = java_field(home, "version");
    XmlNode *out = add_element(t, node, "environment", environment ? environment : home, 1);
    if (colour && colour->type == 'I') {
        unsigned rgb = (unsigned)(int)colour->number;
        if (version && version->number <= DARKENED)
            rgb =
                ((rgb >> 16 & 0xFF) * 3 / 4) << 16 | ((rgb >> 8 & 0xFF) * 3 / 4) << 8 | (rgb & 0xFF) * 3 / 4;
        set(out, GROUND, arena_format(t->arena, "%08X", rgb));
    }
    const JavaObject *ground = java_object(home, PICTURE), *sky = java_object(environment, "skyTexture");
    if (java_is(ground, MODEL "HomeTexture")) put_object(t, out, ground, PICTURE);
    if (java_is(sky, MODEL "HomeTexture")) put_object(t, out, sky, "skyTexture");
    add_members(t, out, java_object(environment, "cameraPath"), "cameraPath");
}

// Doors and groups came later than furniture, and stand in lists of their own together with all other pieces.
static const JavaObject *furniture_of(const JavaObject *home) {
    static const char *const LISTS[] = {"furnitureWithGroups", "furnitureWithDoorsAndWindows", "furniture"};
    const JavaObject *out = NULL;
    for (int i = 0; i < 3 && !out; i++) out = java_object(home, LISTS[i]);
    return out;
}

bool sh3d_serialized(Bytes stream, const char *where, Arena *arena, const XmlNode **root, Error *error) {
    static const char *const CAMERAS[] = {"observerCamera", "topCamera"};
    const JavaObject *home;
    if (!java_read(stream, where, arena, &home, error)) return false;
    if (!java_is(home, MODEL "Home"))
        return error_set(error, "%s: the first object is of the class %.80s (" MODEL "Home is needed)", where,
                         home->class ? home->class->name : "java.lang.String");
    Tree t = {.where = where, .arena = arena, .error = error};
    XmlNode *node = add_element(&t, NULL, "home", home, 1);
    const JavaValue *height = java_field(home, "wallHeight");
    if (height && height->type == 'F') set(node, "wallHeight", number_text(&t, height->number));
    add_environment(&t, node, home);
    const JavaObject *compass = java_object(home, "compass");
    if (java_is(compass, MODEL "Compass")) put_object(&t, node, compass, NULL);
    for (int i = 0; i < 2; i++) {
        const JavaObject *camera = java_object(home, CAMERAS[i]);
        if (java_is(camera, MODEL "Camera")) put_object(&t, node, camera, CAMERAS[i]);
    }
    add_members(&t, node, java_object(home, "storedCameras"), "storedCamera");
    add_members(&t, node, java_object(home, "levels"), NULL);
    add_members(&t, node, furniture_of(home), NULL);
    add_members(&t, node, java_object(home, "walls"), NULL);
    add_members(&t, node, java_object(home, "rooms"), NULL);
    *root = node;
    return !t.failed;
}
