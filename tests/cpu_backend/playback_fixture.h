/* SPDX-License-Identifier: Apache-2.0 */
/* Backend cpu without a device: recordings, a submission that ends when the test says so, and what
 * is written to buffers. */
#ifndef ASSAY_TESTS_CPU_BACKEND_PLAYBACK_FIXTURE_H
#define ASSAY_TESTS_CPU_BACKEND_PLAYBACK_FIXTURE_H

#include "src/cpu/playback.h"
#include "tests/fixture/objects.h"

enum { QUERIES = 4, TRIANGLES = 40, WRITES = 8, WRITTEN_MOST = 1 << 16 };

#define BUFFER ((VkBuffer)(uintptr_t)0x40)
#define BUFFER_ADDRESS 0x1000u
#define BUFFER_SIZE 0x10000u

struct submission {
    struct ticket ticket;
    VkResult end;
    uint64_t waited; /* nanoseconds of the longest wait */
};

/* The backend with a built structure, an empty one, and one that is too small for either. */
struct world {
    struct cpu_device *device;
    struct resources *resources;
    struct cpu_playback *playback;
    uint64_t built, other, tiny, pool;
    struct submission submission;
    struct write {
        VkBuffer buffer;
        uint64_t size;
        VkBufferCopy regions[QUERIES];
        uint32_t region_count;
        unsigned char bytes[WRITTEN_MOST];
    } writes[WRITES];
    uint32_t write_count;
    bool postpones_writes;
    int allocations; /* before anything was */
};

/* There is one. Closing it fails if anything of it is left. */
struct world *open_world(void);
void close_world(struct world *world);

/* A command of a journal: JOURNAL_COPY or JOURNAL_EXECUTE, or of backend cpu. */
struct command {
    enum journal_kind kind;
    uint64_t dst, src; /* JOURNAL_COPY */
    bool compacts;
    struct journal *secondary; /* JOURNAL_EXECUTE; owned */
    struct recorded_command own;
};

/* A journal of these commands. play() executes it as so many a batch of queue 1, and releases it.
 */
struct journal *record(const struct command *commands, size_t count);
void play(struct world *world, struct journal *journal, uint64_t batch);
#define PLAY(world, ...)                                                                           \
    play(world,                                                                                    \
         record((const struct command[]){__VA_ARGS__},                                             \
                ARRAY_COUNT(((const struct command[]){__VA_ARGS__}))),                             \
         1)

/* Returns the number of bytes of the structure; 0 if it is not built. */
uint64_t size_of(struct world *world, uint64_t structure);

/* The host has seen the end of so many batches of queue 1. */
void deliver(struct world *world, uint64_t seen);

#endif
