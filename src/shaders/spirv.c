/* SPDX-License-Identifier: Apache-2.0 */
#include "src/shaders/spirv.h"

#include <stdlib.h>
#include <string.h>

#include "src/base/readable.h"

enum {
    MAGIC = 0x07230203,
    HEADER_WORDS = 5,
    BOUND_MAX = 1 << 22, /* the least limit of SPIR-V, 2.17 Universal Limits */
    CHAIN_MAX = 64,      /* access chains that continue each other */
    CAPABILITY_UNTYPED_POINTERS = 4473,
    DIM_BUFFER = 5,
    SAMPLED_STORAGE = 2,
};

bool spirv_read(const struct spirv *spirv, size_t place, struct spirv_instruction *instruction)
{
    const size_t length = place < spirv->words ? spirv->code[place] >> 16 : 0;
    if (!length || length > spirv->words - place)
        return false;
    *instruction = (struct spirv_instruction){.op = spirv->code[place] & 0xffff,
                                              .count = (uint32_t)length - 1,
                                              .operands = &spirv->code[place + 1],
                                              .place = place,
                                              .next = place + length};
    return true;
}

uint32_t spirv_define(const struct spirv *spirv, uint32_t id, struct spirv_instruction *instruction)
{
    const bool is_defined =
        id < spirv->bound && spirv->places[id] && spirv_read(spirv, spirv->places[id], instruction);
    if (!is_defined)
        *instruction = (struct spirv_instruction){0};
    return instruction->op;
}

static bool defines_type(uint32_t op)
{
    return (op >= SPIRV_TYPE_VOID && op <= SPIRV_TYPE_PIPE) || op == SPIRV_TYPE_RAY_QUERY ||
           op == SPIRV_TYPE_STRUCTURE;
}

/* Returns the id that an instruction defines; 0: none. The first operand of all others that define
 * one is a type, and no other instruction behind the types has a type as its first operand. */
static uint32_t find_result(const struct spirv *spirv, const struct spirv_instruction *instruction)
{
    struct spirv_instruction type;
    if (defines_type(instruction->op) || instruction->op == SPIRV_LABEL)
        return spirv_operand(instruction, 0);
    if (instruction->count < 2 ||
        !defines_type(spirv_define(spirv, instruction->operands[0], &type)))
        return 0;
    return instruction->operands[1];
}

static void note_instruction(struct spirv *spirv, const struct spirv_instruction *instruction)
{
    const uint32_t result = find_result(spirv, instruction);
    if (result && result < spirv->bound && !spirv->places[result])
        spirv->places[result] = (uint32_t)instruction->place;
    switch (instruction->op) {
    case SPIRV_KILL:
    case SPIRV_TERMINATE_INVOCATION:
    case SPIRV_IGNORE_INTERSECTION:
    case SPIRV_TERMINATE_RAY:
    case SPIRV_IGNORE_INTERSECTION_NV:
    case SPIRV_TERMINATE_RAY_NV:
    case SPIRV_EMIT_MESH_TASKS:
        spirv->ends_anywhere = true;
        break;
    case SPIRV_TYPE_IMAGE:
        spirv->has_texel_stores |= spirv_operand(instruction, 2) == DIM_BUFFER &&
                                   spirv_operand(instruction, 6) == SAMPLED_STORAGE;
        break;
    case SPIRV_CAPABILITY:
        spirv->has_untyped_pointers |= spirv_operand(instruction, 0) == CAPABILITY_UNTYPED_POINTERS;
        break;
    default:
        break;
    }
}

bool spirv_open(struct spirv *spirv, const uint32_t *code, size_t size)
{
    struct spirv_instruction instruction;
    size_t place = HEADER_WORDS;
    *spirv = (struct spirv){.code = code, .words = size / sizeof(*code)};
    if (spirv->words < HEADER_WORDS || spirv->words > UINT32_MAX ||
        !readable(readable_cache_of_thread(), code, size) || code[0] != MAGIC || !code[3] ||
        code[3] > BOUND_MAX)
        return false;
    spirv->bound = code[3];
    spirv->places = calloc(spirv->bound, sizeof(*spirv->places));
    for (; spirv->places && spirv_read(spirv, place, &instruction); place = instruction.next)
        note_instruction(spirv, &instruction);
    if (spirv->places && place == spirv->words)
        return true;
    spirv_close(spirv);
    return false;
}

void spirv_close(struct spirv *spirv)
{
    free(spirv->places);
    spirv->places = NULL;
}

/* Decorations stand before types, which stand before functions. */
bool spirv_find_decoration(const struct spirv *spirv, uint32_t id, uint32_t member,
                           uint32_t decoration, uint32_t *literal)
{
    const uint32_t skipped = member == UINT32_MAX ? 0 : 1;
    const uint32_t op = skipped ? SPIRV_MEMBER_DECORATE : SPIRV_DECORATE;
    struct spirv_instruction instruction;
    for (size_t place = HEADER_WORDS;
         spirv_read(spirv, place, &instruction) && !defines_type(instruction.op);
         place = instruction.next)
        if (instruction.op == op && spirv_operand(&instruction, 0) == id &&
            (!skipped || spirv_operand(&instruction, 1) == member) &&
            spirv_operand(&instruction, 1 + skipped) == decoration) {
            *literal = spirv_operand(&instruction, 2 + skipped);
            return true;
        }
    return false;
}

uint32_t spirv_find_root(const struct spirv *spirv, uint32_t pointer)
{
    struct spirv_instruction instruction;
    for (unsigned i = 0; i < CHAIN_MAX; i++)
        switch (spirv_define(spirv, pointer, &instruction)) {
        case SPIRV_VARIABLE:
        case SPIRV_FUNCTION_PARAMETER:
            return pointer;
        case SPIRV_ACCESS_CHAIN:
        case SPIRV_IN_BOUNDS_ACCESS_CHAIN:
        case SPIRV_PTR_ACCESS_CHAIN:
        case SPIRV_IN_BOUNDS_PTR_ACCESS_CHAIN:
        case SPIRV_COPY_OBJECT:
            pointer = spirv_operand(&instruction, 2);
            break;
        default:
            return 0;
        }
    return 0;
}

uint32_t spirv_class(const struct spirv *spirv, uint32_t id)
{
    struct spirv_instruction instruction, type;
    const uint32_t op = spirv_define(spirv, id, &instruction);
    if (!op || defines_type(op) || op == SPIRV_LABEL ||
        spirv_define(spirv, spirv_operand(&instruction, 0), &type) != SPIRV_TYPE_POINTER)
        return UINT32_MAX;
    return spirv_operand(&type, 1);
}

/* The name is a literal behind the model and the function. */
uint32_t spirv_find_entry(const struct spirv *spirv, const char *name, uint32_t model)
{
    struct spirv_instruction instruction;
    if (!readable(readable_cache_of_thread(), name, 1))
        return 0;
    for (size_t place = HEADER_WORDS;
         spirv_read(spirv, place, &instruction) && instruction.op != SPIRV_FUNCTION;
         place = instruction.next) {
        const char *literal = (const char *)&instruction.operands[2];
        const size_t room = instruction.count > 2 ? (instruction.count - 2) * sizeof(uint32_t) : 0;
        if (instruction.op == SPIRV_ENTRY_POINT && room && instruction.operands[0] == model &&
            memchr(literal, 0, room) && strncmp(literal, name, room) == 0)
            return instruction.operands[1];
    }
    return 0;
}

bool spirv_traces(const struct spirv_instruction *instruction, uint32_t *structure)
{
    switch (instruction->op) {
    case SPIRV_TRACE_RAY:
    case SPIRV_TRACE_NV:
    case SPIRV_TRACE_MOTION_NV:
    case SPIRV_TRACE_RAY_MOTION_NV:
        *structure = spirv_operand(instruction, 0);
        return true;
    case SPIRV_RAY_QUERY_INITIALIZE:
        *structure = spirv_operand(instruction, 1);
        return true;
    default:
        return false;
    }
}

/* Labels, lines and literals have numbers that are no ids. */
bool spirv_only_reads(uint32_t op)
{
    switch (op) {
    case SPIRV_LOAD:
    case SPIRV_ACCESS_CHAIN:
    case SPIRV_IN_BOUNDS_ACCESS_CHAIN:
    case SPIRV_PTR_ACCESS_CHAIN:
    case SPIRV_IN_BOUNDS_PTR_ACCESS_CHAIN:
    case SPIRV_ARRAY_LENGTH:
    case SPIRV_COMPOSITE_CONSTRUCT:
    case SPIRV_COMPOSITE_EXTRACT:
    case SPIRV_COMPOSITE_INSERT:
    case SPIRV_COPY_OBJECT:
    case SPIRV_CONVERT_PTR_TO_U:
    case SPIRV_CONVERT_U_TO_PTR:
    case SPIRV_BITCAST:
    case SPIRV_SELECT:
    case SPIRV_PHI:
    case SPIRV_RETURN_VALUE:
    case SPIRV_ATOMIC_LOAD:
        return true;
    default:
        return (op >= SPIRV_FUNCTION && op <= SPIRV_FUNCTION_END) ||
               (op >= SPIRV_LOOP_MERGE && op <= SPIRV_UNREACHABLE) || op == SPIRV_VECTOR_SHUFFLE ||
               op == SPIRV_NO_LINE;
    }
}
