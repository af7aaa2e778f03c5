/* SPDX-License-Identifier: Apache-2.0 */
/* Composes messages. */
#include "src/report/message.h"

#include <inttypes.h>
#include <string.h>

#include "src/base/text_buffer.h"
#include "src/report/ids/message_filter.h"
#include "src/report/ids/message_id.h"
#include "src/report/message_path.h"
#include "src/report/specification.h"
#include "src/state/commands/object_names.h"

enum { LAST_NOTICE_SIZE = 384, FRAMES_SHOWN = 4 };

/* ---- objects and labels */

/* Returns the entry of an object; adds it at the first mention. Returns NULL if there is no room.
 */
static const VkDebugUtilsObjectNameInfoEXT *mention(struct message *message, VkObjectType type,
                                                    uint64_t handle,
                                                    const struct object_names *names)
{
    for (uint32_t i = 0; i < message->object_count; i++)
        if (message->objects[i].objectType == type && message->objects[i].objectHandle == handle)
            return &message->objects[i];
    if (message->object_count == MESSAGE_OBJECTS)
        return NULL;

    uint32_t i = message->object_count++;
    char *name = message->names[i];
    name[0] = '\0';
    if (names)
        object_names_get(names, type, handle, name, MESSAGE_NAME_SIZE);
    message->objects[i] = (VkDebugUtilsObjectNameInfoEXT){
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name[0] ? name : NULL,
    };
    return &message->objects[i];
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

/* Appends the labels, outermost first, like a path. */
static void append_labels(struct text_buffer *text, const char *what,
                          const VkDebugUtilsLabelEXT *labels, uint32_t count,
                          const struct label_stack *stack)
{
    if (!count)
        return;
    text_append(text, ", %s %s", what, stack->count > count ? "... > " : "");
    for (uint32_t i = count; i-- > 0;) {
        text_append_quoted(text, labels[i].pLabelName, MESSAGE_NAME_SIZE - 1);
        if (i)
            text_append(text, " > ");
    }
}

/* ---- the finding */

struct message_subject message_subject_of(const struct call_origin *origin,
                                          const struct finding *finding)
{
    for (uint32_t i = 0; i < finding->value_count; i++)
        if (finding->values[i].kind == VALUE_OBJECT && finding->values[i].number)
            return (struct message_subject){finding->values[i].object_type,
                                            finding->values[i].number};
    if (origin->command_buffer)
        return (struct message_subject){VK_OBJECT_TYPE_COMMAND_BUFFER,
                                        (uint64_t)(uintptr_t)origin->command_buffer};
    return (struct message_subject){VK_OBJECT_TYPE_DEVICE, (uint64_t)(uintptr_t)origin->device};
}

/* Appends nothing if the message has no room for one more object. */
static void append_mention(struct text_buffer *text, struct message *message, VkObjectType type,
                           uint64_t handle, const struct object_names *names)
{
    const VkDebugUtilsObjectNameInfoEXT *object = mention(message, type, handle, names);
    if (object)
        append_object(text, object);
}

/* Appends a recorded build such as: in VkCommandBuffer 0x12["frame"], build 3. */
static void append_built(struct text_buffer *text, struct message *message,
                         const struct value *built, const struct object_names *names)
{
    if (!built->number) {
        text_append(text, "by %s, pInfos[%" PRIu32 "]", build_command_name(COMMAND_HOST),
                    built->build);
        return;
    }
    text_append(text, "in ");
    append_mention(text, message, VK_OBJECT_TYPE_COMMAND_BUFFER, built->number, names);
    text_append(text, ", build %" PRIu32, built->build);
}

static void append_value(struct text_buffer *text, struct message *message,
                         const struct value *value, enum build_command command,
                         const struct object_names *names)
{
    switch (value->kind) {
    case VALUE_ADDRESS:
    case VALUE_HEX:
        text_append(text, "0x%" PRIx64, value->number);
        return;
    case VALUE_NUMBER:
        text_append(text, "%" PRIu64, value->number);
        return;
    case VALUE_COUNT:
        text_append_count(text, value->number, value->text);
        return;
    case VALUE_REAL:
        text_append(text, "%.9g", value->real);
        return;
    case VALUE_TEXT:
        text_append(text, "%s", value->text ? value->text : "");
        return;
    case VALUE_FIELD:
        message_append_build(text, command, value->build);
        message_append_field(text, command == COMMAND_NV ? "->" : ".",
                             value->text ? value->text : "");
        return;
    case VALUE_OBJECT:
        if (!value->number) {
            text_append(text, "VK_NULL_HANDLE");
            return;
        }
        append_mention(text, message, value->object_type, value->number, names);
        return;
    case VALUE_BUILT:
        append_built(text, message, value, names);
        return;
    }
}

/* Appends the finding's sentence, with its values in place of {}. */
static void append_statement(struct text_buffer *text, struct message *message,
                             enum build_command command, const struct call_origin *origin,
                             const struct finding *finding)
{
    uint32_t used = 0;
    const char *rest = finding->says, *gap;
    while (used < finding->value_count && (gap = strstr(rest, "{}"))) {
        text_append(text, "%.*s", (int)(gap - rest), rest);
        append_value(text, message, &finding->values[used++], command, origin->names);
        rest = gap + 2;
    }
    size_t length = strlen(rest);
    text_append(text, "%s%s", rest, length && rest[length - 1] == '.' ? "" : ".");
}

static void append_submission(struct text_buffer *text, struct message *message,
                              const struct call_origin *origin)
{
    text_append(text, ", as submitted to ");
    append_mention(text, message, VK_OBJECT_TYPE_QUEUE, (uint64_t)(uintptr_t)origin->queue,
                   origin->names);
    if (origin->submission)
        text_append(text, ", submission %" PRIu64, origin->submission);
    append_labels(text, "queue labels", message->queue_labels, message->queue_label_count,
                  origin->queue_labels);
}

static void append_origin(struct text_buffer *text, struct message *message,
                          const struct location *at, const struct call_origin *origin)
{
    if (!origin->command_buffer)
        return;
    text_append(text, " Command buffer ");
    append_object(text, &message->objects[0]);
    if (at->subject != SUBJECT_CALL)
        text_append(text, ", build %" PRIu64, (uint64_t)origin->build_index + at->build);
    append_labels(text, "labels", message->labels, message->label_count, origin->labels);
    if (origin->queue)
        append_submission(text, message, origin);
    if (origin->when)
        text_append(text, ", %s", origin->when);
    text_append(text, ".");
}

/* Names the ids that the same mistake violates, too. */
static void append_also(struct text_buffer *text, struct message *message,
                        enum build_command command, const struct finding *finding)
{
    const char *before = " (also ";
    for (uint32_t i = 0; i < finding->also_count; i++) {
        enum vuid vuid = rule_infos[finding->also[i]].vuid[command];
        if (vuid == VUID_NONE)
            continue;
        text_append(text, "%s%s", before, vuid_texts[vuid].id);
        message->also[message->also_count++] = vuid_texts[vuid].id;
        before = ", ";
    }
    if (before[0] == ',')
        text_append(text, ")");
}

/* Uses reserved room, so the notice is complete even if the text before it was cut. */
static void append_last_notice(struct text_buffer *text, const char *what,
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

/* ---- whole messages */

static void begin(struct message *message, struct text_buffer *text, enum report_flag severity,
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
                severity == REPORT_ERROR     ? "Error"
                : severity == REPORT_WARNING ? "Warning"
                                             : "Information",
                id, (uint32_t)message->id_number);
    message->heading = message->buffer;
    message->text = message->buffer + text->length;
}

static void mention_origin(struct message *message, const struct call_origin *origin)
{
    if (origin->command_buffer)
        mention(message, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)origin->command_buffer,
                origin->names);
    else if (origin->device)
        mention(message, VK_OBJECT_TYPE_DEVICE, (uint64_t)(uintptr_t)origin->device, origin->names);
    message->label_count = copy_labels(message->labels, origin->labels);
    message->queue_label_count = copy_labels(message->queue_labels, origin->queue_labels);
}

static void append_replaced(struct text_buffer *text, uint32_t count)
{
    if (!count)
        return;
    text_append(text, " The layer replaced ");
    text_append_count(text, count, "reference");
    text_append(text, " of this build by 0 (setting guard).");
}

static void append_finding(struct text_buffer *text, struct message *message,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const char *hint)
{
    text_append(text, "%s(): ", build_command_name(location->command));
    size_t before = text->length;
    message_append_path(text, location, finding->field ? finding->field : "");
    message->main = text->text + before;
    message->path_length = text->length - before;
    if (text->length > before)
        text_append(text, " ");
    append_statement(text, message, location->command, origin, finding);
    for (uint32_t i = 0; i < finding->value_count; i++)
        message_append_destroyed(text, &finding->values[i], origin);
    if (hint)
        text_append(text, " %s", hint);
    append_replaced(text, origin->replaced);
    message->main_length = text->length - before;
    message->origin = origin;
    message->location = *location;
    append_origin(text, message, location, origin);
    if (origin->call_site)
        message_append_call_site(text, origin->call_site, FRAMES_SHOWN);
}

void message_of_finding(struct message *message, enum vuid vuid, const struct location *location,
                        const struct call_origin *origin, const struct finding *finding,
                        const struct message_style *style)
{
    const struct message_subject subject = message_subject_of(origin, finding);
    struct text_buffer text;
    const char *id = NULL;
    if (style->vuid_names == VUID_NAMES_LISTED)
        id = vuid_listed(vuid, location->command, finding->field ? finding->field : "");
    if (!id)
        id = vuid_texts[vuid].id;
    begin(message, &text, vuid_is_warning(vuid) ? REPORT_WARNING : REPORT_ERROR, id);
    mention_origin(message, origin);
    append_finding(&text, message, location, origin, finding, rule_infos[rule_of_vuid(vuid)].hint);
    message->vuid = vuid;
    append_also(&text, message, location->command, finding);
    specification_append(&text, vuid, id, style->spec_text);
    append_last_notice(&text, vuid_is_warning(vuid) ? "warning" : "VUID", &subject, style);
}

void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const struct message_style *style)
{
    const struct message_subject subject = message_subject_of(origin, finding);
    struct text_buffer text;
    begin(message, &text, REPORT_WARNING, difference_id(difference));
    mention_origin(message, origin);
    append_finding(&text, message, location, origin, finding, NULL);
    append_last_notice(&text, "difference", &subject, style);
}

void message_of_layer(struct message *message, enum report_flag severity, const char *line)
{
    const char *id = severity == REPORT_ERROR ? "ASSAY-error" : "ASSAY-warning";
    message_of_event(message, severity, severity == REPORT_INFO ? "ASSAY-info" : id, line);
}

void message_of_event(struct message *message, enum report_flag severity, const char *id,
                      const char *line)
{
    struct text_buffer text;
    begin(message, &text, severity, id);
    text_append(&text, "%s", line);
    message->main = message->text;
    message->main_length = text.length - (size_t)(message->text - message->buffer);
    message->path_length = 0;
}

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
           mutes_label(filters, id, message->origin->queue_labels);
}

void message_write(const struct message *message, FILE *file)
{
    char line[4 * MESSAGE_NAME_SIZE + 64]; /* an escaped byte takes four */
    flockfile(file);
    fprintf(file, "%s\n", message->heading);
    if (message->object_count)
        fprintf(file, "    Objects: %" PRIu32 "\n", message->object_count);
    for (uint32_t i = 0; i < message->object_count; i++) {
        struct text_buffer text;
        text_begin(&text, line, sizeof(line));
        append_object(&text, &message->objects[i]);
        fprintf(file, "        [%" PRIu32 "] %s\n", i, line);
    }
    fflush(file);
    funlockfile(file);
}
