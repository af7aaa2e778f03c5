/* SPDX-License-Identifier: Apache-2.0 */
/* What recording does to a command buffer, beyond what rules about command buffers see. */
#include <stdlib.h>

#include "src/state/commands/bound_shaders.h"
#include "src/state/commands/label_stack.h"
#include "tests/state/fixture.h"

COMMAND_BUFFERS_TEST(what_fails_leaves_a_state_that_is_not_known_or_invalid)
{
    begin_with(all, 1, 0, VK_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_UNKNOWN);
    begin(all, 1);
    command_buffer_end(command_buffers_find(all, handle(1)), VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_INVALID);
    command_buffer_reset(command_buffers_find(all, handle(1)), true, VK_ERROR_OUT_OF_HOST_MEMORY);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_UNKNOWN);
}

COMMAND_BUFFERS_TEST(beginning_again_starts_over)
{
    struct command_buffer *first = begin(all, 1);
    const VkDebugUtilsLabelEXT label = {.pLabelName = "frame"};
    command_buffer_begin_rendering(first, VK_RENDERING_SUSPENDING_BIT);
    command_buffer_end_rendering(first);
    command_buffer_set_video_coding(first, true);
    first->facts.build_index = 7;
    label_stack_push(command_buffers_labels(all, handle(1)), &label);
    assert_int_equal(facts_of(all, 1).build_index, 7);
    begin(all, 1);
    struct command_buffer_facts facts = facts_of(all, 1);
    assert_int_equal(facts.suspended, UNKNOWN);
    assert_int_equal(facts.in_video_coding, NO);
    assert_int_equal(facts.build_index, 0);
    assert_int_equal(command_buffers_labels(all, handle(1))->count, 0);
}

/* The next call adds an input for the buffer, too. */
COMMAND_BUFFERS_TEST(inputs_that_are_taken_back_are_not_recent)
{
    struct journal *journal = begin(all, 1)->journal;
    const struct chunk_place end = journal_end(journal);
    assert_true(journal_notes_buffer(journal, 7));
    assert_false(journal_notes_buffer(journal, 7));
    journal_take_back(journal, end);
    assert_true(journal_notes_buffer(journal, 7));
}

COMMAND_BUFFERS_TEST(a_secondary_leaves_behind_what_it_suspended)
{
    struct command_buffer *first = begin(all, 1), *secondary = begin(all, 3);
    command_buffer_begin_rendering(secondary, VK_RENDERING_SUSPENDING_BIT);
    command_buffer_end_rendering(secondary);
    command_buffer_execute(first, secondary);
    assert_int_equal(facts_of(all, 1).suspended, YES);
    secondary = begin(all, 3); /* one that renders nothing leaves it so */
    command_buffer_execute(first, secondary);
    assert_int_equal(facts_of(all, 1).suspended, YES);
}

COMMAND_BUFFERS_TEST(a_secondary_that_is_not_known_may_have_done_anything)
{
    struct command_buffer *first = begin(all, 1);
    command_buffer_begin_rendering(first, 0);
    command_buffer_end_rendering(first);
    command_buffer_execute(first, NULL);
    assert_int_equal(facts_of(all, 1).suspended, UNKNOWN);
    assert_true(unknown_is_set(&first->journal->unknown));
}

COMMAND_BUFFERS_TEST(an_incomplete_secondary_makes_its_primary_incomplete)
{
    struct command_buffer *first = begin(all, 1), *secondary = begin(all, 3);
    unknown_set(&secondary->journal->unknown, UNKNOWN_COMMANDS);
    command_buffer_execute(first, secondary);
    assert_true(unknown_is_set(&first->journal->unknown));
}

/* One secondary in every frame: what it remembers doesn't grow with them. */
COMMAND_BUFFERS_TEST(a_secondary_remembers_only_those_that_still_execute_it)
{
    struct command_buffer *secondary = begin(all, 3);
    for (int frame = 0; frame < 100; frame++) {
        struct command_buffer *primary = begin(all, 1);
        for (int i = 0; i < 3; i++)
            command_buffer_execute(primary, secondary);
        assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_RECORDING);
    }
    assert_true(secondary->dependents.capacity <= 8);
    command_buffer_execute(begin(all, 2), secondary);
    begin(all, 3);
    assert_int_equal(facts_of(all, 1).state, COMMAND_BUFFER_INVALID);
    assert_int_equal(facts_of(all, 2).state, COMMAND_BUFFER_INVALID);
    assert_int_equal(secondary->dependents.count, 0);
}

/* A primary refers to the journal of each secondary that it executes, until it is recorded anew. */
COMMAND_BUFFERS_TEST(a_primary_releases_the_journals_of_its_secondaries)
{
    struct command_buffer *first = begin(all, 1), *secondary = begin(all, 3);
    const atomic_uint *references = &secondary->journal->references;
    const unsigned before = atomic_load(references);
    command_buffer_execute(first, secondary);
    command_buffer_execute(first, secondary);
    assert_int_equal(atomic_load(references), before + 2);
    begin(all, 1);
    assert_int_equal(atomic_load(references), before);
}

/* Journals free the ranges of entries: this program fails if memory is left. */
COMMAND_BUFFERS_TEST(a_journal_frees_what_its_entries_hold)
{
    struct command_buffer *first = begin(all, 1);
    for (int i = 0; i < 2; i++) {
        struct journal_entry entry = {.kind = JOURNAL_RANGES, .ranges = malloc(16)};
        journal_add(first->journal, &entry);
        assert_true(first->journal->has_references);
        begin(all, 1);
        assert_false(first->journal->has_references);
    }
}

/* They outlive the queue's: this program fails if memory is left. */
TEST(submissions_have_the_labels_of_their_queue)
{
    struct queue_labels *labels;
    assert_int_equal(queue_labels_create(&labels), VK_SUCCESS);
    queue_labels_push(labels, (VkQueue)1, &(VkDebugUtilsLabelEXT){.pLabelName = "frame"});
    const struct submission_origin origin = queue_labels_submit(labels, (VkQueue)1);
    assert_int_equal(origin.number, 1);
    queue_labels_destroy(labels);
    assert_string_equal(origin.labels->stack.labels[0].pLabelName, "frame");
    shared_labels_release(origin.labels);
    queue_labels_destroy(NULL);
}

static void nothing(struct journal_walk *walk, const struct journal_entry *entry)
{
    (void)walk;
    (void)entry;
}

/* What the lists of kinds in journal.h must have follows from journal_entries.def. */
TEST(readers_of_writes_and_uses_get_all_kinds_of_them)
{
    static const struct journal_events writes = {ON_WRITES(nothing)}, uses = {ON_USES(nothing)};
    for (int kind = 0; kind < JOURNAL_KINDS; kind++) {
        const struct journal_entry entry = {.kind = (unsigned char)kind};
        assert_int_equal(writes.of_kind[kind] != NULL, journal_entry_writes(&entry));
        assert_int_equal(uses.of_kind[kind] != NULL, journal_entry_use(&entry) != NO_USE);
    }
}

TEST(each_stage_belongs_to_one_bind_point)
{
    static const VkShaderStageFlagBits rays[] = {
        VK_SHADER_STAGE_RAYGEN_BIT_KHR,       VK_SHADER_STAGE_ANY_HIT_BIT_KHR,
        VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR,  VK_SHADER_STAGE_MISS_BIT_KHR,
        VK_SHADER_STAGE_INTERSECTION_BIT_KHR, VK_SHADER_STAGE_CALLABLE_BIT_KHR};
    static const VkShaderStageFlagBits graphics[] = {VK_SHADER_STAGE_VERTEX_BIT,
                                                     VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT,
                                                     VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT,
                                                     VK_SHADER_STAGE_GEOMETRY_BIT,
                                                     VK_SHADER_STAGE_FRAGMENT_BIT,
                                                     VK_SHADER_STAGE_TASK_BIT_EXT,
                                                     VK_SHADER_STAGE_MESH_BIT_EXT};
    VkShaderStageFlags of[SHADER_POINTS] = {[SHADERS_OF_COMPUTE] = VK_SHADER_STAGE_COMPUTE_BIT};
    for (size_t i = 0; i < sizeof(rays) / sizeof(rays[0]); i++)
        of[SHADERS_OF_RAYS] |= rays[i];
    for (size_t i = 0; i < sizeof(graphics) / sizeof(graphics[0]); i++)
        of[SHADERS_OF_GRAPHICS] |= graphics[i];
    for (int point = 0; point < SHADER_POINTS; point++)
        for (uint32_t bit = 0; bit < 31; bit++)
            assert_int_equal(shader_point_has((enum shader_point)point, 1u << bit),
                             of[point] >> bit & 1);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_COMPUTE), of[SHADERS_OF_COMPUTE]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR), of[SHADERS_OF_RAYS]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_GRAPHICS), of[SHADERS_OF_GRAPHICS]);
    assert_int_equal(shader_stages_of(VK_PIPELINE_BIND_POINT_MAX_ENUM), 0);
}
