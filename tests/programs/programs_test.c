/* SPDX-License-Identifier: Apache-2.0 */
/* programs_test PLATFORM [FOLDER[/FILE]] [--filter NAME] [--list] [--verbose] [--results FILE]
 *               [--level NAME] [--refused | --submitted | --misaligned | --fail]
 * programs_test --peer PLATFORM FOLDER[/FILE]
 *
 * Plays the programs (program.h) of a folder, or of all, through the loader. --results writes which
 * rule fired or stayed silent as lines of tab-separated values: platform, program, command, id, and
 * fired, silent or failed; at a level below execution, unseen. With --refused, the null driver
 * refuses each call of the device once, and nothing may be reported about valid programs. With
 * --peer the Khronos layer's synchronization validation plays the programs, too, and a table says
 * which layer reports what. The other options are those of programs of calls (tests/player/calls/),
 * and no others are played with them: --submitted, --misaligned, and --fail. */
#include "tests/player/calls/case.h"
#include "tests/player/play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct sources sources;
static struct tally tally;
enum { PLAYS = 4 }; /* instances that are open at once */
static struct play plays[PLAYS], khronos = {&tally.platform, .is_khronos = true};
static struct play *assay = plays; /* of the program */
static struct program program;

/* ---- results */

static void write_results(enum vuid vuid, enum build_command command)
{
    if (assay->report.outcome != OUTCOME_SKIPPED)
        tally_note(&tally, program.name, command, vuid,
                   assay->report.outcome != OUTCOME_PASSED ? SIGHT_FAILED
                   : program.is_repaired                   ? SIGHT_SILENT
                   : play_sees_executions(assay)           ? SIGHT_FIRED
                                                           : SIGHT_UNSEEN);
}

/* Every rule about updates that needs no data; on drivers other than the null driver, that of the
 * device's command. */
static bool is_about_updates(const struct rule_info *info, enum build_command command)
{
    const bool is_complete = tally.platform.is_null && !tally.platform.is_cpu;
    return info->level < LEVEL_CONTENT && (command == COMMAND_DEVICE || is_complete) &&
           (strcmp(info->subject, "update") == 0 || strcmp(info->subject, "updated_geometry") == 0);
}

/* ---- playing */

/* How many programs the source has for one twin, if these are sequences. */
static unsigned sequence_variants(const struct source *source)
{
    return case_is_source(source) ? 0 : source_variants(source);
}

/* The play whose instance the program needs; else the next one in turn. */
static struct play *choose_play(void)
{
    static unsigned next;
    for (unsigned i = 0; i < PLAYS; i++)
        if (play_suits(&plays[i], &program))
            return assay = &plays[i];
    next = (next + 1) % PLAYS;
    return assay = &plays[next];
}

/* Without mistakes, and without lines about what the driver or the log counts, or about calls that
 * fail. */
static bool can_be_refused(void)
{
    static const char *const words[] = {"fail",  "fault",   "lose",   "count",
                                        "costs", "records", "returns"};
    if ((program.source->has_twin ? !program.is_repaired : program.expected_count > 0) ||
        program_find(&program, "only", "memory"))
        return false;
    for (unsigned i = 0; i < program.line_count; i++)
        for (char *const *word = program.lines[i].words; *word; word++)
            for (size_t j = 0; j < ARRAY_COUNT(words); j++)
                if (strcmp(*word, words[j]) == 0)
                    return false;
    return true;
}

static void play_one(const struct source *source, unsigned variant, bool is_repaired)
{
    enum vuid vuid;
    enum build_command command = COMMAND_DEVICE;
    program_make(&program, source, variant, is_repaired);
    if (!program_subject(&program, &vuid, &command) || (tally.refuses && !can_be_refused()) ||
        !tally_starts(&tally, program.name))
        return;
    play_program(choose_play(), &program);
    write_results(vuid, command);
    tally_count(&tally, program.name, &assay->report);
}

static bool is_about_calls(void)
{
    return tally.submits || tally.misaligns || tally.fails;
}

/* Plays all programs but those of calls. */
static void play_sequences(void)
{
    for (unsigned i = 0; i < PLAYS; i++)
        plays[i] = (struct play){.platform = &tally.platform,
                                 .level = tally.level,
                                 .is_scarce = tally.refuses,
                                 .repeats = tally.refuses,
                                 .may_warn = tally.refuses};
    if (tally.refuses)
        setenv("NULL_DRIVER_FAILS", "*", 1);
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < sequence_variants(&sources.items[i]); j++) {
            if (sources.items[i].has_twin)
                play_one(&sources.items[i], j, false);
            play_one(&sources.items[i], j, true);
        }
    for (unsigned i = 0; i < PLAYS; i++)
        play_close(&plays[i]);
}

static int play_all(int argc, char **argv, const char *chosen)
{
    const int status = tally_open(&tally, argc, argv,
                                  "usage: programs_test " PLATFORM_NAMES
                                  " [FOLDER[/FILE]] [--filter NAME] [--list] [--verbose]"
                                  " [--results FILE] [--level NAME]"
                                  " [--refused | --submitted | --misaligned | --fail]\n");
    if (status)
        return status;
    if (!is_about_calls())
        play_sequences();
    if (!tally.refuses)
        calls_play(&sources, &tally, !chosen || strcmp(chosen, "calls") == 0);
    if ((!chosen || strcmp(chosen, "execution") == 0) && !tally.filter && !tally.list &&
        !tally.level && !tally.refuses && !is_about_calls())
        tally_check_ids(&tally, "every id about updates has a program", is_about_updates);
    return tally_close(&tally);
}

/* ---- the Khronos layer beside Assay */

/* Prints hazards, and the number of messages with VUIDs. */
static void print_messages(const struct messages *messages)
{
    static const char prefix[] = "SYNC-HAZARD-";
    unsigned others = 0;
    const char *separator = "";
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const char *id = messages->items[i].id;
        if (strncmp(id, prefix, strlen(prefix)) != 0) {
            others += strncmp(id, "VUID-", 5) == 0;
            continue;
        }
        printf("%s%s", separator, id + strlen(prefix));
        separator = " ";
    }
    if (others)
        printf("%s%u VUIDs", separator, others);
    else if (!*separator)
        printf("-");
}

static void compare(const struct source *source, unsigned variant, bool is_repaired)
{
    program_make(&program, source, variant, is_repaired);
    if (program_find(&program, "setting", "log_filename"))
        return; /* it is about Assay's own log */
    play_program(choose_play(), &program);
    if (assay->report.outcome == OUTCOME_SKIPPED)
        return;
    play_program(&khronos, &program);
    const char *colon = strchr(program.name, ':');
    printf("%.*s\t%s\t", (int)(colon - program.name), program.name, colon + 2);
    for (unsigned i = 0; i < program.expected_count && !is_repaired; i++)
        printf("%s%s", i ? " " : "", program.expected[i].id);
    if (!program.expected_count || is_repaired)
        printf("-");
    printf("\t");
    print_messages(&assay->fixture.messages);
    printf("\t");
    print_messages(&khronos.fixture.messages);
    printf("\n");
}

static int compare_all(const char *name)
{
    setenv("ASSAY_TEST_LAYERS", LAYER_FOLDER ":/usr/share/vulkan/explicit_layer.d", 0);
    const char *missing = platform_open(&tally.platform, name);
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 77;
    }
    for (unsigned i = 0; i < PLAYS; i++)
        plays[i].platform = &tally.platform;
    printf("group\tprogram\texpected\tAssay\tKhronos\n");
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < sequence_variants(&sources.items[i]); j++) {
            if (sources.items[i].has_twin)
                compare(&sources.items[i], j, false);
            compare(&sources.items[i], j, true);
        }
    play_close(&khronos);
    for (unsigned i = 0; i < PLAYS; i++)
        play_close(&plays[i]);
    return 0;
}

int main(int argc, char **argv)
{
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (argc > 3 && strcmp(argv[1], "--peer") == 0) {
        sources_read_all(&sources, argv[3]);
        return compare_all(argv[2]);
    }
    const char *chosen = argc > 2 && argv[2][0] != '-' ? argv[2] : NULL;
    if (chosen) {
        argv[2] = argv[1];
        argv[1] = argv[0];
        argv++;
        argc--;
    }
    sources_read_all(&sources, chosen);
    return play_all(argc, argv, chosen);
}
