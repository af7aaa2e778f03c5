/* SPDX-License-Identifier: Apache-2.0 */
/* The hazard check: many pieces, what is dropped, and memory that runs out. random_test.c has the
 * rest. */
#include <string.h>

#include "src/hazards/hazards.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/unit/random.h"
#include "tests/unit/unit_test.h"

enum { BYTES = 4096, KINDS = 8, MEMORY = 7 };

/* What has been found since the last clear. */
static struct hazard found[KINDS * BYTES];
static uint32_t found_count;

static void note(void *user, const struct hazard *hazard)
{
    assert_true(found_count < sizeof(found) / sizeof(found[0]));
    found[found_count++] = *hazard;
}

static struct hazards *set_up(void)
{
    found_count = 0;
    return hazards_create(note, NULL);
}

#define HAZARDS_TEST(name) TEST_WITH(name, struct hazards *hazards, set_up, hazards_destroy)

/* Begins a batch of queue 1, 2 or 3, with so many batches of the first completed. */
static void begin_batch_on(struct hazards *hazards, uint32_t queue, uint64_t number,
                           uint64_t completed)
{
    const uint64_t counts[] = {0, completed, 0, 0};
    const uint64_t before[] = {0, number - 1, number - 1, number - 1};
    hazards_begin_batch(hazards, &(struct hazard_batch){.queue = queue,
                                                        .number = number,
                                                        .completed = counts,
                                                        .before = before,
                                                        .count = 4,
                                                        .is_certain = true});
}

static void begin_batch(struct hazards *hazards, uint64_t number, uint64_t completed)
{
    begin_batch_on(hazards, 1, number, completed);
}

/* One command with one access. Returns its number. */
static uint64_t access_bytes(struct hazards *hazards, enum access_kind kind, uint64_t begin,
                             uint64_t end)
{
    hazards_begin_command(hazards);
    return hazards_access(hazards, &(struct hazard_access){kind, {MEMORY, begin, end}});
}

/* A barrier that makes writes of builds to the bytes available. */
static void barrier(struct hazards *hazards, const struct hazard_bytes *bytes, stage_set dst)
{
    const struct hazard_barrier barrier = {
        .dependency = {.src = 1 << SYNC_BUILD,
                       .dst = dst,
                       .src_kinds = 1 << ACCESS_BUILD_ACCEL_WRITE},
        .bytes = *bytes};
    hazards_barriers(hazards, &barrier, 1);
}

/* ---- pieces */

/* Kinds of reads at several stages, and one of writes. */
static const enum access_kind kinds[KINDS] = {
    ACCESS_BUILD_ACCEL_WRITE, ACCESS_BUILD_ACCEL_READ,    ACCESS_BUILD_SHADER_READ,
    ACCESS_COPY_ACCEL_READ,   ACCESS_BUILD_INDIRECT_READ, ACCESS_TRANSFER_READ,
    ACCESS_MICROMAP_READ,     ACCESS_MICROMAP_SHADER_READ};

/* The last accesses of each byte, and those with which an access was reported; by kind. */
static uint64_t last[BYTES][KINDS], reported[BYTES][KINDS];

/* Fills in `reported` for the bytes of an access. */
static void collect(uint64_t begin, uint64_t end, uint64_t number)
{
    memset(reported[begin], 0, (end - begin) * sizeof(reported[0]));
    for (uint32_t i = 0; i < found_count; i++) {
        uint32_t kind = 0;
        while (kinds[kind] != found[i].earlier.kind)
            kind++;
        assert_int_equal(found[i].later.number, number);
        for (uint64_t byte = found[i].bytes.begin; byte < found[i].bytes.end; byte++) {
            assert_true(begin <= byte && byte < end && !reported[byte][kind]);
            reported[byte][kind] = found[i].earlier.number;
        }
    }
}

/* Without any order, each access is reported with the last write of each byte, and a write with the
 * reads since. */
static void access_and_compare(struct hazards *hazards, uint32_t kind, uint64_t begin, uint64_t end)
{
    found_count = 0;
    const uint64_t number = access_bytes(hazards, kinds[kind], begin, end);
    collect(begin, end, number);
    for (uint64_t byte = begin; byte < end; byte++) {
        const bool is_write = kind == 0;
        assert_memory_equal(reported[byte], last[byte],
                            is_write ? sizeof(last[byte]) : sizeof(last[byte][0]));
        if (is_write)
            memset(last[byte], 0, sizeof(last[byte]));
        last[byte][kind] = number;
    }
}

HAZARDS_TEST(every_byte_has_its_own_last_accesses)
{
    struct random random = random_of("hazards_pieces");
    memset(last, 0, sizeof(last));
    begin_batch(hazards, 1, 0);
    for (uint64_t at = 0; at + 2 <= BYTES; at += 3) /* many leaves in ascending order */
        access_and_compare(hazards, 0, at, at + 2);
    for (uint32_t i = 0; i < 6000; i++) {
        const uint64_t size = random_below(&random, 200) ? 1 + random_below(&random, 12)
                                                         : 1 + random_below(&random, BYTES - 1);
        const uint64_t begin = random_below(&random, (uint32_t)(BYTES - size + 1));
        access_and_compare(hazards, random_below(&random, KINDS), begin, begin + size);
    }
    assert_true(hazards_piece_count(hazards) <= BYTES);
    access_and_compare(hazards, 0, 0, BYTES);
    assert_int_equal(hazards_piece_count(hazards), 1);
    hazards_forget_memory(hazards, MEMORY);
    assert_int_equal(hazards_piece_count(hazards), 0);
    hazards_end_batch(hazards);
}

/* ---- what is dropped */

HAZARDS_TEST(completed_batches_are_pruned)
{
    begin_batch(hazards, 1, 0);
    for (uint64_t at = 0; at < BYTES; at += 2)
        access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, at, at + 1);
    hazards_end_batch(hazards);
    begin_batch(hazards, 2, 0);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 1, 2);
    hazards_end_batch(hazards);
    hazards_prune(hazards, (const uint64_t[]){0, 0}, 2);
    assert_int_equal(hazards_piece_count(hazards), BYTES / 2 + 1);
    for (uint64_t at = BYTES; at < 3 * BYTES; at += 2) { /* until a sweep is worth while */
        begin_batch(hazards, at, 1);
        access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, at, at + 1);
        hazards_end_batch(hazards);
    }
    hazards_prune(hazards, (const uint64_t[]){0, 1}, 2);
    assert_true(hazards_piece_count(hazards) < 2 * BYTES);
    begin_batch(hazards, 3 * BYTES, 1);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, 0, 1); /* written by batch 1 */
    assert_int_equal(found_count, 0);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, 1, 2); /* read by batch 2 */
    assert_int_equal(found_count, 1);
    assert_int_equal(found[0].type, WRITE_AFTER_READ);
}

/* A batch of queue 1 writes bytes [0, 8), and makes HAZARD_SIGNALS signals, from 2 on. Then a batch
 * of queue 2 waits, and reads. Returns how many reads were reported. */
static uint32_t read_after(uint64_t waited, stage_set src)
{
    const struct dependency signal = {.src = src},
                            wait = dependency_of_wait(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    struct hazards *hazards = set_up();
    begin_batch(hazards, 1, 0);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, 0, 8);
    hazards_signal(hazards, 1, 0, &signal);
    for (uint64_t number = 2; number < 2 + HAZARD_SIGNALS; number++)
        hazards_signal(hazards, number, 0, &signal);
    hazards_signal(hazards, 1, 0, &signal); /* too late */
    hazards_end_batch(hazards);
    begin_batch_on(hazards, 2, 1, 0);
    hazards_wait(hazards, waited, &wait);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 0, 4);
    hazards_end_batch(hazards);
    hazards_destroy(hazards);
    return found_count;
}

/* A wait for a signal that is unknown, or no longer kept, orders everything. */
TEST(unknown_signals_never_lead_to_a_finding)
{
    assert_int_equal(read_after(2, 0), 1);
    assert_int_equal(read_after(2, 1 << SYNC_BUILD), 0);
    assert_int_equal(read_after(1 + HAZARD_SIGNALS, 0), 1);
    assert_int_equal(read_after(0, 0), 0);
    assert_int_equal(read_after(1, 0), 0);
    assert_int_equal(read_after(2 + HAZARD_SIGNALS, 0), 0);
}

/* Queue 1 writes and makes signal 1, which one of queue 2 displaces. Another one of queue 2 follows
 * `previous`. Queue 3 waits for that and reads. */
static uint32_t read_behind(uint64_t previous)
{
    const struct dependency none = {.src = 0},
                            wait = dependency_of_wait(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    struct hazards *hazards = set_up();
    begin_batch(hazards, 1, 0);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, 0, 8);
    hazards_signal(hazards, 1, 0, &none);
    hazards_end_batch(hazards);
    for (uint64_t number = 1; number <= 2; number++) {
        begin_batch_on(hazards, 2, number, 0);
        hazards_signal(hazards, number + HAZARD_SIGNALS, number == 1 ? 0 : previous, &none);
        hazards_end_batch(hazards);
    }
    begin_batch_on(hazards, 3, 1, 0);
    hazards_wait(hazards, 2 + HAZARD_SIGNALS, &wait);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 0, 4);
    hazards_end_batch(hazards);
    hazards_destroy(hazards);
    return found_count;
}

/* A signal whose predecessor is no longer kept follows everything. */
TEST(lost_signals_never_lead_to_a_finding)
{
    assert_int_equal(read_behind(0), 1);
    assert_int_equal(read_behind(1), 0);
}

/* A write with more buffer barriers than are remembered counts as ordered. Each of these has three
 * stages, so none covers another one. */
HAZARDS_TEST(many_buffer_barriers_never_lead_to_a_finding)
{
    uint32_t count = 0;
    begin_batch(hazards, 1, 0);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, 0, 8);
    for (stage_set dst = 0; dst < 1u << 10; dst++) {
        if (__builtin_popcount(dst) != 3)
            continue;
        barrier(hazards, &(struct hazard_bytes){MEMORY, 0, 4}, dst << SYNC_ACCESS_STAGES);
        if (++count == 60)
            access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 0, 4);
    }
    assert_int_equal(found_count, 1);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 0, 4);
    assert_int_equal(found_count, 1);
    access_bytes(hazards, ACCESS_BUILD_ACCEL_READ, 4, 8);
    assert_int_equal(found_count, 2);
}

/* ---- memory that runs out */

static void play_barriers(struct hazards *hazards, const struct dependency *signal)
{
    static const struct hazard_bytes bytes = {MEMORY, 30, 200};
    barrier(hazards, &bytes, 1 << SYNC_COPY);
    hazards_set_event(hazards, 5, signal->src);
    for (uint32_t kind = 0; kind < KINDS; kind++)
        access_bytes(hazards, kinds[kind], 31, 50 + kind);
    hazards_wait_event(hazards, 5, NULL, 0);
}

/* The first batch has no barriers, but a signal all the same. */
static void play(void)
{
    const struct dependency signal = dependency_of_signal(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT),
                            wait = dependency_of_wait(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
    struct hazards *hazards = set_up();
    if (!hazards)
        return;
    for (uint64_t batch = 1; batch < 4; batch++) {
        begin_batch_on(hazards, batch == 2 ? 2 : 1, batch, batch == 3);
        if (batch > 1)
            hazards_wait(hazards, batch - 1, &wait);
        for (uint64_t at = 0; at < 300; at += 3)
            access_bytes(hazards, ACCESS_BUILD_ACCEL_WRITE, at, at + 2);
        if (batch > 1)
            play_barriers(hazards, &signal);
        hazards_signal(hazards, batch, batch - 1, &signal);
        hazards_end_batch(hazards);
    }
    hazards_destroy(hazards);
}

/* What is found without memory is found with it, too; and the last access, with memory again. */
TEST(nothing_wrong_is_found_if_memory_runs_out)
{
    play();
    static struct hazard all[sizeof(found) / sizeof(found[0])];
    const uint32_t count = found_count;
    memcpy(all, found, sizeof(all));
    assert_true(count > 10);
    for (int allocation = 0; memory_is_scarce(allocation); allocation++) {
        play();
        const int before = memory_pause();
        for (uint32_t i = 0; i < found_count; i++) {
            bool is_found = false;
            for (uint32_t j = 0; j < count && !is_found; j++)
                is_found = found[i].earlier.number == all[j].earlier.number &&
                           found[i].later.number == all[j].later.number;
            assert_true(is_found);
        }
        memory_resume(before);
    }
    memory_fail_no_more();
    memory_fail_from(0);
    play();
    memory_fail_no_more();
    assert_int_equal(found_count, 0);
}

/* The index only makes searches faster. If memory runs out, it does not grow. */
HAZARDS_TEST(pieces_are_found_without_memory_for_an_index)
{
    struct random random = random_of("hazards_index");
    memset(last, 0, sizeof(last));
    begin_batch(hazards, 1, 0);
    for (uint64_t at = 0; at + 2 <= BYTES; at += 3)
        access_and_compare(hazards, 0, at, at + 2);
    for (uint32_t i = 0; i < 1000; i++) { /* searches make an index */
        const uint64_t at = random_below(&random, BYTES / 3) * 3;
        access_and_compare(hazards, 0, at, at + 2);
    }
    for (uint64_t at = 0; at < BYTES; at++)
        access_and_compare(hazards, 0, at, at + 1);
    memory_fail_from(0);
    for (uint32_t i = 0; i < 5000; i++) {
        const uint64_t at = random_below(&random, BYTES);
        access_and_compare(hazards, 0, at, at + 1);
    }
    assert_true(memory_fail_no_more());
    assert_int_equal(hazards_piece_count(hazards), BYTES);
    hazards_end_batch(hazards);
    hazards_prune(hazards, (const uint64_t[]){0, 1}, 2);
    assert_int_equal(hazards_piece_count(hazards), 0);
}

/* ---- writes of unknown bytes */

static uint64_t write_anywhere(struct hazards *hazards, const struct hazard_bytes *bytes)
{
    hazards_begin_command(hazards);
    return hazards_write_anywhere(hazards, ACCESS_COMPUTE_WRITE, bytes);
}

/* A barrier from writes of compute shaders, of no bytes, to the inputs of builds. */
static void barrier_to_build(struct hazards *hazards)
{
    const struct hazard_barrier barrier = {
        .dependency = {.src = 1 << SYNC_COMPUTE_SHADER,
                       .dst = 1 << SYNC_BUILD,
                       .src_kinds = 1 << ACCESS_COMPUTE_WRITE,
                       .dst_kinds = 1 << ACCESS_BUILD_SHADER_READ}};
    hazards_barriers(hazards, &barrier, 1);
}

static uint64_t first_open(struct hazards *hazards)
{
    return hazards_first_open_write(hazards, ACCESS_BUILD_SHADER_READ);
}

/* Returns the number of the write that is found, or 0. */
static uint64_t missed(struct hazards *hazards, uint64_t first)
{
    struct hazard hazard;
    const struct hazard_access read = {ACCESS_BUILD_SHADER_READ, {MEMORY, 0, 1}};
    hazards_begin_command(hazards);
    hazards_access(hazards, &read);
    const struct hazard_side since = {.queue = hazards_last_access(hazards).queue,
                                      .number = first - 1};
    if (!hazards_read_misses_writes(hazards, first, &since, &read, &hazard))
        return 0;
    assert_int_equal(hazard.type, READ_AFTER_SHADER);
    return hazard.earlier.number;
}

/* One more write is all that a read misses whose data were read before at `behind`. If they were
 * read at `start`, another write is visible. Ends the batch. */
static void expect_misses_only(struct hazards *hazards, uint64_t start, uint64_t behind)
{
    const uint64_t hidden = write_anywhere(hazards, NULL);
    assert_int_equal(missed(hazards, start), 0);
    assert_int_equal(missed(hazards, behind), hidden);
    hazards_end_batch(hazards);
}

HAZARDS_TEST(a_barrier_of_any_bytes_shows_writes_anywhere)
{
    begin_batch(hazards, 1, 0);
    const uint64_t start = first_open(hazards);
    const uint64_t shown = write_anywhere(hazards, NULL);
    assert_int_equal(first_open(hazards), shown);
    barrier_to_build(hazards);
    const uint64_t behind = first_open(hazards);
    assert_true(behind > shown);
    expect_misses_only(hazards, start, behind);
}

/* missed() reads byte 0 of MEMORY. */
HAZARDS_TEST(writes_of_known_bytes_are_missed_by_reads_of_these_alone)
{
    const struct hazard_bytes others[] = {{MEMORY, 1, 4}, {MEMORY + 1, 0, 4}};
    begin_batch(hazards, 1, 0);
    const uint64_t start = first_open(hazards);
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); i++)
        write_anywhere(hazards, &others[i]);
    assert_int_equal(missed(hazards, start), 0);
    const uint64_t hidden = write_anywhere(hazards, &(struct hazard_bytes){MEMORY, 0, 4});
    assert_int_equal(missed(hazards, start), hidden);
    hazards_end_batch(hazards);
}

/* A write of a batch that has completed may have happened before the read or after it: before a
 * read that comes later, it has. */
HAZARDS_TEST(writes_anywhere_of_completed_batches_are_visible)
{
    begin_batch(hazards, 1, 0);
    const uint64_t start = first_open(hazards);
    write_anywhere(hazards, NULL);
    hazards_end_batch(hazards);
    hazards_prune(hazards, (const uint64_t[]){0, 1}, 2);
    begin_batch(hazards, 2, 1);
    const uint64_t behind = first_open(hazards);
    expect_misses_only(hazards, start, behind);
}

/* The engine keeps the last writes. It does not know whether those before them happened before a
 * read or after it. */
HAZARDS_TEST(writes_anywhere_that_are_lost_stay_open_until_they_are_complete)
{
    enum { MANY = 5000 };
    begin_batch(hazards, 1, 0);
    const uint64_t start = first_open(hazards);
    for (uint32_t i = 0; i < MANY; i++)
        write_anywhere(hazards, NULL);
    assert_int_equal(missed(hazards, start), 0);
    barrier_to_build(hazards);
    const uint64_t open = first_open(hazards);
    write_anywhere(hazards, NULL);
    assert_int_equal(missed(hazards, open), 0);
    hazards_end_batch(hazards);
    hazards_prune(hazards, (const uint64_t[]){0, 1}, 2);
    begin_batch(hazards, 2, 1);
    const uint64_t behind = first_open(hazards);
    const uint64_t hidden = write_anywhere(hazards, NULL);
    assert_int_equal(missed(hazards, behind), hidden);
    hazards_end_batch(hazards);
}
