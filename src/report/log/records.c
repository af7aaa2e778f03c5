/* SPDX-License-Identifier: Apache-2.0 */
/* Composes the lines of record_builds = true. */
#include "src/report/log/records.h"

#include "src/report/log/lines.h"
#include "src/state/commands/object_names.h"
#include "src/state/order/order.h"

/* More do not fit into a line for certain. */
enum { COMMAND_BUFFERS_SHOWN = 4096 };

static void write_name(struct json *json, const char *key, const struct log_record *record,
                       VkObjectType type, uint64_t handle)
{
    char name[MESSAGE_NAME_SIZE];
    if (record->names && object_names_get(record->names, type, handle, name, sizeof(name)))
        json_text(json, key, name);
}

static void write_object(struct json *json, const char *key, const char *name_key,
                         const struct log_record *record, VkObjectType type, uint64_t handle)
{
    if (!handle)
        return;
    json_hex(json, key, handle);
    write_name(json, name_key, record, type, handle);
}

static void write_queue(struct json *json, const struct log_record *record)
{
    json_hex(json, "device", (uint64_t)(uintptr_t)record->device);
    if (!record->queue)
        return;
    json_hex(json, "queue", (uint64_t)(uintptr_t)record->queue);
    if (record->submission)
        json_number(json, "submission", record->submission);
}

static void write_command_buffers(struct json *json, const struct log_record *record)
{
    json_begin_array(json, "command_buffers");
    for (uint32_t i = 0; i < record->command_count && i < COMMAND_BUFFERS_SHOWN; i++)
        json_hex(json, NULL, (uint64_t)(uintptr_t)record->commands[i].handle);
    json_end_array(json);
}

static void write_structure(struct json *json, const struct log_record *record)
{
    write_object(json, "dst", "dst_name", record, record->object_type, record->dst);
    write_object(json, "src", "src_name", record, record->object_type, record->src);
}

static void write_command(struct json *json, const struct log_record *record)
{
    write_object(json, "command_buffer", "command_buffer_name", record,
                 VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)record->command_buffer);
    if (record->has_position)
        json_number(json, "build", record->position);
    json_text(json, "mode", record->mode);
    json_text(json, "type", record->type);
    write_structure(json, record);
    if (record->has_geometries)
        json_number(json, "geometries", record->geometries);
    if (record->has_primitives)
        json_number(json, "primitives", record->primitives);
    if (record->size)
        json_number(json, "size", record->size);
    if (record->memory) {
        json_hex(json, "memory", (uint64_t)(uintptr_t)record->memory);
        json_number(json, "memory_offset", record->memory_offset);
    }
}

bool line_of_record(struct json *json, const struct log_record *record)
{
    static const char *const types[] = {
        [RECORD_SUBMISSION] = "Submission",
        [RECORD_BUILD] = "Build",
        [RECORD_COPY] = "Copy",
        [RECORD_SIZE] = "CompactedSize",
    };
    line_begin(json, types[record->kind]);
    write_queue(json, record);
    switch (record->kind) {
    case RECORD_SUBMISSION:
        write_command_buffers(json, record);
        break;
    case RECORD_BUILD:
    case RECORD_COPY:
        write_command(json, record);
        break;
    case RECORD_SIZE:
        write_structure(json, record);
        json_number(json, "compacted_size", record->compacted_size);
        break;
    }
    return json_end(json);
}
