/* SPDX-License-Identifier: Apache-2.0 */
/* Which shaders certainly trace rays. */
#include "src/shaders/facts.h"
#include "src/shaders/paths.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/unit_test.h"

struct path_case {
    const char *name;
    const uint32_t *words;
    size_t size;
    bool is_certain, is_pushed;
    uint32_t pushed[3];
};

#include "path_cases.h"

enum { MODEL_FRAGMENT = 4, MODEL_COMPUTE = 5 };

static uint32_t entry_of(const struct spirv *spirv)
{
    const uint32_t entry = spirv_find_entry(spirv, "main", MODEL_COMPUTE);
    return entry ? entry : spirv_find_entry(spirv, "main", MODEL_FRAGMENT);
}

static bool is_certain(const uint32_t *words, size_t size, struct shader_launch *launch,
                       struct traced_descriptor *traced)
{
    struct spirv spirv;
    bool result = false;
    if (!spirv_open(&spirv, words, size))
        return false;
    const uint32_t entry = entry_of(&spirv);
    if (entry)
        result = shader_certainly_traces(&spirv, entry, launch, traced);
    spirv_close(&spirv);
    return result;
}

TEST(paths_of_each_case)
{
    unsigned failed = 0;
    for (size_t i = 0; i < sizeof(path_cases) / sizeof(path_cases[0]); i++) {
        const struct path_case *path = &path_cases[i];
        struct pushed_constants pushed = {.known = path->is_pushed ? 7 : 0};
        struct shader_launch launch = {.pushed = &pushed, .size = {4, 2, 1}};
        struct traced_descriptor traced;
        memcpy(pushed.words, path->pushed, sizeof(path->pushed));
        const bool certain = is_certain(path->words, path->size, &launch, &traced);
        if (certain != path->is_certain) {
            print_error("%s, %u %u %u%s: %s\n", path->name, path->pushed[0], path->pushed[1],
                        path->pushed[2], path->is_pushed ? "" : " (unknown)",
                        certain ? "certain" : "possible");
            failed++;
        }
    }
    assert_int_equal(failed, 0);
}

static const struct path_case *find_case(const char *name)
{
    for (size_t i = 0; i < sizeof(path_cases) / sizeof(path_cases[0]); i++)
        if (strcmp(path_cases[i].name, name) == 0)
            return &path_cases[i];
    fail_msg("no case %s", name);
    return NULL;
}

/* Specialization turns a trace on that the code leaves out, and the other way. */
TEST(specialization_decides)
{
    const struct path_case *disabled = find_case("a specialization constant");
    const struct path_case *samples =
        find_case("as many samples as a specialization constant says, optimized");
    uint32_t number = 1;
    VkSpecializationMapEntry entry = {0, 0, sizeof(number)};
    VkSpecializationInfo info = {1, &entry, sizeof(number), &number};
    struct shader_launch launch = {.constants = &info, .size = {1, 1, 1}};
    struct traced_descriptor traced;
    assert_true(is_certain(disabled->words, disabled->size, &launch, &traced));
    number = 0;
    assert_false(is_certain(disabled->words, disabled->size, &launch, &traced));
    entry.constantID = 1;
    assert_false(is_certain(samples->words, samples->size, &launch, &traced));
    number = 1;
    assert_true(is_certain(samples->words, samples->size, &launch, &traced));
    info.dataSize = 2; /* the constant lies behind the data */
    assert_false(is_certain(samples->words, samples->size, &launch, &traced));
}

TEST(the_descriptor_is_found)
{
    const struct path_case *path = find_case("nothing in the way");
    struct shader_launch launch = {.size = {1, 1, 1}};
    struct traced_descriptor traced = {.set = 9, .binding = 9, .element = 9};
    assert_true(is_certain(path->words, path->size, &launch, &traced));
    assert_true(traced.is_known);
    assert_int_equal(traced.set, 0);
    assert_int_equal(traced.binding, 0);
    assert_int_equal(traced.element, 0);
    const struct path_case *both = find_case("both sides trace");
    assert_true(is_certain(both->words, both->size, &launch, &traced));
    assert_false(traced.is_known);
}

/* A function gets a pointer to the structure that it traces. */
TEST(structures_that_calls_get_are_found)
{
    const struct path_case *path = find_case("nothing in the way");
    struct shader_facts facts = shader_facts_unknown();
    struct spirv spirv;
    assert_true(spirv_open(&spirv, path->words, path->size));
    shader_facts_read(&spirv, entry_of(&spirv), &facts);
    spirv_close(&spirv);
    assert_true(facts.is_known && facts.may_trace);
    assert_int_equal(facts.structures.count, 1);
    assert_true(shader_bindings_have(&facts.structures, 0, 0));
}

/* Code may be damaged in any way. Copies end where the memory does, for the sanitizers. */
TEST(damaged_code_does_no_harm)
{
    const char *names[] = {"a loop of unknown length", "a function that may return early",
                           "a switch on a push constant, optimized",
                           "as many samples as were pushed, optimized",
                           "a component of a vector that is written"};
    struct pushed_constants pushed = {.known = 7, .words = {1, 8, 8}};
    struct shader_launch launch = {.pushed = &pushed, .size = {4, 2, 1}};
    struct traced_descriptor traced;
    for (size_t n = 0; n < sizeof(names) / sizeof(names[0]); n++) {
        const struct path_case *path = find_case(names[n]);
        const size_t words = path->size / sizeof(uint32_t);
        uint32_t *copy = malloc(path->size);
        assert_non_null(copy);
        memcpy(copy, path->words, path->size);
        for (size_t i = 0; i < words; i++)
            for (unsigned way = 0; way < 6; way++) { /* words[3]: the bound of all ids */
                const uint32_t values[] = {0,
                                           copy[i] ^ 1u << (i + way) % 32,
                                           copy[i * 7 % words],
                                           copy[i - (i > 0)],
                                           path->words[3],
                                           UINT32_MAX};
                const uint32_t before = copy[i];
                copy[i] = values[way];
                is_certain(copy, path->size, &launch, &traced);
                copy[i] = before;
            }
        for (size_t i = 0; i + 8 <= words; i++) { /* a constant that has itself four times */
            const uint32_t id = copy[i + 2];
            memcpy(copy + i, (uint32_t[]){7 << 16 | 44, copy[i + 1], id, id, id, id, id, 1 << 16},
                   8 * sizeof(*copy));
            is_certain(copy, path->size, &launch, &traced);
            memcpy(copy + i, path->words + i, 8 * sizeof(*copy));
        }
        free(copy);
        for (size_t kept = 0; kept < words; kept += 1 + kept / 16) {
            copy = malloc(kept * sizeof(uint32_t) + 1);
            assert_non_null(copy);
            memcpy(copy, path->words, kept * sizeof(uint32_t));
            is_certain(copy, kept * sizeof(uint32_t), &launch, &traced);
            free(copy);
        }
    }
}
