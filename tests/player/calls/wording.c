/* SPDX-License-Identifier: Apache-2.0 */
/* Checks the wording of messages, and mutes rules to see those that their messages name. */
#include "tests/player/calls/judge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- other ids of the same mistake */

static bool names_the_others(const struct play *play, const struct fixture *fixture,
                             struct report *report)
{
    const struct test_case *test_case = play->test_case;
    if (test_case->silent || test_case->name_count == 0 ||
        !judge_expects(play, test_case->rules[0]))
        return true;
    const char *id = rule_id(test_case->rules[0], play->command);
    for (uint32_t i = 0; i < test_case->name_count; i++) {
        const char *other = rule_id(test_case->names[i], play->command);
        if (other == NULL || !judge_expects(play, test_case->names[i]) ||
            messages_count(&fixture->instance.messages, id, other) > 0)
            continue;
        report_say(report, "no message of %s names %s\n", id, other);
        return false;
    }
    return true;
}

static bool is_id(enum rule rule, const struct play *play, const char *at)
{
    const char *id = rule_id(rule, play->command);
    return id != NULL && strncmp(at, id, strlen(id)) == 0;
}

/* Whether the id at `at` is that of a rule in NAMES(), or of one that reads data which the setup's
 * level does not. */
static bool is_named(const struct play *play, const char *at)
{
    const struct test_case *test_case = play->test_case;
    for (uint32_t i = 0; i < test_case->name_count; i++)
        if (is_id(test_case->names[i], play, at))
            return true;
    const char *level = case_wrong(test_case)->setup.level;
    if (level != NULL && level_named(level) >= LEVEL_CONTENT)
        return false;
    for (enum rule rule = 0; rule < RULE_COUNT; rule++)
        if (rule_infos[rule].level == LEVEL_CONTENT && is_id(rule, play, at))
            return true;
    return false;
}

/* Checks only messages of the case's first rule: other cases check those of other rules. */
static bool names_nothing_else(const struct play *play, const struct message *message,
                               struct report *report)
{
    const struct test_case *test_case = play->test_case;
    const char *own =
        test_case->rule_count != 0 ? rule_id(test_case->rules[0], play->command) : NULL;
    const char *end = report_own_end(message);
    if (own == NULL || strcmp(message->id, own) != 0)
        return true;
    for (const char *at = strstr(message->text, " (also VUID-"); at != NULL && at < end;
         at = strstr(at, ", VUID-")) {
        at = strstr(at, "VUID-");
        if (is_named(play, at))
            continue;
        report_say(report, "the message of %s names %.90s\n", own, at);
        return false;
    }
    return true;
}

bool wording_is_good(const struct play *play, const struct fixture *fixture, struct report *report)
{
    const struct messages *messages = &fixture->instance.messages;
    bool good = names_the_others(play, fixture, report) && report_judge_wording(report, messages);
    for (uint32_t i = 0; i < messages_kept(messages); i++)
        good = names_nothing_else(play, &messages->items[i], report) && good;
    return good;
}

bool wording_mute(const struct play *play, struct muted_play *muted)
{
    const struct test_case *test_case = play->test_case;
    const char *id = test_case->rule_count ? rule_id(test_case->rules[0], play->command) : NULL;
    enum rule rules[2 * CASE_RULES] = {0};
    uint32_t count = 0;
    if (test_case->silent || id == NULL || judge_is_refused(play))
        return false;
    for (uint32_t i = 0; i < test_case->name_count; i++)
        if (rule_id(test_case->names[i], play->command) != NULL)
            rules[count++] = test_case->names[i];
    if (count == 0)
        return false;
    for (uint32_t i = 1; i < test_case->rule_count; i++)
        rules[count++] = test_case->rules[i];
    if (count > CASE_RULES)
        abort();

    snprintf(muted->name, sizeof(muted->name), "%s+muted", test_case->name);
    muted->test_case = *test_case;
    muted->test_case.name = muted->name;
    muted->test_case.forms[0].setup.muted = muted->test_case.forms[1].setup.muted = id;
    memcpy(muted->test_case.rules, rules, sizeof(muted->test_case.rules));
    muted->test_case.rule_count = count;
    muted->test_case.name_count = 0;
    muted->test_case.count = 0;
    muted->play = *play;
    muted->play.test_case = &muted->test_case;
    return true;
}
