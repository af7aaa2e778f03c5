/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of the sweep over a call's structures and ranges, against all pairs taken one by one. */
#include <inttypes.h>
#include <string.h>

#include "random.h"
#include "src/check/overlap/sweep.h"
#include "tests/fixture/scarce_memory.h"
#include "tests/state/steps.h"
#include "tests/state/sweep_fixture.h"
#include "tests/state/unit_test.h"

enum { RANGES = 120 };

/* The ranges of a call, and how often each pair of them was visited. */
struct call {
    struct used_range ranges[RANGES];
    uint32_t count;
    uint8_t visits[RANGES][RANGES]; /* [a][b] */
    uint32_t visit_count;
    bool by_memory;                            /* else by handle */
    int wanted_visits[ROLE_COUNT][ROLE_COUNT]; /* how many pairs of two roles are wanted; -1: all */
};

static bool same_range(const struct used_range *a, const struct used_range *b)
{
    return a->role == b->role && a->build == b->build && a->handle == b->handle &&
           a->span.memory == b->span.memory && a->span.begin == b->span.begin &&
           a->span.end == b->span.end;
}

static uint32_t index_of(const struct call *call, const struct used_range *range)
{
    for (uint32_t i = 0; i < call->count; i++)
        if (same_range(&call->ranges[i], range))
            return i;
    fail_msg("a range that was not added was visited");
    return 0;
}

/* ---- what is to be found */

static bool is_ordered(const struct used_range *a, const struct used_range *b)
{
    return a->role != b->role ? a->role < b->role : a->build < b->build;
}

static bool has_equal_handle(const struct used_range *a, const struct used_range *b)
{
    return a->role == ROLE_DST && b->role != ROLE_SCRATCH && a->build != b->build && a->handle &&
           a->handle == b->handle;
}

/* Two src are never written, and a build is not its own neighbour. */
static bool shares_memory(const struct used_range *a, const struct used_range *b)
{
    if ((a->role == ROLE_SRC && b->role == ROLE_SRC) ||
        (a->role == b->role && a->build == b->build) || (a->handle && a->handle == b->handle))
        return false;
    return a->span.memory && a->span.memory == b->span.memory && a->span.begin < a->span.end &&
           b->span.begin < b->span.end && a->span.begin < b->span.end &&
           b->span.begin < a->span.end;
}

static bool is_expected(const struct call *call, uint32_t a, uint32_t b)
{
    const struct used_range *x = &call->ranges[a], *y = &call->ranges[b];
    return is_ordered(x, y) && (call->by_memory ? shares_memory(x, y) : has_equal_handle(x, y));
}

static void assert_shared(const struct used_range *a, const struct used_range *b,
                          const struct memory_span *shared)
{
    VkDeviceSize begin = a->span.begin > b->span.begin ? a->span.begin : b->span.begin;
    VkDeviceSize end = a->span.end < b->span.end ? a->span.end : b->span.end;
    assert_ptr_equal(shared->memory, a->span.memory);
    assert_int_equal(shared->begin, begin);
    assert_int_equal(shared->end, end);
}

static bool visit(void *user, const struct used_range *a, const struct used_range *b,
                  const struct memory_span *shared)
{
    struct call *call = user;
    uint32_t i = index_of(call, a), j = index_of(call, b);
    int *wanted = &call->wanted_visits[a->role][b->role];
    assert_true(is_expected(call, i, j));
    assert_int_not_equal(*wanted, 0);
    assert_int_equal(shared != NULL, call->by_memory);
    if (shared)
        assert_shared(a, b, shared);
    call->visits[i][j]++;
    call->visit_count++;
    *wanted -= *wanted > 0;
    return *wanted != 0;
}

static void assert_all_were_visited(const struct call *call)
{
    for (uint32_t i = 0; i < call->count; i++)
        for (uint32_t j = 0; j < call->count; j++)
            assert_int_equal(call->visits[i][j], is_expected(call, i, j));
}

/* ---- sweeping */

static void want_all(struct call *call)
{
    memset(call->wanted_visits, -1, sizeof(call->wanted_visits));
}

static void sweep_call(struct call *call, struct sweep *sweep, bool by_memory)
{
    call->by_memory = by_memory;
    call->visit_count = 0;
    memset(call->visits, 0, sizeof(call->visits));
    if (by_memory)
        sweep_shared_memory(sweep, visit, call);
    else
        sweep_equal_handles(sweep, visit, call);
}

static void fill(struct sweep *sweep, const struct call *call)
{
    sweep_init(sweep);
    for (uint32_t i = 0; i < call->count; i++)
        sweep_add(sweep, &call->ranges[i]);
}

static void assert_sweeps(struct call *call)
{
    struct sweep sweep;
    fill(&sweep, call);
    want_all(call);
    for (int round = 0; round < 2; round++) { /* neither disturbs the other */
        sweep_call(call, &sweep, false);
        assert_all_were_visited(call);
        sweep_call(call, &sweep, true);
        assert_all_were_visited(call);
    }
    sweep_release(&sweep);
}

/* How a random call is made. */
struct style {
    uint32_t memories, handles, bytes, longest;
    bool in_order;    /* spans and handles ascend with the builds */
    uint32_t between; /* bytes between the places that the roles have in one memory; 0: none have */
};

static void add_random(struct random *random, struct call *call, const struct style *style,
                       enum range_role role, uint32_t build)
{
    uint32_t at = style->in_order ? build * 5 + (uint32_t)role * style->between
                                  : random_below(random, style->bytes);
    uint32_t memory = style->between ? 1 : random_below(random, style->memories);
    uint32_t handle = style->in_order ? build : random_below(random, style->handles);
    struct used_range range = range_of(role, build, role == ROLE_SCRATCH ? 0 : handle, memory, at,
                                       at + random_below(random, style->longest));
    for (uint32_t i = 0; i < call->count; i++)
        if (same_range(&call->ranges[i], &range))
            return; /* index_of could not tell them apart */
    if (call->count < RANGES)
        call->ranges[call->count++] = range;
}

/* Some builds have a src, some a scratch, and some several pieces of one. */
static void make_random(struct random *random, struct call *call, const struct style *style)
{
    *call = (struct call){0};
    uint32_t builds = 1 + random_below(random, 36);
    bool is_sparse = random_one_in(random, 3);
    for (uint32_t build = 0; build < builds; build++) {
        add_random(random, call, style, ROLE_DST, build);
        if (random_one_in(random, 2))
            add_random(random, call, style, ROLE_SRC, build);
        for (uint32_t i = random_below(random, is_sparse ? 4 : 2); i > 0; i--)
            add_random(random, call, style, ROLE_SCRATCH, build);
    }
}

TEST(test_random_calls)
{
    static const struct style styles[] = {
        {3, 20, 200, 40, false, 0},                               /* many pairs */
        {2, 3, 30, 30, false, 0},                                 /* nearly all alias */
        {5, 1000, 4000, 60, false, 0},                            /* few pairs */
        {2, 50, 300, 12, true, 0},     {2, 50, 100, 2, false, 0}, /* empty ones too */
        {0, 50, 0, 6, true, 1000},                                /* apart at a glance */
        {0, 50, 0, 6, true, 80},   /* the ranges of a role are apart, those of two are not */
        {0, 50, 0, 7, true, 1000}, /* the roles are apart, their ranges are not */
    };
    struct random random = random_of("sweep");
    static struct call call;
    for (int round = 0; round < 400; round++) {
        make_random(&random, &call, &styles[round % 8]);
        assert_sweeps(&call);
    }
}

static uint32_t visits_by_handle(struct call *call)
{
    struct sweep sweep;
    fill(&sweep, call);
    want_all(call);
    sweep_call(call, &sweep, false);
    sweep_release(&sweep);
    return call->visit_count;
}

/* A structure in a sparse buffer is added once without memory, and once a piece. */
static void add_pieces(struct call *call, enum range_role role, uint32_t build, uintptr_t handle)
{
    call->ranges[call->count++] = range_of(role, build, handle, 0, 0, 0);
    call->ranges[call->count++] = range_of(role, build, handle, 1, build * 64, build * 64 + 32);
    call->ranges[call->count++] =
        range_of(role, build, handle, 1, build * 64 + 48, build * 64 + 64);
}

TEST(test_a_structure_in_pieces_is_one_structure)
{
    static struct call call;
    add_pieces(&call, ROLE_DST, 0, 7);
    assert_int_equal(visits_by_handle(&call), 0);
    add_pieces(&call, ROLE_DST, 1, 8);
    assert_int_equal(visits_by_handle(&call), 0);
    add_pieces(&call, ROLE_DST, 2, 7);
    assert_int_equal(visits_by_handle(&call), 1);
    add_pieces(&call, ROLE_SRC, 3, 8);
    assert_int_equal(visits_by_handle(&call), 2);
    add_pieces(&call, ROLE_SRC, 1, 8);
    assert_int_equal(visits_by_handle(&call), 2);
}

TEST(test_it_stops_where_no_more_are_wanted)
{
    static const struct style style = {2, 2, 10, 30, false, 0};
    struct random random = random_of("sweep wanted");
    static struct call call;
    for (int round = 0; round < 100; round++) {
        struct sweep sweep;
        make_random(&random, &call, &style);
        fill(&sweep, &call);
        for (int by_memory = 0; by_memory < 2; by_memory++) {
            uint32_t expected = 0, found[ROLE_COUNT][ROLE_COUNT] = {{0}};
            call.by_memory = by_memory;
            for (uint32_t i = 0; i < call.count; i++)
                for (uint32_t j = 0; j < call.count; j++)
                    found[call.ranges[i].role][call.ranges[j].role] += is_expected(&call, i, j);
            for (int a = 0; a < ROLE_COUNT; a++)
                for (int b = a; b < ROLE_COUNT; b++) {
                    uint32_t wanted = 1 + random_below(&random, 4);
                    call.wanted_visits[a][b] = (int)wanted;
                    expected += wanted < found[a][b] ? wanted : found[a][b];
                }
            sweep_call(&call, &sweep, by_memory);
            if (by_memory)
                assert_int_equal(call.visit_count, expected);
            else /* of equal structures in pieces one pair is enough */
                assert_true(call.visit_count <= expected);
        }
        sweep_release(&sweep);
    }
}

/* Updates of many structures from one, as a crowd is animated: each build reads the same bytes. */
static uint64_t steps_of_updates(uint32_t builds, uint32_t *pairs)
{
    struct sweep sweep;
    uint64_t start = steps_so_far();
    sweep_init(&sweep);
    for (uint32_t i = 0; i < builds; i++) {
        add_range(&sweep, range_of(ROLE_DST, i, 2 + i, 1, 1000 + 100 * i, 1100 + 100 * i));
        add_range(&sweep, range_of(ROLE_SRC, i, 1, 1, 0, 1000));
        add_range(&sweep, range_of(ROLE_SCRATCH, i, 0, 2, 100 * i, 100 * i + 100));
    }
    *pairs = count_pairs(&sweep);
    sweep_release(&sweep);
    return steps_so_far() - start;
}

TEST(test_a_common_source_costs_no_square)
{
    uint32_t pairs;
    uint64_t one = steps_of_updates(20000, &pairs);
    assert_int_equal(pairs, 0);
    uint64_t ten = steps_of_updates(200000, &pairs);
    assert_int_equal(pairs, 0);
    print_message("20,000 updates take %" PRIu64 " steps, 200,000 %" PRIu64 "\n", one, ten);
    assert_true(one >= 20000);
    assert_true(ten <= 15 * one);
}

TEST(test_a_lost_range_silences_all)
{
    static struct call call;
    struct sweep sweep;
    for (uint32_t i = 0; i < RANGES; i++)
        call.ranges[call.count++] = range_of(ROLE_DST, i, 1, 1, 0, 8);
    sweep_init(&sweep);
    memory_fail_after(0);
    for (uint32_t i = 0; i < RANGES; i++)
        sweep_add(&sweep, &call.ranges[i]);
    assert_true(memory_fail_no_more());
    want_all(&call);
    sweep_call(&call, &sweep, false);
    assert_int_equal(call.visit_count, 0);
    sweep_call(&call, &sweep, true);
    assert_int_equal(call.visit_count, 0);
    sweep_release(&sweep);
}

/* Whichever allocation of the search fails, what is visited is there, each pair once. */
TEST(test_a_search_without_memory_makes_nothing_up)
{
    static const struct style style = {2, 3, 60, 30, false, 0};
    struct random random = random_of("sweep memory");
    static struct call call;
    bool failed[2] = {true, true};
    make_random(&random, &call, &style);
    while (call.count < 60)
        make_random(&random, &call, &style);
    for (int n = 0; failed[0] || failed[1]; n++) {
        struct sweep sweep;
        fill(&sweep, &call);
        want_all(&call);
        for (int by_memory = 0; by_memory < 2; by_memory++) {
            memory_fail_after(n);
            sweep_call(&call, &sweep, by_memory);
            failed[by_memory] = memory_fail_no_more();
            for (uint32_t i = 0; i < call.count; i++)
                for (uint32_t j = 0; j < call.count; j++)
                    assert_true(call.visits[i][j] <= 1);
        }
        sweep_release(&sweep);
    }
    assert_sweeps(&call);
}
