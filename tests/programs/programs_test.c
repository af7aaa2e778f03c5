/* SPDX-License-Identifier: Apache-2.0 */
/* programs_test PLATFORM [FOLDER[/FILE]] [--filter NAME] [--list] [--verbose] [--results FILE]
 *               [--level NAME]
 * programs_test --peer PLATFORM FOLDER[/FILE]
 *
 * Plays the programs (program.h) of a folder, or of all, through the loader. --results writes which
 * rule fired or stayed silent as lines of tab-separated values: platform, program, command, id, and
 * fired, silent or failed; at a level below execution, unseen. With --peer the Khronos layer's
 * synchronization validation plays the programs, too, and a table says which layer reports what. */
#include "tests/player/play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct sources sources;
static struct platform platform;
enum { PLAYS = 4 }; /* instances that are open at once */
static struct play plays[PLAYS], khronos = {&platform, .is_khronos = true};
static struct play *assay = plays; /* of the program */
static struct program program;
static struct tally tally;

/* ---- results */

static bool fired[MESSAGE_ID_COUNT], stayed_silent[MESSAGE_ID_COUNT];

static void write_results(enum vuid vuid, enum build_command command)
{
    const bool is_unseen = !play_sees_executions(assay);
    const char *word = assay->outcome != OUTCOME_PASSED ? "failed"
                       : program.is_repaired            ? "silent"
                       : is_unseen                      ? "unseen"
                                                        : "fired";
    if (vuid == VUID_NONE || assay->outcome == OUTCOME_SKIPPED)
        return;
    fired[vuid] |= strcmp(word, "fired") == 0;
    stayed_silent[vuid] |= strcmp(word, "silent") == 0;
    if (tally.results)
        tally_write(&tally, &platform, program.name, command, vuid_texts[vuid].id, word);
}

/* Every rule of the subject that needs no data has fired, and stayed silent; on drivers other than
 * the null driver, that of the device's command. */
static void check_subject(const char *subject)
{
    const bool is_complete = platform.is_null && !platform.is_cpu;
    char name[128];
    bool good = true;
    snprintf(name, sizeof(name), "every rule of %s has fired", subject);
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        if (!info->subject || info->level >= LEVEL_CONTENT || strcmp(info->subject, subject) != 0)
            continue;
        for (enum build_command command = COMMAND_DEVICE; command < COMMAND_COUNT; command++) {
            const enum vuid vuid = info->vuid[command];
            if (vuid == VUID_NONE || (command != COMMAND_DEVICE && !is_complete) ||
                (fired[vuid] && stayed_silent[vuid]))
                continue;
            printf("never %s: %s (%s)\n", fired[vuid] ? "silent" : "fired", vuid_texts[vuid].id,
                   info->name);
            good = false;
        }
    }
    tally_count(&tally, good ? OUTCOME_PASSED : OUTCOME_FAILED, name, "");
}

static void check_coverage(const char *chosen)
{
    static const char *const subjects[] = {"update", "updated_geometry"};
    const bool is_all = !chosen || strcmp(chosen, "execution") == 0;
    for (size_t i = 0; i < ARRAY_COUNT(subjects); i++)
        if (is_all && !tally.filter && !tally.list && !tally.level)
            check_subject(subjects[i]);
}

/* ---- playing */

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

static void play_one(const struct source *source, unsigned variant, bool is_repaired)
{
    enum vuid vuid;
    enum build_command command = COMMAND_DEVICE;
    program_make(&program, source, variant, is_repaired);
    if (!program_subject(&program, &vuid, &command) || !tally_starts(&tally, program.name))
        return;
    play_program(choose_play(), &program);
    write_results(vuid, command);
    tally_count(&tally, assay->outcome, program.name, assay->report);
}

static int play_all(int argc, char **argv, const char *chosen)
{
    const int status = tally_open(&tally, &platform, argc, argv,
                                  "usage: programs_test " PLATFORM_NAMES
                                  " [FOLDER[/FILE]] [--filter NAME] [--list] [--verbose]"
                                  " [--results FILE] [--level NAME]\n");
    if (status)
        return status;
    for (unsigned i = 0; i < PLAYS; i++)
        plays[i] = (struct play){.platform = &platform, .level = tally.level};
    for (unsigned i = 0; i < sources.count; i++)
        for (unsigned j = 0; j < source_variants(&sources.items[i]); j++) {
            if (sources.items[i].has_twin)
                play_one(&sources.items[i], j, false);
            play_one(&sources.items[i], j, true);
        }
    for (unsigned i = 0; i < PLAYS; i++)
        play_close(&plays[i]);
    check_coverage(chosen);
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

static void compare(const struct source *source, bool is_repaired)
{
    program_make(&program, source, 0, is_repaired);
    play_program(choose_play(), &program);
    if (assay->outcome == OUTCOME_SKIPPED)
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
    const char *missing = platform_open(&platform, name);
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 77;
    }
    plays[0].platform = &platform;
    printf("group\tprogram\texpected\tAssay\tKhronos\n");
    for (unsigned i = 0; i < sources.count; i++) {
        if (sources.items[i].has_twin)
            compare(&sources.items[i], false);
        compare(&sources.items[i], true);
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
