/* SPDX-License-Identifier: Apache-2.0 */
/* The sweep over a call's structures and ranges, against all pairs taken one by one; and which
 * builds need none. */
#include <inttypes.h>
#include <string.h>

#include "src/check/overlap/pairs.h"
#include "tests/unit/property.h"
#include "tests/unit/steps.h"

enum { RANGES = 90, BUILDS = 64, PLACES = 41 };

/* The ranges of a call, and how often each pair of them was visited. */
struct call {
    struct sweep sweep;
    uint32_t style, build_count, first_of[BUILDS]; /* each build's first range */
    bool is_lost;                                  /* a range, for lack of memory */
    struct used_range ranges[RANGES];
    uint32_t count;
    uint8_t visits[RANGES][RANGES];                                      /* [a][b] */
    bool by_memory;                                                      /* else by handle */
    int wanted[ROLE_COUNT][ROLE_COUNT], visited[ROLE_COUNT][ROLE_COUNT]; /* wanted -1: all */
};

/* ---- ranges and pairs */

static struct used_range range_of(enum range_role role, uint32_t build, uintptr_t handle,
                                  uintptr_t memory, VkDeviceSize begin, VkDeviceSize end)
{
    return (struct used_range){.role = role,
                               .build = build,
                               .handle = (VkAccelerationStructureKHR)handle,
                               .span = {(VkDeviceMemory)memory, begin, end}};
}

/* A visitor that wants all; `user` is a number. */
static bool count_pair(void *user, const struct used_range *a, const struct used_range *b,
                       const struct memory_span *shared)
{
    ++*(uint32_t *)user;
    return true;
}

/* Adds a range that no variable holds. */
static void add_range(struct sweep *sweep, struct used_range range)
{
    sweep_add(sweep, &range);
}

/* How many pairs the sweep finds. */
static uint32_t count_pairs(struct sweep *sweep)
{
    uint32_t pairs = 0;
    sweep_equal_handles(sweep, count_pair, &pairs);
    sweep_shared_memory(sweep, count_pair, &pairs);
    return pairs;
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
    return !call->is_lost && is_ordered(x, y) &&
           (call->by_memory ? shares_memory(x, y) : has_equal_handle(x, y));
}

static bool same_range(const struct used_range *a, const struct used_range *b)
{
    return a->role == b->role && a->build == b->build && a->handle == b->handle &&
           a->span.memory == b->span.memory && a->span.begin == b->span.begin &&
           a->span.end == b->span.end;
}

static uint32_t index_of(const struct call *call, const struct used_range *range)
{
    for (uint32_t i = call->first_of[range->build]; i < call->count; i++)
        if (same_range(&call->ranges[i], range))
            return i;
    return RANGES;
}

static bool visit(void *user, const struct used_range *a, const struct used_range *b,
                  const struct memory_span *shared)
{
    struct call *call = user;
    const uint32_t i = index_of(call, a), j = index_of(call, b);
    EXPECT(i < RANGES && j < RANGES);
    EXPECT(is_expected(call, i, j));
    EXPECT_EQUAL(shared != NULL, call->by_memory);
    if (shared) {
        EXPECT_SAME(shared->memory, a->span.memory);
        EXPECT(shared->begin == (a->span.begin > b->span.begin ? a : b)->span.begin);
        EXPECT(shared->end == (a->span.end < b->span.end ? a : b)->span.end);
    }
    EXPECT_EQUAL(call->visits[i][j]++, 0);
    const int visited = ++call->visited[a->role][b->role], wanted = call->wanted[a->role][b->role];
    EXPECT(wanted < 0 || visited <= wanted);
    return visited != wanted;
}

/* ---- operations */

/* How a call is made. */
static const struct style {
    uint32_t memories, handles, bytes, longest;
    bool in_order;    /* spans and handles ascend with the builds */
    uint32_t between; /* bytes between the places that the roles have in one memory; 0: none have */
    bool has_places;  /* each build has a place of its own, and handles are in another order */
} styles[] = {
    {3, 20, 200, 40},                   /* many pairs */
    {2, 3, 30, 30},                     /* nearly all alias */
    {5, 1000, 4000, 60},                /* few pairs */
    {2, 50, 300, 12, true},             /* in order */
    {2, 50, 100, 2},                    /* empty ones too */
    {0, 50, 0, 6, true, 1000},          /* apart at a glance */
    {0, 50, 0, 6, true, 80},            /* the ranges of a role are apart, those of two are not */
    {0, 50, 0, 7, true, 1000},          /* the roles are apart, their ranges are not */
    {.longest = 1, .has_places = true}, /* apart, but now and then */
};
enum { STYLES = sizeof(styles) / sizeof(styles[0]) };

static void call_begin(void *state)
{
    sweep_init(&((struct call *)state)->sweep);
}

static void call_style(void *state, const uint32_t *operands)
{
    ((struct call *)state)->style = operands[0];
}

/* A range that depends on its role and build and on a number. */
static struct used_range some_range(const struct call *call, enum range_role role, uint64_t number)
{
    const struct style *style = &styles[call->style];
    const uint32_t build = call->build_count;
    const uint32_t place = number % 30 ? build : (uint32_t)number % 40;
    const uint32_t length = style->longest ? (uint32_t)(number >> 20) % style->longest : 0;
    if (style->has_places) {
        const bool is_src = role == ROLE_SRC, is_larger = (number >> 30) % 60 == 0;
        const uint32_t handle = role == ROLE_SCRATCH ? 0 : 1 + place * 7 % PLACES, at = place * 64;
        return range_of(role, build, handle,
                        is_src                 ? 0
                        : role == ROLE_SCRATCH ? 2
                                               : 1,
                        at, at + (is_larger ? 72 : 64));
    }
    const uint32_t at = style->in_order ? build * 5 + (uint32_t)role * style->between
                                        : (uint32_t)(number >> 32) % style->bytes;
    const uint32_t memory = style->between ? 1 : (uint32_t)(number >> 40) % style->memories;
    const uint32_t handle = style->in_order ? build : (uint32_t)(number >> 48) % style->handles;
    return range_of(role, build, role == ROLE_SCRATCH ? 0 : handle, memory, at, at + length);
}

/* Adds a build with a dst, a src perhaps, and a scratch in some pieces. */
static void call_build(void *state, const uint32_t *operands)
{
    struct call *call = state;
    const bool has_src = !styles[call->style].has_places || operands[0] % 60 == 0;
    const uint32_t src = has_src ? operands[1] % 2 : 0, scratch = operands[1] / 2;
    call->first_of[call->build_count] = call->count;
    for (uint32_t i = 0; i < 1 + src + scratch; i++) {
        const enum range_role role = i == 0 ? ROLE_DST : i <= src ? ROLE_SRC : ROLE_SCRATCH;
        const struct used_range range =
            some_range(call, role, property_hash(operands[0] + 0x10000 * i));
        if (index_of(call, &range) < RANGES || call->count == RANGES)
            continue; /* index_of() could not tell them apart */
        call->is_lost |= PROPERTY_CALL(sweep_add(&call->sweep, &range));
        call->ranges[call->count++] = range;
    }
    call->build_count += call->build_count + 1 < BUILDS;
}

static bool search(struct call *call, bool by_memory)
{
    call->by_memory = by_memory;
    memset(call->visits, 0, sizeof(call->visits));
    memset(call->visited, 0, sizeof(call->visited));
    return PROPERTY_CALL(by_memory ? sweep_shared_memory(&call->sweep, visit, call)
                                   : sweep_equal_handles(&call->sweep, visit, call));
}

/* A structure has one place. Those of the test have several. */
static bool has_one_place(const struct used_range *a, const struct used_range *b)
{
    return a->span.memory == b->span.memory && a->span.begin == b->span.begin &&
           a->span.end == b->span.end;
}

static uint32_t plain, without_pairs; /* calls that are known, or found, to have no pairs */

/* All pairs are visited, and neither search disturbs the other. Without memory, what is visited is
 * there. Nothing is there if the sweep says so before any search. */
static void call_search(void *state, const uint32_t *operands)
{
    struct call *call = state;
    uint32_t pairs = 0;
    bool failed = false;
    const bool finds_nothing = sweep_finds_nothing(&call->sweep);
    memset(call->wanted, -1, sizeof(call->wanted));
    for (int by_memory = 0; by_memory < 2; by_memory++) {
        failed |= search(call, by_memory);
        for (uint32_t i = 0; !failed && i < call->count; i++)
            for (uint32_t j = 0; j < call->count; j++) {
                EXPECT_EQUAL(call->visits[i][j], is_expected(call, i, j));
                pairs += call->visits[i][j] &&
                         (by_memory || has_one_place(&call->ranges[i], &call->ranges[j]));
            }
    }
    EXPECT(!finds_nothing || pairs == 0);
    plain += finds_nothing && styles[call->style].has_places;
    without_pairs += pairs == 0 && !failed && styles[call->style].has_places;
}

/* A search stops where no more pairs of two roles are wanted. */
static void call_search_few(void *state, const uint32_t *operands)
{
    struct call *call = state;
    for (int by_memory = 0; by_memory < 2; by_memory++) {
        int expected[ROLE_COUNT][ROLE_COUNT] = {{0}};
        for (uint32_t i = 0; i < ROLE_COUNT * ROLE_COUNT; i++)
            call->wanted[i / ROLE_COUNT][i % ROLE_COUNT] = 1 + (int)(operands[0] >> 2 * i & 3);
        if (search(call, by_memory))
            continue;
        for (uint32_t i = 0; i < call->count; i++)
            for (uint32_t j = 0; j < call->count; j++)
                expected[call->ranges[i].role][call->ranges[j].role] += is_expected(call, i, j);
        for (int a = 0; a < ROLE_COUNT; a++)
            for (int b = 0; b < ROLE_COUNT; b++)
                EXPECT(call->visited[a][b] ==
                       (expected[a][b] < call->wanted[a][b] ? expected[a][b] : call->wanted[a][b]));
    }
}

static void call_end(void *state)
{
    call_search(state, NULL);
    sweep_release(&((struct call *)state)->sweep);
}

PROPERTY_TEST(sweep, .size = sizeof(struct call), .begin = call_begin, .end = call_end,
              .operations = {{"style", call_style, {STYLES}},
                             {"build", call_build, {1 << 16, 8}, 20, .scarce = 1000},
                             {"search", call_search, {0}, 1, 2, 3},
                             {"search_few", call_search_few, {1 << 18}, 1, 2, 3}},
              .sequences = 600, .steps = 24,
              .cases = (const char *const[]){
                  /* A range is lost, and silences all. */
                  "style 0; build 1 0; build 2 0; build 3 0; build 4 0; build 5 0; build 6 0; "
                  "build 7 0; build 8 0;"
                  "build 9 0; build 10 0; build 11 0; build 12 0; build 13 0; build 14 0; build 15 "
                  "0; build 16 0; build 17 0 !0; build 18 0",
                  "style 4; build 1 0; build 1 0", /* two dst of no bytes with one handle */
                  NULL})

TEST(most_calls_without_pairs_are_plain)
{
    print_message("%u of %u calls without pairs are plain\n", plain, without_pairs);
    assert_in_range(plain, without_pairs / 2, without_pairs);
}

/* ---- cost: builds that share what may be shared, or all conflict */

static uint32_t pairs_of(struct sweep *sweep)
{
    const uint32_t pairs = count_pairs(sweep);
    sweep_release(sweep);
    return pairs;
}

/* Updates of many structures from one, as a crowd is animated: each build reads the same bytes. */
static uint64_t steps_of_updates(uint32_t builds)
{
    struct sweep sweep;
    const uint64_t start = steps_so_far;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < builds; i++) {
        add_range(&sweep, range_of(ROLE_DST, i, 2 + i, 1, 1000 + 100 * i, 1100 + 100 * i));
        add_range(&sweep, range_of(ROLE_SRC, i, 1, 1, 0, 1000));
        add_range(&sweep, range_of(ROLE_SCRATCH, i, 0, 2, 100 * i, 100 * i + 100));
    }
    assert_int_equal(pairs_of(&sweep), 0);
    return steps_so_far - start;
}

TEST(a_common_source_costs_no_square)
{
    const uint64_t one = steps_of_updates(20000), ten = steps_of_updates(200000);
    print_message("20,000 updates take %" PRIu64 " steps, 200,000 %" PRIu64 "\n", one, ten);
    assert_true(one >= 20000);
    assert_true(ten <= 15 * one);
}

/* Builds that all have one structure as dst, update it, use it as an instance and a micromap, and
 * have one scratch; or the same with structures of their own, on the same memory. */
static uint32_t pairs_of_conflicts(uint32_t builds, bool one_structure)
{
    struct sweep sweep;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < builds; i++) {
        const uintptr_t handle = one_structure ? 7 : 7 + i;
        struct used_range src = range_of(ROLE_SRC, i, handle, 1, 0, 100);
        add_range(&sweep, range_of(ROLE_DST, i, handle, 1, 0, 100));
        add_range(&sweep, range_of(ROLE_SCRATCH, i, 0, 1, 50, 150));
        for (int kind = 0; kind < 3; kind++) {
            src.is_micromap = kind == 1;
            src.is_instance = kind == 2;
            sweep_add(&sweep, &src);
        }
    }
    return pairs_of(&sweep);
}

/* However many builds there are: as many pairs a build, also if all pairs are wanted. */
TEST(conflicts_cost_no_square)
{
    enum { MANY = 4000, AT_THE_END = 20000 };
    for (int one_structure = 0; one_structure < 2; one_structure++) {
        const uint32_t pairs = pairs_of_conflicts(MANY, one_structure);
        assert_in_range(pairs, MANY + 1, (uint32_t)MANY * SWEEP_PARTNERS * KIND_COUNT * 2);
        assert_true(pairs_of_conflicts(2 * MANY, one_structure) < 2 * pairs + AT_THE_END);
    }
}

/* What conflicts with a range that begins last of all is found behind any number of others. */
TEST(conflicts_hide_no_other)
{
    enum { MANY = 1000 };
    struct sweep sweep;
    uint32_t pairs = 0;
    sweep_init(&sweep);
    for (uint32_t i = 0; i < MANY; i++) /* of one structure, so no pairs of shared memory */
        add_range(&sweep, range_of(ROLE_DST, i, 7, 1, 0, 100));
    add_range(&sweep, range_of(ROLE_DST, MANY, 8, 1, 10, 200));
    sweep_shared_memory(&sweep, count_pair, &pairs);
    assert_int_equal(pairs, SWEEP_PARTNERS);
    add_range(&sweep, range_of(ROLE_SCRATCH, MANY, 0, 1, 150, 160));
    sweep_shared_memory(&sweep, count_pair, &pairs);
    assert_int_equal(pairs, 2 * SWEEP_PARTNERS + 1);
    sweep_release(&sweep);
}

/* ---- pairs_has_none_within() finds the builds that make no pair, before any range is collected */

struct sole {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    struct check_context context;
    struct call_view call;
    struct build_view view;
};

/* A member of a build whose dst and scratch are bytes 100 to 199 and 200 to 299 of one memory
 * becomes another value. */
#define CHANGE(member, value)                                                                      \
#member, offsetof(struct sole, member), sizeof(((struct sole *)0)->member), value
static const struct change {
    const char *name;
    size_t offset, size;
    uint64_t value;
    bool is_plain, is_elsewhere; /* elsewhere: dst lies in another memory */
} changes[] = {
    {CHANGE(view.dst.begin, 100), true}, /* nothing changes */
    {CHANGE(view.dst.begin, 101), false},
    {CHANGE(view.dst.begin, 200), false},
    {CHANGE(view.dst.begin, 299), false},
    {CHANGE(view.dst.begin, 300), true},
    {CHANGE(view.dst.size, 90), true}, /* the smaller of two sizes counts */
    {CHANGE(view.sizes.acceleration_structure, 1000), false},
    {CHANGE(view.sizes.build_scratch, 101), true},
    {CHANGE(view.dst.begin, 200), true, .is_elsewhere = true},
    {CHANGE(view.sizes.known, false), false},
    {CHANGE(view.scratch.status, ADDRESS_UNKNOWN), false},
    {CHANGE(view.scratch.is_sparse, true), false},
    {CHANGE(view.dst.is_sparse, true), false},
    {CHANGE(info.srcAccelerationStructure, 5), false},
    {CHANGE(view.micromaps, 5), false},
    {CHANGE(context.level, LEVEL_PARAMETERS), false},
};

TEST(builds_without_pairs_are_plain)
{
    for (size_t i = 0; i < sizeof(changes) / sizeof(changes[0]); i++) {
        struct sole sole = {.context.level = LEVEL_STATE, .call.command = COMMAND_DEVICE};
        sole.view = (struct build_view){
            .call = &sole.call,
            .info = &sole.info,
            .dst = {.memory = (VkDeviceMemory)(changes[i].is_elsewhere ? 2ull : 1),
                    .begin = 100,
                    .size = 1000},
            .scratch = {.status = ADDRESS_IN_BUFFER,
                        .memory = (VkDeviceMemory)1,
                        .begin = 200,
                        .bytes_left = 100},
            .sizes = {.known = true, .acceleration_structure = 100, .build_scratch = 100}};
        memcpy((char *)&sole + changes[i].offset, &changes[i].value, changes[i].size);
        if (pairs_has_none_within(&sole.context, &sole.view) != changes[i].is_plain)
            fail_msg("%s = %d", changes[i].name, (int)changes[i].value);
    }
}
