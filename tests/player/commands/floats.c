/* SPDX-License-Identifier: Apache-2.0 */
/* Applications with a floating-point environment of their own:
 *
 *     floats traps | upward | downward | toward-zero COMMAND; COMMAND...
 *
 * executes the commands up to the end of the line while floating-point exceptions are signals, or
 * with that rounding. The layer must leave the environment as it is. */
#define _GNU_SOURCE // NOLINT
#include "tests/player/play.h"

#include <fenv.h>

static const int traps = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW;

/* The exceptions that are signals: none if the processor has no such traps, as most ARM processors.
 */
static int enabled_traps(void)
{
#ifdef __GLIBC__
    return fegetexcept();
#else
    return 0;
#endif
}

static void enable_traps(const struct play *play)
{
#ifdef __GLIBC__
    feenableexcept(traps);
#endif
#if defined(__GLIBC__) && defined(__x86_64__)
    PLAY_REQUIRE(play, enabled_traps() == traps);
#endif
    (void)play;
}

void play_floats(struct play *play, char *const *words)
{
    static const struct play_word roundings[] = {
        {"upward", FE_UPWARD}, {"downward", FE_DOWNWARD}, {"toward-zero", FE_TOWARDZERO}};
    PLAY_REQUIRE(play, words[1] != NULL);
    feclearexcept(FE_ALL_EXCEPT);
    if (play_is(words[1], "traps"))
        enable_traps(play);
    else
        fesetround((int)play_words_value(play, words[1], roundings, ARRAY_COUNT(roundings)));
    const int rounding = fegetround(), enabled = enabled_traps();
    play_words(play, words + 2);
    const bool is_kept = fegetround() == rounding && enabled_traps() == enabled &&
                         (!enabled || !fetestexcept(traps));
    fesetenv(FE_DFL_ENV);
    if (is_kept)
        return;
    report_say(&play->report, "the floating-point environment has changed\n");
    play->report.outcome = OUTCOME_FAILED;
}
