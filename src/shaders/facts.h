/* SPDX-License-Identifier: Apache-2.0 */
/* What the functions of a shader can do, whether or not an invocation gets there: the call tree of
 * one entry point, which is what the specification calls static use. */
#ifndef ASSAY_SHADERS_FACTS_H
#define ASSAY_SHADERS_FACTS_H

#include <vulkan/vulkan_core.h>

#include "src/shaders/spirv.h"

enum { SHADER_BINDINGS = 16 }; /* more are unknown */

struct shader_bindings {
    uint32_t count;
    bool has_others; /* there may be more than these */
    struct shader_binding {
        uint32_t set, binding;
    } items[SHADER_BINDINGS];
};

struct shader_facts {
    bool is_known;                     /* false: the shader may do anything */
    bool may_trace;                    /* an instruction traces rays */
    bool stores_addresses;             /* it may write through an address */
    struct shader_bindings structures; /* that the shader uses statically */
    struct shader_bindings stores;     /* buffers that it may write; others: by address, too */
};

/* What a shader may do of which nothing is known. */
struct shader_facts shader_facts_unknown(void);
/* Adds what another shader of the same pipeline may do. */
void shader_facts_add(struct shader_facts *facts, const struct shader_facts *other);
bool shader_bindings_have(const struct shader_bindings *bindings, uint32_t set, uint32_t binding);

/* `entry`: see spirv_find_entry(). */
void shader_facts_read(const struct spirv *spirv, uint32_t entry, struct shader_facts *facts);

/* Returns the SPIR-V execution model of a stage; UINT32_MAX: unknown. */
uint32_t shader_model(VkShaderStageFlagBits stage);

#endif
