/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_calls_replay FOLDER|FILE...: runs the fuzz target without a fuzzer on each file. */
#include "../replay.h"

int main(int count, char **arguments)
{
    return replay(count - 1, arguments + 1) > 0;
}
