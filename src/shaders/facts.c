/* SPDX-License-Identifier: Apache-2.0 */
#include "src/shaders/facts.h"

#include <stdlib.h>

/* ---- sets of bindings */

bool shader_bindings_have(const struct shader_bindings *bindings, uint32_t set, uint32_t binding)
{
    for (uint32_t i = 0; i < bindings->count; i++)
        if (bindings->items[i].set == set && bindings->items[i].binding == binding)
            return true;
    return false;
}

static void add_binding(struct shader_bindings *bindings, struct shader_binding added)
{
    if (shader_bindings_have(bindings, added.set, added.binding))
        return;
    if (bindings->count < SHADER_BINDINGS)
        bindings->items[bindings->count++] = added;
    else
        bindings->has_others = true;
}

static void add_bindings(struct shader_bindings *bindings, const struct shader_bindings *other)
{
    bindings->has_others |= other->has_others;
    for (uint32_t i = 0; i < other->count; i++)
        add_binding(bindings, other->items[i]);
}

struct shader_facts shader_facts_unknown(void)
{
    return (struct shader_facts){.may_trace = true,
                                 .stores_addresses = true,
                                 .structures.has_others = true,
                                 .stores.has_others = true};
}

void shader_facts_add(struct shader_facts *facts, const struct shader_facts *other)
{
    facts->is_known &= other->is_known;
    facts->may_trace |= other->may_trace;
    facts->stores_addresses |= other->stores_addresses;
    add_bindings(&facts->structures, &other->structures);
    add_bindings(&facts->stores, &other->stores);
}

/* Adds the descriptor of a variable, by its id; 0: unknown. Parameters stand for what the calls
 * pass, which is added there. */
static void add_variable(const struct spirv *spirv, struct shader_bindings *bindings, uint32_t id)
{
    struct spirv_instruction variable;
    struct shader_binding added;
    const uint32_t op = spirv_define(spirv, id, &variable);
    if (op == SPIRV_FUNCTION_PARAMETER)
        return;
    if (op == SPIRV_VARIABLE &&
        spirv_find_decoration(spirv, id, UINT32_MAX, SPIRV_DESCRIPTOR_SET, &added.set) &&
        spirv_find_decoration(spirv, id, UINT32_MAX, SPIRV_BINDING, &added.binding))
        add_binding(bindings, added);
    else
        bindings->has_others = true;
}

/* ---- instructions */

/* Notes that an operand is written to, if it is a pointer into a buffer. */
static void note_store(const struct spirv *spirv, struct shader_facts *facts, uint32_t pointer)
{
    switch (spirv_class(spirv, pointer)) {
    case SPIRV_CLASS_PHYSICAL_STORAGE_BUFFER:
        facts->stores_addresses = facts->stores.has_others = true;
        break;
    case SPIRV_CLASS_UNIFORM:
    case SPIRV_CLASS_STORAGE_BUFFER:
        add_variable(spirv, &facts->stores, spirv_find_root(spirv, pointer));
        break;
    default:
        break;
    }
}

static bool is_structure(const struct spirv *spirv, uint32_t type)
{
    struct spirv_instruction definition;
    return spirv_define(spirv, type, &definition) == SPIRV_TYPE_STRUCTURE;
}

/* A call may store through each pointer that it passes, and trace what it leads to. */
static void note_arguments(const struct spirv *spirv, struct shader_facts *facts,
                           const struct spirv_instruction *call)
{
    for (uint32_t i = 3; i < call->count; i++) {
        const uint32_t root = spirv_find_root(spirv, call->operands[i]);
        struct spirv_instruction variable, pointer, pointee;
        if (spirv_class(spirv, call->operands[i]) != SPIRV_CLASS_PHYSICAL_STORAGE_BUFFER)
            note_store(spirv, facts, call->operands[i]);
        if (spirv_class(spirv, root) != SPIRV_CLASS_UNIFORM_CONSTANT)
            continue;
        spirv_define(spirv, root, &variable);
        spirv_define(spirv, spirv_operand(&variable, 0), &pointer);
        const uint32_t op = spirv_define(spirv, spirv_operand(&pointer, 2), &pointee);
        if (op == SPIRV_TYPE_STRUCTURE ||
            ((op == SPIRV_TYPE_ARRAY || op == SPIRV_TYPE_RUNTIME_ARRAY) &&
             is_structure(spirv, spirv_operand(&pointee, 1))))
            add_variable(spirv, &facts->structures, root);
    }
}

static void note_instruction(const struct spirv *spirv, struct shader_facts *facts,
                             const struct spirv_instruction *instruction)
{
    uint32_t structure;
    facts->may_trace |= spirv_traces(instruction, &structure);
    switch (instruction->op) {
    case SPIRV_STORE:
    case SPIRV_COPY_MEMORY:
    case SPIRV_COPY_MEMORY_SIZED:
        note_store(spirv, facts, spirv_operand(instruction, 0));
        return;
    case SPIRV_CONVERT_U_TO_STRUCTURE:
        facts->structures.has_others = true;
        return;
    case SPIRV_FUNCTION_CALL:
        note_arguments(spirv, facts, instruction);
        return;
    case SPIRV_LOAD:
        if (is_structure(spirv, spirv_operand(instruction, 0)))
            add_variable(spirv, &facts->structures,
                         spirv_find_root(spirv, spirv_operand(instruction, 2)));
        return;
    default:
        break;
    }
    for (uint32_t i = 0; !spirv_only_reads(instruction->op) && i < instruction->count; i++)
        note_store(spirv, facts, instruction->operands[i]);
}

/* ---- the call tree */

struct call_tree {
    const struct spirv *spirv;
    unsigned char *is_visited; /* functions, by id */
    uint32_t *waiting;         /* functions that are yet to be read */
    uint32_t count;
};

static void visit(struct call_tree *tree, uint32_t function)
{
    if (function >= tree->spirv->bound || tree->is_visited[function])
        return;
    tree->is_visited[function] = true;
    tree->waiting[tree->count++] = function;
}

static void read_function(struct call_tree *tree, uint32_t function, struct shader_facts *facts)
{
    struct spirv_instruction instruction;
    if (spirv_define(tree->spirv, function, &instruction) != SPIRV_FUNCTION) {
        *facts = shader_facts_unknown();
        return;
    }
    while (spirv_read(tree->spirv, instruction.next, &instruction) &&
           instruction.op != SPIRV_FUNCTION_END) {
        note_instruction(tree->spirv, facts, &instruction);
        if (instruction.op == SPIRV_FUNCTION_CALL)
            visit(tree, spirv_operand(&instruction, 2));
    }
}

void shader_facts_read(const struct spirv *spirv, uint32_t entry, struct shader_facts *facts)
{
    struct call_tree tree = {.spirv = spirv,
                             .is_visited = calloc(spirv->bound, 1),
                             .waiting = malloc(spirv->bound * sizeof(uint32_t))};
    *facts = (struct shader_facts){.is_known = true};
    if (tree.is_visited && tree.waiting)
        visit(&tree, entry);
    if (!tree.count || spirv->has_untyped_pointers)
        *facts = shader_facts_unknown();
    while (tree.count && facts->is_known)
        read_function(&tree, tree.waiting[--tree.count], facts);
    facts->stores.has_others |= spirv->has_texel_stores;
    free(tree.waiting);
    free(tree.is_visited);
}

/* The numbers of SPIR-V for the stages. */
static const struct {
    VkShaderStageFlagBits stage;
    uint32_t model;
} models[] = {
    {VK_SHADER_STAGE_VERTEX_BIT, 0},
    {VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT, 1},
    {VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT, 2},
    {VK_SHADER_STAGE_GEOMETRY_BIT, 3},
    {VK_SHADER_STAGE_FRAGMENT_BIT, 4},
    {VK_SHADER_STAGE_COMPUTE_BIT, 5},
    {VK_SHADER_STAGE_RAYGEN_BIT_KHR, 5313},
    {VK_SHADER_STAGE_INTERSECTION_BIT_KHR, 5314},
    {VK_SHADER_STAGE_ANY_HIT_BIT_KHR, 5315},
    {VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, 5316},
    {VK_SHADER_STAGE_MISS_BIT_KHR, 5317},
    {VK_SHADER_STAGE_CALLABLE_BIT_KHR, 5318},
    {VK_SHADER_STAGE_TASK_BIT_EXT, 5364},
    {VK_SHADER_STAGE_MESH_BIT_EXT, 5365},
};

uint32_t shader_model(VkShaderStageFlagBits stage)
{
    for (size_t i = 0; i < sizeof(models) / sizeof(models[0]); i++)
        if (models[i].stage == stage)
            return models[i].model;
    return UINT32_MAX;
}
