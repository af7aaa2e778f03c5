/* SPDX-License-Identifier: Apache-2.0 */
/* Compares what the layer reported with what a program expects. */
#include "tests/player/play.h"

#include <inttypes.h>
#include <string.h>

void play_expect_number(struct play *play, const char *name, uint64_t found, uint64_t wanted)
{
    if (found == wanted || play->is_scarce)
        return;
    report_say(&play->report, "%s: %#" PRIx64 " instead of %#" PRIx64 "\n", name, found, wanted);
    play->report.outcome = OUTCOME_FAILED;
}

/* ---- one message and one expectation */

const struct rule_info *play_rule(const char *name)
{
    for (enum rule rule = 0; rule < RULE_COUNT; rule++)
        if (strcmp(rule_infos[rule].name, name) == 0)
            return &rule_infos[rule];
    return NULL;
}

/* The command whose name begins the text that is expected; COMMAND_COUNT: none. */
enum build_command play_command_of(const char *text)
{
    enum build_command command = COMMAND_DEVICE;
    while (command < COMMAND_COUNT) {
        const char *name = build_command_name(command);
        if (strncmp(text, name, strlen(name)) == 0 && text[strlen(name)] == '(')
            break;
        command++;
    }
    return command;
}

bool program_subject(const struct program *program, enum vuid *vuid, enum build_command *command)
{
    const struct program_line *line = program_find(program, "about", NULL);
    *vuid = VUID_NONE;
    if (!line)
        return true;
    const struct rule_info *rule = play_rule(line->words[1]);
    for (*command = COMMAND_DEVICE; rule && *command < COMMAND_COUNT; ++*command)
        if (play_is(line->words[3], build_command_name(*command))) {
            *vuid = rule->vuid[*command];
            return *vuid != VUID_NONE;
        }
    program_fail(program->name, line->number, "about RULE of COMMAND");
}

/* A rule names an id for each command. */
static bool has_id(const struct message *message, const struct expectation *expected)
{
    const struct rule_info *rule = play_rule(expected->id);
    const enum build_command command = play_command_of(expected->text);
    if (!rule)
        return report_id_ends(message->id, expected->id);
    return command != COMMAND_COUNT && rule->vuid[command] != VUID_NONE &&
           strcmp(message->id, vuid_texts[rule->vuid[command]].id) == 0;
}

/* ---- all of them */

/* Whether this program expects it: below the rule's level nothing is reported. */
static bool is_active(const struct play *play, const struct expectation *expected)
{
    if (play->program->is_repaired && !expected->is_plain)
        return false;
    return expected->is_plain || play_sees_executions(play);
}

static bool concerns(const struct expectation *expected, int line)
{
    return line == -1 || expected->line == line;
}

bool play_judges_whole(const struct play *play)
{
    for (unsigned i = 0; i < play->program->expected_count; i++)
        if (play->program->expected[i].line == -1)
            return true;
    return false;
}

bool play_expects_mistake(const struct play *play, int line)
{
    for (unsigned i = 0; i < play->program->expected_count; i++) {
        const struct expectation *expected = &play->program->expected[i];
        if (expected->line == line && !expected->is_plain && is_active(play, expected))
            return true;
    }
    return false;
}

static bool find_message(const struct messages *messages, const struct expectation *expected,
                         bool *is_used)
{
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const struct message *message = &messages->items[i];
        if (is_used[i] || !has_id(message, expected) ||
            !report_text_matches(message->text, expected->text))
            continue;
        return is_used[i] = true;
    }
    return false;
}

/* What is said of a lost device, though only the first times, is no finding; unless the program
 * ends with `close`: programs about the loss list all messages. */
static unsigned count_of_loss(const struct messages *messages, const bool *is_used)
{
    unsigned count = 0;
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const struct message *message = &messages->items[i];
        count += !is_used[i] &&
                 (strcmp(message->id, "ASSAY-device-lost") == 0 ||
                  (strcmp(message->id, "ASSAY-warning") == 0 && strstr(message->text, " is lost")));
    }
    return count;
}

static unsigned count_of_warnings(const struct messages *messages, const bool *is_used)
{
    unsigned count = 0;
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        count += !is_used[i] && strcmp(messages->items[i].id, "ASSAY-warning") == 0;
    return count;
}

/* Whether the program expects such a message, of any line. */
static bool is_expected(const struct play *play, const struct message *message)
{
    for (unsigned i = 0; i < play->program->expected_count; i++)
        if (is_active(play, &play->program->expected[i]) &&
            has_id(message, &play->program->expected[i]))
            return true;
    return false;
}

/* Where memory has run out, what is expected may be missing or worded with less, and warnings say
 * what the layer leaves out. A program that repeats calls may hear it later. */
static void judge_scarce(struct play *play, const struct messages *messages, const bool *is_used)
{
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const struct message *message = &messages->items[i];
        if (is_used[i] || strcmp(message->id, "ASSAY-warning") == 0 ||
            (play->was_lost && strcmp(message->id, "ASSAY-device-lost") == 0) ||
            (play->repeats && is_expected(play, message)))
            continue;
        play->report.outcome = OUTCOME_FAILED;
        report_say(&play->report, "got %s\n    %.1000s\n", message->id, message->text);
    }
}

void play_judge(struct play *play, int line)
{
    const struct messages *messages = &play->fixture.messages;
    bool is_used[MESSAGES_MAX] = {false}, good = true;
    unsigned count = 0;
    for (unsigned i = 0; i < play->program->expected_count; i++) {
        const struct expectation *expected = &play->program->expected[i];
        if (!concerns(expected, line) || !is_active(play, expected))
            continue;
        count++;
        if (find_message(messages, expected, is_used) || play->is_scarce)
            continue;
        good = false;
        report_say(&play->report, "no message is %s: %s\n", expected->id, expected->text);
    }
    if (play->is_scarce) {
        judge_scarce(play, messages, is_used);
        return;
    }
    if (play->was_lost && !program_find(play->program, "close", NULL))
        count += count_of_loss(messages, is_used);
    if (play->may_warn)
        count += count_of_warnings(messages, is_used);
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        good = report_judge_wording(&play->report, &messages->items[i]) && good;
    if (good && messages->count == count)
        return;
    play->report.outcome = OUTCOME_FAILED;
    report_say(&play->report, "messages: %u, expected: %u\n", messages->count, count);
    report_say_messages(&play->report, messages, is_used);
}
