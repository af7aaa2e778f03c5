/* SPDX-License-Identifier: Apache-2.0 */
/* What instances refer to:
 *
 *     init PLACE stranger         the reference of a structure that another device had
 *     reads [PLACE | NUMBER]...   the references that builds of top-level structures have read
 *                                 since the last such line, as places of structures or addresses;
 *                                 only the null driver tells */
#include "tests/player/play.h"

#include <inttypes.h>
#include <stdlib.h>

enum { READ_MAX = 64, STRANGERS = 5 };

void play_note_references(struct play *play)
{
    uint64_t none[1];
    if (!play->platform->is_null || !program_find(play->program, "reads", NULL))
        return;
    play->platform->null_driver.set_reads_instances(true);
    play->platform->null_driver.take_references(none, 0);
}

/* Another device creates some structures. The last one has an address that no structure of the
 * program's device has. */
uint64_t play_stranger(struct play *play)
{
    struct play *other = calloc(1, sizeof(*other));
    uint64_t reference = 0;
    PLAY_REQUIRE(play, other != NULL);
    other->platform = play->platform;
    other->program = play->program;
    PLAY_REQUIRE(play, !play_open_device(other));
    play_create_objects(other);
    for (int i = 0; i < STRANGERS; i++) {
        const char name[] = {'B', (char)('0' + i), '\0'};
        reference =
            structure_address(&other->vk, other->device, play_object(other, name)->structure);
    }
    play_destroy_objects(other);
    play_close(other);
    free(other);
    return reference;
}

static void expect_references(struct play *play, char **words)
{
    uint64_t read[READ_MAX], wanted;
    uint32_t at = 0;
    bool is_good = true;
    if (!play->platform->is_null || play->is_scarce)
        return;
    const uint32_t count = play->platform->null_driver.take_references(read, READ_MAX);
    for (; *words; words++, at++) {
        wanted = **words >= '0' && **words <= '9' ? play_number(play, *words)
                 : **words == 'B' ? play_reference_to(play, play_object(play, *words))
                                  : play_address(play, *words);
        is_good = is_good && at < count && read[at] == wanted;
    }
    if (is_good && at == count)
        return;
    for (uint32_t i = 0; i < count; i++)
        report_say(&play->report, "a build read %#" PRIx64 "\n", read[i]);
    play->report.outcome = OUTCOME_FAILED;
}

bool play_reference(struct play *play, char **words)
{
    if (!play_is(words[0], "reads"))
        return false;
    expect_references(play, words + 1);
    return true;
}
