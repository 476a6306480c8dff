// peer_frames.c - the building and the frames as text, and the answers to them.
#include "engine/bench/peer_frames.h"

#include "engine/core/text.h"
#include "maps/building/scan.h"

enum { MOST_ANSWER = 1 << 30 };                // bytes
static const double MOST_MICROSECONDS = 1e12;  // of a frame

static void append_vector(Text *text, Vec3 v) { text_append(text, " %.17g %.17g %.17g", v.x, v.y, v.z); }

static void append_building(const CellGraph *graph, Arena *scratch, Text *text) {
    const Vec3 *vertices = vis_posed(graph, NULL, scratch);
    text_append(text, "objects %d\n", graph->object_count);
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        text_append(text, "object");
        append_vector(text, graph->object_boxes[o].min);
        append_vector(text, graph->object_boxes[o].max);
        text_append(text, "\n");
        if (!vis_shown(object, NULL)) continue;
        for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
            const Polygon *polygon = &graph->polygons[i];
            text_append(text, "polygon %d", vis_is_glass(graph, i));
            for (int k = 0; k < polygon->vertex_count; k++)
                append_vector(text, vertices[polygon->first_vertex + k]);
            text_append(text, "\n");
        }
    }
}

static void append_frames(const Camera *cameras, int count, Text *text) {
    text_append(text, "frames %d\n", count);
    for (int i = 0; i < count; i++) {
        const Camera *c = &cameras[i];
        text_append(text, "frame %d %d %.17g %.17g", c->width, c->height, c->tan_x, c->tan_y);
        append_vector(text, c->eye);
        append_vector(text, c->forward);
        append_vector(text, c->right);
        append_vector(text, c->up);
        text_append(text, "\n");
    }
}

static bool read_frame(Scan *scan, const char *program, int index, int object_count, Arena *arena,
                       PeerFrame *out, Error *error) {
    double value;
    *out = (PeerFrame){0};
    if (!scan_next_line(scan, 0) || !scan_number(scan, 0, MOST_MICROSECONDS, &value))
        return error_set(error, "%s: its answer %d is no time in microseconds", program, index);
    out->seconds = 1e-6 * value;
    int *objects = NULL, count = 0, capacity = 0;
    while (scan_blanks(scan), !scan_line_ends(scan, 0)) {
        int least = count > 0 ? objects[count - 1] + 1 : 0;
        char quote[SCAN_QUOTE];
        if (!scan_number(scan, least, object_count - 1, &value) || value != (int)value)
            return error_set(error, "%s: an object of its answer %d is `%s` (allowed: %d to %d, increasing)",
                             program, index, scan_quote(scan, quote), least, object_count - 1);
        *ARENA_PUSH(arena, objects, count, capacity) = (int)value;
    }
    out->objects = objects;
    out->object_count = count;
    return true;
}

typedef struct FramesJob {
    const char *program;
    const CellGraph *graph;
    const Camera *cameras;
    int count;
    PeerFrame *out;
} FramesJob;

static bool ask_peer(const char *folder, void *context, Arena *arena, Error *error) {
    const FramesJob *job = context;
    Text text = {.arena = arena};
    append_building(job->graph, arena, &text);
    append_frames(job->cameras, job->count, &text);
    const char *question = arena_format(arena, "%s/frames", folder),
               *answer = arena_format(arena, "%s/answers", folder);
    const char *words[] = {job->program, question, answer, NULL};
    PeerUsage usage;
    Bytes content;
    if (!file_write(question, text.data, text.size, error) ||
        !peer_run(words, folder, arena, &usage, error) ||
        !file_read(answer, MOST_ANSWER, arena, &content, error))
        return false;
    Scan scan = scan_begin(answer, content);
    for (int i = 0; i < job->count; i++) {
        if (!read_frame(&scan, job->program, i, job->graph->object_count, arena, &job->out[i], error))
            return false;
    }
    return true;
}

bool peer_frames(const char *program, const CellGraph *graph, const Camera *cameras, int count, Arena *arena,
                 PeerFrame *frames, Error *error) {
    FramesJob job = {program, graph, cameras, count, frames};
    return peer_in_folder(ask_peer, &job, arena, error);
}
