/* SPDX-License-Identifier: Apache-2.0 */
/* What the call tree of a shader can do. */
#include "src/shaders/facts.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/unit_test.h"

#include "accesses_calls_comp.h"
#include "accesses_counts_comp.h"
#include "accesses_links_comp.h"
#include "accesses_none_comp.h"
#include "accesses_reads_comp.h"
#include "accesses_stores_comp.h"
#include "accesses_texels_comp.h"
#include "descriptors_comp.h"
#include "trace_comp.h"
#include "trace_set_comp.h"

static bool read_facts(const uint32_t *code, size_t size, struct shader_facts *facts)
{
    struct spirv spirv;
    *facts = shader_facts_unknown();
    if (!spirv_open(&spirv, code, size))
        return false;
    const uint32_t entry =
        spirv_find_entry(&spirv, "main", shader_model(VK_SHADER_STAGE_COMPUTE_BIT));
    if (entry)
        shader_facts_read(&spirv, entry, facts);
    spirv_close(&spirv);
    return entry;
}

/* A buffer of texels is part of no binding that is followed. */
TEST(stores_of_texels_are_found)
{
    struct shader_facts facts;
    assert_true(read_facts(accesses_texels_comp, sizeof(accesses_texels_comp), &facts));
    assert_true(facts.stores.has_others);
    assert_false(facts.stores_addresses);
}

/* Each of these also writes the buffer of binding 0. */
TEST(stores_through_addresses_are_found)
{
    const struct {
        const uint32_t *code;
        size_t size;
        bool stores;
    } cases[] = {
        {descriptors_comp, sizeof(descriptors_comp), false},
        {accesses_none_comp, sizeof(accesses_none_comp), false},
        {accesses_reads_comp, sizeof(accesses_reads_comp), false},
        {accesses_stores_comp, sizeof(accesses_stores_comp), true},
        {accesses_calls_comp, sizeof(accesses_calls_comp), true},
        {accesses_counts_comp, sizeof(accesses_counts_comp), true},
        {accesses_links_comp, sizeof(accesses_links_comp), true},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct shader_facts facts;
        assert_true(read_facts(cases[i].code, cases[i].size, &facts));
        assert_true(facts.is_known);
        assert_false(facts.may_trace);
        assert_int_equal(facts.stores_addresses, cases[i].stores);
        assert_int_equal(facts.stores.has_others, cases[i].stores);
        assert_int_equal(facts.stores.count, 1);
        assert_true(shader_bindings_have(&facts.stores, 0, 0));
        assert_int_equal(facts.structures.count, 0);
    }
}

TEST(structures_are_found)
{
    struct shader_facts facts;
    assert_true(read_facts(trace_set_comp, sizeof(trace_set_comp), &facts));
    assert_true(facts.may_trace);
    assert_int_equal(facts.structures.count, 1);
    assert_true(shader_bindings_have(&facts.structures, 0, 0));
    assert_false(facts.structures.has_others);
    assert_int_equal(facts.stores.count, 0);
    assert_true(read_facts(trace_comp, sizeof(trace_comp), &facts));
    assert_true(facts.may_trace);
    assert_int_equal(facts.structures.count, 0);
    assert_true(facts.structures.has_others);
}

TEST(entry_points_have_a_name_and_a_stage)
{
    struct spirv spirv;
    assert_true(spirv_open(&spirv, accesses_none_comp, sizeof(accesses_none_comp)));
    assert_int_not_equal(
        spirv_find_entry(&spirv, "main", shader_model(VK_SHADER_STAGE_COMPUTE_BIT)), 0);
    assert_int_equal(spirv_find_entry(&spirv, "main", shader_model(VK_SHADER_STAGE_FRAGMENT_BIT)),
                     0);
    assert_int_equal(spirv_find_entry(&spirv, "mai", shader_model(VK_SHADER_STAGE_COMPUTE_BIT)), 0);
    assert_int_equal(spirv_find_entry(&spirv, "main2", shader_model(VK_SHADER_STAGE_COMPUTE_BIT)),
                     0);
    assert_int_equal(spirv_find_entry(&spirv, NULL, shader_model(VK_SHADER_STAGE_COMPUTE_BIT)), 0);
    spirv_close(&spirv);
}

TEST(facts_of_a_pipeline_are_those_of_all_shaders)
{
    struct shader_facts facts, other;
    assert_true(read_facts(trace_set_comp, sizeof(trace_set_comp), &facts));
    assert_true(read_facts(descriptors_comp, sizeof(descriptors_comp), &other));
    shader_facts_add(&facts, &other);
    assert_true(facts.is_known && facts.may_trace);
    assert_true(shader_bindings_have(&facts.structures, 0, 0));
    assert_true(shader_bindings_have(&facts.stores, 0, 0));
    for (uint32_t i = 0; i <= SHADER_BINDINGS; i++) {
        other.stores.items[0] = (struct shader_binding){1, i};
        shader_facts_add(&facts, &other);
    }
    assert_true(facts.stores.has_others);
    other = shader_facts_unknown();
    shader_facts_add(&facts, &other);
    assert_false(facts.is_known);
    assert_true(facts.stores_addresses);
}

/* Their loads and stores are other instructions. */
TEST(code_with_untyped_pointers_may_do_anything)
{
    enum { HEADER = 5, CAPABILITY = 17, UNTYPED_POINTERS = 4473 };
    uint32_t code[sizeof(accesses_none_comp) / sizeof(accesses_none_comp[0]) + 2];
    struct shader_facts facts;
    assert_true(read_facts(accesses_none_comp, sizeof(accesses_none_comp), &facts));
    assert_true(facts.is_known && !facts.stores_addresses);
    memcpy(code, accesses_none_comp, HEADER * sizeof(*code));
    code[HEADER] = 2 << 16 | CAPABILITY;
    code[HEADER + 1] = UNTYPED_POINTERS;
    memcpy(code + HEADER + 2, accesses_none_comp + HEADER,
           sizeof(accesses_none_comp) - HEADER * sizeof(*code));
    assert_true(read_facts(code, sizeof(code), &facts));
    assert_true(!facts.is_known && facts.stores_addresses);
}

/* What is no code may do anything. Copies end where the memory does, for the sanitizers. */
TEST(damaged_code_is_unknown)
{
    struct shader_facts facts;
    assert_false(read_facts(NULL, 0, &facts));
    assert_false(read_facts(NULL, sizeof(accesses_reads_comp), &facts));
    assert_true(facts.stores_addresses);
    for (size_t words = 0; words < sizeof(accesses_reads_comp) / sizeof(accesses_reads_comp[0]);
         words++) {
        uint32_t *copy = malloc(words ? words * sizeof(*copy) : 1);
        assert_non_null(copy);
        memcpy(copy, accesses_reads_comp, words * sizeof(*copy));
        read_facts(copy, words * sizeof(*copy), &facts);
        for (size_t i = 0; i < words; i++) {
            copy[i] ^= 0x10001u << (i + words) % 15;
            read_facts(copy, words * sizeof(*copy), &facts);
            copy[i] = accesses_reads_comp[i];
        }
        free(copy);
    }
    uint32_t copy[sizeof(accesses_reads_comp) / sizeof(accesses_reads_comp[0])];
    memcpy(copy, accesses_reads_comp, sizeof(accesses_reads_comp));
    copy[5] = 17; /* an instruction of 0 words */
    assert_false(read_facts(copy, sizeof(copy), &facts));
    copy[5] = 0xffff0011; /* longer than the module */
    assert_false(read_facts(copy, sizeof(copy), &facts));
    memcpy(copy, accesses_reads_comp, sizeof(accesses_reads_comp));
    copy[3] = UINT32_MAX; /* ids without end */
    assert_false(read_facts(copy, sizeof(copy), &facts));
}
