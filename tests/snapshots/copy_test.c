/* SPDX-License-Identifier: Apache-2.0 */
/* The shader that copies, by itself: sources of any alignment and size, against memcpy(). */
#include "tests/snapshots/fixture.h"

#include <stdio.h>
#include <string.h>

#include "../state/random.h"
#include "src/snapshots/recorded_build.h"

static const uint32_t code[] = {
#include "copy_comp.h"
};

enum {
    ORDERS = 300,
    SMALL_MAX = 300,
    ROOM = COPY_SIZE_MAX, /* of each target, */
    LARGE = 7,            /* and every so many sources are nearly as large */
    SOURCE_SIZE = 1 << 18,
    UNTOUCHED = 0xa5,
};

static struct platform platform;
static struct fixture fixture;
static VkPipelineLayout layout;
static VkPipeline pipeline;
static struct fixture_buffer source, target, list, gate;

static void create_pipeline(void)
{
    const VkuDeviceDispatchTable *vk = &fixture.vk;
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 2 * sizeof(uint64_t)};
    const VkPipelineLayoutCreateInfo layout_info = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    const VkShaderModuleCreateInfo module_info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = sizeof(code),
        .pCode = code,
    };
    VkShaderModule module;
    GET(vk->CreatePipelineLayout(fixture.device, &layout_info, NULL, &layout));
    GET(vk->CreateShaderModule(fixture.device, &module_info, NULL, &module));
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main"},
        .layout = layout,
    };
    GET(vk->CreateComputePipelines(fixture.device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline));
    vk->DestroyShaderModule(fixture.device, module, NULL);
}

static void open_fixture(void)
{
    fixture_open(&fixture, &platform, &(struct fixture_setup){.has_layer = false});
    create_pipeline();
    source = fixture_buffer(&fixture, SOURCE_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    target =
        fixture_buffer(&fixture, (VkDeviceSize)ORDERS * ROOM, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    gate = fixture_buffer(&fixture, sizeof(uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    list = fixture_buffer(&fixture, ORDERS * sizeof(struct copy_order),
                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
}

static void close_fixture(void)
{
    fixture_destroy_buffer(&fixture, &source);
    fixture_destroy_buffer(&fixture, &target);
    fixture_destroy_buffer(&fixture, &gate);
    fixture_destroy_buffer(&fixture, &list);
    fixture.vk.DestroyPipeline(fixture.device, pipeline, NULL);
    fixture.vk.DestroyPipelineLayout(fixture.device, layout, NULL);
    fixture_close(&fixture);
}

static struct copy_order draw(struct random *random, uint32_t i)
{
    uint32_t size = i % LARGE ? random_below(random, SMALL_MAX)
                              : COPY_SIZE_MAX - random_below(random, SMALL_MAX);
    uint64_t left = size;
    if (i % 3 == 1)
        left = random_below(random, size + 1);
    if (i % 3 == 2)
        left = size + ((uint64_t)random_below(random, 2) << 32);
    return (struct copy_order){
        .source = source.address + random_below(random, SOURCE_SIZE - COPY_SIZE_MAX),
        .target = target.address + (uint64_t)i * ROOM,
        .size = size,
        .left = left,
    };
}

static void run(bool is_open)
{
    *(uint32_t *)gate.bytes = is_open;
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    fixture.vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    const VkDeviceAddress constants[] = {gate.address, list.address};
    fixture.vk.CmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(constants),
                                constants);
    fixture.vk.CmdDispatch(commands, ORDERS, 1, 1);
    fixture_barrier(&fixture, commands);
    fixture_finish(&fixture, commands);
}

static void test_copies(void **state)
{
    (void)state;
    open_fixture();
    struct random random = random_of("copy_test");
    struct copy_order *orders = (struct copy_order *)list.bytes;
    for (uint32_t i = 0; i < SOURCE_SIZE; i++)
        source.bytes[i] = (unsigned char)random_below(&random, 256);
    memset(target.bytes, UNTOUCHED, target.size);
    for (uint32_t i = 0; i < ORDERS; i++)
        orders[i] = draw(&random, i);
    run(true);
    for (uint32_t i = 0; i < ORDERS; i++) {
        const unsigned char *to = target.bytes + (size_t)i * ROOM;
        uint64_t size = orders[i].left < orders[i].size ? orders[i].left : orders[i].size;
        assert_int_equal(orders[i].is_done, 1);
        assert_memory_equal(to, source.bytes + (orders[i].source - source.address), size);
        for (uint64_t at = (size + 3) / 4 * 4; at < ROOM; at++)
            assert_int_equal(to[at], UNTOUCHED);
    }
    close_fixture();
}

static void test_closed_gate(void **state)
{
    (void)state;
    open_fixture();
    struct copy_order *orders = (struct copy_order *)list.bytes;
    memset(target.bytes, UNTOUCHED, target.size);
    for (uint32_t i = 0; i < ORDERS; i++)
        orders[i] = (struct copy_order){.source = source.address,
                                        .target = target.address,
                                        .left = sizeof(uint32_t),
                                        .size = sizeof(uint32_t)};
    run(false);
    for (uint32_t i = 0; i < ORDERS; i++)
        assert_int_equal(orders[i].is_done, 0);
    assert_int_equal(target.bytes[0], UNTOUCHED);
    close_fixture();
}

int main(int argc, char **argv)
{
    const char *reason = platform_open(&platform, argc > 1 ? argv[1] : "lavapipe");
    if (reason) {
        puts(reason);
        return 77;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_copies),
                                       cmocka_unit_test(test_closed_gate)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
