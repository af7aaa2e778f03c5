/* SPDX-License-Identifier: Apache-2.0 */
/* A model of the hazard check, as close to the specification's definitions as can be (chapter
 * Synchronization and Cache Control, Execution and Memory Dependencies).
 *
 * It lists all accesses and all dependencies. For each byte of each access it computes which
 * dependencies the access happens before, by the definition of execution dependency chains, and
 * whether it is available there. It judges one byte at a time, so a buffer barrier is a barrier
 * with access scopes for some bytes and without for others. */
#include "program.h"

#include <stdlib.h>
#include <string.h>

enum { MODEL_LINKS = PROGRAM_STEPS * 16, MODEL_SIGNALS = PROGRAM_STEPS };

/* How far an access has come when a dependency is through. VISIBLE: to all accesses. */
enum reach { NOT_REACHED, ORDERED, AVAILABLE, VISIBLE };

struct access {
    const struct hazard_access *is;
    uint32_t step, command, queue;
    uint64_t batch;
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
    uint64_t object, value;
    uint32_t queue, step, batch; /* batch: its step */
    const struct dependency *src;
};

struct model {
    struct access accesses[PROGRAM_STEPS];
    struct link links[MODEL_LINKS];
    struct signal signals[MODEL_SIGNALS];
    uint32_t access_count, link_count, signal_count;
    /* of a byte of an access, when a link is through */
    uint8_t reached[PROGRAM_STEPS][PROGRAM_BYTES][MODEL_LINKS];
    const struct program *program;
    const struct step *batch;
    struct findings *findings;
};

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

/* ---- dependencies */

/* The first access scope of a chain is that of its first dependency: only an access that is
 * directly in a dependency's first scope is made available by it. */
static enum reach direct_reach(const struct access *access, uint64_t byte, const struct link *link)
{
    const struct dependency *dependency = &link->barrier.dependency;
    if (access->queue != link->from_queue || access->step >= link->from_step ||
        !has_stage(dependency->src, access->is->kind))
        return NOT_REACHED;
    bool is_available = has_kind(dependency->src_kinds, access->is->kind) &&
                        barrier_holds(&link->barrier, access->is->bytes.memory, byte);
    return is_available ? AVAILABLE : ORDERED;
}

/* A chain exists if the second scope of one dependency and the first scope of the next intersect.
 */
static bool is_continued(const struct link *first, const struct link *next)
{
    return first->to_queue == next->from_queue && first->to_step < next->from_step &&
           (first->barrier.dependency.dst & next->barrier.dependency.src);
}

static enum reach reach_of(const struct model *model, uint32_t access, uint64_t byte,
                           const struct link *link)
{
    enum reach reach = direct_reach(&model->accesses[access], byte, link);
    for (uint32_t i = 0; i < model->link_count && reach < VISIBLE; i++)
        if (model->reached[access][byte][i] > reach && is_continued(&model->links[i], link))
            reach = model->reached[access][byte][i];
    if (reach && link->is_full)
        return VISIBLE;
    if (reach == ORDERED && link->barrier.is_acquisition &&
        barrier_holds(&link->barrier, model->accesses[access].is->bytes.memory, byte))
        return AVAILABLE;
    return reach;
}

/* Links are added in the order of their ends, so all that may precede one are there. */
static void add_link(struct model *model, const struct link *link)
{
    if (model->link_count == MODEL_LINKS)
        abort();
    for (uint32_t access = 0; access < model->access_count; access++)
        for (uint64_t byte = 0; byte < PROGRAM_BYTES; byte++)
            model->reached[access][byte][model->link_count] =
                (uint8_t)reach_of(model, access, byte, link);
    model->links[model->link_count++] = *link;
}

static void add_barriers(struct model *model, const struct step *step, uint32_t from_step,
                         const struct dependency *src)
{
    uint32_t here = (uint32_t)(step - model->program->steps);
    for (uint32_t i = 0; i < step->barrier_count; i++) {
        struct link link = {step->barriers[i],   false, model->batch->queue, from_step,
                            model->batch->queue, here};
        if (src)
            link.barrier.dependency.src = src->src;
        add_link(model, &link);
    }
}

/* The first step of the queue that is in none of its completed batches. */
static uint32_t completed_end(const struct model *model, uint32_t queue, uint64_t completed)
{
    uint32_t here = (uint32_t)(model->batch - model->program->steps), step = 0;
    for (; step < here; step++) {
        const struct step *batch = &model->program->steps[step];
        if (batch->type == STEP_BATCH && batch->queue == queue && batch->number > completed)
            break;
    }
    return step;
}

/* All that a queue has executed before `end` happens before this step. */
static void order_all(struct model *model, uint32_t queue, uint32_t end, const struct step *step)
{
    const uint32_t here = (uint32_t)(step - model->program->steps);
    add_link(
        model,
        &(struct link){
            {{ALL_SYNC_STAGES, ALL_SYNC_STAGES}}, true, queue, end, model->batch->queue, here});
}

static void order_everything(struct model *model, const struct step *step)
{
    for (uint32_t queue = 0; queue < PROGRAM_QUEUES; queue++)
        order_all(model, queue, (uint32_t)(step - model->program->steps), step);
}

static void begin_batch(struct model *model, const struct step *step)
{
    model->batch = step;
    if (!step->is_certain)
        order_everything(model, step);
    for (uint32_t queue = 0; queue < PROGRAM_QUEUES && step->is_certain; queue++)
        if (step->completed[queue])
            order_all(model, queue, completed_end(model, queue, step->completed[queue]), step);
}

/* ---- semaphores */

static void add_signal(struct model *model, const struct step *step, bool is_event)
{
    const struct step *steps = model->program->steps;
    model->signals[model->signal_count++] = (struct signal){is_event,
                                                            false,
                                                            step->object,
                                                            step->value,
                                                            model->batch->queue,
                                                            (uint32_t)(step - steps),
                                                            (uint32_t)(model->batch - steps),
                                                            &step->dependency};
}

/* The first scope of a signal has the signals of the queue's earlier batches (signal operation
 * order). Signals with smaller values of the semaphore happen before it, too. */
static bool is_signalled_before(const struct signal *first, const struct signal *second)
{
    return first->step < second->step && !first->is_event &&
           ((first->queue == second->queue && first->batch != second->batch) ||
            (first->object == second->object && first->value < second->value));
}

static const struct signal *find_semaphore(const struct model *model, uint64_t semaphore,
                                           uint64_t value)
{
    const struct signal *found = NULL;
    for (uint32_t i = 0; i < model->signal_count; i++) {
        const struct signal *signal = &model->signals[i];
        if (!signal->is_event && signal->object == semaphore && signal->value >= value &&
            (!found || signal->value < found->value))
            found = signal;
    }
    return value ? found : NULL;
}

/* A wait for an unknown signal may follow anything. */
static void wait_semaphore(struct model *model, const struct step *step)
{
    const struct signal *waited = find_semaphore(model, step->object, step->value);
    bool is_before[MODEL_SIGNALS] = {false};
    if (!waited)
        order_everything(model, step);
    for (uint32_t i = model->signal_count; waited && i--;) {
        const struct signal *signal = &model->signals[i];
        is_before[i] = signal == waited;
        for (uint32_t later = i + 1; later < model->signal_count; later++)
            is_before[i] |= is_before[later] && is_signalled_before(signal, &model->signals[later]);
        if (!is_before[i])
            continue;
        struct link link = {{{signal->src->src, step->dependency.dst}},
                            true,
                            signal->queue,
                            signal->step,
                            model->batch->queue,
                            (uint32_t)(step - model->program->steps)};
        add_link(model, &link);
    }
}

/* ---- events */

/* vkCmdSetEvent has no effect on an event that is set. But programs do not describe what the host
 * resets (vkResetEvent): so an event that is set twice has both first scopes. */
static void step_event(struct model *model, const struct step *step)
{
    for (uint32_t i = 0; i < model->signal_count; i++) {
        struct signal *event = &model->signals[i];
        if (!event->is_event || event->is_reset || event->object != step->object)
            continue;
        if (step->type == STEP_RESET_EVENT ||
            (step->type == STEP_SET_EVENT && event->queue != model->batch->queue))
            event->is_reset = true;
        else if (step->type == STEP_WAIT_EVENT && event->queue == model->batch->queue)
            add_barriers(model, step, event->step, event->src);
    }
    if (step->type == STEP_SET_EVENT)
        add_signal(model, step, true);
}

/* ---- accesses */

struct order {
    bool is_ordered, is_available, is_visible;
};

static struct order order_of(const struct model *model, uint32_t earlier,
                             const struct access *later, uint64_t byte)
{
    struct order order = {0};
    for (uint32_t i = 0; i < model->link_count; i++) {
        const struct link *link = &model->links[i];
        enum reach reach = model->reached[earlier][byte][i];
        if (!reach || link->to_queue != later->queue ||
            !has_stage(link->barrier.dependency.dst, later->is->kind))
            continue;
        order.is_ordered = true;
        if (reach < AVAILABLE)
            continue;
        order.is_available = true;
        if (reach == VISIBLE)
            order.is_visible = true;
        if (has_kind(link->barrier.dependency.dst_kinds, later->is->kind) &&
            barrier_holds(&link->barrier, later->is->bytes.memory, byte))
            order.is_visible = true;
    }
    return order;
}

static void compare(struct model *model, uint32_t index, const struct access *later, uint64_t byte)
{
    const struct access *earlier = &model->accesses[index];
    bool wrote = access_is_write(earlier->is->kind), writes = access_is_write(later->is->kind);
    struct order order = order_of(model, index, later, byte);
    if (earlier->is->kind == ACCESS_MARKER_WRITE && later->is->kind == ACCESS_MARKER_WRITE)
        return;
    if (wrote ? order.is_visible : order.is_ordered)
        return;
    /* Queues execute their batches in order; the host does not. */
    bool has_order =
        earlier->queue == later->queue && (later->queue || earlier->batch == model->batch->number);
    bool is_racing = !has_order && earlier->batch > model->batch->before[earlier->queue];
    struct finding finding = {
        (uint8_t)earlier->step,
        (uint8_t)later->step,
        (uint8_t)later->is->bytes.memory,
        (uint8_t)byte,
        !wrote   ? WRITE_AFTER_READ
        : writes ? WRITE_AFTER_WRITE
                 : READ_AFTER_WRITE,
        is_racing,
        order.is_ordered,
        wrote && order.is_available,
    };
    findings_add(model->findings, &finding, byte + 1);
}

/* Compares with the last write and, for a write, with the last read since then of each queue and
 * kind. Accesses of the same command are left out. */
static void find_hazards(struct model *model, const struct access *later, uint64_t byte)
{
    kind_set seen[PROGRAM_QUEUES] = {0};
    for (uint32_t i = model->access_count; i--;) {
        const struct access *earlier = &model->accesses[i];
        enum access_kind kind = earlier->is->kind;
        if (!bytes_contain(&earlier->is->bytes, later->is->bytes.memory, byte))
            continue;
        bool is_same = earlier->command == later->command;
        if (access_is_write(kind)) {
            if (!is_same)
                compare(model, i, later, byte);
            return;
        }
        if (!access_is_write(later->is->kind) || is_same || has_kind(seen[earlier->queue], kind))
            continue;
        seen[earlier->queue] |= 1u << kind;
        compare(model, i, later, byte);
    }
}

static void add_access(struct model *model, const struct step *step)
{
    uint32_t here = (uint32_t)(step - model->program->steps);
    struct access access = {&step->access, here, step->command, model->batch->queue,
                            model->batch->number};
    for (uint64_t byte = step->access.bytes.begin; byte < step->access.bytes.end; byte++)
        find_hazards(model, &access, byte);
    memset(model->reached[model->access_count], NOT_REACHED, sizeof(model->reached[0]));
    model->accesses[model->access_count++] = access;
}

static void forget_memory(struct model *model, uint64_t memory)
{
    static const struct hazard_access none = {ACCESS_BUILD_ACCEL_READ, {0, 0, 0}};
    for (uint32_t i = 0; i < model->access_count; i++)
        if (model->accesses[i].is->bytes.memory == memory)
            model->accesses[i].is = &none;
}

void model_play(const struct program *program, struct findings *findings)
{
    static struct model model;
    model.access_count = model.link_count = model.signal_count = findings->count = 0;
    model.program = program;
    model.findings = findings;
    for (uint32_t i = 0; i < program->count; i++) {
        const struct step *step = &program->steps[i];
        if (step->type == STEP_BATCH)
            begin_batch(&model, step);
        else if (step->type == STEP_WAIT)
            wait_semaphore(&model, step);
        else if (step->type == STEP_SIGNAL)
            add_signal(&model, step, false);
        else if (step->type == STEP_ACCESS)
            add_access(&model, step);
        else if (step->type == STEP_BARRIERS)
            add_barriers(&model, step, i, NULL);
        else if (step->type == STEP_FORGET_MEMORY)
            forget_memory(&model, step->object);
        else
            step_event(&model, step);
    }
    findings_sort(findings);
}
