/* SPDX-License-Identifier: Apache-2.0 */
#include "src/shaders/evaluate.h"

#include <stdlib.h>
#include <string.h>

enum {
    CALLS_MAX = 32,       /* parameters that stand for parameters */
    DEPTH_MAX = 16,       /* constants made of constants */
    VISITS_MAX = 1 << 20, /* operands; constants that share constants may have far more */
    BUILT_IN_WORKGROUPS = 24,
    BUILT_IN_WORKGROUP = 26,
    BUILT_IN_LOCAL = 27,
    BUILT_IN_GLOBAL = 28,
    BUILT_IN_LOCAL_INDEX = 29,
    BUILT_IN_LAUNCH = 5319,
    BUILT_IN_LAUNCH_SIZE = 5320,
};

/* ---- constants and inputs */

static struct value find_value(struct invocation *invocation, uint32_t id, unsigned depth);

/* Returns the number that the application specializes a constant with, or the one in the code. */
static struct value specialize(const struct invocation *invocation, uint32_t id, uint32_t number,
                               bool is_bool)
{
    const VkSpecializationInfo *info = invocation->launch->constants;
    uint32_t constant, result;
    if (!info ||
        !spirv_find_decoration(invocation->spirv, id, UINT32_MAX, SPIRV_SPEC_ID, &constant))
        return value_of_number(number);
    for (uint32_t i = 0; i < info->mapEntryCount; i++) {
        const VkSpecializationMapEntry *entry = &info->pMapEntries[i];
        if (entry->constantID != constant)
            continue;
        if (entry->size != sizeof(result) || entry->offset > info->dataSize ||
            info->dataSize - entry->offset < sizeof(result))
            return (struct value){0};
        memcpy(&result, (const char *)info->pData + entry->offset, sizeof(result));
        return value_of_number(is_bool ? result != 0 : result);
    }
    return value_of_number(number);
}

static struct value compose(struct invocation *invocation, const struct spirv_instruction *from,
                            unsigned depth)
{
    struct value result = {.known = 0};
    for (uint32_t i = 0; i < VALUE_PARTS && i + 2 < from->count; i++) {
        const struct value part = find_value(invocation, from->operands[i + 2], depth);
        if (from->count > VALUE_PARTS + 2)
            break;
        result.parts[i] = part.parts[0];
        result.known |= (unsigned char)((part.known & 1) << i);
        result.positive |= (unsigned char)((part.positive & 1) << i);
    }
    return result;
}

/* A vector may be composed of vectors. */
static bool composes_scalars(struct invocation *invocation, const struct spirv_instruction *from)
{
    struct spirv_instruction part, type;
    for (uint32_t i = 2; i < from->count; i++)
        if (!spirv_define(invocation->spirv, from->operands[i], &part) ||
            spirv_define(invocation->spirv, spirv_operand(&part, 0), &type) == SPIRV_TYPE_VECTOR)
            return false;
    return true;
}

/* Computes an instruction whose operands begin with the one of that index. */
static struct value compute(struct invocation *invocation, uint32_t op,
                            const struct spirv_instruction *from, uint32_t first, unsigned depth)
{
    struct value operands[3];
    uint32_t count = 0;
    if (op == SPIRV_COMPOSITE_EXTRACT) {
        const struct value whole = find_value(invocation, spirv_operand(from, first), depth);
        return from->count == first + 2 ? value_part(&whole, from->operands[first + 1])
                                        : (struct value){0};
    }
    for (uint32_t i = first; i < from->count && count < 3; i++)
        operands[count++] = find_value(invocation, from->operands[i], depth);
    return from->count <= first + 3 ? value_compute(op, operands, count) : (struct value){0};
}

/* Returns the value of a constant, or the last one of another id. */
static struct value find_value(struct invocation *invocation, uint32_t id, unsigned depth)
{
    struct spirv_instruction from, type;
    const uint32_t op = spirv_define(invocation->spirv, id, &from);
    if (!op || depth == 0 || invocation->visits++ >= VISITS_MAX)
        return (struct value){0};
    switch (op) {
    case SPIRV_CONSTANT_TRUE:
    case SPIRV_CONSTANT_FALSE:
        return value_of_number(op == SPIRV_CONSTANT_TRUE);
    case SPIRV_CONSTANT_NULL:
        return value_of_number(0);
    case SPIRV_SPEC_CONSTANT_TRUE:
    case SPIRV_SPEC_CONSTANT_FALSE:
        return specialize(invocation, id, op == SPIRV_SPEC_CONSTANT_TRUE, true);
    case SPIRV_CONSTANT:
    case SPIRV_SPEC_CONSTANT:
        spirv_define(invocation->spirv, from.operands[0], &type);
        if (spirv_operand(&type, 1) != 32 || from.count != 3)
            return (struct value){0};
        return op == SPIRV_CONSTANT ? value_of_number(from.operands[2])
                                    : specialize(invocation, id, from.operands[2], false);
    case SPIRV_CONSTANT_COMPOSITE:
    case SPIRV_SPEC_CONSTANT_COMPOSITE:
        return compose(invocation, &from, depth - 1);
    case SPIRV_SPEC_CONSTANT_OP:
        return compute(invocation, spirv_operand(&from, 2), &from, 3, depth - 1);
    default:
        return invocation->values[id];
    }
}

struct value invocation_value(struct invocation *invocation, uint32_t id)
{
    return find_value(invocation, id, DEPTH_MAX);
}

/* Returns what the first invocation finds in a built-in variable. */
static struct value built_in(const struct invocation *invocation, uint32_t number)
{
    const struct shader_launch *launch = invocation->launch;
    struct value result = {.known = 0};
    switch (number) {
    case BUILT_IN_WORKGROUPS:
    case BUILT_IN_LAUNCH_SIZE:
        for (unsigned i = 0; i < 3; i++) {
            result.parts[i] = launch->size[i];
            result.known |= (unsigned char)((launch->size[i] != 0) << i);
            result.positive |= (unsigned char)((launch->size[i] == 0) << i);
        }
        return result;
    case BUILT_IN_WORKGROUP:
        memcpy(result.parts, launch->base, sizeof(launch->base));
        result.known = 7;
        return result;
    case BUILT_IN_GLOBAL:
        for (unsigned i = 0; i < 3; i++)
            result.known |= (unsigned char)(!launch->base[i] << i);
        return result;
    case BUILT_IN_LOCAL:
    case BUILT_IN_LOCAL_INDEX:
    case BUILT_IN_LAUNCH:
        return value_of_number(0);
    default:
        return result;
    }
}

/* Returns the number of 32-bit parts of a scalar or vector; 0: the type is another one. Damaged
 * code may have a vector of itself. */
static uint32_t count_parts(const struct spirv *spirv, uint32_t type)
{
    struct spirv_instruction definition;
    uint32_t op = spirv_define(spirv, type, &definition), count = 1;
    if (op == SPIRV_TYPE_VECTOR) {
        count = spirv_operand(&definition, 2);
        op = spirv_define(spirv, spirv_operand(&definition, 1), &definition);
    }
    const bool is_part =
        op == SPIRV_TYPE_BOOL ||
        ((op == SPIRV_TYPE_INT || op == SPIRV_TYPE_FLOAT) && spirv_operand(&definition, 1) == 32);
    return is_part ? count : 0;
}

/* Steps from a type into its member, element or part: adds the offset of that in bytes. Returns the
 * type of it; 0: unknown. */
static uint32_t step_into(const struct spirv *spirv, uint32_t type, uint32_t index,
                          uint32_t *offset)
{
    struct spirv_instruction definition;
    uint32_t step = 0;
    switch (spirv_define(spirv, type, &definition)) {
    case SPIRV_TYPE_STRUCT:
        if (!spirv_find_decoration(spirv, type, index, SPIRV_OFFSET, &step))
            return 0;
        *offset += step;
        return spirv_operand(&definition, 1 + index);
    case SPIRV_TYPE_ARRAY:
        if (!spirv_find_decoration(spirv, type, UINT32_MAX, SPIRV_ARRAY_STRIDE, &step))
            return 0;
        *offset += step * index;
        return spirv_operand(&definition, 1);
    case SPIRV_TYPE_VECTOR:
        *offset += (uint32_t)sizeof(uint32_t) * index;
        return spirv_operand(&definition, 1);
    default:
        return 0;
    }
}

/* Loads push constants. `chain`: an access chain, or the variable itself. */
static struct value load_pushed(struct invocation *invocation,
                                const struct spirv_instruction *chain, uint32_t type)
{
    const struct pushed_constants *pushed = invocation->launch->pushed;
    struct spirv_instruction variable, pointer;
    struct value result = {.known = 0};
    uint32_t offset = 0;
    if (!pushed || chain->op == SPIRV_VARIABLE ||
        spirv_define(invocation->spirv, spirv_operand(chain, 2), &variable) != SPIRV_VARIABLE)
        return result;
    spirv_define(invocation->spirv, spirv_operand(&variable, 0), &pointer);
    uint32_t inner = spirv_operand(&pointer, 2);
    for (uint32_t i = 3; i < chain->count && inner; i++) {
        const struct value at = invocation_value(invocation, chain->operands[i]);
        uint32_t index;
        inner =
            value_is_known(&at, &index) ? step_into(invocation->spirv, inner, index, &offset) : 0;
    }
    const uint32_t count = inner == type ? count_parts(invocation->spirv, type) : 0;
    for (uint32_t i = 0; i < count && i < VALUE_PARTS; i++) {
        const uint32_t word = offset / 4 + i;
        if (word >= PUSHED_BYTES / 4 || !(pushed->known >> word & 1))
            continue;
        result.parts[i] = pushed->words[word];
        result.known |= (unsigned char)(1 << i);
    }
    return result;
}

/* ---- variables */

uint32_t invocation_variable(const struct invocation *invocation, uint32_t pointer)
{
    struct spirv_instruction instruction;
    uint32_t root = spirv_find_root(invocation->spirv, pointer);
    for (unsigned i = 0; i < CALLS_MAX && root; i++) {
        if (spirv_define(invocation->spirv, root, &instruction) == SPIRV_VARIABLE)
            return root;
        root = spirv_find_root(invocation->spirv, invocation->arguments[root]);
    }
    return 0;
}

static void forget_variable(struct invocation *invocation, uint32_t pointer)
{
    const uint32_t class = spirv_class(invocation->spirv, pointer);
    const bool is_variable = class == SPIRV_CLASS_FUNCTION || class == SPIRV_CLASS_PRIVATE;
    const uint32_t variable = is_variable ? invocation_variable(invocation, pointer) : 0;
    if (variable)
        invocation->values[variable] = (struct value){0};
}

void invocation_forget_variables(struct invocation *invocation)
{
    struct spirv_instruction instruction;
    for (uint32_t id = 0; id < invocation->spirv->bound; id++)
        if (spirv_define(invocation->spirv, id, &instruction) == SPIRV_VARIABLE)
            invocation->values[id] = (struct value){0};
}

/* Finds which part of a variable a pointer leads to. VALUE_PARTS: the whole one. Returns false if
 * that is unknown. */
static bool find_part(struct invocation *invocation, uint32_t pointer, uint32_t *part)
{
    struct spirv_instruction from, type;
    struct value index;
    switch (spirv_define(invocation->spirv, pointer, &from)) {
    case SPIRV_VARIABLE:
        *part = VALUE_PARTS;
        return true;
    case SPIRV_FUNCTION_PARAMETER:
        return invocation->arguments[pointer] != pointer &&
               spirv_define(invocation->spirv, invocation->arguments[pointer], &type) ==
                   SPIRV_VARIABLE &&
               find_part(invocation, invocation->arguments[pointer], part);
    case SPIRV_ACCESS_CHAIN:
    case SPIRV_IN_BOUNDS_ACCESS_CHAIN:
        index = invocation_value(invocation, spirv_operand(&from, 3));
        return from.count == 4 && find_part(invocation, from.operands[2], part) &&
               *part == VALUE_PARTS && value_is_known(&index, part) && *part < VALUE_PARTS;
    default:
        return false;
    }
}

/* Whether a variable is one whose value is kept: a scalar or a vector. */
static bool is_kept(const struct spirv *spirv, uint32_t variable)
{
    struct spirv_instruction from, pointer;
    spirv_define(spirv, variable, &from);
    spirv_define(spirv, spirv_operand(&from, 0), &pointer);
    const uint32_t count = count_parts(spirv, spirv_operand(&pointer, 2));
    return count && count <= VALUE_PARTS;
}

static struct value load(struct invocation *invocation, const struct spirv_instruction *instruction)
{
    const uint32_t pointer = spirv_operand(instruction, 2);
    const uint32_t variable = invocation_variable(invocation, pointer);
    struct spirv_instruction chain;
    struct value value = {.known = 0};
    uint32_t number, part;
    switch (variable ? spirv_class(invocation->spirv, variable) : UINT32_MAX) {
    case SPIRV_CLASS_PUSH_CONSTANT:
        spirv_define(invocation->spirv, pointer, &chain);
        return load_pushed(invocation, &chain, spirv_operand(instruction, 0));
    case SPIRV_CLASS_INPUT:
        if (!spirv_find_decoration(invocation->spirv, variable, UINT32_MAX, SPIRV_BUILT_IN,
                                   &number))
            return value;
        value = built_in(invocation, number);
        break;
    case SPIRV_CLASS_PRIVATE:
    case SPIRV_CLASS_FUNCTION:
        value = invocation->values[variable];
        break;
    default:
        return value;
    }
    if (!is_kept(invocation->spirv, variable) || !find_part(invocation, pointer, &part))
        return (struct value){0};
    return part == VALUE_PARTS ? value : value_part(&value, part);
}

static void store(struct invocation *invocation, uint32_t pointer, const struct value *value)
{
    const uint32_t variable = invocation_variable(invocation, pointer);
    uint32_t part;
    if (!variable)
        return;
    if (!is_kept(invocation->spirv, variable) || !find_part(invocation, pointer, &part)) {
        invocation->values[variable] = (struct value){0};
        return;
    }
    if (part == VALUE_PARTS) {
        invocation->values[variable] = *value;
        return;
    }
    struct value *kept = &invocation->values[variable];
    const unsigned char bit = (unsigned char)(1 << part);
    kept->parts[part] = value->parts[0];
    kept->known = (unsigned char)((kept->known & ~bit) | (value->known & 1 ? bit : 0));
    kept->positive = (unsigned char)((kept->positive & ~bit) | (value->positive & 1 ? bit : 0));
}

/* ---- instructions */

bool invocation_defines(const struct invocation *invocation,
                        const struct spirv_instruction *instruction)
{
    const uint32_t result = spirv_operand(instruction, 1);
    return result && result < invocation->spirv->bound &&
           invocation->spirv->places[result] == instruction->place;
}

void invocation_forget(struct invocation *invocation, const struct spirv_instruction *instruction)
{
    if (invocation_defines(invocation, instruction) && instruction->op != SPIRV_VARIABLE)
        invocation->values[instruction->operands[1]] = (struct value){0};
    if (instruction->op == SPIRV_FUNCTION_CALL)
        invocation_forget_variables(invocation);
    for (uint32_t i = 0; !spirv_only_reads(instruction->op) && i < instruction->count; i++)
        forget_variable(invocation, instruction->operands[i]);
}

static void initialize(struct invocation *invocation, const struct spirv_instruction *variable)
{
    invocation->values[variable->operands[1]] =
        variable->count > 3 ? invocation_value(invocation, variable->operands[3])
                            : (struct value){0};
}

/* Returns how many parts the value of an id has. */
static uint32_t parts_of(const struct invocation *invocation, uint32_t id)
{
    struct spirv_instruction from;
    return spirv_define(invocation->spirv, id, &from)
               ? count_parts(invocation->spirv, spirv_operand(&from, 0))
               : 0;
}

/* OpAny and OpAll. */
static struct value gather(struct invocation *invocation,
                           const struct spirv_instruction *instruction)
{
    const uint32_t decides = instruction->op == SPIRV_ANY;
    const uint32_t vector = spirv_operand(instruction, 2), count = parts_of(invocation, vector);
    const struct value from = invocation_value(invocation, vector);
    bool is_known = count && count <= VALUE_PARTS;
    for (uint32_t i = 0; i < count && i < VALUE_PARTS; i++) {
        if (from.known >> i & 1 && from.parts[i] == decides)
            return value_of_number(decides);
        is_known &= from.known >> i & 1;
    }
    return is_known ? value_of_number(!decides) : (struct value){0};
}

static struct value shuffle(struct invocation *invocation,
                            const struct spirv_instruction *instruction)
{
    const struct value from[2] = {invocation_value(invocation, spirv_operand(instruction, 2)),
                                  invocation_value(invocation, spirv_operand(instruction, 3))};
    const uint32_t count = parts_of(invocation, spirv_operand(instruction, 2));
    struct value result = {.known = 0};
    for (uint32_t i = 0; i < VALUE_PARTS && i + 4 < instruction->count; i++) {
        const uint32_t index = instruction->operands[i + 4];
        const struct value part =
            index < count ? value_part(&from[0], index) : value_part(&from[1], index - count);
        result.parts[i] = part.parts[0];
        result.known |= (unsigned char)((part.known & 1) << i);
        result.positive |= (unsigned char)((part.positive & 1) << i);
    }
    return result;
}

/* Returns the value that an instruction defines. */
static struct value evaluate(struct invocation *invocation,
                             const struct spirv_instruction *instruction)
{
    switch (instruction->op) {
    case SPIRV_LOAD:
        return load(invocation, instruction);
    case SPIRV_IMAGE_QUERY_SIZE:
    case SPIRV_IMAGE_QUERY_SIZE_LOD:
        return value_positive();
    case SPIRV_COMPOSITE_CONSTRUCT:
        return composes_scalars(invocation, instruction)
                   ? compose(invocation, instruction, DEPTH_MAX)
                   : (struct value){0};
    case SPIRV_ANY:
    case SPIRV_ALL:
        return gather(invocation, instruction);
    case SPIRV_VECTOR_SHUFFLE:
        return shuffle(invocation, instruction);
    default:
        return compute(invocation, instruction->op, instruction, 2, DEPTH_MAX);
    }
}

void invocation_execute(struct invocation *invocation, const struct spirv_instruction *instruction)
{
    const uint32_t result = spirv_operand(instruction, 1);
    struct value value = {.known = 0};
    if (instruction->op == SPIRV_PHI || instruction->op == SPIRV_LABEL)
        return;
    if (instruction->op == SPIRV_STORE) {
        value = invocation_value(invocation, result);
        store(invocation, spirv_operand(instruction, 0), &value);
        return;
    }
    if (!invocation_defines(invocation, instruction)) {
        invocation_forget(invocation, instruction);
        return;
    }
    if (instruction->op == SPIRV_VARIABLE) {
        initialize(invocation, instruction);
        return;
    }
    if (count_parts(invocation->spirv, spirv_operand(instruction, 0)))
        value = evaluate(invocation, instruction);
    invocation_forget(invocation, instruction);
    invocation->values[result] = value;
}

void invocation_end(struct invocation *invocation)
{
    free(invocation->values);
    free(invocation->arguments);
}

bool invocation_begin(struct invocation *invocation, const struct spirv *spirv,
                      const struct shader_launch *launch)
{
    struct spirv_instruction variable;
    *invocation = (struct invocation){.spirv = spirv,
                                      .launch = launch,
                                      .values = calloc(spirv->bound, sizeof(struct value)),
                                      .arguments = calloc(spirv->bound, sizeof(uint32_t))};
    if (!invocation->values || !invocation->arguments) {
        invocation_end(invocation);
        return false;
    }
    for (uint32_t id = 0; id < spirv->bound; id++)
        if (spirv_define(spirv, id, &variable) == SPIRV_VARIABLE &&
            spirv_class(spirv, id) == SPIRV_CLASS_PRIVATE)
            initialize(invocation, &variable);
    return true;
}
