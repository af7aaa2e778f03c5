/* SPDX-License-Identifier: Apache-2.0 */
/* What is read from the code of shaders: whether they write through addresses, and trace rays. */
#include "src/view/shader_code.h"

#include <stdlib.h>
#include <string.h>

#include "tests/state/unit_test.h"

static const uint32_t descriptors[] = {
#include "descriptors_comp.h"
};
static const uint32_t none[] = {
#include "accesses_none_comp.h"
};
static const uint32_t reads[] = {
#include "accesses_reads_comp.h"
};
static const uint32_t writes[] = {
#include "accesses_stores_comp.h"
};
static const uint32_t calls[] = {
#include "accesses_calls_comp.h"
};
static const uint32_t counts[] = {
#include "accesses_counts_comp.h"
};
static const uint32_t links[] = {
#include "accesses_links_comp.h"
};

TEST(stores_through_addresses_are_found)
{
    const struct {
        const uint32_t *code;
        size_t size;
        bool stores;
    } cases[] = {
        {descriptors, sizeof(descriptors), false},
        {none, sizeof(none), false},
        {reads, sizeof(reads), false},
        {writes, sizeof(writes), true},
        {calls, sizeof(calls), true},
        {counts, sizeof(counts), true},
        {links, sizeof(links), true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        assert_int_equal(shader_code_stores(cases[i].code, cases[i].size), cases[i].stores);
}

/* A header, the capability of ray queries, and entry points. */
#define TRACING 0x07230203, 0x10400, 0, 8, 0, 2 << 16 | 17, 4472, 3 << 16 | 15, 5, 1
static const uint32_t one_entry[] = {TRACING};
static const uint32_t two_entries[] = {TRACING, 3 << 16 | 15, 5, 2};
static const uint32_t by_address[] = {TRACING, 4 << 16 | 4447, 3, 4, 5};

TEST(a_module_with_two_entries_need_not_trace)
{
    assert_true(shader_code_certainly_traces(one_entry, sizeof(one_entry)));
    assert_true(shader_code_traces(two_entries, sizeof(two_entries)));
    assert_false(shader_code_certainly_traces(two_entries, sizeof(two_entries)));
    assert_false(shader_code_certainly_traces(none, sizeof(none)));
    assert_false(shader_code_certainly_traces(NULL, 0));
}

TEST(traces_by_address_are_found)
{
    uint32_t copy[sizeof(one_entry) / sizeof(one_entry[0])];
    assert_false(shader_code_traces_addresses(one_entry, sizeof(one_entry)));
    assert_true(shader_code_traces_addresses(by_address, sizeof(by_address)));
    assert_true(shader_code_traces_addresses(NULL, 0));
    memcpy(copy, one_entry, sizeof(copy));
    copy[7] = 0; /* an instruction of 0 words */
    assert_true(shader_code_traces_addresses(copy, sizeof(copy)));
}

/* Code of a stage: that of a module was read when the module was created. */
TEST(code_in_the_chain_of_a_stage_is_read)
{
    VkShaderModuleCreateInfo code = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                     .codeSize = sizeof(reads),
                                     .pCode = reads};
    VkPipelineShaderStageCreateInfo stage = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .pNext = &code};
    assert_false(shader_stage_stores(&stage));
    code.codeSize = sizeof(writes);
    code.pCode = writes;
    assert_true(shader_stage_stores(&stage));
    stage.module = (VkShaderModule)(uintptr_t)1;
    assert_false(shader_stage_stores(&stage));
    stage.module = VK_NULL_HANDLE; /* an identifier, or a binary */
    stage.pNext = NULL;
    assert_true(shader_stage_stores(&stage));
}

/* What is no code may store. Copies end where the memory does, for the sanitizers. */
TEST(code_that_is_damaged_may_store)
{
    assert_true(shader_code_stores(NULL, 0));
    assert_true(shader_code_stores(NULL, sizeof(reads)));
    for (size_t words = 0; words < sizeof(reads) / sizeof(reads[0]); words++) {
        uint32_t *copy = malloc(words ? words * sizeof(*copy) : 1);
        assert_non_null(copy);
        memcpy(copy, reads, words * sizeof(*copy));
        shader_code_stores(copy, words * sizeof(*copy));
        if (words < 5)
            assert_true(shader_code_stores(copy, words * sizeof(*copy)));
        for (size_t i = 0; i < words; i++) {
            copy[i] ^= 0x10001u << (i + words) % 15;
            shader_code_stores(copy, words * sizeof(*copy));
            copy[i] = reads[i];
        }
        free(copy);
    }
    uint32_t copy[sizeof(reads) / sizeof(reads[0])];
    memcpy(copy, reads, sizeof(reads));
    copy[5] = 17; /* an instruction of 0 words */
    assert_true(shader_code_stores(copy, sizeof(copy)));
    copy[5] = 0xffff0011; /* longer than the module */
    assert_true(shader_code_stores(copy, sizeof(copy)));
    memcpy(copy, reads, sizeof(reads));
    copy[3] = UINT32_MAX; /* ids without end */
    assert_true(shader_code_stores(copy, sizeof(copy)));
}
