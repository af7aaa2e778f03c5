/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene view: what the 3D view on the page of assay-run shows, as JSON. The view shows one
 * structure at a time, after one of the commands that wrote it: a moment. Arrays are in base64,
 * each once. scripts/assay_run/page_parts/scene.js reads all of it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "src/base/array.h"
#include "src/scene/contents.h"
#include "src/scene/tool.h"

/* Lower numbers come first, as long as there is room. */
enum importance {
    LAST_OF_TOP,
    HAS_FINDINGS,
    HELD_BY_NO_TOP, /* no top-level structure refers to what was built */
    EARLIER,
};
struct moment {
    uint32_t command, build; /* what it wrote is of this build */
    enum importance importance;
};

/* Roughly what an entry of a list takes, which is not measured. */
enum { ENTRY_BYTES = 200 };

struct view {
    struct capture *capture;
    struct capture_error *error;
    size_t used, limit; /* bytes of arrays, and of entries */
    bool is_full;       /* something had no room: what is less important is left out */
    struct handle_table array_ids, row_ids; /* indices + 1 by hash */
    VkAccelerationStructureInstanceKHR *rows;
    uint32_t row_count, row_capacity;
    uint32_t *writes; /* by command: index in `written`, or CAPTURE_NONE */
    uint32_t *meshes; /* by command: index in `mesh_list`, or CAPTURE_NONE */
    bool *is_named;   /* by structure: a write names it */
    json_t *arrays, *mesh_list, *written, *moments;
};

static uint32_t add(json_t *array, json_t *object)
{
    json_array_append_new(array, object);
    return (uint32_t)json_array_size(array) - 1;
}

static json_t *number_or_null(uint32_t index)
{
    return index == CAPTURE_NONE ? json_null() : json_integer(index);
}

static void require_memory(bool has_memory)
{
    if (!has_memory)
        capture_allocate(NULL, SIZE_MAX, 2);
}

static void use(struct view *view, size_t bytes)
{
    view->is_full |= bytes > view->limit - view->used;
    view->used = view->is_full ? view->limit : view->used + bytes;
}

/* ---- arrays */

static json_t *encode_base64(const uint8_t *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const size_t length = (size + 2) / 3 * 4;
    char *text = capture_allocate(NULL, length + 1, 1), *to = text;
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const uint32_t bits = (uint32_t)bytes[i] << 16 |
                              (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) |
                              (left > 2 ? bytes[i + 2] : 0);
        for (int j = 0; j < 4; j++)
            *to++ = (size_t)j > left ? '=' : digits[bits >> (18 - 6 * j) & 63];
    }
    json_t *string = json_stringn(text, length);
    free(text);
    return string;
}

/* Adds an array, or finds it. Returns CAPTURE_NONE if there is no room for it, unless it is needed.
 */
static uint32_t add_array(struct view *view, const void *bytes, size_t size, bool is_needed)
{
    uint64_t hash = XXH3_64bits(bytes, size);
    hash += !hash; /* key 0 is in no table */
    const uintptr_t known = (uintptr_t)handle_table_find(&view->array_ids, hash);
    if (known)
        return (uint32_t)known - 1;
    if (size > view->limit - view->used && !is_needed) {
        view->is_full = true;
        return CAPTURE_NONE;
    }
    use(view, size);
    const uint32_t index = add(view->arrays, encode_base64(bytes, size));
    require_memory(handle_table_set(&view->array_ids, hash, (void *)((uintptr_t)index + 1)));
    return index;
}

static json_t *make_left_out(const uint64_t counts[LEFT_OUT])
{
    json_t *object = json_object();
    for (uint32_t i = 0; i < LEFT_OUT; i++)
        if (counts[i])
            json_object_set_new(object, left_out_names[i], json_integer((json_int_t)counts[i]));
    return object;
}

/* ---- writes: builds and copies */

static bool is_write(const struct captured_command *command)
{
    return command->dst != CAPTURE_NONE &&
           (command->kind == CAPTURE_COMMAND_BUILD || command->kind == CAPTURE_COMMAND_COPY);
}

/* Returns the entry of a build or copy; `build` is what its dst holds then. */
static uint32_t write_of(struct view *view, uint32_t index, uint32_t build)
{
    if (view->writes[index] != CAPTURE_NONE)
        return view->writes[index];
    const struct captured_command *command = &view->capture->commands[index];
    char queue[20], buffer[20], flags[20];
    snprintf(queue, sizeof(queue), "0x%llx", (unsigned long long)command->queue);
    snprintf(buffer, sizeof(buffer), "0x%llx", (unsigned long long)command->command_buffer);
    snprintf(flags, sizeof(flags), "0x%x", view->capture->commands[build].flags);
    use(view, ENTRY_BYTES);
    view->is_named[command->dst] = true;
    view->writes[index] =
        add(view->written,
            json_pack("{s:I, s:s, s:I, s:I, s:s, s:s, s:I, s:s, s:s*, s:i}", "n",
                      (json_int_t)command->n, "mode", capture_mode_name(command->mode), "frame",
                      (json_int_t)command->frame, "submission", (json_int_t)command->submission,
                      "queue", queue, "commandBuffer", buffer, "build", (json_int_t)command->build,
                      "flags", flags, "labels", command->region, "structure", (int)command->dst));
    return view->writes[index];
}

/* ---- meshes */

static void extend_box(float box[6], const float position[3])
{
    for (int i = 0; i < 3; i++) {
        box[i] = fminf(box[i], position[i]);
        box[3 + i] = fmaxf(box[3 + i], position[i]);
    }
}

/* A geometry has positions and indices, or without room neither. `primitives` has the numbers of
 * those that are shown, unless that is all of them. */
static json_t *make_geometry(struct view *view, const struct captured_geometry *geometry,
                             const struct mesh *mesh)
{
    const bool has_all = mesh->primitive_count == geometry->primitive_count;
    const uint32_t positions = add_array(view, mesh->positions,
                                         mesh->position_count * sizeof(*mesh->positions), false),
                   indices = add_array(view, mesh->indices,
                                       mesh->index_count * sizeof(*mesh->indices), false),
                   primitives =
                       has_all
                           ? CAPTURE_NONE
                           : add_array(view, mesh->primitives,
                                       mesh->primitive_count * sizeof(*mesh->primitives), false);
    const bool has_room = positions != CAPTURE_NONE && indices != CAPTURE_NONE &&
                          (has_all || primitives != CAPTURE_NONE);
    return json_pack("{s:b, s:i, s:I, s:i, s:o, s:o, s:o}", "opaque", (int)geometry->flags & 1,
                     "each", (int)mesh->each, "count", (json_int_t)geometry->primitive_count,
                     "shown", (int)mesh->primitive_count, "positions",
                     number_or_null(has_room ? positions : CAPTURE_NONE), "indices",
                     number_or_null(has_room ? indices : CAPTURE_NONE), "primitives",
                     number_or_null(primitives));
}

/* Returns the mesh of a build, which is made at its first use. */
static uint32_t mesh_of(struct view *view, uint32_t command)
{
    if (view->meshes[command] != CAPTURE_NONE)
        return view->meshes[command];
    const struct captured_command *build = &view->capture->commands[command];
    uint64_t left_out[LEFT_OUT] = {0};
    float box[6] = {INFINITY, INFINITY, INFINITY, -INFINITY, -INFINITY, -INFINITY};
    json_t *geometries = json_array();
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        struct mesh mesh = mesh_read(view->capture, &build->geometries[i], left_out, view->error);
        for (uint32_t j = 0; j < mesh.position_count; j++)
            extend_box(box, mesh.positions[j]);
        add(geometries, make_geometry(view, &build->geometries[i], &mesh));
        mesh_release(&mesh);
    }
    use(view, ENTRY_BYTES);
    json_t *corners = isfinite(box[0]) ? json_array() : json_null();
    for (int i = 0; i < 6; i++)
        json_array_append_new(corners, json_real((double)box[i]));
    view->meshes[command] = add(view->mesh_list, json_pack("{s:i, s:o, s:o, s:o}", "write",
                                                           (int)write_of(view, command, command),
                                                           "geometries", geometries, "box", corners,
                                                           "leftOut", make_left_out(left_out)));
    return view->meshes[command];
}

/* ---- moments */

/* Returns the number of a row, which all instances that are equal share, also those of other
 * moments; CAPTURE_NONE if there is no room. */
static uint32_t add_row(struct view *view, const VkAccelerationStructureInstanceKHR *row)
{
    uint64_t hash = XXH3_64bits(row, sizeof(*row));
    hash += !hash; /* key 0 is in no table */
    const uintptr_t known = (uintptr_t)handle_table_find(&view->row_ids, hash);
    if (known)
        return (uint32_t)known - 1;
    use(view, sizeof(*row));
    if (view->is_full)
        return CAPTURE_NONE;
    require_memory(
        ARRAY_HAS_ROOM(view->rows, view->row_count, view->row_capacity) &&
        handle_table_set(&view->row_ids, hash, (void *)((uintptr_t)view->row_count + 1)));
    view->rows[view->row_count] = *row;
    return view->row_count++;
}

/* Returns the array with the rows of instances, and sets how many it has: fewer if there is no
 * room. Half of it is for meshes. In a row the reference is replaced by numbers: that of the
 * structure, and above it the instance's. */
static uint32_t add_instances(struct view *view, const struct placing *placings, uint32_t count,
                              uint32_t *shown)
{
    uint32_t *numbers = capture_allocate(NULL, count, sizeof(*numbers));
    const size_t each = sizeof(*numbers) + (view->row_count ? 0 : 2 * sizeof(*view->rows)),
                 room = (view->limit - view->used) / each;
    for (*shown = 0; *shown < count && *shown < room; ++*shown) {
        VkAccelerationStructureInstanceKHR row = placings[*shown].instance;
        row.accelerationStructureReference =
            (uint64_t)placings[*shown].number << 32 | placings[*shown].structure;
        numbers[*shown] = add_row(view, &row);
        if (numbers[*shown] == CAPTURE_NONE)
            break;
    }
    view->is_full |= *shown < count;
    const uint32_t array = add_array(view, numbers, *shown * sizeof(*numbers), true);
    free(numbers);
    return array;
}

/* Adds pairs of numbers for all structures that instances refer to: its write, and its mesh. */
static void add_contents(struct view *view, const uint32_t *builds, const uint32_t *writes,
                         const struct placing *placings, uint32_t count, json_t *contents)
{
    bool *is_added = capture_allocate(NULL, view->capture->structure_count, sizeof(*is_added));
    memset(is_added, 0, view->capture->structure_count * sizeof(*is_added));
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t structure = placings[i].structure, build = builds[structure];
        if (is_added[structure])
            continue;
        is_added[structure] = true;
        add(contents, json_integer(write_of(view, writes[structure], build)));
        add(contents, json_integer(mesh_of(view, build)));
    }
    free(is_added);
}

/* Returns false if there is no room for the moment. Only the first one is shown in part. */
static bool add_moment(struct view *view, uint32_t command)
{
    struct capture *capture = view->capture;
    const uint32_t structure = capture->commands[command].dst;
    uint32_t *builds = contents_find_builds(capture, command + 1), count = 1,
             *writes = capture_allocate(NULL, capture->structure_count, sizeof(*writes));
    for (uint32_t i = 0; i <= command; i++)
        if (is_write(&capture->commands[i]))
            writes[capture->commands[i].dst] = i;
    const uint32_t build = builds[structure];
    const bool is_top = contents_is_top(capture, build);
    uint64_t left_out[LEFT_OUT] = {0};
    struct placing alone = {.structure = structure}, *placings = &alone;
    for (int i = 0; i < 3; i++)
        alone.instance.transform.matrix[i][i] = 1;
    if (is_top)
        placings = contents_read_instances(capture, builds, &capture->commands[build], &count,
                                           left_out, view->error);
    uint32_t shown;
    const uint32_t array = add_instances(view, placings, count, &shown);
    const bool is_shown = shown == count || json_array_size(view->moments) == 0;
    if (is_shown) {
        json_t *contents = json_array();
        add_contents(view, builds, writes, placings, shown, contents);
        use(view, ENTRY_BYTES + 8 * json_array_size(contents));
        add(view->moments, json_pack("{s:i, s:i, s:b, s:i, s:i, s:o, s:o}", "write",
                                     (int)write_of(view, command, build), "content",
                                     (int)write_of(view, build, build), "isTop", is_top,
                                     "instances", (int)array, "noRoom", (int)(count - shown),
                                     "contents", contents, "leftOut", make_left_out(left_out)));
    }
    if (is_top)
        free(placings);
    free(builds);
    free(writes);
    return is_shown;
}

static int compare_moments(const void *first, const void *second)
{
    const struct moment *a = first, *b = second;
    if (a->importance != b->importance)
        return a->importance < b->importance ? -1 : 1;
    return (a->command < b->command) - (a->command > b->command); /* the newest first */
}

/* Finds all commands after which the capture has the data of what they wrote, the most important
 * first. Returns how many there are. */
static uint32_t find_moments(const struct capture *capture, struct moment *moments)
{
    uint32_t *builds = contents_find_builds(capture, 0), count = 0, kept = 0,
             *writes = capture_allocate(NULL, capture->structure_count, sizeof(*writes));
    bool *is_held = capture_allocate(NULL, capture->command_count, sizeof(*is_held)),
         *has_findings = capture_allocate(NULL, capture->command_count, sizeof(*has_findings));
    memset(is_held, 0, capture->command_count * sizeof(*is_held));
    memset(has_findings, 0, capture->command_count * sizeof(*has_findings));
    for (uint32_t i = 0; i < capture->finding_count; i++)
        if (capture->findings[i].command != CAPTURE_NONE)
            has_findings[capture->findings[i].command] = true;
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        contents_execute(capture, i, builds);
        if (!is_write(command) || builds[command->dst] == CAPTURE_NONE)
            continue;
        writes[command->dst] = i;
        const bool is_top = contents_is_top(capture, builds[command->dst]);
        moments[count++] =
            (struct moment){i, builds[command->dst], is_top ? LAST_OF_TOP : HELD_BY_NO_TOP};
        const struct captured_command *build = &capture->commands[builds[command->dst]];
        for (uint32_t j = 0; j < build->reference_count; j++) {
            const uint32_t structure = build->references[j].structure;
            if (structure != CAPTURE_NONE && builds[structure] != CAPTURE_NONE)
                is_held[builds[structure]] = true;
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        struct moment moment = moments[i];
        if (moment.importance == HELD_BY_NO_TOP && is_held[moment.build])
            continue;
        if (has_findings[moment.command])
            moment.importance = HAS_FINDINGS;
        if (moment.importance == LAST_OF_TOP &&
            writes[capture->commands[moment.command].dst] != moment.command)
            moment.importance = EARLIER;
        moments[kept++] = moment;
    }
    free(builds);
    free(writes);
    free(is_held);
    free(has_findings);
    qsort(moments, kept, sizeof(*moments), compare_moments);
    return kept;
}

/* ---- structures */

static json_t *make_structure(const struct capture *capture, uint32_t index, uint32_t born,
                              uint32_t died)
{
    const struct captured_structure *structure = &capture->structures[index];
    char handle[20];
    snprintf(handle, sizeof(handle), "0x%llx", (unsigned long long)structure->handle);
    json_t *object =
        json_pack("{s:s, s:s*, s:s, s:I, s:I}", "handle", handle, "name", structure->name, "type",
                  capture_structure_type_name(structure->type), "size", (json_int_t)structure->size,
                  "born", (json_int_t)capture->commands[born].n);
    if (died < capture->command_count)
        json_object_set_new(object, "died", json_integer((json_int_t)capture->commands[died].n));
    if (structure->buffer == CAPTURE_NONE ||
        capture->buffers[structure->buffer].memory == CAPTURE_NONE)
        return object;
    const struct captured_buffer *buffer = &capture->buffers[structure->buffer];
    const uint64_t offset = buffer->memory_offset + structure->offset;
    json_object_set_new(object, "memory",
                        json_integer((json_int_t)capture->memories[buffer->memory].id));
    json_object_set_new(object, "offset", json_integer((json_int_t)offset));
    return object;
}

/* Returns, by their indices, the structures that writes name, and those that were alive at a moment
 * which is shown: they may share memory. */
static json_t *make_structures(const struct view *view, const struct moment *moments,
                               uint32_t moment_count)
{
    const struct capture *capture = view->capture;
    const uint32_t commands = capture->command_count, count = capture->structure_count;
    uint32_t *shown =
                 capture_allocate(NULL, commands + (size_t)1, sizeof(*shown)), /* before each */
        *born = capture_allocate(NULL, count, sizeof(*born)),
             *died = capture_allocate(NULL, count, sizeof(*died));
    memset(shown, 0, (commands + (size_t)1) * sizeof(*shown));
    memset(born, 0xff, count * sizeof(*born));
    for (uint32_t i = 0; i < moment_count; i++)
        shown[moments[i].command + 1] = 1;
    for (uint32_t i = 0; i < commands; i++) {
        const struct captured_command *command = &capture->commands[i];
        shown[i + 1] += shown[i];
        if (is_write(command) && born[command->dst] == CAPTURE_NONE) {
            born[command->dst] = i;
            died[command->dst] = commands;
        } else if (command->kind == CAPTURE_DESTROYED && command->dst != CAPTURE_NONE) {
            died[command->dst] = i;
        }
    }
    json_t *structures = json_object();
    for (uint32_t i = 0; i < count; i++) {
        char key[16];
        snprintf(key, sizeof(key), "%u", i);
        if (view->is_named[i] || (born[i] != CAPTURE_NONE && shown[died[i]] > shown[born[i]]))
            json_object_set_new(structures, key, make_structure(capture, i, born[i], died[i]));
    }
    free(shown);
    free(born);
    free(died);
    return structures;
}

/* ---- the file */

static uint32_t count_missing(const struct capture *capture)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < capture->structure_count; i++)
        count += capture->structures[i].missing != NULL;
    return count;
}

bool export_view(struct capture *capture, const char *path, uint64_t limit,
                 struct capture_error *error)
{
    struct view view = {
        .capture = capture,
        .error = error,
        .limit = limit,
        .writes = capture_allocate(NULL, capture->command_count, sizeof(*view.writes)),
        .meshes = capture_allocate(NULL, capture->command_count, sizeof(*view.meshes)),
        .arrays = json_array(),
        .mesh_list = json_array(),
        .written = json_array(),
        .moments = json_array(),
    };
    memset(view.writes, 0xff, capture->command_count * sizeof(*view.writes));
    memset(view.meshes, 0xff, capture->command_count * sizeof(*view.meshes));
    view.is_named = memset(capture_allocate(NULL, capture->structure_count, sizeof(*view.is_named)),
                           0, capture->structure_count * sizeof(*view.is_named));
    error->text[0] = '\0';
    struct moment *moments = capture_allocate(NULL, capture->command_count, sizeof(*moments));
    const uint32_t moment_count = find_moments(capture, moments);
    uint32_t shown = 0;
    while (shown < moment_count && !view.is_full && add_moment(&view, moments[shown].command))
        shown++;
    const uint32_t rows = add_array(&view, view.rows, view.row_count * sizeof(*view.rows), true);
    json_t *root = json_pack(
        "{s:i, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:s?}", "rows", (int)rows, "moments",
        view.moments, "writes", view.written, "meshes", view.mesh_list, "arrays", view.arrays,
        "structures", make_structures(&view, moments, shown), "leftOut",
        (int)(moment_count - shown), "missing", (int)count_missing(capture), "end", capture->end);
    const bool is_written = !error->text[0] && json_dump_file(root, path, JSON_COMPACT) == 0;
    if (!is_written && !error->text[0])
        snprintf(error->text, sizeof(error->text), "%s: cannot be written", path);
    json_decref(root);
    free(moments);
    free(view.rows);
    free(view.writes);
    free(view.meshes);
    free(view.is_named);
    handle_table_release(&view.array_ids);
    handle_table_release(&view.row_ids);
    return is_written;
}
