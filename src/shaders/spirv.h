/* SPDX-License-Identifier: Apache-2.0 */
/* Reads modules of SPIR-V: instructions, and where each id is defined. This is our own reader,
 * because the kept libraries are in C++ and larger than the layer, which depends on libc alone. */
#ifndef ASSAY_SHADERS_SPIRV_H
#define ASSAY_SHADERS_SPIRV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Numbers of the SPIR-V specification and its extensions. */
enum spirv_op {
    SPIRV_EXT_INST = 12,
    SPIRV_ENTRY_POINT = 15,
    SPIRV_EXECUTION_MODE = 16,
    SPIRV_CAPABILITY = 17,
    SPIRV_TYPE_VOID = 19,
    SPIRV_TYPE_BOOL,
    SPIRV_TYPE_INT,
    SPIRV_TYPE_FLOAT,
    SPIRV_TYPE_VECTOR,
    SPIRV_TYPE_MATRIX,
    SPIRV_TYPE_IMAGE,
    SPIRV_TYPE_SAMPLER,
    SPIRV_TYPE_SAMPLED_IMAGE,
    SPIRV_TYPE_ARRAY,
    SPIRV_TYPE_RUNTIME_ARRAY,
    SPIRV_TYPE_STRUCT,
    SPIRV_TYPE_OPAQUE,
    SPIRV_TYPE_POINTER,
    SPIRV_TYPE_FUNCTION,
    SPIRV_TYPE_PIPE = 38,
    SPIRV_CONSTANT_TRUE = 41,
    SPIRV_CONSTANT_FALSE,
    SPIRV_CONSTANT,
    SPIRV_CONSTANT_COMPOSITE,
    SPIRV_CONSTANT_NULL = 46,
    SPIRV_SPEC_CONSTANT_TRUE = 48,
    SPIRV_SPEC_CONSTANT_FALSE,
    SPIRV_SPEC_CONSTANT,
    SPIRV_SPEC_CONSTANT_COMPOSITE,
    SPIRV_SPEC_CONSTANT_OP,
    SPIRV_FUNCTION = 54,
    SPIRV_FUNCTION_PARAMETER,
    SPIRV_FUNCTION_END,
    SPIRV_FUNCTION_CALL,
    SPIRV_VARIABLE = 59,
    SPIRV_IMAGE_TEXEL_POINTER,
    SPIRV_LOAD,
    SPIRV_STORE,
    SPIRV_COPY_MEMORY,
    SPIRV_COPY_MEMORY_SIZED,
    SPIRV_ACCESS_CHAIN,
    SPIRV_IN_BOUNDS_ACCESS_CHAIN,
    SPIRV_PTR_ACCESS_CHAIN,
    SPIRV_ARRAY_LENGTH,
    SPIRV_IN_BOUNDS_PTR_ACCESS_CHAIN = 70,
    SPIRV_DECORATE,
    SPIRV_MEMBER_DECORATE,
    SPIRV_GROUP_MEMBER_DECORATE = 75,
    SPIRV_VECTOR_SHUFFLE = 79,
    SPIRV_COMPOSITE_CONSTRUCT,
    SPIRV_COMPOSITE_EXTRACT,
    SPIRV_COMPOSITE_INSERT,
    SPIRV_COPY_OBJECT,
    SPIRV_IMAGE_QUERY_SIZE_LOD = 103,
    SPIRV_IMAGE_QUERY_SIZE,
    SPIRV_CONVERT_PTR_TO_U = 117,
    SPIRV_CONVERT_U_TO_PTR = 120,
    SPIRV_BITCAST = 124,
    SPIRV_S_NEGATE = 126,
    SPIRV_I_ADD = 128,
    SPIRV_I_SUB = 130,
    SPIRV_I_MUL = 132,
    SPIRV_U_DIV = 134,
    SPIRV_U_MOD = 137,
    SPIRV_ANY = 154,
    SPIRV_ALL,
    SPIRV_LOGICAL_EQUAL = 164,
    SPIRV_LOGICAL_NOT_EQUAL,
    SPIRV_LOGICAL_OR,
    SPIRV_LOGICAL_AND,
    SPIRV_LOGICAL_NOT,
    SPIRV_SELECT,
    SPIRV_I_EQUAL,
    SPIRV_I_NOT_EQUAL,
    SPIRV_U_GREATER,
    SPIRV_S_GREATER,
    SPIRV_U_GREATER_EQUAL,
    SPIRV_S_GREATER_EQUAL,
    SPIRV_U_LESS,
    SPIRV_S_LESS,
    SPIRV_U_LESS_EQUAL,
    SPIRV_S_LESS_EQUAL,
    SPIRV_F_ORD_EQUAL,
    SPIRV_F_UNORD_EQUAL,
    SPIRV_F_ORD_NOT_EQUAL,
    SPIRV_F_UNORD_NOT_EQUAL,
    SPIRV_F_ORD_LESS,
    SPIRV_F_UNORD_LESS,
    SPIRV_F_ORD_GREATER,
    SPIRV_F_UNORD_GREATER,
    SPIRV_F_ORD_LESS_EQUAL,
    SPIRV_F_UNORD_LESS_EQUAL,
    SPIRV_F_ORD_GREATER_EQUAL,
    SPIRV_F_UNORD_GREATER_EQUAL,
    SPIRV_SHIFT_RIGHT_LOGICAL = 194,
    SPIRV_SHIFT_LEFT_LOGICAL = 196,
    SPIRV_BITWISE_OR,
    SPIRV_BITWISE_XOR,
    SPIRV_BITWISE_AND,
    SPIRV_NOT,
    SPIRV_ATOMIC_LOAD = 227,
    SPIRV_PHI = 245,
    SPIRV_LOOP_MERGE,
    SPIRV_SELECTION_MERGE,
    SPIRV_LABEL,
    SPIRV_BRANCH,
    SPIRV_BRANCH_CONDITIONAL,
    SPIRV_SWITCH,
    SPIRV_KILL,
    SPIRV_RETURN,
    SPIRV_RETURN_VALUE,
    SPIRV_UNREACHABLE,
    SPIRV_NO_LINE = 317,
    SPIRV_TERMINATE_INVOCATION = 4416,
    SPIRV_TRACE_RAY = 4445,
    SPIRV_CONVERT_U_TO_STRUCTURE = 4447,
    SPIRV_IGNORE_INTERSECTION = 4448,
    SPIRV_TERMINATE_RAY = 4449,
    SPIRV_TYPE_RAY_QUERY = 4472,
    SPIRV_RAY_QUERY_INITIALIZE = 4473,
    SPIRV_EMIT_MESH_TASKS = 5294,
    SPIRV_IGNORE_INTERSECTION_NV = 5335,
    SPIRV_TERMINATE_RAY_NV = 5336,
    SPIRV_TRACE_NV = 5337,
    SPIRV_TRACE_MOTION_NV = 5338,
    SPIRV_TRACE_RAY_MOTION_NV = 5339,
    SPIRV_TYPE_STRUCTURE = 5341,
};

enum {
    SPIRV_CLASS_UNIFORM_CONSTANT = 0,
    SPIRV_CLASS_INPUT = 1,
    SPIRV_CLASS_UNIFORM = 2,
    SPIRV_CLASS_PRIVATE = 6,
    SPIRV_CLASS_FUNCTION = 7,
    SPIRV_CLASS_PUSH_CONSTANT = 9,
    SPIRV_CLASS_STORAGE_BUFFER = 12,
    SPIRV_CLASS_PHYSICAL_STORAGE_BUFFER = 5349,
    SPIRV_SPEC_ID = 1, /* decorations */
    SPIRV_ARRAY_STRIDE = 6,
    SPIRV_BUILT_IN = 11,
    SPIRV_BINDING = 33,
    SPIRV_DESCRIPTOR_SET = 34,
    SPIRV_OFFSET = 35,
    SPIRV_LOCAL_SIZE = 17, /* an execution mode */
};

struct spirv_instruction {
    uint32_t op;
    uint32_t count; /* of operands, its result and type included */
    const uint32_t *operands;
    size_t place, next; /* in words from the beginning of the module */
};

struct spirv {
    const uint32_t *code; /* of the caller, who keeps it */
    size_t words;
    uint32_t bound;        /* ids are smaller; not 0 */
    uint32_t *places;      /* where each id is defined; 0: nowhere that is known */
    bool ends_anywhere;    /* a function may end the invocation: OpKill and the like */
    bool has_texel_stores; /* a storage image may be a buffer */
    bool has_untyped_pointers;
};

/* Returns false if that is no readable module, or memory runs out. `size`: in bytes. */
bool spirv_open(struct spirv *spirv, const uint32_t *code, size_t size);
void spirv_close(struct spirv *spirv);

/* Reads the instruction at a place. Returns false at the end. */
bool spirv_read(const struct spirv *spirv, size_t place, struct spirv_instruction *instruction);
/* Reads the instruction that defines an id. Returns its op; 0: the id is not defined. */
uint32_t spirv_define(const struct spirv *spirv, uint32_t id,
                      struct spirv_instruction *instruction);
/* Returns an operand; 0 if there are fewer. */
static inline uint32_t spirv_operand(const struct spirv_instruction *instruction, uint32_t i)
{
    return i < instruction->count ? instruction->operands[i] : 0;
}

/* Finds the literal of a decoration of an id, or of a member of a type (UINT32_MAX: of the id).
 * Returns false if there is none. */
bool spirv_find_decoration(const struct spirv *spirv, uint32_t id, uint32_t member,
                           uint32_t decoration, uint32_t *literal);
/* Returns the OpVariable or OpFunctionParameter that a pointer leads into; 0: unknown. */
uint32_t spirv_find_root(const struct spirv *spirv, uint32_t pointer);
/* Returns the storage class of a pointer; UINT32_MAX: the id is no pointer. */
uint32_t spirv_class(const struct spirv *spirv, uint32_t id);
/* Returns the function of an entry point; 0: there is none. `model`: of SPIR-V. */
uint32_t spirv_find_entry(const struct spirv *spirv, const char *name, uint32_t model);
/* Whether an instruction traces rays. `structure`: the id of the structure that it traces; 0:
 * unknown. */
bool spirv_traces(const struct spirv_instruction *instruction, uint32_t *structure);
/* Whether an instruction only reads what a pointer among its operands leads to, or computes another
 * pointer. A store may write a pointer to where no pointer leads. */
bool spirv_only_reads(uint32_t op);

#endif
