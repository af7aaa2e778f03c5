/* SPDX-License-Identifier: Apache-2.0 */
/* Composes messages, which quote the specification. */
#include "src/report/finding_message.h"

#include <string.h>

#include "src/report/ids/message_filter.h"
#include "src/report/words.h"
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
                                   enum spec_text_setting spec_text)
{
    if (!vuid->sentence[0] || spec_text == SPEC_TEXT_NONE)
        return;
    size_t length = strlen(vuid->sentence), shown = length;
    if (spec_text == SPEC_TEXT_SHORT)
        shown = short_length(vuid->sentence);
    text_append_part(text, vuid->sentence, shown);
    text_append(text, shown < length ? "..." : "");
}

void specification_append_url(struct text_buffer *text, const struct vuid_text *vuid)
{
    text_say(text, SPECIFICATION "{}#{}", phrase(vuid->page), phrase(vuid->id));
}

/* Appends a line with the sentence, its address, and the other ids of the same sentence. `named` is
 * the message's id. If the message has the current id, retired ids are appended. */
static void specification_append(struct text_buffer *text, enum vuid vuid, const char *named,
                                 enum spec_text_setting spec_text)
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
        text_say(text, " (today {})", phrase(current->id));
        return;
    }
    const char *retired;
    for (unsigned n = 0; (retired = vuid_retired(vuid, n)); n++)
        text_say(text, n ? ", {}" : " (formerly {}", phrase(retired));
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

static void append_instance(struct text_buffer *text,
                            const VkAccelerationStructureInstanceKHR *instance)
{
    text_append(text, " The instance has transform (");
    for (uint32_t row = 0; row < 3; row++)
        for (uint32_t column = 0; column < 4; column++) {
            text_append(text, column ? " " : row ? ", " : "");
            text_append_real(text, (double)instance->transform.matrix[row][column], 4);
        }
    text_say(text,
             "), instanceCustomIndex {}, mask {}, instanceShaderBindingTableRecordOffset {} and "
             "flags {}.",
             number(instance->instanceCustomIndex), hex(instance->mask),
             number(instance->instanceShaderBindingTableRecordOffset), hex(instance->flags));
}

/* Appends what is wrong, and how many elements more are. */
static void append_statement(const struct words *words, const struct finding *finding)
{
    words_append(words, finding->says, finding->values, finding->value_count);
    if (finding->more)
        words_say(words, " (and {})", count_of(finding->more, finding->element));
    text_append(words->text, ".");
}

/* Appends what helps to find the cause. */
static void append_remarks(const struct words *words, const struct finding *finding)
{
    if (finding->has_instance)
        append_instance(words->text, &finding->instance);
    for (uint32_t i = 0; i < finding->remark_count; i++) {
        const struct remark *remark = &finding->remarks[i];
        text_append(words->text, " ");
        words_append(words, remark->says, remark->values, remark->value_count);
        text_append(words->text, ".");
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
        text_say(text, "{}{}", phrase(before), phrase(vuid_texts[vuid].id));
        message->also[message->also_count++] = vuid_texts[vuid].id;
        before = ", ";
    }
    if (before[0] == ',')
        text_append(text, ")");
}

/* ---- whole messages */

static void append_finding(struct text_buffer *text, struct message *message,
                           const struct location *location, const struct call_origin *origin,
                           const struct finding *finding, const char *hint)
{
    const struct words words = {text, &message->named, origin->names, location->command, false};
    words_say(&words, "{}(): ", phrase(build_command_name(location->command)));
    size_t before = text->length;
    message_append_path(text, location, finding->field ? finding->field : "");
    message->main = text->text + before;
    message->path_length = text->length - before;
    if (text->length > before)
        text_append(text, " ");
    append_statement(&words, finding);
    for (uint32_t i = 0; i < finding->value_count; i++)
        message_append_about_address(text, message, &finding->values[i]);
    append_remarks(&words, finding);
    if (hint)
        words_say(&words, " {}", phrase(hint));
    if (origin->replaced)
        words_say(&words, " The layer replaced {} of this build by 0 (setting guard).",
                  count_of(origin->replaced, "reference"));
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

/* Its object may be destroyed by now, so it has no origin. */
void message_of_advice(struct message *message, const struct advice_report *report,
                       const struct message_style *style)
{
    const struct advice_info *info = &advice_infos[report->advice];
    const struct message_subject subject = {report->type, report->object};
    struct text_buffer text;
    const struct words words = {&text, &message->named, report->names, COMMAND_COUNT, false};
    message_begin(message, &text,
                  info->kind == ADVICE_IS_WASTE ? REPORT_PERFORMANCE : REPORT_WARNING, info->id);
    const size_t before = text.length;
    message->main = message->text;
    message->path_length = 0;
    words_append_object(&words, report->type, report->object, report->name);
    text_append(&text, " ");
    append_statement(&words, &report->finding);
    words_say(&words, " {}", phrase(info->hint));
    if (report->more)
        words_say(&words,
                  " The list leaves out {} with this advice (setting advice_limits, lines).",
                  count_of(report->more, "more object"));
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
    text_append(&text, line);
    message->main = message->text;
    message->main_length = text.length - (size_t)(message->text - message->buffer);
    message->path_length = 0;
}
