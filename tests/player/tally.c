/* SPDX-License-Identifier: Apache-2.0 */
/* Options and counts of what plays cases and programs. */
#include "tests/player/tally.h"

#include <stdlib.h>
#include <string.h>

enum level level_named(const char *name)
{
    static const char *const names[LEVEL_COUNT] = {"parameters", "state", "execution", "content"};
    enum level level = LEVEL_PARAMETERS;
    while (level < LEVEL_COUNT && strcmp(names[level], name) != 0)
        level++;
    return level;
}

static bool read_arguments(struct tally *tally, int argc, char **argv)
{
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--list") == 0) {
            tally->list = true;
        } else if (strcmp(argv[i], "--misaligned") == 0) {
            tally->misaligns = true;
        } else if (strcmp(argv[i], "--submitted") == 0) {
            tally->submits = true;
        } else if (strcmp(argv[i], "--fail") == 0) {
            tally->fails = true;
        } else if (strcmp(argv[i], "--refused") == 0) {
            tally->refuses = true;
        } else if (strcmp(argv[i], "--verbose") == 0) {
            tally->verbose = true;
        } else if (strcmp(argv[i], "--filter") == 0 && i + 1 < argc) {
            tally->filter = argv[++i];
        } else if (strcmp(argv[i], "--level") == 0 && i + 1 < argc &&
                   level_named(argv[i + 1]) != LEVEL_COUNT) {
            tally->level = argv[++i];
        } else if (strcmp(argv[i], "--results") == 0 && i + 1 < argc) {
            tally->results = fopen(argv[++i], "w");
            if (tally->results == NULL) {
                perror(argv[i]);
                return false;
            }
        } else {
            return false;
        }
    }
    return true;
}

int tally_open(struct tally *tally, int argc, char **argv, const char *usage)
{
    if (argc > 1 && strcmp(argv[1], "--help") == 0) {
        fputs(usage, stdout);
        exit(0);
    }
    if (argc < 2 || !read_arguments(tally, argc, argv)) {
        fputs(usage, stderr);
        return 2;
    }
    tally->argument_count = argc;
    tally->arguments = argv;
    setvbuf(stdout, NULL, _IOLBF, 0);
    const char *missing = platform_open(&tally->platform, argv[1]);
    if (missing == NULL)
        return 0;
    printf("[  SKIPPED ] %s: %s\n", argv[1], missing);
    return 77;
}

/* A filter with ! leaves out what others would choose. */
static bool is_wanted(const struct tally *tally, const char *name)
{
    const char *filter = tally->filter;
    if (filter == NULL)
        return true;
    const bool leaves_out = filter[0] == '!';
    return (strstr(name, filter + leaves_out) == NULL) == leaves_out;
}

bool tally_starts(const struct tally *tally, const char *name)
{
    if (!is_wanted(tally, name))
        return false;
    if (tally->list)
        puts(name);
    else if (tally->verbose)
        printf("[ RUN      ] %s\n", name);
    return !tally->list;
}

const char *command_word(enum build_command command)
{
    static const char *const words[BUILD_COMMAND_COUNT] = {"device", "indirect", "host", "nv"};
    return command < BUILD_COMMAND_COUNT ? words[command] : build_command_name(command);
}

void tally_note(struct tally *tally, const char *name, enum build_command command, enum vuid vuid,
                enum sight sight)
{
    static const char *const words[] = {"fired", "silent", "unseen", "failed"};
    if (vuid == VUID_NONE)
        return;
    tally->fired[vuid] |= sight == SIGHT_FIRED;
    tally->stayed_silent[vuid] |= sight == SIGHT_SILENT;
    if (tally->results != NULL &&
        !vuid_is_warning(vuid)) /* scripts/coverage counts the registry's ids */
        fprintf(tally->results, "%s\t%s\t%s\t%s\t%s\n", tally->platform.name, name,
                command_word(command), vuid_texts[vuid].id, words[sight]);
}

void tally_check_ids(struct tally *tally, const char *name,
                     bool (*is_asked_for)(const struct rule_info *info, enum build_command command))
{
    struct report report = {.outcome = OUTCOME_PASSED};
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        const struct rule_info *info = &rule_infos[rule];
        for (enum build_command command = COMMAND_DEVICE; info->subject && command < COMMAND_COUNT;
             command++) {
            const enum vuid vuid = info->vuid[command];
            if (vuid == VUID_NONE || (tally->fired[vuid] && tally->stayed_silent[vuid]) ||
                !is_asked_for(info, command))
                continue;
            report_say(&report, "never %s: %s (%s)\n", tally->fired[vuid] ? "silent" : "fired",
                       vuid_texts[vuid].id, info->name);
            tally->fired[vuid] = tally->stayed_silent[vuid] = true; /* reported once */
            report.outcome = OUTCOME_FAILED;
        }
    }
    tally_count(tally, name, &report);
}

static void count_reason(struct tally *tally, const char *text)
{
    for (uint32_t i = 0; i < TALLY_REASONS_MAX; i++) {
        if (tally->reasons[i].count != 0 && strncmp(tally->reasons[i].text, text, 100) != 0)
            continue;
        snprintf(tally->reasons[i].text, sizeof(tally->reasons[i].text), "%.100s", text);
        tally->reasons[i].count++;
        return;
    }
}

/* Without a filter, and without results, of which the file would hold no others. */
static void print_command(const struct tally *tally, const char *name)
{
    printf("again: ");
    for (int i = 0; i < tally->argument_count; i++) {
        const char *argument = tally->arguments[i];
        const bool is_dropped =
            strcmp(argument, "--filter") == 0 || strcmp(argument, "--results") == 0;
        i += is_dropped;
        if (!is_dropped)
            printf("%s ", argument);
    }
    printf("--filter '%s'\n", name);
}

void tally_count(struct tally *tally, const char *name, const struct report *report)
{
    switch (report->outcome) {
    case OUTCOME_PASSED:
        tally->passed++;
        if (tally->verbose)
            printf("[       OK ] %s\n", name);
        break;
    case OUTCOME_FAILED:
        tally->failed++;
        printf("%s[  FAILED  ] %s\n", report->text, name);
        print_command(tally, name);
        break;
    case OUTCOME_SKIPPED:
        tally->skipped++;
        count_reason(tally, report->text);
        if (tally->verbose)
            printf("[  SKIPPED ] %s: %s\n", name, report->text);
        break;
    }
}

int tally_close(struct tally *tally)
{
    for (uint32_t i = 0; i < TALLY_REASONS_MAX && tally->reasons[i].count != 0; i++)
        printf("[  SKIPPED ] %u: %s\n", tally->reasons[i].count, tally->reasons[i].text);
    if (!tally->list) {
        printf("[==========] %u test(s) run.\n", tally->passed + tally->failed);
        printf("%u passed, %u failed, %u skipped\n", tally->passed, tally->failed, tally->skipped);
    }
    if (tally->results != NULL && fclose(tally->results) != 0)
        return 1;
    if (tally->filter != NULL && !tally->list &&
        tally->passed + tally->failed + tally->skipped == 0) {
        fprintf(stderr, "no test has %s in its name\n", tally->filter);
        return 2;
    }
    return tally->failed == 0 ? 0 : 1;
}
