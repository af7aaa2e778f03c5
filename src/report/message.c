/* SPDX-License-Identifier: Apache-2.0 */
/* Paths of fields and call sites, parts of messages, filters by names, and the text of the log. */
#include "src/report/message.h"

#include <string.h>

#include "src/platform/files.h"
#include "src/platform/process.h"
#include "src/report/ids/message_filter.h"
#include "src/report/words.h"
#include "src/state/commands/call_sites.h"
#include "src/state/commands/object_names.h"
#include "src/state/resources/destroyed.h"
#include "src/state/resources/resources.h"

enum { MODULE_SHOWN = 512 };

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
    text_append_part(text, field, gap ? (size_t)(gap - field) : strlen(field));
    if (gap)
        text_say(text, "[{}]{}", number(index), phrase(gap + 2));
}

static void append_argument(struct text_buffer *text, const struct location *at, const char *field)
{
    text_append(text, at->argument ? at->argument : "");
    if (at->is_element)
        text_say(text, "[{}]", number(at->build));
    if (at->argument && field[0])
        text_append(text, at->is_element ? "." : "->");
    append_indexed(text, field, at->geometry);
}

void message_append_path(struct text_buffer *text, const struct location *at, const char *field)
{
    const char *separator = words_separator(at->command);
    switch (at->subject) {
    case SUBJECT_CALL:
    case SUBJECT_PARAMETER:
        text_append(text, field);
        return;
    case SUBJECT_BUILD:
        words_append_build(text, at->command, at->build);
        words_append_field(text, separator, field);
        return;
    case SUBJECT_GEOMETRY:
        words_append_build(text, at->command, at->build);
        text_say(text, "{}{}[{}]", phrase(separator),
                 phrase(at->geometry_by_pointer ? "ppGeometries" : "pGeometries"),
                 number(at->geometry));
        words_append_field(text, at->geometry_by_pointer ? "->" : ".", field);
        return;
    case SUBJECT_RANGE:
        text_say(text, "{}[{}][{}]", phrase(ranges_name(at->command, field)), number(at->build),
                 number(at->geometry));
        words_append_field(text, ".", field);
        return;
    case SUBJECT_ARGUMENT:
        append_argument(text, at, field);
        return;
    case SUBJECT_ELEMENT:
        text_say(text, "{}[{}]", phrase(field), number(at->build));
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
    const uint64_t submissions = origin->submissions
                                     ? origin->submissions
                                     : destroyed_objects_submissions(origin->destroyed);
    const struct words words = {.text = text};
    text_append(text, " ");
    words_append_object(&words, object.type, object.handle, object.name);
    text_append(text, " had this address and was destroyed ");
    if (submissions > object.submissions)
        text_say(text, "{} ago.", count_of(submissions - object.submissions, "submission"));
    else
        text_append(text, "since the last submission.");
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
    words_say(
        (&(const struct words){.text = text, .named = &message->named, .names = origin->names}),
        " It is {} past the end of {}.", count_of(before.distance, "byte"),
        object(VK_OBJECT_TYPE_BUFFER, handle_number(before.buffer)));
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
        text_append(text, i ? ", " : "");
        text_append_escaped(text, call_frame_module(&site->frames[i]), MODULE_SHOWN);
        text_append(text, "+");
        text_append_hex(text, site->frames[i].offset);
    }
}

void message_append_call_site(struct text_buffer *text, const struct call_site *site, uint32_t most)
{
    text_append(text, " Called from ");
    message_append_call_frames(text, site, most);
    text_append(text, ".");
}

/* ---- parts of messages, filters by names, and the text of the log */

enum { LAST_NOTICE_SIZE = 384, FRAMES_SHOWN = 4 };

/* ---- objects and labels */

/* Mentions an object that is alive, or that messages never name. */
static void mention_live(struct message *message, VkObjectType type, uint64_t handle,
                         const struct object_names *names)
{
    char name[MESSAGE_NAME_SIZE] = "";
    if (names)
        object_names_get(names, type, handle, name, sizeof(name));
    named_objects_add(&message->named, type, handle, name);
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
    const uint32_t count = !stack                          ? 0
                           : stack->count < MESSAGE_LABELS ? stack->count
                                                           : MESSAGE_LABELS;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t at = stack->count - count + i;
        text_append(text, i ? " > " : what);
        text_append(text, !i && at ? "... > " : "");
        text_append_quoted(text, stack->labels[at].pLabelName, MESSAGE_NAME_SIZE - 1);
    }
}

int64_t message_build(const struct message *message)
{
    const struct location *at = &message->location;
    return message->origin->command_buffer && location_is_of_build(at)
               ? (int64_t)message->origin->build_index + at->build
               : -1;
}

void message_append_place(const struct words *words, const struct call_origin *origin,
                          int64_t build, bool is_aside)
{
    const char *template;
#define PLACE(key, type, is_known, value, says, aside, range, about)                               \
    template = is_aside ? aside : says;                                                            \
    if (template && (is_known))                                                                    \
        words_say(words, template, value);
#define LABELS(labels, says, aside)                                                                \
    template = is_aside ? aside : says;                                                            \
    if (template)                                                                                  \
        message_append_labels(words->text, template, labels);
#include "src/report/properties.def"
}

/* Nothing is said of a call without a command buffer whose place has no properties. */
static void append_place(struct text_buffer *text, struct message *message)
{
    const struct call_origin *origin = message->origin;
    const struct words words = {.text = text, .named = &message->named, .names = origin->names};
    const struct text_buffer before = *text;
    if (origin->command_buffer)
        words_say(&words, " Command buffer {}",
                  object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(origin->command_buffer)));
    else if (origin->device)
        words_say(&words, " Device {}",
                  object(VK_OBJECT_TYPE_DEVICE, handle_number(origin->device)));
    const size_t length = text->length;
    message_append_place(&words, origin, message_build(message), false);
    if (origin->command_buffer || text->length > length) {
        text_append(text, ".");
        return;
    }
    *text = before;
    text->text[text->length] = '\0';
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
    message->named.count = message->label_count = message->queue_label_count = 0;
    text_begin(text, message->buffer, sizeof(message->buffer) - LAST_NOTICE_SIZE);
    text_say(text, "Validation {}: [ {} ] | MessageID = {}\n",
             phrase(severity == REPORT_ERROR         ? "Error"
                    : severity == REPORT_WARNING     ? "Warning"
                    : severity == REPORT_PERFORMANCE ? "Performance Warning"
                                                     : "Information"),
             phrase(id), hex((uint32_t)message->id_number));
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
        mention_live(message, VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(origin->command_buffer),
                     origin->names);
    else if (origin->device)
        mention_live(message, VK_OBJECT_TYPE_DEVICE, handle_number(origin->device), origin->names);
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
    const struct words words = {.text = text};
    words_say(&words, "\nThis {} has now been reported {}", phrase(what),
              count_of(style->sent, "time"));
    if (style->last == LAST_OF_OBJECT)
        words_say(
            &words,
            " for {} and will not be reported for it again: duplicate_message_limit is reached. At "
            "most {} more follow for other objects.",
            object(subject->type, subject->handle), number(style->left));
    else
        text_append(text,
                    " and will not be reported again: ten times duplicate_message_limit is "
                    "reached.");
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
    for (uint32_t i = 0; i < message->named.count; i++)
        if (narrow_filters_match(filters, id, message->named.objects[i].pObjectName))
            return true;
    return mutes_label(filters, id, message->origin->labels) ||
           mutes_label(filters, id, shared_labels_stack(message->origin->submission.labels));
}

void message_append_lines(const struct message *message, struct text_buffer *text)
{
    text_say(text, "{}\n", phrase(message->heading));
    if (message->named.count)
        text_say(text, "    Objects: {}\n", number(message->named.count));
    for (uint32_t i = 0; i < message->named.count; i++) {
        const VkDebugUtilsObjectNameInfoEXT *named = &message->named.objects[i];
        text_say(text, "        [{}] ", number(i));
        words_append_object(&(const struct words){.text = text}, named->objectType,
                            named->objectHandle, message->named.names[i]);
        text_append(text, "\n");
    }
}

void message_write(const struct message *message, FILE *file)
{
    char lines[MESSAGE_LINES_SIZE];
    struct text_buffer text;
    text_begin(&text, lines, sizeof(lines));
    message_append_lines(message, &text);
    file_lock(file);
    fputs(lines, file);
    fflush(file);
    file_unlock(file);
}

void message_write_to_debugger(const struct message *message)
{
    char lines[MESSAGE_LINES_SIZE];
    struct text_buffer text;
    text_begin(&text, lines, sizeof(lines));
    message_append_lines(message, &text);
    process_write_to_debugger(lines);
}
