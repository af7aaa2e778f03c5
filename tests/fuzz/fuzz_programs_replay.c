/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_programs_replay FOLDER|FILE...: runs the fuzz target without a fuzzer on each file.
 * fuzz_programs_replay --random COUNT: on random bytes.
 * With ASSAY_FUZZ_PRINT in the environment each program is printed. */
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

int main(int count, char **arguments)
{
    static const int signals[] = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL};
    for (size_t i = 0; i < sizeof(signals) / sizeof(signals[0]); i++)
        signal(signals[i], fuzz_programs_crash);
    if (count == 3 && strcmp(arguments[1], "--random") == 0)
        return replay_random((uint32_t)strtoul(arguments[2], NULL, 0));
    return replay(count - 1, arguments + 1) > 0;
}
