/* SPDX-License-Identifier: Apache-2.0 */
/* content_test PLATFORM [--filter NAME] [--list] [--verbose] [--results FILE]
 *
 * Plays the cases about the data of builds by command buffers, in every variant that fits, and
 * writes what fired and what stayed silent as lines of tab-separated values: platform,
 * case+variant, command, id, fired|silent|failed. */
#include <stdio.h>
#include <string.h>

#include "tests/rules/wording.h"
#include "variant.h"

#define LIST(name) &cases_##name,
static const struct case_list *const lists[] = {
#include "tests/rules/lists_of_content_test.def"
};
enum { LIST_COUNT = sizeof(lists) / sizeof(lists[0]) };

struct run {
    struct platform platform;
    struct tally tally;
    struct fixture fixture;
    struct report report;
    const struct setup *setup; /* in which the valid call was silent, in these variants: */
    uint64_t known;
    bool fired[MESSAGE_ID_COUNT], stayed_silent[MESSAGE_ID_COUNT];
};

static void write_results(struct run *run, const char *name, const struct play *play)
{
    const struct test_case *test_case = play->test_case;
    const struct report *report = &run->report;
    const bool is_silent = test_case->silent || play->variant->change == CHANGE_FOR_THE_BETTER;

    for (uint32_t i = 0; i < test_case->rule_count && report->outcome == OUTCOME_PASSED; i++) {
        const enum vuid vuid = rule_infos[test_case->rules[i]].vuid[play->variant->command];
        run->fired[vuid] |= !is_silent;
        run->stayed_silent[vuid] = true;
    }
    if (run->tally.results == NULL || report->outcome == OUTCOME_SKIPPED)
        return;
    for (uint32_t i = 0; i < test_case->rule_count; i++) {
        const char *id = rule_id(test_case->rules[i], play->variant->command);
        if (vuid_is_warning(rule_infos[test_case->rules[i]].vuid[play->variant->command]))
            continue; /* scripts/coverage counts the registry's ids */
        const bool stayed_silent = report->stayed_silent && (report->fired || !is_silent);
        if (!is_silent)
            tally_write(&run->tally, &run->platform, name, play->variant->command, id,
                        report->fired ? "fired" : "failed");
        tally_write(&run->tally, &run->platform, name, play->variant->command, id,
                    stayed_silent ? "silent" : "failed");
    }
}

static void play_variant(struct run *run, const struct case_list *list,
                         const struct test_case *test_case, uint32_t index)
{
    const struct variant *variant = &variants[index];
    char name[256];

    snprintf(name, sizeof(name), "%s.%s/%s", list->name, test_case->name, variant->name);
    if (!variant_fits(variant, &run->platform, test_case) || !tally_starts(&run->tally, name))
        return;
    const struct play play = {.make_call = content_call,
                              .platform = &run->platform,
                              .test_case = test_case,
                              .command = variant->command,
                              .geometry_pointers = variant->geometry_pointers,
                              .variant = variant,
                              .base_is_known = run->setup == test_case->setup &&
                                               test_case->right_setup == NULL &&
                                               (run->known >> index & 1) != 0,
                              .is_made_better = variant->change == CHANGE_FOR_THE_BETTER};
    judge_play(&play, &run->fixture, &run->report);
    if (run->setup != test_case->setup)
        run->known = 0;
    run->setup = test_case->setup;
    if (run->report.stayed_silent && test_case->right_setup == NULL)
        run->known |= UINT64_C(1) << index;
    write_results(run, name, &play);
    tally_count(&run->tally, run->report.outcome, name, run->report.text);
}

/* Plays a case; or the case with its first rule muted, if the message of that rule names others. */
static void play_one(struct run *run, const struct case_list *list,
                     const struct test_case *test_case, uint32_t index, bool mutes)
{
    const struct play play = {.test_case = test_case, .command = variants[index].command};
    struct muted_play muted;
    if (!mutes) {
        play_variant(run, list, test_case, index);
    } else if (variants[index].change != CHANGE_FOR_THE_BETTER && wording_mute(&play, &muted)) {
        play_variant(run, list, &muted.test_case, index);
        run->setup = NULL; /* `muted` ends here */
    }
}

/* Those that read data, which at level content alone is done. */
static bool is_about_inputs(const struct test_case *test_case)
{
    return test_case->setup != NULL && test_case->setup->level != NULL &&
           strcmp(test_case->setup->level, "content") == 0 && !test_case->is_for_the_call;
}

/* The muted plays come last, because each of them has a device of its own. */
static void play_all(struct run *run, bool mutes)
{
    for (size_t i = 0; i < LIST_COUNT; i++)
        for (size_t j = 0; j < lists[i]->count; j++) {
            const struct test_case *test_case = &lists[i]->cases[j];
            for (uint32_t k = 0; k < variant_count && is_about_inputs(test_case); k++)
                play_one(run, lists[i], test_case, k, mutes);
        }
}

/* On the null driver, which takes everything. */
static void check_every_rule_has_fired(struct run *run)
{
    run->report = (struct report){.outcome = OUTCOME_PASSED};
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        for (int command = 0; command < BUILD_COMMAND_COUNT && info->subject != NULL; command++) {
            const enum vuid vuid = info->vuid[command];
            if (info->level != LEVEL_CONTENT || command == COMMAND_HOST || vuid == VUID_NONE ||
                (run->fired[vuid] && run->stayed_silent[vuid]))
                continue;
            printf("never fired and silent: %s (%s)\n", vuid_texts[vuid].id, info->name);
            run->report.outcome = OUTCOME_FAILED;
        }
    }
    tally_count(&run->tally, run->report.outcome, "every_rule_has_fired", "");
}

int main(int argc, char **argv)
{
    static struct run run;

    const int status = tally_open(&run.tally, &run.platform, argc, argv,
                                  "usage: content_test " PLATFORM_NAMES
                                  " [--filter NAME] [--list] [--verbose] [--results FILE]\n");
    if (status != 0)
        return status;
    play_all(&run, false);
    play_all(&run, true);
    texts_play(&run.platform, &run.fixture, &run.tally);
    fixture_close(&run.fixture);
    if (run.platform.is_null && !run.platform.is_cpu && !run.platform.is_guarded &&
        run.tally.filter == NULL && !run.tally.list)
        check_every_rule_has_fired(&run);
    return tally_close(&run.tally);
}
