/* SPDX-License-Identifier: Apache-2.0 */
#include "src/shaders/values.h"

#include <string.h>

enum { ALL_PARTS = (1 << VALUE_PARTS) - 1 };

struct value value_of_number(uint32_t number)
{
    return (struct value){.parts = {number, number, number, number}, .known = ALL_PARTS};
}

struct value value_positive(void)
{
    return (struct value){.positive = ALL_PARTS};
}

struct value value_part(const struct value *value, uint32_t part)
{
    if (part >= VALUE_PARTS)
        return (struct value){0};
    if (value->known >> part & 1)
        return value_of_number(value->parts[part]);
    return value->positive >> part & 1 ? value_positive() : (struct value){0};
}

bool value_is_known(const struct value *value, uint32_t *number)
{
    *number = value->parts[0];
    return value->known & 1;
}

/* ---- numbers */

static float as_float(uint32_t number)
{
    float result;
    memcpy(&result, &number, sizeof(result));
    return result;
}

static bool compare_floats(uint32_t op, float a, float b, uint32_t *result)
{
    const bool is_unordered = a != a || b != b;
    switch (op) {
    case SPIRV_F_ORD_EQUAL:
    case SPIRV_F_UNORD_EQUAL:
        *result = a == b;
        break;
    case SPIRV_F_ORD_NOT_EQUAL:
    case SPIRV_F_UNORD_NOT_EQUAL:
        *result = a != b;
        break;
    case SPIRV_F_ORD_LESS:
    case SPIRV_F_UNORD_LESS:
        *result = a < b;
        break;
    case SPIRV_F_ORD_GREATER:
    case SPIRV_F_UNORD_GREATER:
        *result = a > b;
        break;
    case SPIRV_F_ORD_LESS_EQUAL:
    case SPIRV_F_UNORD_LESS_EQUAL:
        *result = a <= b;
        break;
    case SPIRV_F_ORD_GREATER_EQUAL:
    case SPIRV_F_UNORD_GREATER_EQUAL:
        *result = a >= b;
        break;
    default:
        return false;
    }
    return !is_unordered;
}

static bool compare(uint32_t op, uint32_t a, uint32_t b, uint32_t *result)
{
    switch (op) {
    case SPIRV_I_EQUAL:
    case SPIRV_LOGICAL_EQUAL:
        *result = a == b;
        return true;
    case SPIRV_I_NOT_EQUAL:
    case SPIRV_LOGICAL_NOT_EQUAL:
        *result = a != b;
        return true;
    case SPIRV_U_GREATER:
        *result = a > b;
        return true;
    case SPIRV_S_GREATER:
        *result = (int32_t)a > (int32_t)b;
        return true;
    case SPIRV_U_GREATER_EQUAL:
        *result = a >= b;
        return true;
    case SPIRV_S_GREATER_EQUAL:
        *result = (int32_t)a >= (int32_t)b;
        return true;
    case SPIRV_U_LESS:
        *result = a < b;
        return true;
    case SPIRV_S_LESS:
        *result = (int32_t)a < (int32_t)b;
        return true;
    case SPIRV_U_LESS_EQUAL:
        *result = a <= b;
        return true;
    case SPIRV_S_LESS_EQUAL:
        *result = (int32_t)a <= (int32_t)b;
        return true;
    default:
        return compare_floats(op, as_float(a), as_float(b), result);
    }
}

/* Returns false if the result is unknown, or undefined. */
static bool calculate(uint32_t op, uint32_t a, uint32_t b, uint32_t *result)
{
    switch (op) {
    case SPIRV_I_ADD:
        *result = a + b;
        return true;
    case SPIRV_I_SUB:
        *result = a - b;
        return true;
    case SPIRV_I_MUL:
        *result = a * b;
        return true;
    case SPIRV_U_DIV:
        *result = b ? a / b : 0;
        return b;
    case SPIRV_U_MOD:
        *result = b ? a % b : 0;
        return b;
    case SPIRV_SHIFT_RIGHT_LOGICAL:
        *result = b < 32 ? a >> b : 0;
        return b < 32;
    case SPIRV_SHIFT_LEFT_LOGICAL:
        *result = b < 32 ? a << b : 0;
        return b < 32;
    case SPIRV_BITWISE_OR:
    case SPIRV_LOGICAL_OR:
        *result = a | b;
        return true;
    case SPIRV_BITWISE_XOR:
        *result = a ^ b;
        return true;
    case SPIRV_BITWISE_AND:
    case SPIRV_LOGICAL_AND:
        *result = a & b;
        return true;
    default:
        return compare(op, a, b, result);
    }
}

static bool calculate_one(uint32_t op, uint32_t a, uint32_t *result)
{
    switch (op) {
    case SPIRV_COPY_OBJECT:
    case SPIRV_BITCAST:
        *result = a;
        return true;
    case SPIRV_S_NEGATE:
        *result = 0 - a;
        return true;
    case SPIRV_NOT:
        *result = ~a;
        return true;
    case SPIRV_LOGICAL_NOT:
        *result = !a;
        return true;
    default:
        return false;
    }
}

/* ---- values of which not all is known */

/* A known 0 decides "and", a known 1 decides "or". */
static bool is_decided_by(uint32_t op, uint32_t number)
{
    return (op == SPIRV_LOGICAL_AND && !number) || (op == SPIRV_LOGICAL_OR && number) ||
           (op == SPIRV_BITWISE_AND && !number) || (op == SPIRV_I_MUL && !number);
}

/* Compares 0 with a number of at least 1. */
static bool compare_with_positive(uint32_t op, bool is_first_zero, uint32_t *result)
{
    switch (op) {
    case SPIRV_I_EQUAL:
    case SPIRV_I_NOT_EQUAL:
    case SPIRV_U_GREATER:
    case SPIRV_S_GREATER:
    case SPIRV_U_GREATER_EQUAL:
    case SPIRV_S_GREATER_EQUAL:
    case SPIRV_U_LESS:
    case SPIRV_S_LESS:
    case SPIRV_U_LESS_EQUAL:
    case SPIRV_S_LESS_EQUAL:
        return is_first_zero ? compare(op, 0, 1, result) : compare(op, 1, 0, result);
    default:
        return false;
    }
}

static bool compute_part(uint32_t op, const struct value *a, const struct value *b, uint32_t part,
                         uint32_t *result)
{
    const bool a_is_known = a->known >> part & 1, b_is_known = b->known >> part & 1;
    if (a_is_known && b_is_known)
        return calculate(op, a->parts[part], b->parts[part], result);
    if ((a_is_known && is_decided_by(op, a->parts[part])) ||
        (b_is_known && is_decided_by(op, b->parts[part]))) {
        *result = a_is_known ? a->parts[part] : b->parts[part];
        return true;
    }
    if (a_is_known && !a->parts[part] && b->positive >> part & 1)
        return compare_with_positive(op, true, result);
    if (b_is_known && !b->parts[part] && a->positive >> part & 1)
        return compare_with_positive(op, false, result);
    return false;
}

static struct value compute_two(uint32_t op, const struct value *a, const struct value *b)
{
    struct value result = {.known = 0};
    for (uint32_t i = 0; i < VALUE_PARTS; i++)
        if (compute_part(op, a, b, i, &result.parts[i]))
            result.known |= (unsigned char)(1 << i);
    return result;
}

static struct value compute_one(uint32_t op, const struct value *a)
{
    struct value result = {.known = 0};
    for (uint32_t i = 0; i < VALUE_PARTS; i++)
        if (a->known >> i & 1 && calculate_one(op, a->parts[i], &result.parts[i]))
            result.known |= (unsigned char)(1 << i);
    if (op == SPIRV_COPY_OBJECT || op == SPIRV_BITCAST)
        result.positive = a->positive;
    return result;
}

static struct value select_value(const struct value *condition, const struct value *yes,
                                 const struct value *no)
{
    struct value result = {.known = 0};
    for (uint32_t i = 0; i < VALUE_PARTS; i++) {
        const struct value *chosen = condition->parts[i] ? yes : no;
        if (!(condition->known >> i & 1))
            continue;
        result.parts[i] = chosen->parts[i];
        result.known |= (unsigned char)(chosen->known & 1 << i);
        result.positive |= (unsigned char)(chosen->positive & 1 << i);
    }
    return result;
}

struct value value_compute(uint32_t op, const struct value *operands, uint32_t count)
{
    if (op == SPIRV_SELECT && count == 3)
        return select_value(&operands[0], &operands[1], &operands[2]);
    if (count == 2)
        return compute_two(op, &operands[0], &operands[1]);
    return count == 1 ? compute_one(op, &operands[0]) : (struct value){0};
}
