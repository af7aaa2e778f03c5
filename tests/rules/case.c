/* SPDX-License-Identifier: Apache-2.0 */
/* Reads lists of cases: each case inherits what the cases of its group share. */
#include "case.h"

static void inherit_mutations(struct test_case *test_case, const struct test_case *shared)
{
    if (test_case->prepare == NULL)
        test_case->prepare = shared->prepare;
    if (test_case->prepare_edits == NULL)
        test_case->prepare_edits = shared->prepare_edits;
    if (test_case->mutate == NULL)
        test_case->mutate = shared->mutate;
    if (test_case->edits == NULL)
        test_case->edits = shared->edits;
    if (test_case->mutate_twin == NULL)
        test_case->mutate_twin = shared->mutate_twin;
    if (test_case->twin_edits == NULL)
        test_case->twin_edits = shared->twin_edits;
    if (test_case->then == NULL)
        test_case->then = shared->then;
    if (test_case->twin_then == NULL)
        test_case->twin_then = shared->twin_then;
}

static void inherit_values(struct test_case *test_case, const struct test_case *shared)
{
    if (test_case->rules == NULL) {
        test_case->rules = shared->rules;
        test_case->rule_count = shared->rule_count;
    }
    if (test_case->commands == 0)
        test_case->commands = shared->commands;
    if (test_case->refusal == NULL)
        test_case->refusal = shared->refusal;
    if (test_case->setup == NULL)
        test_case->setup = shared->setup;
    if (test_case->twin_setup == NULL)
        test_case->twin_setup = shared->twin_setup;
    if (test_case->path == NULL)
        test_case->path = shared->path;
    if (test_case->count == 0)
        test_case->count = shared->count;
}

static void inherit_flags(struct test_case *test_case, const struct test_case *shared)
{
    test_case->silent |= shared->silent;
    test_case->needs_null_driver |= shared->needs_null_driver;
    test_case->spares_drivers |= shared->spares_drivers;
    test_case->may_fail_on_cpu |= shared->may_fail_on_cpu;
    test_case->keep_arrays |= shared->keep_arrays;
    test_case->forwards |= shared->forwards;
    test_case->below_content |= shared->below_content;
    test_case->submits |= shared->submits;
    test_case->is_wild |= shared->is_wild;
    test_case->has_pointers |= shared->has_pointers;
    test_case->is_for_the_call |= shared->is_for_the_call;
    test_case->is_for_contents |= shared->is_for_contents;
}

bool case_read(const struct case_list *list, size_t row, struct test_case *test_case)
{
    *test_case = list->cases[row];
    if (test_case->name == NULL)
        return false;
    while (row > 0 && list->cases[row - 1].name != NULL)
        row--;
    if (row > 0) {
        const struct test_case *shared = &list->cases[row - 1];
        inherit_mutations(test_case, shared);
        inherit_values(test_case, shared);
        inherit_flags(test_case, shared);
    }
    return true;
}
