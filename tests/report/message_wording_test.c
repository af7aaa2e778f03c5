/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what messages say beside the finding: counts with their nouns, hints, and the other ids
 * that the same mistake violates. */
#include "hearing.h"
#include "src/report/finding_message.h"
#include "src/state/commands/call_sites.h"

static struct message message;

static const char *word(enum rule rule, enum build_command command, const struct finding *finding)
{
    const struct location location = {.command = command, .subject = SUBJECT_BUILD};
    message_of_finding(&message, rule_infos[rule].vuid[command], &location,
                       &(struct call_origin){0}, finding, &(struct message_style){0});
    return message.text;
}

static void assert_counted(uint64_t count, const char *noun, const char *expected)
{
    struct finding finding;
    finding_says(&finding, "a", "has {}", count_of(count, noun));
    const char *text = word(RULE_opacity_index_stride_fits_32_bits, COMMAND_DEVICE, &finding);
    const char *found = strstr(text, " has ");
    assert_non_null(found);
    assert_int_equal(strncmp(found + strlen(" has "), expected, strlen(expected)), 0);
}

TEST(test_counts_agree_with_their_nouns)
{
    assert_counted(0, "byte", "0 bytes.");
    assert_counted(1, "byte", "1 byte.");
    assert_counted(2, "byte", "2 bytes.");
    assert_counted(UINT64_MAX, "byte", "18446744073709551615 bytes.");
    assert_counted(1, "vertex", "1 vertex.");
    assert_counted(3, "vertex", "3 vertices.");
    assert_counted(3, "index", "3 indices.");
    assert_counted(1, "geometry", "1 geometry.");
    assert_counted(2, "geometry", "2 geometries.");
    assert_counted(21, "AABB", "21 AABBs.");
    assert_counted(4096, "ray", "4096 rays.");
}

TEST(test_the_hint_is_the_second_sentence)
{
    struct finding finding;
    finding_fill(&finding, "flags", "are odd", NULL, 0);
    assert_has(word(RULE_fast_trace_excludes_fast_build, COMMAND_HOST, &finding),
               "(): pInfos[0].flags are odd. Clear one of the two flags.\n");
    assert_has(word(RULE_opacity_index_stride_fits_32_bits, COMMAND_HOST, &finding),
               "(): pInfos[0].flags are odd.\n");
}

/* The id of a command is named with the messages of that command. */
TEST(test_other_ids_of_the_mistake_are_named)
{
    struct finding finding;
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    also_violates(&finding, RULE_indirect_build_ranges_are_valid);
    assert_lacks(word(RULE_build_mode_is_valid, COMMAND_DEVICE, &finding), "(also");
    assert_has(
        word(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding),
        " (also VUID-vkCmdBuildAccelerationStructuresIndirectKHR-pIndirectDeviceAddresses-03651)"
        "\nThe Vulkan spec states: ");
    also_violates(&finding, RULE_build_flags_are_valid);
    assert_has(
        word(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding),
        " (also VUID-vkCmdBuildAccelerationStructuresIndirectKHR-pIndirectDeviceAddresses-03651, "
        "VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-parameter)\n");
    assert_has(word(RULE_build_mode_is_valid, COMMAND_HOST, &finding),
               " (also VUID-VkAccelerationStructureBuildGeometryInfoKHR-flags-parameter)\n");
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    assert_lacks(word(RULE_build_mode_is_valid, COMMAND_INDIRECT, &finding), "(also");
    also_violates(&finding, RULE_build_flags_are_valid);
    is_reported_with(&finding, RULE_build_flags_are_valid);
    assert_lacks(word(RULE_build_mode_is_valid, COMMAND_DEVICE, &finding), "(also");
    /* A caller that needs the result of a predicate passes no finding. */
    assert_false(also_violates(NULL, RULE_build_flags_are_valid));
    assert_false(is_reported_with(NULL, RULE_build_flags_are_valid));
}

TEST(test_a_call_site_is_named_by_its_first_frames)
{
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    struct call_site site = {6,
                             {{"/a/\"b\n", 0x1139}, {NULL, 7}, {"/c", 8}, {"/d", 9}, {"/e", 10}}};
    const struct call_origin origin = {.call_site = &site};
    const struct message_style style = {.spec_text = SPEC_TEXT_NONE};
    struct finding finding;
    finding_fill(&finding, "mode", "is odd", NULL, 0);
    message_of_finding(&message, rule_infos[RULE_build_mode_is_valid].vuid[COMMAND_DEVICE],
                       &location, &origin, &finding, &style);
    assert_non_null(strstr(
        message.text, ". Called from /a/\\\"b\\n+0x1139, unknown module+0x7, /c+0x8, /d+0x9."));
    site.count = 1;
    message_of_finding(&message, rule_infos[RULE_build_mode_is_valid].vuid[COMMAND_DEVICE],
                       &location, &origin, &finding, &style);
    assert_non_null(strstr(message.text, " Called from /a/\\\"b\\n+0x1139."));
}
