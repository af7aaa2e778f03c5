/* SPDX-License-Identifier: Apache-2.0 */
/* Calls that build the same few structures over and over, mostly as before, while what they use
 * comes and goes: of each call the check that knows what it found before says what one says that
 * knows nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../report/scarce_memory.h"
#include "random.h"
#include "src/check/call/check.h"
#include "src/state/builds/known_builds.h"
#include "tests/state/fixture.h"

enum { MEMORIES = 2, BUFFERS = 6, ACCELS = 4, SPECS = 6, CALL_MAX = 2, STEPS = 4000, LIVES = 40 };

#define BASE_OF(n) (0x100000u + 0x10000u * (n))
enum { SIZE = 0x1000 };

static const VkBaseInStructure stray = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO};

/* A build that is asked for again and again. */
struct spec {
    VkAccelerationStructureBuildGeometryInfoKHR info;
    VkAccelerationStructureGeometryKHR geometry;
    VkAccelerationStructureBuildRangeInfoKHR range;
};

struct fixture {
    struct resources *resources;
    struct device_facts device;
    bool active[RULE_COUNT];
    struct spec specs[SPECS];
};

/* ---- what a check says */

enum { TRACE_MAX = 4096 };

struct trace {
    struct fixture *fixture;
    uint64_t words[TRACE_MAX];
    uint32_t count, findings, formats_asked;
};

static void say(struct trace *trace, uint64_t word)
{
    assert_true(trace->count < TRACE_MAX);
    trace->words[trace->count++] = word;
}

/* Of some rules one finding a call is enough. */
static bool found(void *user, enum rule rule, const struct location *location,
                  const struct finding *finding)
{
    struct trace *trace = user;
    (void)finding;
    trace->findings++;
    say(trace, (uint64_t)rule << 32 | location->build);
    return rule % 2;
}

static void find_sizes(void *user, const VkAccelerationStructureBuildGeometryInfoKHR *info,
                       const uint32_t *counts, VkAccelerationStructureBuildTypeKHR build_type,
                       struct size_facts *sizes)
{
    (void)user;
    (void)info;
    (void)build_type;
    *sizes = (struct size_facts){.known = true,
                                 .acceleration_structure = 0x100 + 0x20 * (VkDeviceSize)counts[0],
                                 .build_scratch = 0x80 + 0x10 * (VkDeviceSize)counts[0],
                                 .update_scratch = 0x40};
}

static enum tristate format_supported(void *user, VkFormat format)
{
    struct trace *trace = user;
    (void)format;
    trace->formats_asked++;
    return YES;
}

static bool of_another_device(void *user, enum resource_kind kind, uint64_t handle)
{
    (void)user;
    (void)kind;
    (void)handle;
    return false;
}

static const struct check_hooks hooks = {
    .found = found,
    .find_sizes = find_sizes,
    .vertex_format_supported = format_supported,
    .radius_format_supported = format_supported,
    .of_another_device = of_another_device,
};

static void say_address(struct trace *trace, const struct address_facts *facts)
{
    say(trace, facts->status);
    if (facts->status != ADDRESS_IN_BUFFER)
        return;
    say(trace, facts->buffer_id);
    say(trace, facts->address);
}

static void say_accel(struct trace *trace, const struct accel_facts *facts)
{
    say(trace, (uint64_t)(uintptr_t)facts->handle);
    say(trace, facts->id);
    say(trace, facts->size);
    say(trace, facts->backed);
    say(trace, facts->is_sparse);
    say(trace, (uint64_t)(uintptr_t)facts->memory);
    say(trace, facts->memory ? facts->begin : 0);
}

/* What journals read of it. */
static void record_build(void *user, const struct build_view *build,
                         const struct geometry_view *geometry)
{
    struct trace *trace = user;
    say(trace, build->index);
    say_accel(trace, &build->dst);
    if (build->info->mode == VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR)
        say_accel(trace, &build->src);
    say(trace, build->sizes.known);
    if (build->sizes.known) {
        say(trace, build->sizes.acceleration_structure);
        say_address(trace, &build->scratch);
    }
    if (!geometry)
        return;
    say_address(trace, &geometry->vertex);
    say_address(trace, &geometry->index_data);
    say_address(trace, &geometry->transform);
    say_address(trace, &geometry->data);
}

static void record_geometry(void *user, const struct geometry_view *geometry)
{
    say_address(user, &geometry->vertex);
}

static void record_ranges(void *user, struct noted_ranges *ranges)
{
    struct trace *trace = user;
    say(trace, ranges ? ranges->count : 0);
    free(ranges);
}

static const struct build_recorder recorder = {.record_build = record_build,
                                               .record_geometry = record_geometry,
                                               .record_ranges = record_ranges};

static void check(struct fixture *fixture, struct known_builds *known, const uint32_t *chosen,
                  uint32_t count, struct trace *trace)
{
    VkAccelerationStructureBuildGeometryInfoKHR infos[CALL_MAX];
    const VkAccelerationStructureBuildRangeInfoKHR *ranges[CALL_MAX];
    for (uint32_t i = 0; i < count; i++) {
        infos[i] = fixture->specs[chosen[i]].info;
        ranges[i] = &fixture->specs[chosen[i]].range;
    }
    struct readable_cache readable = {0};
    struct check_context context = {.hooks = &hooks,
                                    .recorder = &recorder,
                                    .user = trace,
                                    .level = LEVEL_STATE,
                                    .active = fixture->active,
                                    .readable = &readable,
                                    .resources = fixture->resources,
                                    .known = known};
    struct call_view call = {.command = COMMAND_DEVICE,
                             .info_count = count,
                             .device = &fixture->device,
                             .infos = infos,
                             .build_ranges = ranges};
    trace->fixture = fixture;
    trace->count = trace->findings = trace->formats_asked = 0;
    check_builds(&context, &call);
}

/* ---- what happens */

static void make_buffer(struct random *random, struct fixture *fixture, unsigned n)
{
    const VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    unsigned at = random_one_in(random, 20) ? 1 + random_below(random, BUFFERS) : n;
    if (random_one_in(random, 20))
        have_sparse_buffer(fixture->resources, n, SIZE);
    else
        have_buffer(fixture->resources, n, random_one_in(random, 20) ? SIZE / 4 : SIZE,
                    random_one_in(random, 20) ? VK_BUFFER_USAGE_TRANSFER_DST_BIT : usage);
    if (!random_one_in(random, 20))
        resources_bind_buffer(
            fixture->resources, buffer(n), memory(1 + random_below(random, MEMORIES)),
            (VkDeviceSize)SIZE * (random_one_in(random, 8) ? at : n), random_one_in(random, 10));
    resources_set_address(fixture->resources, buffer(n),
                          BASE_OF(at) + (random_one_in(random, 20) ? 0x80 : 0));
}

static void make_accel(struct random *random, struct fixture *fixture, unsigned n)
{
    have_accel(fixture->resources, n, 1 + random_below(random, 2), 0x400 * (n - 1),
               random_one_in(random, 20) ? 0x80 : 0x400);
}

/* A buffer beside the others comes to share the addresses of one of them, is bound, or goes. */
static void change_alias(struct random *random, struct fixture *fixture)
{
    enum { ALIAS = BUFFERS + 1 };
    unsigned like = 1 + random_below(random, BUFFERS);
    switch (random_below(random, 3)) {
    case 0:
        resources_remove_buffer(fixture->resources, buffer(ALIAS));
        break;
    case 1:
        have_buffer(fixture->resources, ALIAS, random_one_in(random, 2) ? 2 * SIZE : SIZE / 2, 0);
        resources_set_address(fixture->resources, buffer(ALIAS), BASE_OF(like));
        break;
    default:
        bind_at(fixture->resources, ALIAS, 1 + random_below(random, MEMORIES),
                (VkDeviceSize)SIZE * like);
    }
}

/* One of the things that change what is known. */
static void change_state(struct random *random, struct fixture *fixture)
{
    unsigned b = 1 + random_below(random, BUFFERS), a = 1 + random_below(random, ACCELS);
    unsigned m = 1 + random_below(random, MEMORIES);
    switch (random_below(random, 24)) {
    case 0:
        resources_remove_buffer(fixture->resources, buffer(b));
        break;
    case 1:
    case 2:
    case 3:
        make_buffer(random, fixture, b);
        break;
    case 4:
        resources_remove_accel(fixture->resources, accel(a));
        break;
    case 5:
    case 6:
        make_accel(random, fixture, a);
        break;
    case 7:
        resources_bind_buffer(fixture->resources, buffer(b), memory(m),
                              SIZE * (VkDeviceSize)random_below(random, 4), false);
        break;
    case 8:
        resources_set_address(fixture->resources, buffer(b),
                              BASE_OF(b) + (random_one_in(random, 2) ? 0x80 : 0));
        break;
    case 9:
        change_alias(random, fixture);
        break;
    case 11:
        if (random_one_in(random, 3))
            resources_forget_binding(fixture->resources, buffer(b));
        break;
    case 10:
        if (random_one_in(random, 3))
            resources_remove_memory(fixture->resources, memory(m));
        break;
    default:
        for (m = 1; m <= MEMORIES; m++)
            have_memory(fixture->resources, m);
        for (unsigned n = 1; n <= BUFFERS; n++)
            make_buffer(random, fixture, n);
        for (unsigned n = 1; n <= ACCELS; n++)
            make_accel(random, fixture, n);
    }
}

/* Mostly in a buffer from the first to the last. */
static VkDeviceAddress some_address(struct random *random, unsigned first, unsigned last)
{
    unsigned n = random_one_in(random, 30) ? 1 + random_below(random, BUFFERS)
                                           : first + random_below(random, last - first + 1);
    VkDeviceAddress address = BASE_OF(n) + 0x100 * (VkDeviceAddress)random_below(random, 12);
    return random_one_in(random, 60) ? address + 1 : random_one_in(random, 60) ? 0 : address;
}

static void set_geometry(struct random *random, VkAccelerationStructureGeometryKHR *geometry)
{
    *geometry = (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    if (random_one_in(random, 4)) {
        geometry->geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
        geometry->geometry.aabbs = (VkAccelerationStructureGeometryAabbsDataKHR){
            .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
            .data.deviceAddress = some_address(random, 4, BUFFERS),
            .stride = random_one_in(random, 40) ? 25 : 24};
        return;
    }
    geometry->geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry->geometry.triangles = (VkAccelerationStructureGeometryTrianglesDataKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
        .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
        .vertexData.deviceAddress = some_address(random, 4, BUFFERS),
        .vertexStride = random_one_in(random, 40) ? 13 : 12,
        .maxVertex = random_one_in(random, 20) ? 3 : 30 + random_below(random, 2),
        .indexType = random_one_in(random, 3) ? VK_INDEX_TYPE_NONE_KHR : VK_INDEX_TYPE_UINT32,
        .indexData.deviceAddress = some_address(random, 4, BUFFERS),
        .transformData.deviceAddress =
            random_one_in(random, 3) ? some_address(random, 4, BUFFERS) : 0};
}

enum { MEMBERS = 18 };

static void set_member_of_triangles(struct random *random,
                                    VkAccelerationStructureGeometryTrianglesDataKHR *triangles,
                                    unsigned member)
{
    switch (member) {
    case 0:
        triangles->vertexData.deviceAddress = some_address(random, 4, BUFFERS);
        break;
    case 1:
        triangles->indexData.deviceAddress = some_address(random, 4, BUFFERS);
        break;
    default:
        triangles->transformData.deviceAddress = some_address(random, 4, BUFFERS);
    }
}

static void set_member(struct random *random, struct spec *spec, unsigned member)
{
    VkAccelerationStructureBuildGeometryInfoKHR *info = &spec->info;
    switch (member) {
    case 0:
        info->sType = random_one_in(random, 30)
                          ? VK_STRUCTURE_TYPE_APPLICATION_INFO
                          : VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
        break;
    case 1:
        info->pNext = random_one_in(random, 30) ? &stray : NULL;
        break;
    case 2:
        info->type = random_one_in(random, 20) ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                               : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
        break;
    case 3:
        info->flags = random_one_in(random, 40) ? 4 | 8 : random_below(random, 4);
        break;
    case 4:
        info->mode = (VkBuildAccelerationStructureModeKHR)(random_one_in(random, 30)
                                                               ? 7
                                                               : random_one_in(random, 4));
        break;
    case 5:
        info->srcAccelerationStructure = random_one_in(random, 3) ? accel(0)
                                         : random_one_in(random, 8)
                                             ? accel(1 + random_below(random, ACCELS))
                                             : info->dstAccelerationStructure;
        break;
    case 6:
        info->dstAccelerationStructure =
            accel(random_one_in(random, 40) ? 0 : 1 + random_below(random, ACCELS));
        break;
    case 7:
        info->scratchData.deviceAddress = some_address(random, 3, 3);
        break;
    case 8:
        spec->range.primitiveCount = random_below(random, 8);
        break;
    case 9:
        spec->range.primitiveOffset = random_one_in(random, 30) ? 4 : 8 * random_below(random, 3);
        break;
    case 10:
        spec->range.firstVertex = 20 * random_below(random, 2);
        break;
    case 11:
        spec->range.transformOffset = random_one_in(random, 30) ? 8 : 16 * random_below(random, 3);
        break;
    case 12:
        spec->geometry.flags = random_one_in(random, 40) ? 1 << 9 : random_below(random, 2);
        break;
    case 13:
        spec->geometry.sType = random_one_in(random, 10)
                                   ? VK_STRUCTURE_TYPE_APPLICATION_INFO
                                   : VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        break;
    case 14:
        if (random_one_in(random, 10))
            spec->geometry.pNext = &stray;
        else
            set_geometry(random, &spec->geometry);
        break;
    default:
        if (spec->geometry.geometryType == VK_GEOMETRY_TYPE_TRIANGLES_KHR)
            set_member_of_triangles(random, &spec->geometry.geometry.triangles, member - 15);
    }
}

static void make_spec(struct random *random, struct spec *spec)
{
    *spec = (struct spec){.info = {.geometryCount = 1}};
    set_geometry(random, &spec->geometry);
    for (unsigned member = 0; member < 14; member++)
        set_member(random, spec, member);
    spec->info.pGeometries = &spec->geometry;
}

static void make_fixture(struct random *random, struct fixture *fixture)
{
    static const bool muted[MESSAGE_ID_COUNT];
    memset(fixture, 0, sizeof(*fixture));
    fixture->resources = no_resources();
    fixture->device.acceleration_structure = true;
    fixture->device.limits.maxGeometryCount = fixture->device.limits.maxPrimitiveCount = 1 << 20;
    fixture->device.limits.minAccelerationStructureScratchOffsetAlignment = 64;
    fixture->device.extension.adds_to_inputs = random_one_in(random, 2);
    fixture->device.extension.motion_blur_nv = fixture->device.extension.adds_to_inputs;
    fixture->device.micromap.any = random_one_in(random, 3);
    check_select(COMMAND_DEVICE, LEVEL_STATE, muted, fixture->active);
    for (unsigned n = 1; n <= MEMORIES; n++)
        have_memory(fixture->resources, n);
    for (unsigned n = 1; n <= BUFFERS; n++)
        make_buffer(random, fixture, n);
    for (unsigned n = 1; n <= ACCELS; n++)
        make_accel(random, fixture, n);
    for (unsigned i = 0; i < SPECS; i++)
        make_spec(random, &fixture->specs[i]);
}

static uint32_t happen(struct random *random, struct fixture *fixture, uint32_t chosen[CALL_MAX])
{
    if (random_one_in(random, 10))
        change_state(random, fixture);
    uint32_t count = 1 + random_below(random, CALL_MAX);
    for (uint32_t i = 0; i < count; i++) {
        chosen[i] = random_below(random, SPECS);
        struct spec *spec = &fixture->specs[chosen[i]];
        if (random_one_in(random, 40))
            set_member(random, spec, random_below(random, MEMBERS));
        else if (random_one_in(random, 60))
            make_spec(random, spec);
    }
    return count;
}

/* ---- the tests */

static void test_what_is_known_changes_nothing(void **state)
{
    (void)state;
    struct random random = random_of("known builds");
    uint32_t spared = 0, calls_with_findings = 0;
    static struct trace with, without;
    static struct fixture fixture;
    for (int life = 0; life < LIVES; life++) {
        struct known_builds known = {0};
        make_fixture(&random, &fixture);
        for (int i = 0; i < STEPS; i++) {
            uint32_t chosen[CALL_MAX];
            uint32_t count = happen(&random, &fixture, chosen);
            known.rest = 0; /* there is more out of date here than it would put up with */
            check(&fixture, &known, chosen, count, &with);
            check(&fixture, NULL, chosen, count, &without);
            assert_int_equal(with.count, without.count);
            assert_memory_equal(with.words, without.words, with.count * sizeof(*with.words));
            spared += without.formats_asked - with.formats_asked;
            calls_with_findings += without.findings > 0;
        }
        known_builds_release(&known);
        resources_destroy(fixture.resources);
    }
    print_message("%u builds were known, %u calls had findings\n", spared, calls_with_findings);
    assert_true(spared > LIVES * STEPS / 20);
    assert_true(calls_with_findings > LIVES * STEPS / 20);
}

/* Where memory runs out while a state is kept less is known; where it does in a check less is
 * found.
 */
static void test_without_memory_nothing_else_is_found(void **state)
{
    (void)state;
    struct random random = random_of("known builds without memory");
    static struct trace with, without;
    static struct fixture fixture;
    uint32_t failures = 0;
    for (int life = 0; life < 4 * LIVES; life++) {
        struct known_builds known = {0};
        make_fixture(&random, &fixture);
        for (int i = 0; i < STEPS / 20; i++) {
            uint32_t chosen[CALL_MAX];
            bool fails_in_state = random_one_in(&random, 50);
            if (fails_in_state)
                memory_fail_after((int)random_below(&random, 4));
            if (fails_in_state)
                change_alias(&random, &fixture);
            uint32_t count = happen(&random, &fixture, chosen);
            failures += memory_fail_no_more();
            if (!fails_in_state && random_one_in(&random, 4))
                memory_fail_after((int)random_below(&random, 4));
            check(&fixture, &known, chosen, count, &with);
            bool failed = memory_fail_no_more();
            failures += failed;
            check(&fixture, NULL, chosen, count, &without);
            assert_true(with.findings <= without.findings);
            if (!failed)
                assert_memory_equal(with.words, without.words, with.count * sizeof(*with.words));
        }
        known_builds_release(&known);
        resources_destroy(fixture.resources);
    }
    assert_true(failures > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_known_changes_nothing),
        cmocka_unit_test(test_without_memory_nothing_else_is_found),
    };
    return cmocka_run_group_tests_name("known builds at random", tests, NULL, NULL);
}
