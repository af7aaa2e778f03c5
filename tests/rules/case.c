/* SPDX-License-Identifier: Apache-2.0 */
/* Reads lists of cases: each case inherits what the cases of its group share. */
#include "case.h"

#define INHERIT(member) test_case->member = test_case->member ? test_case->member : shared->member

static void inherit(struct test_case *test_case, const struct test_case *shared)
{
    INHERIT(prepare);
    INHERIT(prepare_edits);
    INHERIT(mutate);
    INHERIT(edits);
    INHERIT(mutate_twin);
    INHERIT(twin_edits);
    INHERIT(then);
    INHERIT(twin_then);
    if (!test_case->rules) {
        INHERIT(names);
        INHERIT(name_count);
    }
    INHERIT(rules);
    INHERIT(rule_count);
    INHERIT(commands);
    INHERIT(refusal);
    INHERIT(setup);
    INHERIT(twin_setup);
    INHERIT(path);
    INHERIT(count);
    INHERIT(silent);
    INHERIT(needs_null_driver);
    INHERIT(spares_drivers);
    INHERIT(may_fail_on_cpu);
    INHERIT(keep_arrays);
    INHERIT(forwards);
    INHERIT(below_content);
    INHERIT(submits);
    INHERIT(is_wild);
    INHERIT(has_pointers);
    INHERIT(is_for_the_call);
    INHERIT(is_for_contents);
}

bool case_read(const struct case_list *list, size_t row, struct test_case *test_case)
{
    *test_case = list->cases[row];
    if (test_case->name == NULL)
        return false;
    while (row > 0 && list->cases[row - 1].name != NULL)
        row--;
    if (row > 0)
        inherit(test_case, &list->cases[row - 1]);
    return true;
}

void offer_packed_format(struct null_driver_config *config)
{
    static const VkFormat formats[] = {VK_FORMAT_A2B10G10R10_SNORM_PACK32,
                                       VK_FORMAT_R64G64B64_SFLOAT, VK_FORMAT_R8G8B8A8_SNORM};
    for (size_t i = 0; i < sizeof(formats) / sizeof(formats[0]); i++)
        config->formats[config->format_count++] = (struct null_driver_format){
            formats[i], VK_FORMAT_FEATURE_2_ACCELERATION_STRUCTURE_VERTEX_BUFFER_BIT_KHR};
}
