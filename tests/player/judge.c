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

/* The id for a command that an expectation names by its end or by a rule; VUID_NONE: there is none.
 */
static enum vuid vuid_expected(const char *name, enum build_command command)
{
    const struct rule_info *named = play_rule(name);
    if (named)
        return named->vuid[command];
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        const enum vuid vuid = rule_infos[rule].vuid[command];
        if (vuid != VUID_NONE && report_id_ends(vuid_texts[vuid].id, name))
            return vuid;
    }
    return VUID_NONE;
}

/* Without the line `about`, a program and its twin are about the first mistake that the broken one
 * expects of a command. */
static void subject_expected(const struct program *program, enum vuid *vuid,
                             enum build_command *command)
{
    static struct program broken;
    if (program->is_repaired && program->source && program->source->has_twin) {
        program_make(&broken, program->source, program->variant, false);
        program = &broken;
    }
    for (unsigned i = 0; i < program->expected_count && *vuid == VUID_NONE; i++) {
        *command = play_command_of(program->expected[i].text);
        if (*command != COMMAND_COUNT && !program->expected[i].is_plain)
            *vuid = vuid_expected(program->expected[i].id, *command);
    }
}

bool program_subject(const struct program *program, enum vuid *vuid, enum build_command *command)
{
    const struct program_line *line = program_find(program, "about", NULL);
    *vuid = VUID_NONE;
    if (!line) {
        subject_expected(program, vuid, command);
        return true;
    }
    const struct rule_info *rule = play_rule(line->words[1]);
    for (*command = COMMAND_DEVICE; rule && *command < COMMAND_COUNT; ++*command)
        if (play_is(line->words[3], build_command_name(*command))) {
            *vuid = rule->vuid[*command];
            return *vuid != VUID_NONE;
        }
    program_fail(program->name, line->number, "about RULE of COMMAND");
}

/* The end of the id that is expected: a rule names an id for each command. */
static const char *id_of(const struct expectation *expected)
{
    const struct rule_info *rule = play_rule(expected->id);
    const enum build_command command = play_command_of(expected->text);
    if (!rule)
        return expected->id;
    return command != COMMAND_COUNT && rule->vuid[command] != VUID_NONE
               ? vuid_texts[rule->vuid[command]].id
               : "none of the command";
}

/* ---- all of them */

/* Whether this program may hear it: its repaired twin does not. */
static bool is_possible(const struct play *play, const struct expectation *expected)
{
    return expected->is_plain || !play->program->is_repaired;
}

/* Whether this program must hear it. Below level execution a mistake is found if it is there when
 * the command is recorded, and not if it arises later. */
static bool is_active(const struct play *play, const struct expectation *expected)
{
    return is_possible(play, expected) && (expected->is_plain || play_sees_executions(play));
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

/* Whether the program expects a message with this id, of any line. */
static bool expects_id(const struct play *play, const char *id)
{
    for (unsigned i = 0; i < play->program->expected_count; i++)
        if (is_possible(play, &play->program->expected[i]) &&
            report_id_ends(id, id_of(&play->program->expected[i])))
            return true;
    return false;
}

/* Whether a message is no finding. What is said of a lost device, though only the first times, is
 * none, unless the program ends with `close`: programs about the loss list all messages. Where
 * memory has run out, warnings say what the layer leaves out, and a program that repeats calls may
 * hear later what it expects. */
static bool is_allowed(const struct play *play, const struct message *message)
{
    const bool is_warning = strcmp(message->id, "ASSAY-warning") == 0;
    const bool is_loss = play->was_lost && strcmp(message->id, "ASSAY-device-lost") == 0;
    if (play->is_scarce)
        return is_warning || is_loss || (play->repeats && expects_id(play, message->id));
    if ((play->may_warn && is_warning) ||
        (!play_sees_executions(play) && expects_id(play, message->id)))
        return true;
    return !program_find(play->program, "close", NULL) && play->was_lost &&
           (is_loss || (is_warning && strstr(message->text, " is lost")));
}

/* Where memory has run out, what is expected may be missing or worded with less. */
void play_judge(struct play *play, int line)
{
    const struct messages *messages = &play->fixture.messages;
    bool is_expected[MESSAGES_MAX] = {false}, good = true;
    for (unsigned i = 0; i < play->program->expected_count; i++) {
        const struct expectation *expected = &play->program->expected[i];
        if (concerns(expected, line) && is_active(play, expected))
            good &= report_expect(
                play->is_scarce ? NULL : &play->report, messages,
                &(struct expected_message){id_of(expected), expected->text, .is_any = false},
                is_expected);
    }
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        is_expected[i] |= is_allowed(play, &messages->items[i]);
    if (!play->is_scarce)
        good &= report_judge_wording(&play->report, messages);
    if (!report_judge(&play->report, messages, is_expected, good || play->is_scarce))
        play->report.outcome = OUTCOME_FAILED;
}
