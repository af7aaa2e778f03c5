/* SPDX-License-Identifier: Apache-2.0 */
/* Compares messages with what is expected, and says what differs. */
#include "tests/player/report.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "tests/player/program.h"
#include "vuid-tables/rules.h"

void report_say(struct report *report, const char *format, ...)
{
    const size_t length = strlen(report->text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(report->text + length, sizeof(report->text) - length, format, arguments);
    va_end(arguments);
}

void report_program(struct report *report, const struct program *program, unsigned at)
{
    if (program->source && at < program->line_count)
        report_say(report, "tests/programs/%s.cases:%u: ", program->source->group,
                   program->lines[at].number);
    report_say(report, "%s\n", program->name);
    for (unsigned i = 0; i < program->line_count; i++) {
        const struct program_line *line = &program->lines[i];
        report_say(report, "%s%4u  %s\n", i == at ? " >" : "  ", line->number, line->text);
        for (unsigned j = 0; j < program->expected_count; j++)
            if (program->expected[j].line == (int)i && !program->is_repaired)
                report_say(report, "            expect %s: %s\n", program->expected[j].id,
                           program->expected[j].text);
    }
}

bool report_id_ends(const char *id, const char *end)
{
    const size_t length = strlen(id), size = strlen(end);
    return length == size ? strcmp(id, end) == 0
                          : length > size && id[length - size - 1] == '-' &&
                                strcmp(id + length - size, end) == 0;
}

bool report_text_matches(const char *text, const char *wanted)
{
    while (*wanted) {
        const char *end = strstr(wanted, " ... ");
        size_t length = end ? (size_t)(end - wanted) : strlen(wanted);
        char part[512];
        snprintf(part, sizeof(part), "%.*s", (int)length, wanted);
        const bool is_absent = strncmp(part, "NOT ", 4) == 0;
        const char *found = strstr(text, part + (is_absent ? 4 : 0));
        if (is_absent == (found != NULL))
            return false;
        if (!is_absent)
            text = found + length;
        wanted = end ? end + strlen(" ... ") : wanted + length;
    }
    return true;
}

const char *report_own_end(const struct message *message)
{
    const char *sentence = strstr(message->text, "\nThe Vulkan spec states");
    return sentence != NULL ? sentence : message->text + strlen(message->text);
}

static bool says(const struct message *message, const char *wanted)
{
    char own[MESSAGE_TEXT_MAX];
    snprintf(own, sizeof(own), "%.*s", (int)(report_own_end(message) - message->text),
             message->text);
    return report_text_matches(own, wanted);
}

bool report_expect(struct report *report, const struct messages *messages,
                   const struct expected_message *expected, bool *is_expected)
{
    bool is_found = false;
    for (uint32_t i = 0; i < messages_kept(messages) && (!is_found || expected->is_any); i++) {
        const struct message *message = &messages->items[i];
        if (is_expected[i] || !report_id_ends(message->id, expected->id))
            continue;
        const bool fits = !expected->text || says(message, expected->text);
        is_expected[i] = fits || expected->is_any;
        is_found |= fits;
    }
    if (!is_found && report)
        report_say(report, "no message is %s: %s\n", expected->id,
                   expected->text ? expected->text : "");
    return is_found;
}

bool report_judge(struct report *report, const struct messages *messages, const bool *is_expected,
                  bool good)
{
    uint32_t others = messages->count;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        others -= is_expected[i];
    if (good && others == 0)
        return true;
    report_say(report, "messages: %u, of which %u are not expected\n", messages->count, others);
    for (uint32_t i = 0; i < messages_kept(messages) && i < 12; i++)
        report_say(report, "    %s %s\n        %.1000s\n", is_expected[i] ? "expected" : "got",
                   messages->items[i].id, messages->items[i].text);
    return false;
}

bool report_expect_none(struct report *report, const struct messages *messages, const char *call,
                        const char *when)
{
    static const bool is_expected[MESSAGES_MAX];
    if (messages->count == 0)
        return true;
    report_say(report, "%s: %u messages %s\n", call, messages->count, when);
    return report_judge(report, messages, is_expected, false);
}

/* ---- hints */

static const char *hint_of(const char *id)
{
    for (int vuid = VUID_NONE + 1; vuid < MESSAGE_ID_COUNT; vuid++)
        if (vuid != VUID_COUNT && strcmp(vuid_texts[vuid].id, id) == 0)
            return rule_infos[rule_of_vuid((enum vuid)vuid)].hint;
    return NULL;
}

static bool has_its_hint(struct report *report, const struct message *message)
{
    const char *hint = hint_of(message->id);
    if (hint == NULL || strstr(message->text, hint) != NULL)
        return true;
    report_say(report, "the message of %s lacks its hint: %s\n", message->id, hint);
    return false;
}

/* ---- counts */

/* Whether `at` begins a number of one digit, 1, and is followed by a plural. */
static bool is_one_of_many(const char *text, const char *at)
{
    static const char *const plurals[] = {"bytes",   "triangles", "AABBs",      "vertices",
                                          "indices", "elements",  "geometries", "pointers",
                                          "times",   "rays"};
    if (at != text && (isalnum((unsigned char)at[-1]) || at[-1] == '.' || at[-1] == '-'))
        return false;
    for (size_t i = 0; i < sizeof(plurals) / sizeof(plurals[0]); i++)
        if (strncmp(at + 2, plurals[i], strlen(plurals[i])) == 0)
            return true;
    return false;
}

static bool counts_agree(struct report *report, const struct message *message)
{
    const char *end = report_own_end(message);
    for (const char *at = message->text; (at = strstr(at, "1 ")) != NULL && at < end; at++) {
        if (is_one_of_many(message->text, at)) {
            report_say(report, "a count of %s does not agree: %.40s\n", message->id, at);
            return false;
        }
    }
    return true;
}

/* ---- other ids of the same mistake */

static bool names_no_id_twice(struct report *report, const struct message *message)
{
    const char *also = strstr(message->text, " (also ");
    const char *own = also != NULL ? strstr(also, message->id) : NULL;
    if (own == NULL || own > report_own_end(message))
        return true;
    report_say(report, "the message of %s names its own id\n", message->id);
    return false;
}

bool report_judge_wording(struct report *report, const struct messages *messages)
{
    bool good = true;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        good = has_its_hint(report, &messages->items[i]) &&
               counts_agree(report, &messages->items[i]) &&
               names_no_id_twice(report, &messages->items[i]) && good;
    return good;
}
