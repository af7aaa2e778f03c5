/* SPDX-License-Identifier: Apache-2.0 */
/* Composes messages, which quote the specification. */
#include "src/report/finding_message.h"

#include <inttypes.h>
#include <string.h>

#include "src/report/ids/message_filter.h"
#include "src/state/commands/object_names.h"

enum { SENTENCE_SHOWN = 160 };

#define SPECIFICATION "https://docs.vulkan.org/spec/latest/"

/* Returns the length of a sentence that is cut between words, to at most SENTENCE_SHOWN characters.
 */
static size_t short_length(const char *sentence)
{
    size_t length = 0, end_of_word = 0;
    for (uint32_t characters = 0; characters <= SENTENCE_SHOWN; characters++) {
        if (!sentence[length])
            return length;
        if (sentence[length] == ' ')
            end_of_word = length;
        do
            length++;
        while (((unsigned char)sentence[length] & 0xc0) == 0x80);
    }
    return end_of_word;
}

void specification_append_sentence(struct text_buffer *text, const struct vuid_text *vuid,
                                   enum spec_text spec_text)
{
    if (!vuid->sentence[0] || spec_text == SPEC_TEXT_NONE)
        return;
    size_t length = strlen(vuid->sentence), shown = length;
    if (spec_text == SPEC_TEXT_SHORT)
        shown = short_length(vuid->sentence);
    text_append(text, "%.*s%s", (int)shown, vuid->sentence, shown < length ? "..." : "");
}

void specification_append_url(struct text_buffer *text, const struct vuid_text *vuid)
{
    text_append(text, SPECIFICATION "%s#%s", vuid->page, vuid->id);
}

/* Appends a line with the sentence, its address, and the other ids of the same sentence. `named` is
 * the message's id. If the message has the current id, retired ids are appended. */
static void specification_append(struct text_buffer *text, enum vuid vuid, const char *named,
                                 enum spec_text spec_text)
{
    const struct vuid_text *current = &vuid_texts[vuid];
    if (current->sentence[0] && spec_text != SPEC_TEXT_NONE) {
        text_append(text, "\nThe Vulkan spec states: ");
        specification_append_sentence(text, current, spec_text);
        text_append(text, " (");
        specification_append_url(text, current);
        text_append(text, ")");
    }
    if (named != current->id) {
        text_append(text, " (today %s)", current->id);
        return;
    }
    const char *retired;
    for (unsigned n = 0; (retired = vuid_retired(vuid, n)); n++)
        text_append(text, "%s%s", n ? ", " : " (formerly ", retired);
    if (vuid_retired(vuid, 0))
        text_append(text, ")");
}

/* ---- composes messages */

/* ---- the finding */

struct message_subject message_subject_of(const struct call_origin *origin,
                                          const struct finding *finding)
{
    for (uint32_t i = 0; i < finding->value_count; i++)
        if ((finding->values[i].kind == VALUE_OBJECT ||
             finding->values[i].kind == VALUE_DESTROYED) &&
            finding->values[i].number)
            return (struct message_subject){finding->values[i].object_type,
                                            finding->values[i].number};
    if (origin->command_buffer)
        return (struct message_subject){VK_OBJECT_TYPE_COMMAND_BUFFER,
                                        handle_number(origin->command_buffer)};
    return (struct message_subject){VK_OBJECT_TYPE_DEVICE, handle_number(origin->device)};
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
    char name[MESSAGE_NAME_SIZE] = "";
    if (names)
        object_names_get_of(names, VK_OBJECT_TYPE_COMMAND_BUFFER, built->number, built->id, name,
                            sizeof(name));
    text_append(text, "in ");
    message_append_named_object(text, message, VK_OBJECT_TYPE_COMMAND_BUFFER, built->number, name);
    text_append(text, ", build %" PRIu32, built->build);
}

/* Names end in _BIT, most of them with the author's tag behind it, which says nothing here. Returns
 * the length up to there; 0: the bit has no name. */
static size_t name_length(const struct value *flags, uint64_t bit)
{
    const char *name = flags->name_of_bit(bit), *end = name ? strstr(name, "_BIT") : NULL;
    return end ? (size_t)(end - name) : 0;
}

/* Appends 0x5 (ALLOW_UPDATE | PREFER_FAST_TRACE); without the names if no bit has one. */
static void append_flags(struct text_buffer *text, const struct value *flags)
{
    const char *before = " (";
    bool has_names = false;
    text_append(text, "0x%" PRIx64, flags->number);
    for (uint64_t rest = flags->number; rest; rest &= rest - 1)
        has_names |= name_length(flags, rest & -rest) > 0;
    for (uint64_t rest = has_names ? flags->number : 0; rest; rest &= rest - 1) {
        const uint64_t bit = rest & -rest;
        const size_t length = name_length(flags, bit);
        if (length)
            text_append(text, "%s%.*s", before, (int)length, flags->name_of_bit(bit));
        else
            text_append(text, "%s0x%" PRIx64, before, bit);
        before = " | ";
    }
    text_append(text, has_names ? ")" : "");
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
    case VALUE_FLAGS:
        append_flags(text, value);
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
        message_append_field(text, message_separator(command), value->text ? value->text : "");
        return;
    case VALUE_OBJECT:
        if (!value->number) {
            text_append(text, "VK_NULL_HANDLE");
            return;
        }
        message_append_object(text, message, value->object_type, value->number, names);
        return;
    case VALUE_DESTROYED:
        message_append_destroyed_object(text, message, value->object_type, value->number, value->id,
                                        names);
        return;
    case VALUE_BUILT:
        append_built(text, message, value, names);
        return;
    }
}

/* Appends how many elements more violate the rule, such as: (and 99 more instances). */
static void append_more(struct text_buffer *text, const struct finding *finding)
{
    if (!finding->more)
        return;
    text_append(text, " (and ");
    text_append_count(text, finding->more, finding->element);
    text_append(text, ")");
}

/* Appends a sentence without its period, with values in place of {}. */
static void append_sentence(struct text_buffer *text, struct message *message,
                            enum build_command command, const struct call_origin *origin,
                            const char *says, const struct value *values, uint32_t count)
{
    uint32_t used = 0;
    const char *rest = says, *gap;
    while (used < count && (gap = strstr(rest, "{}"))) {
        text_append(text, "%.*s", (int)(gap - rest), rest);
        append_value(text, message, &values[used++], command, origin->names);
        rest = gap + 2;
    }
    size_t length = strlen(rest);
    length -= length && rest[length - 1] == '.';
    text_append(text, "%.*s", (int)length, rest);
}

static void append_statement(struct text_buffer *text, struct message *message,
                             enum build_command command, const struct call_origin *origin,
                             const struct finding *finding)
{
    append_sentence(text, message, command, origin, finding->says, finding->values,
                    finding->value_count);
    append_more(text, finding);
    text_append(text, ".");
}

static void append_instance(struct text_buffer *text,
                            const VkAccelerationStructureInstanceKHR *instance)
{
    text_append(text, " The instance has transform (");
    for (uint32_t row = 0; row < 3; row++)
        for (uint32_t column = 0; column < 4; column++)
            text_append(text, "%s%.4g",
                        column ? " "
                        : row  ? ", "
                               : "",
                        (double)instance->transform.matrix[row][column]);
    text_append(text,
                "), instanceCustomIndex %" PRIu32 ", mask 0x%" PRIx32
                ", instanceShaderBindingTableRecordOffset %" PRIu32 " and flags 0x%" PRIx32 ".",
                (uint32_t)instance->instanceCustomIndex, (uint32_t)instance->mask,
                (uint32_t)instance->instanceShaderBindingTableRecordOffset,
                (uint32_t)instance->flags);
}

/* Appends what helps to find the cause. */
static void append_remarks(struct text_buffer *text, struct message *message,
                           enum build_command command, const struct call_origin *origin,
                           const struct finding *finding)
{
    if (finding->has_instance)
        append_instance(text, &finding->instance);
    for (uint32_t i = 0; i < finding->remark_count; i++) {
        const struct remark *remark = &finding->remarks[i];
        text_append(text, " ");
        append_sentence(text, message, command, origin, remark->says, remark->values,
                        remark->value_count);
        text_append(text, ".");
    }
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

/* ---- whole messages */

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
        message_append_about_address(text, message, &finding->values[i]);
    append_remarks(text, message, location->command, origin, finding);
    if (hint)
        text_append(text, " %s", hint);
    append_replaced(text, origin->replaced);
    message->main_length = text->length - before;
    message_append_origin(text, message);
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
    message_begin(message, &text, vuid_is_warning(vuid) ? REPORT_WARNING : REPORT_ERROR, id);
    message_set_origin(message, origin, build_command_name(location->command),
                       rule_infos[rule_of_vuid(vuid)].level, location);
    append_finding(&text, message, location, origin, finding, rule_infos[rule_of_vuid(vuid)].hint);
    message->vuid = vuid;
    append_also(&text, message, location->command, finding);
    specification_append(&text, vuid, id, style->spec_text);
    message_append_last_notice(&text, vuid_is_warning(vuid) ? "warning" : "VUID", &subject, style);
}

void message_of_difference(struct message *message, enum difference difference,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const struct message_style *style)
{
    const struct message_subject subject = message_subject_of(origin, finding);
    struct text_buffer text;
    message_begin(message, &text, REPORT_WARNING, difference_id(difference));
    message_set_origin(message, origin, build_command_name(location->command), LEVEL_CONTENT,
                       location);
    append_finding(&text, message, location, origin, finding, NULL);
    message_append_last_notice(&text, "difference", &subject, style);
}

static void append_more_advice(struct text_buffer *text, uint32_t more)
{
    if (!more)
        return;
    text_append(text, " The list leaves out ");
    text_append_count(text, more, "more object");
    text_append(text, " with this advice (setting advice_limits, lines).");
}

/* Its object may be destroyed by now, so it has no origin. */
void message_of_advice(struct message *message, const struct advice_report *report,
                       const struct message_style *style)
{
    const struct call_origin nowhere = {.names = report->names};
    const struct advice_info *info = &advice_infos[report->advice];
    const struct message_subject subject = {report->type, report->object};
    struct text_buffer text;
    message_begin(message, &text,
                  info->kind == ADVICE_IS_WASTE ? REPORT_PERFORMANCE : REPORT_WARNING, info->id);
    const size_t before = text.length;
    message->main = message->text;
    message->path_length = 0;
    message_append_named_object(&text, message, report->type, report->object, report->name);
    text_append(&text, " ");
    append_statement(&text, message, COMMAND_COUNT, &nowhere, &report->finding);
    text_append(&text, " %s", info->hint);
    append_more_advice(&text, report->more);
    message->main_length = text.length - before;
    message_append_last_notice(&text, "advice", &subject, style);
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
    message_begin(message, &text, severity, id);
    text_append(&text, "%s", line);
    message->main = message->text;
    message->main_length = text.length - (size_t)(message->text - message->buffer);
    message->path_length = 0;
}
