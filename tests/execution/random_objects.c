/* SPDX-License-Identifier: Apache-2.0 */
/* Objects of random programs, which are created again. In faulty programs that may fail. */
#include "random_test.h"

#include <stdio.h>

void create_all(struct random_test *test)
{
    add_line(test, "have V0 I0 I1 X0 A0 N0 R1 R2 D0 G0 S0 d1 d2 s0 s1 s2 s3");
    if (test->play.platform->is_cpu)
        add_line(test, "host build B0; host serialize B0 > D0");
    for (uint32_t i = 0; i <= COMMAND_BUFFERS; i++)
        add_line(test, "begin c%u%s for %s; end", i,
                 i >= SECONDARIES && i < COMMAND_BUFFERS ? " secondary" : "",
                 queue_name(test, i >= OTHER_QUEUE && i < SECONDARIES));
}

/* A build of a structure whose buffer has no memory. */
static void build_unbacked(struct random_test *test, uint32_t structure)
{
    add_line(test, "begin c%u for %s", COMMAND_BUFFERS, queue_name(test, 0));
    if (!play_lines(test))
        return;
    add_line(test, "build B%u", structure);
    expect_mistake(test, RULE_dst_is_backed_by_memory);
    add_line(test, "end");
    play_lines(test);
}

/* Creates an object again; the old one is destroyed even if that fails. */
static void create_again(struct random_test *test, const char *command, const char *name)
{
    add_line(test, "%s %s", command, name);
    if (play_lines(test))
        return;
    add_line(test, "%s %s", command, name);
    test->is_over = !play_lines(test);
}

/* The buffer of a structure and its memory. If only the binding failed, the structure can be
 * created all the same. */
static void renew_backing(struct random_test *test, uint32_t structure, const char *name)
{
    if (chance(test, 50)) {
        add_line(test, "%s %s", chance(test, 50) ? "free" : "destroy buffer", name);
        build_unbacked(test, structure);
    }
    add_line(test, "renew %s", name);
    if (play_lines(test))
        return;
    if (play_object(&test->play, name)->buffer.handle) {
        add_line(test, "create %s", name);
        if (play_lines(test))
            build_unbacked(test, structure);
    }
    create_again(test, "renew", name);
}

void recreate(struct random_test *test, uint32_t structure)
{
    char name[8];
    snprintf(name, sizeof(name), "B%u", structure);
    if (test->is_faulty && chance(test, 50))
        renew_backing(test, structure, name);
    if (!test->is_over)
        create_again(test, "create", name);
    model_create(&test->now.model, structure);
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        if (test->uses[cb][structure])
            forget_recording(test, cb);
}

/* Any command buffer may use it. */
void renew_scratch(struct random_test *test)
{
    if (chance(test, 50))
        add_line(test, "free S0");
    create_again(test, "renew", "S0");
    for (uint32_t cb = 0; cb < COMMAND_BUFFERS; cb++)
        forget_recording(test, cb);
}
