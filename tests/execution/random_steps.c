/* SPDX-License-Identifier: Apache-2.0 */
/* Dice, steps, and the comparison with the model. */
#include "random_test.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint32_t below(struct random_test *test, uint32_t bound)
{
    return (uint32_t)(random_next(&test->random) >> 32) % bound;
}

bool chance(struct random_test *test, uint32_t percent)
{
    return below(test, 100) < percent;
}

/* ---- one step, and what came of it */

static void print_program(const struct random_test *test)
{
    for (uint32_t i = 0; i < test->step_count; i++) {
        const struct step *step = &test->steps[i];
        printf("    %3u: action %d object %d dst %d src %d value %" PRIu64 "\n", i, step->action,
               step->object, step->dst, step->src, step->value);
    }
}

/* Several commands may have one id. */
static uint32_t count_of_rule(const struct messages *messages, enum rule rule)
{
    const uint16_t *ids = rule_infos[rule].vuid;
    uint32_t found = 0;
    for (enum build_command i = 0; i < COMMAND_COUNT; i++) {
        enum build_command first = 0;
        while (ids[first] != ids[i])
            first++;
        if (ids[i] != VUID_NONE && first == i)
            found += messages_count(messages, vuid_texts[ids[i]].id, NULL);
    }
    return found;
}

static void compare(struct random_test *test)
{
    const struct messages *messages = &test->fixture.messages;
    uint32_t expected = 0;
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        if (test->model.findings[rule] == 0)
            continue;
        const uint32_t found = count_of_rule(messages, rule);
        expected += test->model.findings[rule];
        if (found != test->model.findings[rule]) {
            printf("%s: %u instead of %u\n", rule_infos[rule].name, found,
                   test->model.findings[rule]);
            test->failed = true;
        }
    }
    if (expected != messages->count) {
        printf("%u messages instead of %u\n", messages->count, expected);
        test->failed = true;
    }
    test->findings += expected;
    for (uint32_t i = 0; test->failed && i < messages_kept(messages); i++)
        printf("    got %s\n        %.300s\n", messages->items[i].id, messages->items[i].text);
}

void take_step(struct random_test *test, struct step step)
{
    if (test->step_count == STEPS_MAX)
        abort();
    test->steps[test->step_count++] = step;
    machine_step(&test->machine, &step);
}

void settle(struct random_test *test)
{
    if (test->failed)
        return;
    compare(test);
    if (test->failed)
        print_program(test);
    messages_clear(&test->fixture.messages);
    memset(test->model.findings, 0, sizeof(test->model.findings));
}

struct shape random_shape(struct random_test *test)
{
    struct shape shape = shape_plain();
    if (chance(test, 55))
        return shape;
    const struct difference *difference = &differences[below(test, DIFFERENCES)];
    shape = chance(test, 50) ? difference->built : difference->asked;
    if (chance(test, 20))
        shape.max_vertex++;
    if (chance(test, 20) && shape.type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
        shape.geometry_count = 1 + below(test, SHAPE_GEOMETRIES);
    if (chance(test, 20))
        shape.flags &= ~(VkFlags)VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
    return shape;
}

bool has_findings(const struct model *model)
{
    for (enum rule rule = 0; rule < RULE_COUNT; rule++)
        if (model->findings[rule] != 0)
            return true;
    return false;
}
