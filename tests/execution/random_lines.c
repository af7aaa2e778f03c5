/* SPDX-License-Identifier: Apache-2.0 */
/* Dice, and the lines of random programs. */
#include "random_test.h"

#include <stdarg.h>
#include <stdio.h>

uint32_t below(struct random_test *test, uint32_t bound)
{
    return (uint32_t)(random_next(&test->random) >> 32) % bound;
}

const char *queue_name(const struct random_test *test, uint32_t queue)
{
    return test->queue ? test->queue : queue ? "q2" : "q0";
}

bool chance(struct random_test *test, uint32_t percent)
{
    return below(test, 100) < percent;
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

void add_line(struct random_test *test, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    program_add(&test->program, text, test->program.line_count + 1);
}

bool play_lines(struct random_test *test)
{
    struct play *play = &test->play;
    struct program *program = &test->program;
    for (; test->played < program->line_count && play->report.outcome == OUTCOME_PASSED;
         test->played++) {
        play_line(play, test->played);
        if (play->result != VK_SUCCESS && !program->lines[test->played].result)
            program_note_result(program, test->played, play_name_of(play->result));
    }
    return play->result == VK_SUCCESS;
}

void expect_findings(struct random_test *test, bool skips)
{
    struct model *model = &test->now.model;
    struct program *program = &test->program;
    for (uint32_t i = 0; i < model->finding_count; i++) {
        PLAY_REQUIRE(&test->play, program->expected_count < PROGRAM_EXPECTATIONS);
        program->expected[program->expected_count++] =
            (struct expectation){.id = rule_infos[model->findings[i].rule].name,
                                 .text = model->findings[i].command,
                                 .line = (int)program->line_count - 1,
                                 .is_plain = !skips};
    }
    test->findings += model->finding_count;
    model->finding_count = 0;
}

void expect_mistake(struct random_test *test, enum rule rule)
{
    struct model *model = &test->now.model;
    model->findings[0].rule = rule;
    model->findings[0].command = "vkCmdBuildAccelerationStructuresKHR()";
    model->finding_count = 1;
    expect_findings(test, false);
}
