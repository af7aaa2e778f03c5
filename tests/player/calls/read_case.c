/* SPDX-License-Identifier: Apache-2.0 */
/* Reads programs of calls. Lines of both programs, the broken and the repaired one:
 *
 *     breaks RULE, RULE        the rules that the broken program violates
 *     keeps [RULE, RULE]       the program is valid, and the rules stay silent
 *     names RULE, RULE         rules whose ids the message of the first rule names, too
 *     on COMMAND COMMAND       the commands that the program is played on: device, indirect, host,
 *                              nv, command_buffers (device and indirect), with_ranges (device and
 *                              host), or names such as CopyMicromapEXT. Without the line: all
 *                              commands that have ids of the rules
 *     count NUMBER             the number of messages of the first rule
 *     refused COMMAND RULE     see test_case.refused
 *     reports TEXT             what each message contains; anything: nothing is asked. Without the
 *                              line: the path of the first member that only this program edits
 *     only null                the null driver alone plays it
 *     may_fail_on_cpu, ...     other members of struct test_case
 *
 * Lines of which each program may have its own:
 *
 *     edit EDITS               edits the call before it is made
 *     with WORDS               what the device has; see struct setup for these lines
 *     setting level NAME
 *     configure EDITS          edits the configuration of the null driver
 *     route chain | features2 | khr | ext
 *     api 1.NUMBER
 *     muted ID */
#include <stdio.h>
#include <stdlib.h>

#include "tests/player/calls/case.h"
#include "tests/player/play.h"

/* ---- edits ---- */

static const struct call_edits *const all_edits[] = {
#define EDITS(name) &call_edits_##name,
#include "all_edits.inc"
#undef EDITS
};

/* The edit of that text in a file. */
static const struct call_edit *find_edit(const struct program *program,
                                         const struct program_line *line, const char *text)
{
    for (size_t i = 0; i < ARRAY_COUNT(all_edits); i++) {
        if (strcmp(all_edits[i]->group, program->source->group) != 0)
            continue;
        for (size_t j = 0; j < all_edits[i]->count; j++)
            if (strcmp(all_edits[i]->edits[j].text, text) == 0)
                return &all_edits[i]->edits[j];
    }
    program_fail(program->name, line->number, "the edit was not compiled: build the tests again");
}

/* ---- words ---- */

static enum rule rule_of(const struct program *program, const struct program_line *line,
                         const char *word)
{
    char name[128];
    snprintf(name, sizeof(name), "%.*s", (int)strcspn(word, ","), word);
    const struct rule_info *rule = play_rule(name);
    if (!rule)
        program_fail(program->name, line->number, "there is no such rule");
    return (enum rule)(rule - rule_infos);
}

static void read_rules(const struct program *program, const struct program_line *line,
                       char *const *words, enum rule rules[CASE_RULES], uint32_t *count)
{
    for (*count = 0; words[*count] && !play_is(words[*count], ";"); ++*count) {
        if (*count == CASE_RULES)
            program_fail(program->name, line->number, "too many rules");
        rules[*count] = rule_of(program, line, words[*count]);
    }
}

/* Bits of the commands that a word stands for. */
static uint64_t commands_of(const struct program *program, const struct program_line *line,
                            const char *word)
{
    static const struct {
        const char *word;
        uint64_t commands;
    } groups[] = {{"command_buffers", 1 << COMMAND_DEVICE | 1 << COMMAND_INDIRECT},
                  {"with_ranges", 1 << COMMAND_DEVICE | 1 << COMMAND_HOST}};
    for (size_t i = 0; i < ARRAY_COUNT(groups); i++)
        if (play_is(groups[i].word, word))
            return groups[i].commands;
    for (enum build_command command = COMMAND_DEVICE; command < COMMAND_COUNT; command++)
        if (play_is(command_word(command), word) ||
            play_is(build_command_name(command) + strlen("vk"), word))
            return UINT64_C(1) << command;
    program_fail(program->name, line->number, "there is no such command");
}

/* ---- lines ---- */

/* The text behind a word of a line, which stays allocated. */
static const char *text_behind(const struct program_line *line, const char *word)
{
    return strdup(line->text + strlen(word) + 1);
}

/* Whether it is a line of which each program may have its own. */
static bool is_of_form(const struct program_line *line)
{
    static const char *const words[] = {"edit",  "with", "setting", "configure",
                                        "route", "api",  "muted"};
    for (size_t i = 0; i < ARRAY_COUNT(words); i++)
        if (play_is(words[i], line->words[0]))
            return true;
    return false;
}

static enum setup_route route_of(const struct program *program, const struct program_line *line)
{
    static const char *const routes[] = {"chain", "features2", "khr", "ext"};
    for (size_t i = 0; i < ARRAY_COUNT(routes); i++)
        if (play_is(routes[i], line->words[1]))
            return (enum setup_route)i;
    program_fail(program->name, line->number, "there is no such route");
}

static void read_setup(struct setup *setup, const struct program *program,
                       const struct program_line *line)
{
    const char *word = line->words[0];
    if (play_is(word, "with"))
        setup->with = text_behind(line, word);
    else if (play_is(word, "setting") && play_is(line->words[1], "level"))
        setup->level = text_behind(line, "setting level");
    else if (play_is(word, "configure"))
        setup->configure = find_edit(program, line, line->text + strlen("configure "))->configure;
    else if (play_is(word, "route"))
        setup->route = route_of(program, line);
    else if (play_is(word, "api"))
        setup->api_version =
            VK_MAKE_API_VERSION(0, 1, (uint32_t)atoi(line->text + strlen("api 1.")), 0);
    else if (play_is(word, "muted"))
        setup->muted = text_behind(line, word);
    else
        program_fail(program->name, line->number,
                     "programs of calls have no other setting than the level");
}

/* Members of struct test_case that a line of this name sets. */
#define FLAG(member)                                                                               \
    {                                                                                              \
#member, offsetof(struct test_case, member)                                                \
    }
static const struct {
    const char *word;
    size_t offset;
} flags[] = {FLAG(needs_drivers_sizes),
             FLAG(spares_drivers),
             FLAG(may_fail_on_cpu),
             FLAG(keep_arrays),
             FLAG(forwards),
             FLAG(below_content),
             FLAG(guard_protects),
             FLAG(guard_warns),
             FLAG(is_wild),
             FLAG(has_pointers),
             FLAG(is_for_the_call),
             FLAG(is_for_contents),
             {"only", offsetof(struct test_case, needs_null_driver)}};

static bool read_flag(struct test_case *test_case, const char *word)
{
    for (size_t i = 0; i < ARRAY_COUNT(flags); i++)
        if (play_is(flags[i].word, word)) {
            *(bool *)((char *)test_case + flags[i].offset) = true;
            return true;
        }
    return false;
}

/* Reads a line of both programs. */
static void read_line(struct test_case *test_case, const struct program *program,
                      const struct program_line *line)
{
    char *const *words = line->words;
    if (play_is(words[0], "breaks") || play_is(words[0], "keeps")) {
        test_case->silent = play_is(words[0], "keeps");
        read_rules(program, line, words + 1, test_case->rules, &test_case->rule_count);
    } else if (play_is(words[0], "names")) {
        read_rules(program, line, words + 1, test_case->names, &test_case->name_count);
    } else if (play_is(words[0], "on")) {
        for (unsigned i = 1; words[i]; i++)
            test_case->commands |= commands_of(program, line, words[i]);
    } else if (play_is(words[0], "count")) {
        test_case->count = (uint32_t)atoi(words[1]);
    } else if (play_is(words[0], "refused")) {
        test_case->refused = commands_of(program, line, words[1]);
        test_case->refusal = rule_of(program, line, words[2]);
    } else if (!read_flag(test_case, words[0])) {
        program_fail(program->name, line->number, "no line of a call");
    }
}

/* Reads the edits and the setup of one of the programs. Returns the path of the first edit that the
 * other program lacks. */
static const char *read_form(struct test_case *test_case, struct case_form *form,
                             const struct program *program)
{
    const char *path = NULL;
    for (unsigned i = 0; i < program->line_count; i++) {
        const struct program_line *line = &program->lines[i];
        if (!play_is(line->words[0], "edit")) {
            if (is_of_form(line))
                read_setup(&form->setup, program, line);
            continue;
        }
        if (form->step_count == CASE_STEPS)
            program_fail(program->name, line->number, "too many edits");
        const struct call_edit *edit = find_edit(program, line, line->text + strlen("edit "));
        const bool is_changed = line->is_changed || test_case->silent;
        form->steps[form->step_count++] = (struct case_step){edit->edit, is_changed};
        if (is_changed && !path)
            path = edit->path;
    }
    return path;
}

bool case_is_source(const struct source *source)
{
    return strncmp(source->group, "calls/", strlen("calls/")) == 0;
}

void case_read(struct test_case *test_case, const struct source *source, unsigned variant)
{
    static struct program program;
    const struct program_line *reports = NULL;
    program_make(&program, source, variant, !source->has_twin);
    *test_case =
        (struct test_case){.source = source, .variant = variant, .name = strdup(program.name)};
    for (unsigned i = 0; i < program.line_count; i++) {
        const struct program_line *line = &program.lines[i];
        if (play_is(line->words[0], "reports"))
            reports = line;
        else if (!is_of_form(line))
            read_line(test_case, &program, line);
    }
    test_case->path = read_form(test_case, &test_case->forms[0], &program);
    if (reports)
        test_case->path =
            play_is(reports->words[1], "anything") ? NULL : text_behind(reports, "reports");
    program_make(&program, source, variant, true);
    read_form(test_case, &test_case->forms[1], &program);
}
