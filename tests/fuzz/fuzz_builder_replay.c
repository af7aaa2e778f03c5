/* SPDX-License-Identifier: Apache-2.0 */
/* fuzz_builder_replay [[--digest NUMBER] FOLDER|FILE...]: runs the fuzz target without a fuzzer on
 * each file, or, with none, on structures and geometries of its own with bytes changed at random, a
 * number of rounds. With --digest, it fails if anything else is built, traced or decoded than when
 * that number was printed. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "tests/builder/fixture.h"
#include "tests/unit/random.h"

#define ROUNDS 20000
#define INPUT_MAX 4096

static uint8_t input[INPUT_MAX];

/* A serialized structure of a small mesh, after the two bytes that say so. */
static size_t make_bytes(uint64_t *random)
{
    static const struct builder_uuids uuids = {{'a'}, {'b'}};
    struct fixture_mesh mesh = fixture_soup(1 + (uint32_t)(fixture_random(random) % 24), *random);
    struct fixture_input fixture;
    fixture_input_mesh(&fixture, &mesh);
    fixture.input.quality = (enum builder_quality)(fixture_random(random) % 3);
    void *structure = fixture_build(&fixture.input, NULL);
    uint64_t size = builder_serialized_size(structure);
    memset(input, 0, 2);
    builder_serialize(structure, &uuids, input + 2, size);
    free(structure);
    fixture_mesh_free(&mesh);
    return 2 + size;
}

static size_t make_noise(uint64_t *random)
{
    size_t size = fixture_random(random) % INPUT_MAX;
    for (size_t i = 0; i < size; i++)
        input[i] = fixture_random(random) % 4 == 0 ? (uint8_t)fixture_random(random) : 0;
    input[0] = 1;
    input[1] = 0;
    return size < 2 ? 2 : size;
}

int main(int count, char **arguments)
{
    if (count > 1) {
        const bool is_compared = count > 3 && strcmp(arguments[1], "--digest") == 0;
        const int first = is_compared ? 3 : 1;
        if (replay(count - first, arguments + first) > 0)
            return 1;
        printf("digest 0x%" PRIx64 "\n", fuzz_digest);
        return is_compared && fuzz_digest != strtoull(arguments[2], NULL, 0);
    }
    uint64_t random = random_seed(88172645463325252u);
    random += !random; /* the generator stays at 0 */
    printf("ASSAY_TEST_SEED=%" PRIu64 "\n", random);
    for (int round = 0; round < ROUNDS; round++) {
        size_t size = round % 2 ? make_noise(&random) : make_bytes(&random);
        for (uint64_t changes = fixture_random(&random) % 4; round % 2 == 0 && changes > 0;
             changes--)
            input[2 + fixture_random(&random) % (size - 2)] ^=
                (uint8_t)(1 << fixture_random(&random) % 8);
        LLVMFuzzerTestOneInput(input, size);
    }
    return 0;
}
