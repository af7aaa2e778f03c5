/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene info: figures of a capture. They are collected as JSON, of which the tables are made.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <vulkan/vulkan_core.h>

#include "src/base/text_buffer.h"
#include "src/scene/tool.h"

enum { ROWS_MOST = 40, CELL_SIZE = 64 };

/* What happened to a structure. What is built into it can move on by copies and updates: `root` is
 * the structure that it was built in. */
struct structure_use {
    uint32_t root;
    uint32_t geometries, builds, updates, compactions, copies, destructions, instances;
    uint64_t primitives;
    uint32_t flags;
    bool is_updated, is_compacted, is_referred_to, has_motion_data; /* of roots */
};

/* What a scene can have, in the order of the list. */
#define EFFECT_LIST(X)                                                                             \
    X(HOST_BUILDS, "builds by the host")                                                           \
    X(INDIRECT_BUILDS, "indirect builds")                                                          \
    X(UPDATES, "updates")                                                                          \
    X(COMPACTIONS, "compactions")                                                                  \
    X(CLONES, "clones")                                                                            \
    X(DESERIALIZATIONS, "deserializations")                                                        \
    X(SEVERAL_GEOMETRIES, "builds of several geometries")                                          \
    X(OPAQUE, "opaque geometries")                                                                 \
    X(NO_DUPLICATES, "geometries without duplicate any-hit invocations")                           \
    X(GEOMETRY_TRANSFORMS, "geometries with a transform")                                          \
    X(BOXES, "geometries of AABBs")                                                                \
    X(SPHERES, "geometries of spheres")                                                            \
    X(SWEPT_SPHERES, "geometries of linear swept spheres")                                         \
    X(DENSE, "geometries of dense triangles")                                                      \
    X(MOTION, "builds with motion")                                                                \
    X(OPACITY_MICROMAPS, "geometries with opacity micromaps")                                      \
    X(DISPLACEMENTS, "geometries with displacement micromaps")                                     \
    X(POINTERS, "arrays of pointers to instances")                                                 \
    X(NO_CULLING, "instances without culling of faces")                                            \
    X(FLIPPED_FACES, "instances with flipped faces")                                               \
    X(FORCED_OPAQUE, "instances that are forced to be opaque")                                     \
    X(FORCED_NON_OPAQUE, "instances that are forced not to be opaque")                             \
    X(FORCED_2_STATE, "instances with micromaps forced to two states")                             \
    X(NO_MICROMAPS, "instances without their micromaps")                                           \
    X(MIRRORED, "instances with a mirrored transform")                                             \
    X(MASKED, "instances with another mask than 0xff")                                             \
    X(NULL_INSTANCES, "instances without a structure")
#define NUMBER_OF(name, text) name,
#define TEXT_OF(name, text) text,
enum effect { EFFECT_LIST(NUMBER_OF) EFFECTS };
static const char *const effects[] = {EFFECT_LIST(TEXT_OF)};

struct figures {
    struct capture *capture;
    struct structure_use *uses;
    uint64_t effects[EFFECTS], inputs;
    bool has_references;
};

/* ---- collecting */

static void count_instance(struct figures *figures, const VkAccelerationStructureInstanceKHR *from)
{
    const struct {
        VkGeometryInstanceFlagsKHR flag;
        enum effect effect;
    } flags[] = {
        {VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR, NO_CULLING},
        {VK_GEOMETRY_INSTANCE_TRIANGLE_FLIP_FACING_BIT_KHR, FLIPPED_FACES},
        {VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR, FORCED_OPAQUE},
        {VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR, FORCED_NON_OPAQUE},
        {VK_GEOMETRY_INSTANCE_FORCE_OPACITY_MICROMAP_2_STATE_BIT_EXT, FORCED_2_STATE},
        {VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_EXT, NO_MICROMAPS},
    };
    for (size_t i = 0; i < sizeof(flags) / sizeof(*flags); i++)
        figures->effects[flags[i].effect] += (from->flags & flags[i].flag) != 0;
    const float(*m)[4] = from->transform.matrix;
    const double determinant =
        (double)m[0][0] * ((double)m[1][1] * m[2][2] - (double)m[1][2] * m[2][1]) -
        (double)m[0][1] * ((double)m[1][0] * m[2][2] - (double)m[1][2] * m[2][0]) +
        (double)m[0][2] * ((double)m[1][0] * m[2][1] - (double)m[1][1] * m[2][0]);
    figures->effects[MIRRORED] += determinant < 0;
    figures->effects[MASKED] += from->mask != 0xff;
    figures->effects[NULL_INSTANCES] += from->accelerationStructureReference == 0;
}

/* The last build of each top-level structure says how often each structure is there. */
static bool count_instances(struct figures *figures, const struct captured_command *build,
                            struct capture_error *error)
{
    const struct captured_input *input =
        build->geometry_count ? capture_input_of(build->geometries, CAPTURE_INSTANCE_ROWS) : NULL;
    if (!input || input->data == CAPTURE_NONE ||
        figures->capture->data[input->data].element != CAPTURE_INSTANCE)
        return true;
    const VkAccelerationStructureInstanceKHR *rows =
        capture_load_data(figures->capture, input->data, error);
    for (uint64_t i = 0; rows && i < figures->capture->data[input->data].rows; i++) {
        VkAccelerationStructureInstanceKHR instance;
        memcpy(&instance, (const char *)rows + i * sizeof(instance), sizeof(instance));
        count_instance(figures, &instance);
        const struct captured_reference *reference =
            capture_reference_of(build, instance.accelerationStructureReference);
        if (reference && reference->structure != CAPTURE_NONE)
            figures->uses[reference->structure].instances++;
    }
    capture_release_data(figures->capture, input->data);
    return rows;
}

static void count_geometry(struct figures *figures, const struct captured_geometry *geometry,
                           struct structure_use *root)
{
    static const enum effect of_types[CAPTURE_GEOMETRY_TYPES] = {
        [CAPTURE_AABBS] = BOXES,
        [CAPTURE_SPHERES] = SPHERES,
        [CAPTURE_SWEPT_SPHERES] = SWEPT_SPHERES,
        [CAPTURE_DENSE_TRIANGLES] = DENSE,
    };
    uint64_t *counts = figures->effects;
    if (of_types[geometry->type])
        counts[of_types[geometry->type]]++;
    counts[OPAQUE] += (geometry->flags & VK_GEOMETRY_OPAQUE_BIT_KHR) != 0;
    counts[NO_DUPLICATES] +=
        (geometry->flags & VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR) != 0;
    counts[GEOMETRY_TRANSFORMS] += capture_input_of(geometry, CAPTURE_TRANSFORM) != NULL;
    counts[OPACITY_MICROMAPS] += capture_input_of(geometry, CAPTURE_OPACITY_INDICES) != NULL;
    counts[DISPLACEMENTS] += capture_input_of(geometry, CAPTURE_DISPLACEMENTS) != NULL;
    counts[POINTERS] += geometry->array_of_pointers;
    root->has_motion_data |= capture_input_of(geometry, CAPTURE_MOTION_VERTICES) != NULL;
    figures->inputs += geometry->input_count;
}

static void count_build(struct figures *figures, const struct captured_command *build)
{
    struct structure_use *uses = figures->uses, *use = &uses[build->dst];
    if (build->mode == CAPTURE_UPDATE) {
        const uint32_t root = uses[build->src == CAPTURE_NONE ? build->dst : build->src].root;
        use->updates++;
        use->root = root;
        uses[root].is_updated = true;
        figures->effects[UPDATES]++;
    } else {
        use->builds++;
        use->root = build->dst;
    }
    figures->effects[MOTION] += (build->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) != 0;
    figures->effects[SEVERAL_GEOMETRIES] += build->geometry_count > 1;
    figures->effects[HOST_BUILDS] += build->queue == 0;
    figures->effects[INDIRECT_BUILDS] += build->command && strstr(build->command, "Indirect");
    use->flags = build->flags;
    use->geometries = build->geometry_count;
    use->primitives = 0;
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        use->primitives += build->geometries[i].primitive_count;
        count_geometry(figures, &build->geometries[i], &uses[use->root]);
    }
    for (uint32_t i = 0; i < build->reference_count; i++) {
        figures->has_references = true;
        if (build->references[i].structure != CAPTURE_NONE)
            uses[uses[build->references[i].structure].root].is_referred_to = true;
    }
}

static void count_copy(struct figures *figures, const struct captured_command *copy)
{
    struct structure_use *use = &figures->uses[copy->dst];
    figures->effects[CLONES] += copy->mode == CAPTURE_CLONE;
    figures->effects[DESERIALIZATIONS] += copy->mode == CAPTURE_DESERIALIZE;
    figures->effects[COMPACTIONS] += copy->mode == CAPTURE_COMPACT;
    if (copy->src == CAPTURE_NONE)
        return;
    struct structure_use *src = &figures->uses[copy->src];
    src->copies += copy->mode == CAPTURE_CLONE;
    src->compactions += copy->mode == CAPTURE_COMPACT;
    figures->uses[src->root].is_compacted |= copy->mode == CAPTURE_COMPACT;
    use->root = src->root;
    use->flags = src->flags;
    use->geometries = src->geometries;
    use->primitives = src->primitives;
}

static bool count_commands(struct figures *figures, struct capture_error *error)
{
    const struct capture *capture = figures->capture;
    uint32_t *last = capture_allocate(NULL, capture->structure_count, sizeof(*last));
    memset(last, 0xff, capture->structure_count * sizeof(*last));
    for (uint32_t i = 0; i < capture->structure_count; i++)
        figures->uses[i].root = i;
    for (uint32_t i = 0; i < capture->command_count; i++) {
        const struct captured_command *command = &capture->commands[i];
        if (command->dst == CAPTURE_NONE)
            continue;
        if (command->kind == CAPTURE_COMMAND_BUILD) {
            count_build(figures, command);
            last[command->dst] = command->reference_count ? i : CAPTURE_NONE;
        } else if (command->kind == CAPTURE_COMMAND_COPY) {
            count_copy(figures, command);
        } else if (command->kind == CAPTURE_DESTROYED) {
            figures->uses[command->dst].destructions++;
        }
    }
    bool is_read = true;
    for (uint32_t i = 0; i < capture->structure_count && is_read; i++)
        is_read =
            last[i] == CAPTURE_NONE || count_instances(figures, &capture->commands[last[i]], error);
    free(last);
    return is_read;
}

/* ---- as JSON */

static json_t *make_devices(const struct capture *capture)
{
    json_t *devices = json_array();
    for (uint32_t i = 0; i < capture->device_count; i++) {
        const struct captured_device *device = &capture->devices[i];
        json_array_append_new(devices,
                              json_pack("{s:s*, s:s*, s:s*}", "device", device->name, "driver",
                                        device->driver, "version", device->driver_info));
    }
    return devices;
}

static json_t *make_counts(const struct structure_use *use, uint64_t bytes)
{
    return json_pack("{s:I, s:I, s:i, s:i, s:i, s:i, s:i, s:i}", "primitives",
                     (json_int_t)use->primitives, "bytes", (json_int_t)bytes, "builds", use->builds,
                     "updates", use->updates, "compactions", use->compactions, "clones",
                     use->copies, "destroyed", use->destructions, "instances", use->instances);
}

static json_t *make_structures(const struct figures *figures)
{
    json_t *structures = json_array();
    for (uint32_t i = 0; i < figures->capture->structure_count; i++) {
        const struct captured_structure *structure = &figures->capture->structures[i];
        const struct structure_use *use = &figures->uses[i];
        json_t *object =
            json_pack("{s:I, s:s, s:s, s:o, s:i}", "structure", (json_int_t)structure->id, "name",
                      structure->name ? structure->name : "", "type",
                      capture_structure_type_name(structure->type), "flags",
                      json_sprintf("0x%" PRIx32, use->flags), "geometries", use->geometries);
        json_object_update_new(object, make_counts(use, structure->size));
        json_array_append_new(structures, object);
    }
    return structures;
}

static json_t *make_types(const struct figures *figures)
{
    json_t *types = json_array();
    for (uint32_t type = 0; type < CAPTURE_STRUCTURE_TYPES; type++) {
        struct structure_use sum = {.root = 0};
        uint64_t bytes = 0;
        int count = 0;
        for (uint32_t i = 0; i < figures->capture->structure_count; i++) {
            const struct structure_use *use = &figures->uses[i];
            if (figures->capture->structures[i].type != type)
                continue;
            count++;
            bytes += figures->capture->structures[i].size;
            sum.primitives += use->primitives;
            sum.builds += use->builds;
            sum.updates += use->updates;
            sum.compactions += use->compactions;
            sum.copies += use->copies;
            sum.destructions += use->destructions;
            sum.instances += use->instances;
        }
        json_t *object = json_pack("{s:s, s:i}", "type",
                                   capture_structure_type_name((enum capture_structure_type)type),
                                   "structures", count);
        json_object_update_new(object, make_counts(&sum, bytes));
        if (count)
            json_array_append(types, object);
        json_decref(object);
    }
    return types;
}

static json_t *make_effects(const struct figures *figures)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < EFFECTS; i++)
        if (figures->effects[i])
            json_array_append_new(list, json_pack("{s:s, s:I}", "effect", effects[i], "count",
                                                  (json_int_t)figures->effects[i]));
    return list;
}

/* Whether a structure has something that it never uses. Only structures that were built count. */
static bool is_unused(const struct figures *figures, uint32_t structure, uint32_t way)
{
    const struct structure_use *use = &figures->uses[structure];
    const enum capture_structure_type type = figures->capture->structures[structure].type;
    if (!use->builds)
        return false;
    switch (way) {
    case 0:
        return (use->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) &&
               !use->is_updated;
    case 1:
        return (use->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR) &&
               !use->is_compacted;
    case 2:
        return (use->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV) &&
               type == CAPTURE_BOTTOM && !use->has_motion_data;
    default:
        return figures->has_references && type == CAPTURE_BOTTOM && !use->is_referred_to;
    }
}

static json_t *make_unused(const struct figures *figures)
{
    static const char *const ways[] = {
        "ALLOW_UPDATE, never updated",
        "ALLOW_COMPACTION, never compacted",
        "MOTION, no motion data",
        "built, never referred to",
    };
    json_t *list = json_array();
    for (uint32_t way = 0; way < sizeof(ways) / sizeof(*ways); way++) {
        json_t *structures = json_array();
        for (uint32_t i = 0; i < figures->capture->structure_count; i++)
            if (is_unused(figures, i, way))
                json_array_append_new(structures,
                                      json_integer((json_int_t)figures->capture->structures[i].id));
        if (json_array_size(structures))
            json_array_append_new(list, json_pack("{s:s, s:I, s:O}", "unused", ways[way], "count",
                                                  (json_int_t)json_array_size(structures),
                                                  "structures", structures));
        json_decref(structures);
    }
    return list;
}

static json_t *make_summary(const struct figures *figures)
{
    const struct capture *capture = figures->capture;
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < capture->data_count; i++)
        bytes += capture->data[i].size;
    return json_pack("{s:s, s:s*, s:s*, s:s*, s:s*, s:i, s:i, s:I, s:I, s:i, s:s}", "capture",
                     capture->folder, "application", capture->application, "executable",
                     capture->executable, "layer", capture->layer_version, "time", capture->time,
                     "commands", capture->command_count, "arrays", capture->data_count,
                     "bytes of arrays", (json_int_t)bytes, "inputs", (json_int_t)figures->inputs,
                     "findings", capture->finding_count, "end",
                     capture->end ? capture->end : "the process ended without one");
}

/* ---- as text */

static void write_cell(const json_t *value, char cell[CELL_SIZE])
{
    struct text_buffer text;
    text_begin(&text, cell, CELL_SIZE);
    if (json_is_string(value))
        text_append_escaped(&text, json_string_value(value), json_string_length(value));
    else if (json_is_integer(value))
        text_append_decimal(&text, (uint64_t)json_integer_value(value));
}

/* Prints an array of objects with the same keys. */
static void print_table(const json_t *rows, size_t most)
{
    const json_t *first = json_array_get(rows, 0);
    const size_t count = json_array_size(rows), shown = count < most ? count : most;
    for (size_t i = 0; i <= shown && count; i++) {
        const char *key;
        json_t *value;
        json_object_foreach((json_t *)(uintptr_t)first, key, value)
        {
            if (json_is_array(value))
                continue;
            size_t width = strlen(key);
            char cell[CELL_SIZE];
            for (size_t j = 0; j < shown; j++) {
                write_cell(json_object_get(json_array_get(rows, j), key), cell);
                width = strlen(cell) > width ? strlen(cell) : width;
            }
            if (i > 0)
                write_cell(json_object_get(json_array_get(rows, i - 1), key), cell);
            printf(json_is_string(value) ? "  %-*s" : "  %*s", (int)width, i ? cell : key);
        }
        putchar('\n');
    }
    if (shown < count)
        printf("  ... and %zu more: --all lists them\n", count - shown);
}

static void print_text(const json_t *info, bool lists_all)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)info, key, value)
    {
        if (json_is_array(value)) {
            printf("\n%s%s\n", key, json_array_size(value) ? "" : ": none");
            print_table(value, lists_all ? SIZE_MAX : ROWS_MOST);
            continue;
        }
        const char *name;
        json_t *member;
        json_object_foreach(value, name, member)
        {
            char cell[CELL_SIZE];
            write_cell(member, cell);
            printf("%-16s  %s\n", name, cell);
        }
    }
}

json_t *info_make(struct capture *capture, struct capture_error *error)
{
    struct figures figures = {.capture = capture};
    figures.uses = capture_allocate(NULL, capture->structure_count, sizeof(*figures.uses));
    memset(figures.uses, 0, capture->structure_count * sizeof(*figures.uses));
    json_t *info = NULL;
    if (count_commands(&figures, error))
        info = json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "summary", make_summary(&figures),
                         "devices", make_devices(capture), "types of structures",
                         make_types(&figures), "structures", make_structures(&figures), "effects",
                         make_effects(&figures), "enabled and not used", make_unused(&figures));
    free(figures.uses);
    return info;
}

bool info_print(struct capture *capture, bool is_json, bool lists_all, struct capture_error *error)
{
    json_t *info = info_make(capture, error);
    if (!info)
        return false;
    if (is_json)
        json_dumpf(info, stdout, JSON_INDENT(2));
    else
        print_text(info, lists_all);
    putchar('\n');
    json_decref(info);
    return true;
}
