/* SPDX-License-Identifier: Apache-2.0 */
#include "src/shaders/paths.h"

#include <stdlib.h>

#include "src/shaders/evaluate.h"

enum {
    STEPS_MAX = 1 << 17, /* instructions that one walk reads */
    CALLS_MAX = 32,      /* functions that call each other */
    LOOPS_MAX = 32,      /* loops around an instruction */
};

struct walk {
    struct invocation invocation;
    uint32_t *visited; /* by id of a label: the last region that has the block */
    uint32_t *waiting; /* blocks of the region that are yet to be read */
    uint32_t region;   /* number of the last region */
    uint32_t steps;
    unsigned calls;
    uint32_t structure; /* that the trace reads, by id; 0: unknown */
};

/* How a path ends. */
enum path_end { PATH_RETURNS, PATH_TRACES, PATH_IS_UNKNOWN };

/* ---- regions: blocks that are left together */

static uint32_t label_of(const struct spirv *spirv, uint32_t block, size_t *place)
{
    struct spirv_instruction label;
    const uint32_t op = spirv_define(spirv, block, &label);
    *place = label.next;
    return op == SPIRV_LABEL ? block : 0;
}

static void wait_for(struct walk *walk, uint32_t block, uint32_t *count)
{
    if (block >= walk->invocation.spirv->bound || walk->visited[block] == walk->region)
        return;
    walk->visited[block] = walk->region;
    walk->waiting[(*count)++] = block;
}

/* Adds the blocks behind the last instruction of a block. Returns false if it ends the function. */
static bool wait_for_next(struct walk *walk, const struct spirv_instruction *last, uint32_t *count)
{
    switch (last->op) {
    case SPIRV_BRANCH:
        wait_for(walk, spirv_operand(last, 0), count);
        return true;
    case SPIRV_BRANCH_CONDITIONAL:
        wait_for(walk, spirv_operand(last, 1), count);
        wait_for(walk, spirv_operand(last, 2), count);
        return true;
    case SPIRV_SWITCH:
        for (uint32_t i = 1; i < last->count; i += 2)
            wait_for(walk, last->operands[i], count);
        return true;
    case SPIRV_UNREACHABLE:
        return true;
    default:
        return false;
    }
}

static bool ends_block(uint32_t op)
{
    return (op >= SPIRV_BRANCH && op <= SPIRV_UNREACHABLE) || op == SPIRV_TERMINATE_INVOCATION ||
           op == SPIRV_IGNORE_INTERSECTION || op == SPIRV_TERMINATE_RAY ||
           op == SPIRV_EMIT_MESH_TASKS || op == SPIRV_FUNCTION_END;
}

/* Reads a block of a region up to a trace. Returns false if the function may end in it. */
static bool read_block(struct walk *walk, uint32_t block, uint32_t *count)
{
    struct spirv_instruction instruction;
    uint32_t structure;
    size_t place;
    if (!label_of(walk->invocation.spirv, block, &place))
        return false;
    for (; spirv_read(walk->invocation.spirv, place, &instruction); place = instruction.next) {
        if (walk->steps++ > STEPS_MAX)
            return false;
        if (spirv_traces(&instruction, &structure))
            return true;
        if (instruction.op == SPIRV_FUNCTION_CALL && walk->invocation.spirv->ends_anywhere)
            return false;
        invocation_forget(&walk->invocation, &instruction);
        if (ends_block(instruction.op))
            return wait_for_next(walk, &instruction, count);
    }
    return false;
}

/* Takes all paths from a branch to its merge block. Returns PATH_RETURNS if they get there, some by
 * a trace perhaps, PATH_TRACES if none gets there without one. */
static enum path_end leave_region(struct walk *walk, const struct spirv_instruction *branch,
                                  uint32_t merge)
{
    uint32_t count = 0;
    if (!merge || merge >= walk->invocation.spirv->bound)
        return PATH_IS_UNKNOWN;
    walk->region++;
    wait_for_next(walk, branch, &count);
    bool is_reached = false;
    while (count) {
        const uint32_t next = walk->waiting[--count];
        if (next == merge)
            is_reached = true;
        else if (!read_block(walk, next, &count))
            return PATH_IS_UNKNOWN;
    }
    walk->structure = 0;
    return is_reached ? PATH_RETURNS : PATH_TRACES;
}

/* ---- one path */

struct path {
    uint32_t block, previous; /* previous: 0: unknown */
    uint32_t selection_merge; /* of the current block; 0: none */
    /* Merge blocks of the loops around, from the outermost one. */
    uint32_t loops[LOOPS_MAX];
    uint32_t loop_count;
};

static void enter_block(struct path *path, uint32_t block)
{
    path->previous = path->block;
    path->block = block;
    path->selection_merge = 0;
    for (uint32_t i = 0; i < path->loop_count; i++)
        if (path->loops[i] == block)
            path->loop_count = i;
}

static void enter_loop(struct path *path, uint32_t merge)
{
    for (uint32_t i = 0; i < path->loop_count; i++)
        if (path->loops[i] == merge)
            return;
    if (path->loop_count < LOOPS_MAX)
        path->loops[path->loop_count++] = merge;
}

/* Continues behind a condition that is unknown: where both sides meet again. */
static enum path_end take_all(struct walk *walk, struct path *path,
                              const struct spirv_instruction *branch)
{
    enum path_end end = leave_region(walk, branch, path->selection_merge);
    uint32_t merge = path->selection_merge;
    for (uint32_t i = path->loop_count; end == PATH_IS_UNKNOWN && i-- > 0;) {
        merge = path->loops[i];
        end = leave_region(walk, branch, merge);
    }
    if (end != PATH_RETURNS)
        return end;
    enter_block(path, merge);
    path->previous = 0;
    return PATH_RETURNS;
}

/* Finds where a branch leads. Returns 0 if that is unknown. */
static uint32_t find_target(struct walk *walk, const struct spirv_instruction *branch)
{
    uint32_t number;
    if (branch->op == SPIRV_BRANCH)
        return spirv_operand(branch, 0);
    const struct value condition = invocation_value(&walk->invocation, spirv_operand(branch, 0));
    if (!value_is_known(&condition, &number))
        return 0;
    if (branch->op == SPIRV_BRANCH_CONDITIONAL)
        return spirv_operand(branch, number ? 1 : 2);
    for (uint32_t i = 2; i + 1 < branch->count; i += 2)
        if (branch->operands[i] == number)
            return branch->operands[i + 1];
    return spirv_operand(branch, 1);
}

/* Chooses the values of all OpPhi of a block at once: they may read each other. */
static void choose_values(struct walk *walk, const struct path *path, size_t place)
{
    enum { PHI_MAX = 32 };
    struct value chosen[PHI_MAX];
    uint32_t results[PHI_MAX], count = 0;
    struct spirv_instruction phi;
    for (; spirv_read(walk->invocation.spirv, place, &phi) && phi.op == SPIRV_PHI;
         place = phi.next) {
        struct value value = {.known = 0};
        for (uint32_t i = 2; path->previous && i + 1 < phi.count; i += 2)
            if (phi.operands[i + 1] == path->previous)
                value = invocation_value(&walk->invocation, phi.operands[i]);
        const uint32_t result = spirv_operand(&phi, 1);
        if (result < walk->invocation.spirv->bound && count < PHI_MAX) {
            results[count] = result;
            chosen[count++] = value;
        } else if (result < walk->invocation.spirv->bound) {
            walk->invocation.values[result] = (struct value){0};
        }
    }
    for (uint32_t i = 0; i < count; i++)
        walk->invocation.values[results[i]] = chosen[i];
}

static enum path_end follow_function(struct walk *walk, uint32_t function, struct value *result);

static enum path_end follow_call(struct walk *walk, const struct spirv_instruction *call)
{
    struct spirv_instruction from;
    const uint32_t function = spirv_operand(call, 2);
    struct value result = {.known = 0};
    enum path_end end = PATH_IS_UNKNOWN;
    spirv_define(walk->invocation.spirv, function, &from);
    for (uint32_t i = 3; i < call->count && from.op; i++) {
        const uint32_t argument = call->operands[i];
        spirv_read(walk->invocation.spirv, from.next, &from);
        const uint32_t parameter = spirv_operand(&from, 1);
        if (from.op != SPIRV_FUNCTION_PARAMETER || parameter >= walk->invocation.spirv->bound)
            return PATH_IS_UNKNOWN;
        walk->invocation.arguments[parameter] = argument;
        walk->invocation.values[parameter] = invocation_value(&walk->invocation, argument);
    }
    if (walk->calls++ < CALLS_MAX)
        end = follow_function(walk, function, &result);
    walk->calls--;
    /* It returns, unless something in the module may end the invocation. */
    if (end == PATH_IS_UNKNOWN && !walk->invocation.spirv->ends_anywhere) {
        invocation_forget_variables(&walk->invocation);
        result = (struct value){0};
        end = PATH_RETURNS;
    }
    if (invocation_defines(&walk->invocation, call))
        walk->invocation.values[call->operands[1]] = result;
    return end;
}

/* Follows a block to its last instruction. Returns whether that is a branch. */
static bool follow_block(struct walk *walk, struct path *path, struct spirv_instruction *last,
                         enum path_end *end)
{
    size_t place;
    *end = PATH_IS_UNKNOWN;
    if (!label_of(walk->invocation.spirv, path->block, &place))
        return false;
    choose_values(walk, path, place);
    for (; spirv_read(walk->invocation.spirv, place, last) && walk->steps++ < STEPS_MAX;
         place = last->next) {
        if (spirv_traces(last, &walk->structure)) {
            *end = PATH_TRACES;
            return false;
        }
        if (last->op == SPIRV_FUNCTION_CALL) {
            *end = follow_call(walk, last);
            if (*end != PATH_RETURNS)
                return false;
        } else if (last->op == SPIRV_SELECTION_MERGE) {
            path->selection_merge = spirv_operand(last, 0);
        } else if (last->op == SPIRV_LOOP_MERGE) {
            enter_loop(path, spirv_operand(last, 0));
        } else if (ends_block(last->op)) {
            *end = PATH_IS_UNKNOWN;
            return last->op == SPIRV_BRANCH || last->op == SPIRV_BRANCH_CONDITIONAL ||
                   last->op == SPIRV_SWITCH;
        } else {
            invocation_execute(&walk->invocation, last);
        }
    }
    *end = PATH_IS_UNKNOWN;
    return false;
}

/* The first block follows the parameters. */
static enum path_end follow_function(struct walk *walk, uint32_t function, struct value *result)
{
    struct path path = {.block = 0};
    struct spirv_instruction last;
    enum path_end end;
    if (spirv_define(walk->invocation.spirv, function, &last) != SPIRV_FUNCTION)
        return PATH_IS_UNKNOWN;
    while (spirv_read(walk->invocation.spirv, last.next, &last) &&
           last.op == SPIRV_FUNCTION_PARAMETER)
        continue;
    enter_block(&path, spirv_operand(&last, 0));
    while (follow_block(walk, &path, &last, &end)) {
        const uint32_t target = find_target(walk, &last);
        if (target)
            enter_block(&path, target);
        else if ((end = take_all(walk, &path, &last)) != PATH_RETURNS)
            return end;
    }
    if (end != PATH_IS_UNKNOWN || (last.op != SPIRV_RETURN && last.op != SPIRV_RETURN_VALUE))
        return end;
    if (last.op == SPIRV_RETURN_VALUE)
        *result = invocation_value(&walk->invocation, spirv_operand(&last, 0));
    return PATH_RETURNS;
}

/* ---- the result */

static void find_descriptor(struct walk *walk, struct traced_descriptor *traced)
{
    struct spirv_instruction load, chain;
    struct value index = value_of_number(0);
    *traced = (struct traced_descriptor){.is_known = false};
    if (spirv_define(walk->invocation.spirv, walk->structure, &load) != SPIRV_LOAD)
        return;
    uint32_t pointer = spirv_operand(&load, 2);
    const uint32_t variable = invocation_variable(&walk->invocation, pointer);
    uint32_t op = spirv_define(walk->invocation.spirv, pointer, &chain);
    for (unsigned i = 0; i < CALLS_MAX && op == SPIRV_FUNCTION_PARAMETER; i++) {
        pointer = walk->invocation.arguments[pointer];
        op = spirv_define(walk->invocation.spirv, pointer, &chain);
    }
    if (op == SPIRV_ACCESS_CHAIN || op == SPIRV_IN_BOUNDS_ACCESS_CHAIN)
        index = invocation_value(&walk->invocation, spirv_operand(&chain, 3));
    traced->is_known =
        variable && value_is_known(&index, &traced->element) &&
        (op == SPIRV_VARIABLE || (chain.count == 4 && chain.operands[2] == variable)) &&
        spirv_find_decoration(walk->invocation.spirv, variable, UINT32_MAX, SPIRV_DESCRIPTOR_SET,
                              &traced->set) &&
        spirv_find_decoration(walk->invocation.spirv, variable, UINT32_MAX, SPIRV_BINDING,
                              &traced->binding);
}

bool shader_certainly_traces(const struct spirv *spirv, uint32_t function,
                             const struct shader_launch *launch, struct traced_descriptor *traced)
{
    struct walk walk = {.visited = calloc(spirv->bound, sizeof(uint32_t)),
                        .waiting = calloc(spirv->bound, sizeof(uint32_t))};
    struct value result;
    bool traces = false;
    if (walk.visited && walk.waiting && invocation_begin(&walk.invocation, spirv, launch)) {
        traces = follow_function(&walk, function, &result) == PATH_TRACES;
        if (traces)
            find_descriptor(&walk, traced);
        invocation_end(&walk.invocation);
    }
    free(walk.visited);
    free(walk.waiting);
    return traces;
}
