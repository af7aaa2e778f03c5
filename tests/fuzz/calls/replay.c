/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_calls_replay FOLDER|FILE...: runs the fuzz target without a fuzzer on each file.
 * fuzz_calls_replay --mutated COUNT FOLDER: on files chosen and changed at random. */
#include <stdlib.h>
#include <string.h>

#include "../replay.h"

int main(int count, char **arguments)
{
    if (count == 4 && strcmp(arguments[1], "--mutated") == 0)
        return replay_mutated(arguments[3], (uint32_t)strtoul(arguments[2], NULL, 0));
    return replay(count - 1, arguments + 1) > 0;
}
