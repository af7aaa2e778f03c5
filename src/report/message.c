/* SPDX-License-Identifier: Apache-2.0 */
/* Paths of fields and call sites, parts of messages, filters by names, and the text of the log. */
#include "src/report/message.h"

#include <inttypes.h>
#include <string.h>

#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/ids/message_filter.h"
#include "src/state/commands/call_sites.h"
#include "src/state/commands/object_names.h"
#include "src/state/resources/destroyed.h"
#include "src/state/resources/resources.h"

enum { MODULE_SHOWN = 512 };

void message_append_build(struct text_buffer *text, enum build_command command, uint32_t build)
{
    if (command == COMMAND_NV)
        text_append(text, "pInfo");
    else if (command == COMMAND_GetAccelerationStructureBuildSizesKHR)
        text_append(text, "pBuildInfo");
    else if (command == COMMAND_CreateAccelerationStructureNV)
        text_append(text, "pCreateInfo->info");
    else
        text_append(text, "pInfos[%" PRIu32 "]", build);
}

const char *message_separator(enum build_command command)
{
    return command == COMMAND_NV || command == COMMAND_GetAccelerationStructureBuildSizesKHR ? "->"
                                                                                             : ".";
}

void message_append_field(struct text_buffer *text, const char *separator, const char *field)
{
    if (field[0])
        text_append(text, "%s%s", separator, field);
}

/* A range of the indirect command lies in device memory; only its count is a parameter, and has no
 * fields. */
static const char *ranges_name(enum build_command command, const char *field)
{
    if (command != COMMAND_INDIRECT)
        return "ppBuildRangeInfos";
    return field[0] ? "pIndirectDeviceAddresses" : "ppMaxPrimitiveCounts";
}

/* Appends a field in which [] stands for an index. */
static void append_indexed(struct text_buffer *text, const char *field, uint32_t index)
{
    const char *gap = strstr(field, "[]");
    if (gap)
        text_append(text, "%.*s[%" PRIu32 "]%s", (int)(gap - field), field, index, gap + 2);
    else
        text_append(text, "%s", field);
}

static void append_argument(struct text_buffer *text, const struct location *at, const char *field)
{
    text_append(text, "%s", at->argument ? at->argument : "");
    if (at->is_element)
        text_append(text, "[%" PRIu32 "]", at->build);
    if (at->argument && field[0])
        text_append(text, at->is_element ? "." : "->");
    append_indexed(text, field, at->geometry);
}

void message_append_path(struct text_buffer *text, const struct location *at, const char *field)
{
    const char *separator = message_separator(at->command);
    switch (at->subject) {
    case SUBJECT_CALL:
    case SUBJECT_PARAMETER:
        text_append(text, "%s", field);
        return;
    case SUBJECT_BUILD:
        message_append_build(text, at->command, at->build);
        message_append_field(text, separator, field);
        return;
    case SUBJECT_GEOMETRY:
        message_append_build(text, at->command, at->build);
        text_append(text, "%s%s[%" PRIu32 "]", separator,
                    at->geometry_by_pointer ? "ppGeometries" : "pGeometries", at->geometry);
        message_append_field(text, at->geometry_by_pointer ? "->" : ".", field);
        return;
    case SUBJECT_RANGE:
        text_append(text, "%s[%" PRIu32 "][%" PRIu32 "]", ranges_name(at->command, field),
                    at->build, at->geometry);
        message_append_field(text, ".", field);
        return;
    case SUBJECT_ARGUMENT:
        append_argument(text, at, field);
        return;
    case SUBJECT_ELEMENT:
        text_append(text, "%s[%" PRIu32 "]", field, at->build);
        return;
    }
}

static bool append_destroyed(struct text_buffer *text, const struct value *value,
                             const struct call_origin *origin)
{
    struct destroyed_object object;
    if (!origin->destroyed ||
        !destroyed_objects_find(origin->destroyed, value->object_type, value->number, &object))
        return false;
    uint64_t submissions = origin->submissions ? origin->submissions
                                               : destroyed_objects_submissions(origin->destroyed);
    text_append(text, " %s 0x%" PRIx64, object_type_name(object.type), object.handle);
    if (object.name[0]) {
        text_append(text, "[");
        text_append_quoted(text, object.name, sizeof(object.name) - 1);
        text_append(text, "]");
    }
    text_append(text, " had this address and was destroyed ");
    if (submissions > object.submissions) {
        text_append_count(text, submissions - object.submissions, "submission");
        text_append(text, " ago.");
    } else {
        text_append(text, "since the last submission.");
    }
    return true;
}

/* Farther away, the buffer has nothing to do with the address. */
enum { DISTANCE_SHOWN = 1 << 20 };

static void append_buffer_before(struct text_buffer *text, struct message *message,
                                 const struct value *value)
{
    const struct call_origin *origin = message->origin;
    struct resources_before before;
    if (value->object_type != VK_OBJECT_TYPE_BUFFER || !origin->resources ||
        !resources_find_before(origin->resources, value->number, &before) ||
        before.distance > DISTANCE_SHOWN)
        return;
    text_append(text, " It is ");
    text_append_count(text, before.distance, "byte");
    text_append(text, " past the end of ");
    message_append_object(text, message, VK_OBJECT_TYPE_BUFFER, handle_number(before.buffer),
                          origin->names);
    text_append(text, ".");
}

void message_append_about_address(struct text_buffer *text, struct message *message,
                                  const struct value *value)
{
    if (value->kind == VALUE_ADDRESS && !append_destroyed(text, value, message->origin))
        append_buffer_before(text, message, value);
}

void message_append_call_frames(struct text_buffer *text, const struct call_site *site,
                                uint32_t most)
{
    for (uint32_t i = 0; i < site->count && i < most; i++) {
        text_append_plain(text, i ? ", " : "");
        text_append_escaped(text, call_frame_module(&site->frames[i]), MODULE_SHOWN);
        text_append_plain(text, "+");
        text_append_hex(text, site->frames[i].offset);
    }
}

void message_append_call_site(struct text_buffer *text, const struct call_site *site, uint32_t most)
{
    text_append_plain(text, " Called from ");
    message_append_call_frames(text, site, most);
    text_append_plain(text, ".");
}

/* ---- parts of messages, filters by names, and the text of the log */

enum { LAST_NOTICE_SIZE = 384, FRAMES_SHOWN = 4 };

/* ---- objects and labels */

/* Returns the entry of an object of that name ("": none); adds it at the first mention. Returns
 * NULL if there is no room. */
static const VkDebugUtilsObjectNameInfoEXT *
mention_named(struct message *message, VkObjectType type, uint64_t handle, const char *name)
{
    for (uint32_t i = 0; i < message->object_count; i++)
        if (message->objects[i].objectType == type && message->objects[i].objectHandle == handle &&
            strcmp(message->names[i], name) == 0)
            return &message->objects[i];
    if (message->object_count == MESSAGE_OBJECTS)
        return NULL;

    uint32_t i = message->object_count++;
    snprintf(message->names[i], MESSAGE_NAME_SIZE, "%s", name);
    message->objects[i] = (VkDebugUtilsObjectNameInfoEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name[0] ? message->names[i] : NULL,
    };
    return &message->objects[i];
}

/* The same for a live object, or for one that messages never name. */
static const VkDebugUtilsObjectNameInfoEXT *mention(struct message *message, VkObjectType type,
                                                    uint64_t handle,
                                                    const struct object_names *names)
{
    char name[MESSAGE_NAME_SIZE] = "";
    if (names)
        object_names_get(names, type, handle, name, sizeof(name));
    return mention_named(message, type, handle, name);
}

/* Appends an object such as VkBuffer 0x12["vertices"]. */
static void append_object(struct text_buffer *text, const VkDebugUtilsObjectNameInfoEXT *object)
{
    const char *type = object_type_name(object->objectType);
    text_append(text, "%s 0x%" PRIx64, type ? type : "object", object->objectHandle);
    if (!object->pObjectName)
        return;
    text_append(text, "[");
    text_append_quoted(text, object->pObjectName, MESSAGE_NAME_SIZE - 1);
    text_append(text, "]");
}

/* Returns the number of labels copied. */
static uint32_t copy_labels(VkDebugUtilsLabelEXT labels[MESSAGE_LABELS],
                            const struct label_stack *stack)
{
    uint32_t count = 0;
    for (; stack && count < MESSAGE_LABELS && count < stack->count; count++)
        labels[count] = stack->labels[stack->count - 1 - count];
    return count;
}

void message_append_labels(struct text_buffer *text, const char *what,
                           const struct label_stack *stack)
{
    VkDebugUtilsLabelEXT labels[MESSAGE_LABELS];
    uint32_t count = copy_labels(labels, stack);
    if (!count)
        return;
    text_append(text, ", %s %s", what, stack->count > count ? "... > " : "");
    for (uint32_t i = count; i-- > 0;) {
        text_append_quoted(text, labels[i].pLabelName, MESSAGE_NAME_SIZE - 1);
        if (i)
            text_append(text, " > ");
    }
}

void message_append_object(struct text_buffer *text, struct message *message, VkObjectType type,
                           uint64_t handle, const struct object_names *names)
{
    const VkDebugUtilsObjectNameInfoEXT *object = mention(message, type, handle, names);
    if (object)
        append_object(text, object);
}

void message_append_destroyed_object(struct text_buffer *text, struct message *message,
                                     VkObjectType type, uint64_t handle, uint64_t id,
                                     const struct object_names *names)
{
    char name[MESSAGE_NAME_SIZE] = "";
    if (names)
        object_names_get_past(names, type, handle, id, name, sizeof(name));
    message_append_named_object(text, message, type, handle, name);
}

void message_append_named_object(struct text_buffer *text, struct message *message,
                                 VkObjectType type, uint64_t handle, const char *name)
{
    const VkDebugUtilsObjectNameInfoEXT *object = mention_named(message, type, handle, name);
    if (object)
        append_object(text, object);
}

static void append_submission(struct text_buffer *text, struct message *message,
                              const struct call_origin *origin)
{
    text_append(text, ", as submitted to ");
    message_append_object(text, message, VK_OBJECT_TYPE_QUEUE,
                          handle_number(origin->submission.queue), origin->names);
    if (origin->submission.number)
        text_append(text, ", submission %" PRIu64, origin->submission.number);
    message_append_labels(text, "queue labels", shared_labels_stack(origin->submission.labels));
}

int64_t message_build(const struct message *message)
{
    const struct location *at = &message->location;
    return message->origin->command_buffer && location_is_of_build(at)
               ? (int64_t)message->origin->build_index + at->build
               : -1;
}

static void append_place(struct text_buffer *text, struct message *message)
{
    const struct call_origin *origin = message->origin;
    const struct location *at = &message->location;
    if (!origin->command_buffer)
        return;
    text_append(text, " Command buffer ");
    append_object(text, &message->objects[0]);
    if (location_is_of_build(at))
        text_append(text, ", build %" PRIu64, (uint64_t)origin->build_index + at->build);
    message_append_labels(text, "labels", origin->labels);
    if (origin->submission.queue)
        append_submission(text, message, origin);
    if (origin->when)
        text_append(text, ", %s", origin->when);
    text_append(text, ".");
}

void message_append_origin(struct text_buffer *text, struct message *message)
{
    append_place(text, message);
    if (message->origin->call_site)
        message_append_call_site(text, message->origin->call_site, FRAMES_SHOWN);
}

/* ---- heading and notice */

void message_begin(struct message *message, struct text_buffer *text, enum report_flag severity,
                   const char *id)
{
    message->severity = severity;
    message->id = id;
    message->id_number = message_id_number(id);
    message->vuid = VUID_NONE;
    message->origin = NULL;
    message->also_count = 0;
    message->object_count = message->label_count = message->queue_label_count = 0;
    text_begin(text, message->buffer, sizeof(message->buffer) - LAST_NOTICE_SIZE);
    text_append(text, "Validation %s: [ %s ] | MessageID = 0x%" PRIx32 "\n",
                severity == REPORT_ERROR         ? "Error"
                : severity == REPORT_WARNING     ? "Warning"
                : severity == REPORT_PERFORMANCE ? "Performance Warning"
                                                 : "Information",
                id, (uint32_t)message->id_number);
    message->heading = message->buffer;
    message->text = message->buffer + text->length;
}

void message_set_origin(struct message *message, const struct call_origin *origin,
                        const char *function, enum level level, const struct location *location)
{
    message->origin = origin;
    message->function = function;
    message->level = level;
    message->location = *location;
    if (origin->command_buffer)
        mention(message, VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(origin->command_buffer),
                origin->names);
    else if (origin->device)
        mention(message, VK_OBJECT_TYPE_DEVICE, handle_number(origin->device), origin->names);
    message->label_count = copy_labels(message->labels, origin->labels);
    message->queue_label_count =
        copy_labels(message->queue_labels, shared_labels_stack(origin->submission.labels));
}

void message_append_last_notice(struct text_buffer *text, const char *what,
                                const struct message_subject *subject,
                                const struct message_style *style)
{
    if (style->last == LAST_OF_NOTHING)
        return;
    text->size += LAST_NOTICE_SIZE;
    text->cut = false;
    text_append(text, "\nThis %s has now been reported ", what);
    text_append_count(text, style->sent, "time");
    if (style->last == LAST_OF_OBJECT) {
        const char *type = object_type_name(subject->type);
        text_append(text,
                    " for %s 0x%" PRIx64
                    " and will not be reported for it again: "
                    "duplicate_message_limit is reached. At most %" PRIu32
                    " more follow for other objects.",
                    type ? type : "object", subject->handle, style->left);
    } else {
        text_append(text,
                    " and will not be reported again: ten times duplicate_message_limit is "
                    "reached.");
    }
    if (style->are_counted)
        text_append(text, " Further ones are only counted.");
}

/* ---- filters, and the log */

static bool mutes_label(const struct narrow_filter *filters, uint32_t id,
                        const struct label_stack *stack)
{
    for (uint32_t i = 0; stack && i < stack->count; i++)
        if (narrow_filters_match(filters, id, stack->labels[i].pLabelName))
            return true;
    return false;
}

bool message_is_muted(const struct message *message, const struct narrow_filter *filters,
                      uint32_t id)
{
    for (uint32_t i = 0; i < message->object_count; i++)
        if (narrow_filters_match(filters, id, message->objects[i].pObjectName))
            return true;
    return mutes_label(filters, id, message->origin->labels) ||
           mutes_label(filters, id, shared_labels_stack(message->origin->submission.labels));
}

static void each_line(const struct message *message, void (*write)(void *context, const char *line),
                      void *context)
{
    char line[4 * MESSAGE_NAME_SIZE + 96]; /* an escaped byte takes four */
    struct text_buffer text;
    write(context, message->heading);
    write(context, "\n");
    text_begin(&text, line, sizeof(line));
    text_append(&text, "    Objects: %" PRIu32 "\n", message->object_count);
    if (message->object_count)
        write(context, line);
    for (uint32_t i = 0; i < message->object_count; i++) {
        text_begin(&text, line, sizeof(line));
        text_append(&text, "        [%" PRIu32 "] ", i);
        append_object(&text, &message->objects[i]);
        write(context, line);
        write(context, "\n");
    }
}

static void write_to_file(void *file, const char *line)
{
    fputs(line, file);
}

static void write_to_debugger(void *unused, const char *line)
{
    (void)unused;
    process_write_to_debugger(line);
}

void message_write(const struct message *message, FILE *file)
{
    file_lock(file);
    each_line(message, write_to_file, file);
    fflush(file);
    file_unlock(file);
}

void message_write_to_debugger(const struct message *message)
{
    each_line(message, write_to_debugger, NULL);
}
