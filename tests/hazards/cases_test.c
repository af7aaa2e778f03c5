/* SPDX-License-Identifier: Apache-2.0 */
/* hazards_cases_test PLATFORM [--filter NAME] [--list] [--verbose]
 * hazards_cases_test --peer PLATFORM [FILTER]
 *
 * Plays the cases of the hazard check (cases.h) through the loader. With --peer the Khronos layer's
 * synchronization validation plays them, too, and a table says which layer reports what. */
#include "play.h"
#include "tally.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PREFIX "SYNC-HAZARD-"

static const char *const groups[] = {"builds", "copies", "scopes", "queues", "host", "valid"};
static struct hazard_cases cases;
static struct platform platform;

/* ---- Assay */

struct assay {
    struct instance_fixture fixture;
    const char *level; /* of the instance; NULL: there is none */
};

static void open_level(struct assay *assay, const char *level)
{
    if (assay->level && strcmp(assay->level, level) == 0)
        return;
    if (assay->level)
        instance_fixture_close(&assay->fixture);
    assay->level = level;
    instance_fixture_create(&assay->fixture, &platform,
                            &(struct instance_settings){.level = level, .hazards = "true"});
}

static const char *play_with_assay(struct assay *assay, const struct hazard_case *item,
                                   bool is_repaired)
{
    open_level(assay, item->level ? item->level : "content");
    messages_clear(&assay->fixture.messages);
    return play_case(&assay->fixture, item, is_repaired);
}

static bool has_message(const struct messages *messages, const struct case_expectation *expected)
{
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const struct message *message = &messages->items[i];
        if (strncmp(message->id, PREFIX, strlen(PREFIX)) == 0 &&
            strcmp(message->id + strlen(PREFIX), expected->id) == 0 &&
            case_text_matches(message->text, expected->text))
            return true;
    }
    return false;
}

static bool is_as_expected(const struct messages *messages, const struct hazard_case *item,
                           bool is_repaired)
{
    const unsigned count = is_repaired ? 0 : item->expected_count;
    bool good = messages->count == count;
    for (unsigned i = 0; i < count; i++)
        good = good && has_message(messages, &item->expected[i]);
    return good;
}

static void describe(const struct messages *messages, char *text, size_t size)
{
    size_t length = (size_t)snprintf(text, size, "%u messages\n", messages->count);
    for (uint32_t i = 0; i < messages_kept(messages) && length < size; i++)
        length += (size_t)snprintf(text + length, size - length, "  %s: %s\n",
                                   messages->items[i].id, messages->items[i].text);
}

static void test(struct assay *assay, struct tally *tally, const struct hazard_case *item,
                 bool is_repaired)
{
    char name[192], text[8192];
    snprintf(name, sizeof(name), "%s: %s%s", item->group, item->name,
             item->expected_count && is_repaired ? " (repaired)" : "");
    if (!tally_starts(tally, name))
        return;
    const char *missing = play_with_assay(assay, item, is_repaired);
    describe(&assay->fixture.messages, text, sizeof(text));
    if (missing)
        tally_count(tally, OUTCOME_SKIPPED, name, missing);
    else if (is_as_expected(&assay->fixture.messages, item, is_repaired))
        tally_count(tally, OUTCOME_PASSED, name, "");
    else
        tally_count(tally, OUTCOME_FAILED, name, text);
}

/* ---- the Khronos layer beside it */

static void open_khronos(struct instance_fixture *fixture)
{
    static const VkBool32 yes = VK_TRUE, no = VK_FALSE;
    const char *name = "VK_LAYER_KHRONOS_validation";
    const VkLayerSettingEXT settings[] = {
        {name, "validate_sync", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &yes},
        {name, "syncval_full_validation", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &yes},
        {name, "enable_message_limit", VK_LAYER_SETTING_TYPE_BOOL32_EXT, 1, &no},
    };
    const STRUCT(VkLayerSettingsCreateInfoEXT, chain, .settingCount = ARRAY_COUNT(settings),
                 .pSettings = settings);
    instance_fixture_create(fixture, &platform,
                            &(struct instance_settings){.layer = name, .chain = &chain});
}

/* Prints hazards, and the number of messages with VUIDs. */
static void print_messages(const struct messages *messages)
{
    unsigned others = 0;
    const char *separator = "";
    for (uint32_t i = 0; i < messages_kept(messages); i++) {
        const char *id = messages->items[i].id;
        if (strncmp(id, PREFIX, strlen(PREFIX)) != 0) {
            others += strncmp(id, "VUID-", 5) == 0;
            continue;
        }
        printf("%s%s", separator, id + strlen(PREFIX));
        separator = " ";
    }
    if (others)
        printf("%s%u VUIDs", separator, others);
    else if (!*separator)
        printf("-");
}

static void compare(struct assay *assay, struct instance_fixture *khronos,
                    const struct hazard_case *item, bool is_repaired)
{
    messages_clear(&khronos->messages);
    if (play_with_assay(assay, item, is_repaired))
        return;
    play_case(khronos, item, is_repaired);
    printf("%s\t%s%s\t", item->group, item->name,
           item->expected_count && is_repaired ? " (repaired)" : "");
    for (unsigned i = 0; i < item->expected_count && !is_repaired; i++)
        printf("%s%s", i ? " " : "", item->expected[i].id);
    if (!item->expected_count || is_repaired)
        printf("-");
    printf("\t");
    print_messages(&assay->fixture.messages);
    printf("\t");
    print_messages(&khronos->messages);
    printf("\n");
}

static int compare_all(const char *name, const char *filter)
{
    static struct instance_fixture khronos;
    static struct assay assay;
    setenv("ASSAY_TEST_LAYERS", LAYER_FOLDER ":/usr/share/vulkan/explicit_layer.d", 0);
    const char *missing = platform_open(&platform, name);
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 77;
    }
    open_khronos(&khronos);
    printf("group\tprogram\texpected\tAssay\tKhronos\n");
    for (unsigned i = 0; i < cases.count; i++) {
        if (filter && !strstr(cases.items[i].name, filter))
            continue;
        if (cases.items[i].expected_count)
            compare(&assay, &khronos, &cases.items[i], false);
        compare(&assay, &khronos, &cases.items[i], true);
    }
    instance_fixture_close(&khronos);
    open_level(&assay, "content");
    instance_fixture_close(&assay.fixture);
    return 0;
}

/* ---- the program */

static int test_all(int argc, char **argv)
{
    static struct assay assay;
    static struct tally tally;
    const int status = tally_open(&tally, &platform, argc, argv,
                                  "usage: hazards_cases_test " PLATFORM_NAMES
                                  " [--filter NAME] [--list] [--verbose]\n");
    if (status)
        return status;
    for (unsigned i = 0; i < cases.count; i++) {
        if (cases.items[i].expected_count)
            test(&assay, &tally, &cases.items[i], false);
        test(&assay, &tally, &cases.items[i], true);
    }
    if (assay.level)
        instance_fixture_close(&assay.fixture);
    return tally_close(&tally);
}

int main(int argc, char **argv)
{
    const char *folder = getenv("ASSAY_HAZARD_CASES"); /* where scripts/nvidia has packed them */
    for (size_t i = 0; i < ARRAY_COUNT(groups); i++)
        cases_read(&cases, folder ? folder : CASES_FOLDER, groups[i]);
    setenv("VK_ASSAY_VALIDATION_ENABLE_MESSAGE_LIMIT", "false", 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (argc > 2 && strcmp(argv[1], "--peer") == 0)
        return compare_all(argv[2], argc > 3 ? argv[3] : NULL);
    return test_all(argc, argv);
}
