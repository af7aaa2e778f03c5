/* SPDX-License-Identifier: Apache-2.0 */
/* The variants, and which cases they are for. */
#include "tests/rules/submitted/variant.h"

#include <string.h>

#define VARIANT(name_, ...)                                                                        \
    {                                                                                              \
        .name = (name_), __VA_ARGS__                                                               \
    }
const struct variant variants[] = {
    VARIANT("visible", .inputs = INPUTS_VISIBLE, .waiting = WAIT_DEVICE),
    VARIANT("visible+ppGeometries", .inputs = INPUTS_VISIBLE, .waiting = WAIT_QUEUE,
            .geometry_pointers = true),
    VARIANT("uploaded", .inputs = INPUTS_UPLOADED, .waiting = WAIT_FENCE),
    VARIANT("copied", .inputs = INPUTS_COPIED, .waiting = WAIT_FENCE_STATUS),
    VARIANT("copied_and_waited_for_by_timeline", .inputs = INPUTS_COPIED, .waiting = WAIT_TIMELINE),
    VARIANT("inline", .inputs = INPUTS_INLINE, .waiting = WAIT_QUEUE),
    VARIANT("made_worse", .inputs = INPUTS_VISIBLE, .change = CHANGE_FOR_THE_WORSE,
            .waiting = WAIT_FENCE),
    VARIANT("made_better", .inputs = INPUTS_VISIBLE, .change = CHANGE_FOR_THE_BETTER,
            .waiting = WAIT_FENCE),
    VARIANT("copied_and_made_worse", .inputs = INPUTS_COPIED, .change = CHANGE_FOR_THE_WORSE,
            .waiting = WAIT_DEVICE),
    VARIANT("resubmitted", .inputs = INPUTS_VISIBLE, .change = CHANGE_AND_RESUBMIT,
            .waiting = WAIT_QUEUE),
    VARIANT("secondary", .inputs = INPUTS_COPIED, .waiting = WAIT_FENCE_STATUS,
            .in_secondary = true),
    VARIANT("secondary_resubmitted", .inputs = INPUTS_COPIED, .change = CHANGE_AND_RESUBMIT,
            .waiting = WAIT_FENCE, .in_secondary = true),
    VARIANT("two_queues", .inputs = INPUTS_INLINE, .waiting = WAIT_DEVICE, .uses_two_queues = true),
    VARIANT("uploaded_by_another_queue", .inputs = INPUTS_UPLOADED, .waiting = WAIT_FENCE,
            .uses_two_queues = true),
    VARIANT("pointers", .inputs = INPUTS_VISIBLE, .waiting = WAIT_FENCE, .instance_pointers = true),
    VARIANT("copied_pointers", .inputs = INPUTS_COPIED, .waiting = WAIT_QUEUE,
            .instance_pointers = true),
    VARIANT("indirect", .command = COMMAND_INDIRECT, .inputs = INPUTS_VISIBLE,
            .waiting = WAIT_FENCE),
    VARIANT("indirect_copied", .command = COMMAND_INDIRECT, .inputs = INPUTS_COPIED,
            .waiting = WAIT_DEVICE),
    VARIANT("indirect_resubmitted", .command = COMMAND_INDIRECT, .inputs = INPUTS_VISIBLE,
            .change = CHANGE_AND_RESUBMIT, .waiting = WAIT_QUEUE),
    VARIANT("nv", .command = COMMAND_NV, .inputs = INPUTS_VISIBLE, .waiting = WAIT_FENCE),
    VARIANT("nv_copied", .command = COMMAND_NV, .inputs = INPUTS_COPIED, .waiting = WAIT_DEVICE),
    VARIANT("nv_resubmitted", .command = COMMAND_NV, .inputs = INPUTS_VISIBLE,
            .change = CHANGE_AND_RESUBMIT, .waiting = WAIT_QUEUE),
};
const uint32_t variant_count = sizeof(variants) / sizeof(variants[0]);

/* Cases that are for the host alone are for command buffers here. */
static uint32_t commands_for(enum build_command command)
{
    switch (command) {
    case COMMAND_NV:
        return ON_NV;
    case COMMAND_INDIRECT:
        return ON_HOST | ON_INDIRECT;
    default:
        return ON_HOST | ON_DEVICE;
    }
}

/* Those with motion have other pointers. */
static bool has_plain_instances(const struct test_case *test_case)
{
    return strstr(test_case->name, "instance") != NULL && strstr(test_case->name, "motion") == NULL;
}

static bool is_for_command(const struct test_case *test_case, enum build_command command)
{
    return (test_case->commands & commands_for(command)) != 0 ||
           (test_case->refusal != NULL && test_case->refusal->command == command);
}

/* Guarded builds do not read such references. A structure without memory has no address, so nothing
 * is known of references to it. */
static bool refers_to_nothing(const struct test_case *test_case)
{
    return strstr(test_case->name, "instance_") != NULL &&
           strcmp(test_case->name, "instance_of_unbound_blas") != 0;
}

/* The guard warns of what no rule is about: references of moving instances, unbuilt
 * structures in external memory, and pointers to no memory. */
static bool guard_warns_of(const struct test_case *test_case)
{
    static const char *const names[] = {"pointer_to_instance_misaligned",
                                        "null_pointer_to_instance",
                                        "pointer_to_no_buffer",
                                        "pointers_to_nowhere",
                                        "flat_motion_instance",
                                        "flat_packed_motion_instance",
                                        "motion_instance_without_memory",
                                        "instance_in_external_memory",
                                        "null_pointer_to_motion_instance",
                                        "motion_pointer_to_no_buffer"};
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        if (strcmp(test_case->name, names[i]) == 0)
            return true;
    return false;
}

bool variant_fits(const struct variant *variant, const struct platform *platform,
                  const struct test_case *test_case)
{
    const bool changes = variant->change != CHANGE_NOTHING;
    if (variant->uses_two_queues && !platform->is_null)
        return false;
    if (!is_for_command(test_case, variant->command) ||
        (variant->instance_pointers && !has_plain_instances(test_case)))
        return false;
    if (changes && (test_case->silent || test_case->has_parameters))
        return false; /* parameters are what is bad, or nothing is */
    for (uint32_t i = 0; i < test_case->rule_count; i++)
        if (rule_id(test_case->rules[i], variant->command) == NULL)
            return false;
    if (platform->is_guarded && guard_warns_of(test_case))
        return false;
    return !test_case->is_wild || platform->is_null || platform->is_cpu ||
           (platform->is_guarded && refers_to_nothing(test_case));
}
