/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the striped lock: readers see no half-done writes, and writers are not starved. */
#include <pthread.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "src/base/reader_lock.h"
#include "tests/unit/unit_test.h"

enum { READERS = READER_LOCK_STRIPES + 3, WRITERS = 3, WRITES = 300 };

/* Equal wherever no writer is at work. */
struct guarded {
    struct reader_lock lock;
    long first, second;
    atomic_bool done;
    atomic_int torn;
    atomic_uint stripes_seen; /* a bit each */
};

static void *read_many(void *context)
{
    struct guarded *guarded = context;
    while (!atomic_load(&guarded->done)) {
        unsigned stripe = reader_lock_enter(&guarded->lock);
        if (guarded->first != guarded->second)
            atomic_fetch_add(&guarded->torn, 1);
        reader_lock_leave(&guarded->lock, stripe);
        atomic_fetch_or(&guarded->stripes_seen, 1u << stripe);
    }
    return NULL;
}

static void *write_many(void *context)
{
    struct guarded *guarded = context;
    for (int i = 0; i < WRITES; i++) {
        reader_lock_write(&guarded->lock);
        guarded->first++;
        guarded->second++;
        reader_lock_write_done(&guarded->lock);
    }
    return NULL;
}

static void read_and_write(struct guarded *guarded)
{
    pthread_t readers[READERS], writers[WRITERS];
    for (int i = 0; i < READERS; i++)
        assert_int_equal(pthread_create(&readers[i], NULL, read_many, guarded), 0);
    for (int i = 0; i < WRITERS; i++)
        assert_int_equal(pthread_create(&writers[i], NULL, write_many, guarded), 0);
    for (int i = 0; i < WRITERS; i++)
        pthread_join(writers[i], NULL);
    atomic_store(&guarded->done, true);
    for (int i = 0; i < READERS; i++)
        pthread_join(readers[i], NULL);
    assert_int_equal(guarded->first, WRITERS * WRITES);
    assert_int_equal(guarded->second, WRITERS * WRITES);
    assert_int_equal(atomic_load(&guarded->torn), 0);
}

TEST(test_writes_are_whole)
{
    static struct guarded guarded;
    read_and_write(&guarded);
}

static void *enter_once(void *context)
{
    struct guarded *guarded = context;
    unsigned stripe = reader_lock_enter(&guarded->lock);
    reader_lock_leave(&guarded->lock, stripe);
    unsigned again = reader_lock_enter(&guarded->lock);
    reader_lock_leave(&guarded->lock, again);
    atomic_fetch_add(&guarded->torn, again != stripe);
    atomic_fetch_or(&guarded->stripes_seen, 1u << stripe);
    return NULL;
}

/* A thread keeps its stripe, and the threads share all stripes out among them. */
TEST(test_threads_spread_over_the_stripes)
{
    static struct guarded guarded;
    for (int i = 0; i < READER_LOCK_STRIPES; i++) {
        pthread_t thread;
        assert_int_equal(pthread_create(&thread, NULL, enter_once, &guarded), 0);
        pthread_join(thread, NULL);
    }
    assert_int_equal(atomic_load(&guarded.stripes_seen), (1u << READER_LOCK_STRIPES) - 1);
    assert_int_equal(atomic_load(&guarded.torn), 0);
}

TEST(test_readers_do_not_share_cache_lines)
{
    static struct guarded guarded;
    for (int i = 1; i < READER_LOCK_STRIPES; i++) {
        uintptr_t end = (uintptr_t)&guarded.lock.stripes[i - 1].is_taken;
        uintptr_t begin = (uintptr_t)&guarded.lock.stripes[i].is_taken;
        assert_true(begin / 64 > end / 64);
    }
    /* Modules allocate what holds a lock with calloc, so it may ask for no more alignment. */
    assert_true(alignof(struct reader_lock) <= alignof(max_align_t));
}
