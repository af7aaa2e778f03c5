/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that the layer keeps at level execution, beyond that at level state, for a build that
 * can't be updated: from its recording until after its submission. Exit status 1 if that is too
 * much. scripts/bench measures the time of submissions. */
#include <stdio.h>
#include <stdlib.h>

#include "scripts/tools/measure.h"
#include "tests/player/play.h"

enum { BUILDS = 10000, MOST_BYTES = 256 /* a build */ };

static struct platform platform;

static double bytes_at(const char *level)
{
    static struct play play;
    static struct program program;
    play = (struct play){.platform = &platform, .level = level};
    if (!play_begin(&play, &program))
        exit(2);
    play_text(&play, &program, "have B0 V0 S0; begin c0");
    const double before = bytes_allocated();
    play_text(&play, &program, "repeat %d build B0", BUILDS);
    play_text(&play, &program, "end; submit c0; host wait idle");
    const double after = bytes_allocated();
    messages_expect_none(&play.fixture.messages);
    play_end(&play);
    play_close(&play);
    return (after - before) / BUILDS;
}

int main(void)
{
    const char *missing = platform_open(&platform, "null");
    if (missing) {
        fprintf(stderr, "%s\n", missing);
        return 2;
    }
    const double state = bytes_at("state"), execution = bytes_at("execution");
    printf("%.1f bytes a build at level state, %.1f at level execution: at most %d more\n", state,
           execution, MOST_BYTES);
    return execution - state > MOST_BYTES;
}
