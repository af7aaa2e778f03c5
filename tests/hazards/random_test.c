/* SPDX-License-Identifier: Apache-2.0 */
/* Random sequences of batches, accesses and dependencies (tests/unit/property.h): the hazard check
 * finds what the model finds, byte by byte. A sequence that ASSAY_TEST_STEPS repeats is printed in
 * words. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "src/hazards/hazards.h"
#include "tests/unit/property.h"
#include "tests/unit/random.h"

enum {
    QUEUES = 4, /* the host, and three queues */
    BYTES = 4,  /* of each memory */
    SEMAPHORES = 2,
    EVENTS = 2,
    BARRIERS = 3, /* of one command */
    WAITS = 2,
    COMMAND_ACCESSES = 3,
    STEPS = 28, /* of a sequence */
    MOST_ACCESSES = STEPS * COMMAND_ACCESSES,
    MOST_LINKS = 1024,
};

/* How far an access has come when a dependency is through. VISIBLE: to all accesses. */
enum reach { NOT_REACHED, ORDERED, AVAILABLE, VISIBLE };

struct batch {
    uint32_t queue, step;
    bool is_certain, is_signalled;
    /* As in struct hazard_batch; `clock` is before[] of a batch that follows this one. */
    uint64_t number, completed[QUEUES], before[QUEUES], clock[QUEUES];
};

struct access {
    struct hazard_access is;
    uint32_t step, command, queue;
    uint64_t batch, number;
};

/* One dependency: from what a queue executed before a step, to what a queue executes after one. */
struct link {
    struct hazard_barrier barrier;
    /* Semaphores and host waits: their access scopes include all memory access of the device,
     * whatever the stages. */
    bool is_full;
    uint32_t from_queue, from_step, to_queue, to_step;
};

/* A signal of a semaphore or of an event. */
struct signal {
    bool is_event, is_reset;
    bool has_gap; /* nothing signals the value before */
    uint64_t object, value;
    uint32_t queue, step, batch;
    stage_set src;
    const uint64_t *clock; /* what is before a batch that waits for the signal */
};

struct world {
    struct hazards *hazards;
    struct random random; /* of the step that is made */

    /* what steps are made of */
    bool has_host;
    uint32_t queue_count; /* without the host */
    uint64_t memories;
    kind_set kinds;
    stage_set stages;        /* of the kinds, and one that only continues chains */
    stage_set focus[QUEUES]; /* of the queue's last access or second scope */
    uint64_t numbers[QUEUES];
    uint64_t known[QUEUES]; /* what the host has observed */
    /* of the last batch of each queue; and the least that any batch to come may have completed */
    uint64_t before[QUEUES][QUEUES], completed[QUEUES][QUEUES], pruned[QUEUES];
    uint64_t values[SEMAPHORES];
    stage_set event_stages[QUEUES][EVENTS]; /* 0: not set */

    /* the model: all that has happened, each at a step of its own */
    uint32_t step, command;
    struct batch *batch; /* that is open; or NULL */
    struct batch batches[STEPS + 1];
    struct access accesses[MOST_ACCESSES];
    struct link links[MOST_LINKS];
    struct signal signals[STEPS];
    uint32_t batch_count, access_count, link_count, signal_count;
    /* of a byte of an access, when a link is through */
    uint8_t reached[MOST_ACCESSES][BYTES][MOST_LINKS];
    /* what the model and the check find between an earlier access and the last one: a verdict() */
    uint8_t expected[MOST_ACCESSES][BYTES], found[MOST_ACCESSES][BYTES];
};

/* ---- words */

static bool tells; /* the steps of the sequence */

__attribute__((format(printf, 1, 2))) static void show(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (tells)
        vprintf(format, arguments);
    va_end(arguments);
}

static const char *const kind_names[ACCESS_KINDS] = {
    "build_accel_read",     "build_accel_write",   "build_shader_read", "build_indirect",
    "build_micromap_read",  "accel_copy_read",     "accel_copy_write",  "accel_transfer_read",
    "accel_transfer_write", "transfer_read",       "transfer_write",    "fill_write",
    "marker_write",         "micromap_read",       "micromap_write",    "micromap_shader_read",
    "micromap_copy_read",   "micromap_copy_write", "host_read",         "host_write",
    "compute_trace",        "rays_trace",          "compute_write",     "rays_write",
    "graphics_write",
};

static const char *const stage_names[SYNC_ACCESS_STAGES] = {
    "build", "accel_copy", "copy", "fill", "micromap", "host", "compute", "rays", "draw_indirect"};

/* The names of the bits, and the other bits as a number. */
static void tell_set(const char *before, uint32_t set, const char *const *names, uint32_t count)
{
    show("%s", before);
    for (uint32_t i = 0; i < count; i++)
        if (set >> i & 1)
            show("%s|", names[i]);
    show("0x%" PRIx32, set >> count << count);
}

static void tell_bytes(const struct hazard_bytes *bytes)
{
    show(" memory %" PRIu64 " [%" PRIu64 ", %" PRIu64 ")", bytes->memory, bytes->begin, bytes->end);
}

static void tell_counts(const char *name, const uint64_t *counts)
{
    show(" %s", name);
    for (uint32_t i = 0; i < QUEUES; i++)
        show(" %" PRIu64, counts[i]);
}

static void tell_barriers(const struct hazard_barrier *barriers, uint32_t count)
{
    for (const struct hazard_barrier *barrier = barriers; barrier < barriers + count; barrier++) {
        tell_set("      ", barrier->dependency.src, stage_names, SYNC_ACCESS_STAGES);
        tell_set(" ", barrier->dependency.src_kinds, kind_names, ACCESS_KINDS);
        tell_set(" -> ", barrier->dependency.dst, stage_names, SYNC_ACCESS_STAGES);
        tell_set(" ", barrier->dependency.dst_kinds, kind_names, ACCESS_KINDS);
        if (barrier->is_global)
            show(" global");
        else
            tell_bytes(&barrier->bytes);
        show("%s\n", barrier->is_acquisition ? " acquisition" : "");
    }
}

/* ---- a model of the hazard check, as close to the specification's definitions as can be (chapter
 * Synchronization and Cache Control, Execution and Memory Dependencies)
 *
 * It lists all accesses and all dependencies. For each byte of each access it computes which
 * dependencies the access happens before, by the definition of execution dependency chains, and
 * whether it is available there. It judges one byte at a time, so a buffer barrier is a barrier
 * with access scopes for some bytes and without for others. */

static bool bytes_contain(const struct hazard_bytes *bytes, uint64_t memory, uint64_t byte)
{
    return bytes->memory == memory && bytes->begin <= byte && byte < bytes->end;
}

static bool barrier_holds(const struct hazard_barrier *barrier, uint64_t memory, uint64_t byte)
{
    return barrier->is_global || bytes_contain(&barrier->bytes, memory, byte);
}

static bool has_stage(stage_set stages, enum access_kind kind)
{
    return stages >> access_stage(kind) & 1;
}

static bool has_kind(kind_set kinds, enum access_kind kind)
{
    return kinds >> kind & 1;
}

/* The first access scope of a chain is that of its first dependency: only an access that is
 * directly in a dependency's first scope is made available by it. */
static enum reach direct_reach(const struct access *access, uint64_t byte, const struct link *link)
{
    const struct dependency *dependency = &link->barrier.dependency;
    if (access->queue != link->from_queue || access->step >= link->from_step ||
        !has_stage(dependency->src, access->is.kind))
        return NOT_REACHED;
    bool is_available = has_kind(dependency->src_kinds, access->is.kind) &&
                        barrier_holds(&link->barrier, access->is.bytes.memory, byte);
    return is_available ? AVAILABLE : ORDERED;
}

/* A chain exists if the second scope of one dependency and the first scope of the next intersect.
 */
static bool is_continued(const struct link *first, const struct link *next)
{
    return first->to_queue == next->from_queue && first->to_step < next->from_step &&
           (first->barrier.dependency.dst & next->barrier.dependency.src);
}

static enum reach reach_of(const struct world *world, uint32_t access, uint64_t byte,
                           const struct link *link)
{
    enum reach reach = direct_reach(&world->accesses[access], byte, link);
    for (uint32_t i = 0; i < world->link_count && reach < VISIBLE; i++)
        if (world->reached[access][byte][i] > reach && is_continued(&world->links[i], link))
            reach = world->reached[access][byte][i];
    if (reach && link->is_full)
        return VISIBLE;
    if (reach == ORDERED && link->barrier.is_acquisition &&
        barrier_holds(&link->barrier, world->accesses[access].is.bytes.memory, byte))
        return AVAILABLE;
    return reach;
}

/* From what a queue executed before a step, to what the open batch executes from now on. Links are
 * added in the order of their ends, so all that may precede one are there. */
static void add_link(struct world *world, struct hazard_barrier barrier, bool is_full,
                     uint32_t from_queue, uint32_t from_step)
{
    const struct link link = {barrier,    is_full, from_queue, from_step, world->batch->queue,
                              world->step};
    EXPECT(world->link_count < MOST_LINKS);
    for (uint32_t access = 0; access < world->access_count; access++)
        for (uint64_t byte = 0; byte < BYTES; byte++)
            world->reached[access][byte][world->link_count] =
                (uint8_t)reach_of(world, access, byte, &link);
    world->links[world->link_count++] = link;
}

/* All that a queue has executed before a step happens before what comes now. */
static void order_all(struct world *world, uint32_t queue, uint32_t from_step)
{
    add_link(
        world,
        (struct hazard_barrier){.dependency = {.src = ALL_SYNC_STAGES, .dst = ALL_SYNC_STAGES}},
        true, queue, from_step);
}

static void order_everything(struct world *world)
{
    for (uint32_t queue = 0; queue < QUEUES; queue++)
        order_all(world, queue, world->step);
}

/* The first step of the queue that is in none of its completed batches. */
static uint32_t completed_end(const struct world *world, uint32_t queue, uint64_t completed)
{
    for (const struct batch *batch = world->batches; batch < world->batch; batch++)
        if (batch->queue == queue && batch->number > completed)
            return batch->step;
    return world->step;
}

static void model_batch(struct world *world)
{
    const struct batch *batch = world->batch;
    if (!batch->is_certain)
        order_everything(world);
    for (uint32_t queue = 0; queue < QUEUES && batch->is_certain; queue++)
        if (batch->completed[queue])
            order_all(world, queue, completed_end(world, queue, batch->completed[queue]));
}

/* The first scope of a signal has the signals of the queue's earlier batches (signal operation
 * order). Signals with smaller values of the semaphore happen before it, too. */
static bool is_signalled_before(const struct signal *first, const struct signal *second)
{
    return first->step < second->step && !first->is_event &&
           ((first->queue == second->queue && first->batch != second->batch) ||
            (first->object == second->object && first->value < second->value));
}

/* A wait for an unknown signal may follow anything. */
static void model_wait(struct world *world, const struct signal *waited, stage_set dst)
{
    bool is_before[STEPS] = {false};
    if (!waited)
        order_everything(world);
    for (uint32_t i = world->signal_count; waited && i--;) {
        const struct signal *signal = &world->signals[i];
        is_before[i] = signal == waited;
        for (uint32_t later = i + 1; later < world->signal_count; later++)
            is_before[i] |= is_before[later] && is_signalled_before(signal, &world->signals[later]);
        if (is_before[i])
            add_link(world, (struct hazard_barrier){.dependency = {.src = signal->src, .dst = dst}},
                     true, signal->queue, signal->step);
    }
}

/* vkCmdSetEvent has no effect on an event that is set. But sequences do not describe what the host
 * resets (vkResetEvent): so an event that is set twice has both first scopes. */
static void model_reset_event(struct world *world, uint64_t event, bool is_set)
{
    for (struct signal *signal = world->signals; signal < world->signals + world->signal_count;
         signal++)
        if (signal->is_event && signal->object == event &&
            (!is_set || signal->queue != world->batch->queue))
            signal->is_reset = true;
}

static void model_wait_event(struct world *world, uint64_t event,
                             const struct hazard_barrier *barriers, uint32_t count)
{
    for (uint32_t i = 0; i < world->signal_count; i++) {
        const struct signal *signal = &world->signals[i];
        if (!signal->is_event || signal->is_reset || signal->object != event ||
            signal->queue != world->batch->queue)
            continue;
        for (uint32_t j = 0; j < count; j++) {
            struct hazard_barrier barrier = barriers[j];
            barrier.dependency.src = signal->src;
            add_link(world, barrier, false, signal->queue, signal->step);
        }
    }
}

struct order {
    bool is_ordered, is_available, is_visible;
};

static struct order order_of(const struct world *world, uint32_t earlier,
                             const struct access *later, uint64_t byte)
{
    struct order order = {0};
    for (uint32_t i = 0; i < world->link_count; i++) {
        const struct link *link = &world->links[i];
        enum reach reach = world->reached[earlier][byte][i];
        if (!reach || link->to_queue != later->queue ||
            !has_stage(link->barrier.dependency.dst, later->is.kind))
            continue;
        order.is_ordered = true;
        if (reach < AVAILABLE)
            continue;
        order.is_available = true;
        if (reach == VISIBLE)
            order.is_visible = true;
        if (has_kind(link->barrier.dependency.dst_kinds, later->is.kind) &&
            barrier_holds(&link->barrier, later->is.bytes.memory, byte))
            order.is_visible = true;
    }
    return order;
}

/* 0 stands for no hazard. */
static uint8_t verdict(enum hazard_type type, bool is_racing, bool is_ordered, bool is_available)
{
    return (uint8_t)(0x80 | (uint8_t)type | is_racing << 2 | is_ordered << 3 |
                     (is_available && type != WRITE_AFTER_READ) << 4);
}

static uint8_t compare(const struct world *world, uint32_t index, const struct access *later,
                       uint64_t byte)
{
    const struct access *earlier = &world->accesses[index];
    bool wrote = access_is_write(earlier->is.kind), writes = access_is_write(later->is.kind);
    struct order order = order_of(world, index, later, byte);
    if (earlier->is.kind == ACCESS_MARKER_WRITE && later->is.kind == ACCESS_MARKER_WRITE)
        return 0;
    if (wrote ? order.is_visible : order.is_ordered)
        return 0;
    /* Queues execute their batches in order; the host does not. */
    bool has_order =
        earlier->queue == later->queue && (later->queue || earlier->batch == later->batch);
    bool is_racing = !has_order && earlier->batch > world->batch->before[earlier->queue];
    return verdict(!wrote   ? WRITE_AFTER_READ
                   : writes ? WRITE_AFTER_WRITE
                            : READ_AFTER_WRITE,
                   is_racing, order.is_ordered, order.is_available);
}

/* Compares with the last write and, for a write, with the last read since then of each queue and
 * kind. Accesses of the same command are left out. */
static void model_access(struct world *world, const struct access *later, uint64_t byte)
{
    kind_set seen[QUEUES] = {0};
    for (uint32_t i = world->access_count; i--;) {
        const struct access *earlier = &world->accesses[i];
        enum access_kind kind = earlier->is.kind;
        if (!bytes_contain(&earlier->is.bytes, later->is.bytes.memory, byte))
            continue;
        bool is_same = earlier->command == later->command;
        if (access_is_write(kind)) {
            if (!is_same)
                world->expected[i][byte] = compare(world, i, later, byte);
            return;
        }
        if (!access_is_write(later->is.kind) || is_same || has_kind(seen[earlier->queue], kind))
            continue;
        seen[earlier->queue] |= 1u << kind;
        world->expected[i][byte] = compare(world, i, later, byte);
    }
}

/* ---- what the check finds. The later access is being added: it has the next place. */

static void note_hazard(void *user, const struct hazard *hazard)
{
    struct world *world = user;
    const struct access *later = &world->accesses[world->access_count];
    uint32_t i = 0;
    while (i < world->access_count && world->accesses[i].number != hazard->earlier.number)
        i++;
    EXPECT(i < world->access_count);
    EXPECT_EQUAL(hazard->earlier.queue, world->accesses[i].queue);
    EXPECT_EQUAL(hazard->earlier.kind, world->accesses[i].is.kind);
    EXPECT_EQUAL(hazard->later.queue, later->queue);
    EXPECT_EQUAL(hazard->later.kind, later->is.kind);
    EXPECT(!world->access_count ||
           hazard->later.number > world->accesses[world->access_count - 1].number);
    EXPECT_EQUAL(hazard->bytes.memory, later->is.bytes.memory);
    EXPECT(hazard->bytes.end <= BYTES);
    for (uint64_t byte = hazard->bytes.begin; byte < hazard->bytes.end; byte++)
        world->found[i][byte] =
            verdict(hazard->type, hazard->is_racing, hazard->is_ordered, hazard->is_available);
}

static const char *words_of(uint8_t verdict, char words[64])
{
    static const char *const types[] = {"read after write", "write after read", "write after write",
                                        "another hazard"};
    snprintf(words, 64, "%s%s%s%s", types[verdict & 3], verdict & 4 ? ", racing" : "",
             verdict & 8 ? ", ordered" : "", verdict & 16 ? ", available" : "");
    return verdict ? words : "nothing";
}

static void expect_same_verdicts(const struct world *world)
{
    for (uint32_t i = 0; i < world->access_count; i++)
        for (uint32_t byte = 0; byte < BYTES; byte++) {
            char text[256], words[2][64];
            const uint8_t expected = world->expected[i][byte], found = world->found[i][byte];
            if (expected == found)
                continue;
            snprintf(text, sizeof(text),
                     "byte %u of accesses %u and %u: the model finds %s, the check finds %s", byte,
                     i, world->access_count, words_of(expected, words[0]),
                     words_of(found, words[1]));
            property_expect(false, text, __FILE__, __LINE__);
        }
}

/* ---- random scopes */

static uint32_t below(struct world *world, uint32_t count)
{
    return random_below(&world->random, count);
}

static bool one_in(struct world *world, uint32_t times)
{
    return random_one_in(&world->random, times);
}

static void join(uint64_t *clock, const uint64_t *other)
{
    for (uint32_t i = 0; i < QUEUES; i++)
        if (clock[i] < other[i])
            clock[i] = other[i];
}

static uint32_t random_bit(struct world *world, uint32_t bits)
{
    uint32_t bit;
    do
        bit = 1u << below(world, 32);
    while (!(bits & bit));
    return bit;
}

static stage_set random_stages(struct world *world)
{
    if (one_in(world, 5))
        return ALL_SYNC_STAGES;
    stage_set stages = random_bit(world, world->stages);
    while (one_in(world, 2))
        stages |= random_bit(world, world->stages);
    return stages;
}

/* Often the scope continues a chain. */
static stage_set random_src(struct world *world)
{
    stage_set focus = world->focus[world->batch->queue] & world->stages;
    if (!focus || one_in(world, 3))
        return random_stages(world);
    return random_bit(world, focus) | (one_in(world, 3) ? random_stages(world) : 0);
}

static stage_set random_dst(struct world *world)
{
    return world->focus[world->batch->queue] = random_stages(world);
}

static kind_set kinds_at(stage_set stages)
{
    kind_set kinds = 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (has_stage(stages, (enum access_kind)kind))
            kinds |= 1u << kind;
    return kinds;
}

static kind_set random_kinds(struct world *world, stage_set stages)
{
    kind_set kinds = kinds_at(stages);
    if (one_in(world, 8))
        return 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (one_in(world, 5))
            kinds &= ~(1u << kind);
    return kinds;
}

static struct hazard_bytes random_bytes(struct world *world)
{
    uint64_t memory = 1 + below(world, (uint32_t)world->memories);
    if (one_in(world, 3))
        return (struct hazard_bytes){memory, 0, BYTES};
    uint64_t begin = below(world, BYTES);
    uint64_t end = begin + 1 + below(world, BYTES - (uint32_t)begin);
    return (struct hazard_bytes){memory, begin, end};
}

static struct hazard_barrier random_barrier(struct world *world, stage_set src)
{
    struct hazard_barrier barrier = {.is_global = below(world, 9) < 5,
                                     .bytes = random_bytes(world)};
    barrier.dependency.src = src;
    barrier.dependency.dst = random_dst(world);
    barrier.dependency.src_kinds = random_kinds(world, src);
    barrier.dependency.dst_kinds = random_kinds(world, barrier.dependency.dst);
    if (one_in(world, 8)) {
        barrier.is_acquisition = true;
        barrier.dependency.src_kinds = 0;
    } else if (one_in(world, 8)) {
        barrier.dependency.dst_kinds = 0; /* a release */
    }
    if (one_in(world, 16))
        barrier.bytes.end = barrier.bytes.begin; /* an image barrier */
    return barrier;
}

/* ---- batches */

static void end_batch(struct world *world)
{
    if (!world->batch)
        return;
    memcpy(world->before[world->batch->queue], world->batch->clock, sizeof(world->batch->clock));
    hazards_end_batch(world->hazards);
    world->batch = NULL;
}

/* The host observes that a batch has completed, and may conclude that those before it have. */
static void observe(struct world *world)
{
    if (!world->batch_count || !one_in(world, 6))
        return;
    const struct batch *batch = &world->batches[below(world, world->batch_count)];
    uint64_t alone[QUEUES] = {0};
    alone[batch->queue] = batch->number;
    join(world->known, one_in(world, 2) ? alone : batch->clock);
}

/* The signal of the semaphore with the smallest value that is as large; NULL: there is none. */
static const struct signal *find_signal(const struct world *world, uint64_t semaphore,
                                        uint64_t value)
{
    const struct signal *found = NULL;
    for (uint32_t i = 0; i < world->signal_count; i++) {
        const struct signal *signal = &world->signals[i];
        if (!signal->is_event && signal->object == semaphore && signal->value >= value &&
            (!found || signal->value < found->value))
            found = signal;
    }
    return value ? found : NULL;
}

/* Signals are numbered from 1; 0 stands for none. */
static uint64_t number_of(const struct world *world, const struct signal *signal)
{
    return signal ? (uint64_t)(signal - world->signals) + 1 : 0;
}

struct wait {
    const struct signal *signal; /* NULL: unknown */
    stage_set dst;
};

/* A wait of the batch that begins. Returns false if there is nothing to wait for. */
static bool choose_wait(struct world *world, struct wait *wait)
{
    if (!world->signal_count)
        return false;
    const struct signal *signal = &world->signals[below(world, world->signal_count)];
    if (signal->is_event)
        return false;
    uint64_t value = signal->value - (signal->has_gap && one_in(world, 2));
    wait->dst = random_dst(world);
    if (one_in(world, 16))
        value = one_in(world, 2) ? 0 : world->values[signal->object] + 1;
    else
        join(world->batch->before, signal->clock);
    wait->signal = find_signal(world, signal->object, value);
    return true;
}

static void play_wait(struct world *world, const struct wait *wait)
{
    const struct dependency dependency = {.dst = wait->dst, .dst_kinds = kinds_at(wait->dst)};
    world->step++;
    show("  wait for signal %" PRIu64, number_of(world, wait->signal));
    tell_set(", ", wait->dst, stage_names, SYNC_ACCESS_STAGES);
    show("\n");
    hazards_wait(world->hazards, number_of(world, wait->signal), &dependency);
    model_wait(world, wait->signal, wait->dst);
}

static void play_batch(struct world *world)
{
    struct batch *batch = world->batch;
    batch->step = ++world->step;
    memcpy(batch->clock, batch->before, sizeof(batch->clock));
    batch->clock[batch->queue] = batch->number;
    show("batch of queue %u number %" PRIu64 "%s", batch->queue, batch->number,
         batch->is_certain ? "" : " uncertain");
    tell_counts("before", batch->before);
    tell_counts("completed", batch->completed);
    show("\n");
    hazards_begin_batch(world->hazards,
                        &(struct hazard_batch){batch->queue, batch->number, batch->completed,
                                               batch->before, QUEUES, batch->is_certain});
    model_batch(world);
}

static void begin_batch(struct world *world)
{
    struct wait waits[WAITS];
    uint32_t wait_count = 0;
    end_batch(world);
    observe(world);
    const uint32_t queue =
        world->has_host && one_in(world, 4) ? 0 : 1 + below(world, world->queue_count);
    struct batch *batch = &world->batches[world->batch_count];
    EXPECT(world->batch_count++ < STEPS);
    world->batch = batch;
    batch->queue = queue;
    batch->number = world->numbers[queue] += 1 + one_in(world, 4);
    batch->is_certain = !one_in(world, 24);
    /* It may have been submitted before the host observed what it knows by now. */
    if (one_in(world, 2))
        join(world->completed[queue], world->known);
    join(world->completed[queue], world->pruned);
    memcpy(batch->completed, world->completed[queue], sizeof(batch->completed));
    join(batch->before, batch->completed);
    if (queue || one_in(world, 2))
        join(batch->before, world->before[queue]);
    for (uint32_t i = queue ? below(world, WAITS + 1) : 0; i; i--)
        wait_count += choose_wait(world, &waits[wait_count]);
    play_batch(world);
    for (uint32_t i = 0; i < wait_count; i++)
        play_wait(world, &waits[i]);
}

/* ---- steps, which depend on an operand and on those before */

static void make_step(struct world *world, const uint32_t *operands)
{
    world->random = (struct random){operands[0]};
}

static void ensure_batch(struct world *world)
{
    if (!world->batch || world->batch->is_signalled)
        begin_batch(world);
}

static void step_batch(void *state, const uint32_t *operands)
{
    make_step(state, operands);
    begin_batch(state);
}

/* Few kinds, so that dependencies often fit. */
static void choose_scopes(struct world *world)
{
    static const enum access_kind kinds[] = {
        ACCESS_BUILD_ACCEL_READ, ACCESS_BUILD_ACCEL_WRITE, ACCESS_BUILD_SHADER_READ,
        ACCESS_COPY_ACCEL_READ,  ACCESS_COPY_ACCEL_WRITE,  ACCESS_TRANSFER_READ,
        ACCESS_TRANSFER_WRITE,   ACCESS_FILL_WRITE,        ACCESS_MICROMAP_WRITE,
    };
    world->has_host = one_in(world, 4);
    world->queue_count = one_in(world, 4) ? 1 + below(world, 3) : 2;
    world->memories = one_in(world, 8) ? 2 : 1;
    world->kinds = 1u << (one_in(world, 2) ? ACCESS_BUILD_ACCEL_WRITE : ACCESS_TRANSFER_WRITE);
    for (uint32_t count = 1 + below(world, 4); count; count--)
        world->kinds |= 1u << kinds[below(world, sizeof(kinds) / sizeof(kinds[0]))];
    if (world->has_host)
        world->kinds |= 1u << ACCESS_HOST_READ | 1u << ACCESS_HOST_WRITE;
    world->stages = one_in(world, 2) ? 1u << SYNC_COMPUTE_SHADER : 0;
    for (uint32_t kind = 0; kind < ACCESS_KINDS; kind++)
        if (has_kind(world->kinds, (enum access_kind)kind))
            world->stages |= 1u << access_stage((enum access_kind)kind);
}

static void step_scopes(void *state, const uint32_t *operands)
{
    make_step(state, operands);
    if (!((struct world *)state)->batch_count)
        choose_scopes(state);
}

static enum access_kind random_kind(struct world *world)
{
    const kind_set host = 1u << ACCESS_HOST_READ | 1u << ACCESS_HOST_WRITE;
    stage_set *focus = &world->focus[world->batch->queue];
    enum access_kind kind = 0;
    for (uint32_t tries = 0; tries < 2; tries++) {
        kind = (enum access_kind)__builtin_ctz(
            random_bit(world, world->batch->queue ? world->kinds & ~host : host));
        if (has_stage(*focus, kind))
            break;
    }
    *focus = 1u << access_stage(kind);
    return kind;
}

static void play_access(struct world *world)
{
    struct access *access = &world->accesses[world->access_count];
    EXPECT(world->access_count < MOST_ACCESSES);
    *access = (struct access){.is = {random_kind(world), random_bytes(world)},
                              .step = ++world->step,
                              .command = world->command,
                              .queue = world->batch->queue,
                              .batch = world->batch->number};
    if (one_in(world, 32))
        access->is.bytes.end = access->is.bytes.begin;
    show("  access %u: %s", world->access_count, kind_names[access->is.kind]);
    tell_bytes(&access->is.bytes);
    show(" of command %u\n", world->command);
    memset(world->expected, 0, sizeof(world->expected));
    memset(world->found, 0, sizeof(world->found));
    memset(world->reached[world->access_count], NOT_REACHED, sizeof(world->reached[0]));
    for (uint64_t byte = access->is.bytes.begin; byte < access->is.bytes.end; byte++)
        model_access(world, access, byte);
    access->number = hazards_access(world->hazards, &access->is);
    EXPECT(!world->access_count || access->number > access[-1].number);
    expect_same_verdicts(world);
    world->access_count++;
}

static void step_access(void *state, const uint32_t *operands)
{
    struct world *world = state;
    uint32_t left = COMMAND_ACCESSES;
    make_step(world, operands);
    ensure_batch(world);
    world->command++;
    hazards_begin_command(world->hazards);
    do
        play_access(world);
    while (--left && one_in(world, 3));
}

/* Only queues have other commands. */
static bool begin_command(struct world *world, const uint32_t *operands)
{
    make_step(world, operands);
    ensure_batch(world);
    if (!world->batch->queue)
        step_access(world, operands);
    return world->batch->queue;
}

static void step_barriers(void *state, const uint32_t *operands)
{
    struct world *world = state;
    struct hazard_barrier barriers[BARRIERS];
    stage_set src[BARRIERS];
    uint32_t count = 0;
    if (!begin_command(world, operands))
        return;
    for (uint32_t i = 0; i < BARRIERS; i++)
        src[i] = random_src(world);
    do {
        barriers[count] = random_barrier(world, src[count]);
        count++;
    } while (count < BARRIERS && one_in(world, 3));
    world->step++;
    show("  barriers\n");
    tell_barriers(barriers, count);
    hazards_barriers(world->hazards, barriers, count);
    for (uint32_t i = 0; i < count; i++)
        add_link(world, barriers[i], false, world->batch->queue, world->step);
}

static struct signal *add_signal(struct world *world, bool is_event, uint64_t object)
{
    EXPECT(world->signal_count < STEPS);
    struct signal *signal = &world->signals[world->signal_count++];
    *signal = (struct signal){.is_event = is_event,
                              .object = object,
                              .queue = world->batch->queue,
                              .step = ++world->step,
                              .batch = world->batch->step,
                              .src = random_src(world),
                              .clock = world->batch->clock};
    return signal;
}

/* vkCmdWaitEvents names the stages of all its events, vkCmdWaitEvents2 some of one. */
static void play_wait_event(struct world *world, uint64_t event, stage_set stages)
{
    struct hazard_barrier barriers[BARRIERS];
    uint32_t count = 0;
    do {
        stage_set src = stages ? stages : random_src(world);
        if (one_in(world, 3))
            src |= random_stages(world);
        else if (one_in(world, 3))
            src &= random_stages(world);
        barriers[count++] = random_barrier(world, src);
    } while (count < BARRIERS && one_in(world, 3));
    world->step++;
    show("  wait for event %" PRIu64 "\n", event);
    tell_barriers(barriers, count);
    hazards_wait_event(world->hazards, event, barriers, count);
    model_wait_event(world, event, barriers, count);
}

/* Events of one queue. A wait for that of another is not valid, and orders nothing. */
static void step_event(void *state, const uint32_t *operands)
{
    struct world *world = state;
    if (!begin_command(world, operands))
        return;
    uint32_t queue = world->batch->queue;
    const uint32_t number = below(world, EVENTS);
    if (one_in(world, 16))
        queue = 1 + below(world, world->queue_count);
    const uint64_t event = queue * EVENTS + number;
    stage_set *stages = &world->event_stages[queue][number];
    const uint32_t choice = below(world, 6);
    if (choice < (*stages ? 4u : 1u)) { /* seldom for one that is not set */
        play_wait_event(world, event, *stages);
    } else if (*stages && choice == 4) {
        world->step++;
        show("  reset event %" PRIu64 "\n", event);
        hazards_reset_event(world->hazards, event);
        model_reset_event(world, event, false);
        *stages = 0;
    } else {
        model_reset_event(world, event, true);
        const struct signal *signal = add_signal(world, true, event);
        show("  set event %" PRIu64, event);
        tell_set(" ", signal->src, stage_names, SYNC_ACCESS_STAGES);
        show("\n");
        hazards_set_event(world->hazards, event, signal->src);
        *stages = *stages ? *stages : signal->src;
    }
}

/* The end of the batch signals a semaphore. */
static void step_signal(void *state, const uint32_t *operands)
{
    struct world *world = state;
    make_step(world, operands);
    if (!world->batch)
        return;
    const uint64_t semaphore = below(world, SEMAPHORES);
    const struct signal *previous = find_signal(world, semaphore, world->values[semaphore]);
    struct signal *signal = add_signal(world, false, semaphore);
    signal->has_gap = one_in(world, 2);
    signal->value = world->values[semaphore] += 1 + signal->has_gap;
    world->batch->is_signalled = true;
    show("  signal %" PRIu64 " of semaphore %" PRIu64 ", value %" PRIu64, number_of(world, signal),
         semaphore, signal->value);
    tell_set(", ", signal->src, stage_names, SYNC_ACCESS_STAGES);
    show("\n");
    hazards_signal(world->hazards, number_of(world, signal), number_of(world, previous),
                   &(struct dependency){.src = signal->src, .src_kinds = kinds_at(signal->src)});
}

static void step_prune(void *state, const uint32_t *operands)
{
    struct world *world = state;
    end_batch(world);
    tell_counts("prune", world->known);
    show("\n");
    hazards_prune(world->hazards, world->known, QUEUES);
    join(world->pruned, world->known);
}

static void step_forget(void *state, const uint32_t *operands)
{
    struct world *world = state;
    end_batch(world);
    show("forget memory %u\n", operands[0] + 1);
    hazards_forget_memory(world->hazards, operands[0] + 1);
    for (uint32_t i = 0; i < world->access_count; i++)
        if (world->accesses[i].is.bytes.memory == operands[0] + 1)
            world->accesses[i].is.bytes = (struct hazard_bytes){0, 0, 0};
}

static void world_begin(void *state)
{
    struct world *world = state;
    static bool has_told;
    tells = !has_told && getenv("ASSAY_TEST_STEPS");
    has_told = true;
    world->hazards = hazards_create(note_hazard, world);
    choose_scopes(world);
}

static void world_end(void *state)
{
    end_batch(state);
    hazards_destroy(((struct world *)state)->hazards);
}

enum { ANY = 1 << 30 };

PROPERTY_TEST(hazards, .size = sizeof(struct world), .begin = world_begin, .end = world_end,
              .operations = {{"scopes", step_scopes, {ANY}},
                             {"batch", step_batch, {ANY}, 60},
                             {"access", step_access, {ANY}, 70},
                             {"barriers", step_barriers, {ANY}, 40},
                             {"event", step_event, {ANY}, 40},
                             {"signal", step_signal, {ANY}, 50},
                             {"prune", step_prune, {0}, 3},
                             {"forget", step_forget, {2}, 2}},
              .sequences = HAZARD_PROGRAMS, .steps = STEPS)
