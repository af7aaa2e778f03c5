/* SPDX-License-Identifier: Apache-2.0 */
/* The hazard check keeps nothing of objects that are destroyed. */
#include "tests/player/play.h"
#include "tests/unit/unit_test.h"

#include <malloc.h>

static struct platform platform;
static struct play play;
static struct program program = {.name = "batches"};

const char *unit_test_open(const char *argument)
{
    return platform_open(&platform, argument ? argument : "null");
}

static void open_play(void)
{
    program_add(&program, "setting hazards true", 1);
    play = (struct play){.platform = &platform, .level = "execution"};
    assert_true(play_begin(&play, &program));
}

static void close_play(void)
{
    messages_expect_none(&play.fixture.messages);
    play_end(&play);
    play_close(&play);
}

/* Each batch writes memory, sets an event and signals a semaphore, all of which end with it. */
static size_t used_after(unsigned batches)
{
    for (unsigned i = 0; i < batches; i++) {
        play_text(&play, &program, "renew V1; event E1; timeline t0 0");
        play_text(&play, &program, "c0: fill V1; set1 E1 transfer");
        play_text(&play, &program, "submit1 c0 signal t0=1; host wait idle; reset c0");
    }
    return mallinfo2().uordblks;
}

/* A record of each of the three takes at least 100 bytes. */
TEST_BETWEEN(destroyed_objects_take_no_memory, open_play, close_play)
{
    const size_t before = used_after(1000);
    assert_in_range(used_after(1000), 0, before + 32 * 1024);
    assert_int_equal(play.report.outcome, OUTCOME_PASSED);
}
