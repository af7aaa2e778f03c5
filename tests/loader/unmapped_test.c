/* SPDX-License-Identifier: Apache-2.0 */
/* Arrays of a large call that are unmapped right after it and handed over again: the layer reports
 * them and doesn't read them. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include <sys/mman.h>

#include "loader_test.h"

#define ID "VUID-vkCmdBuildAccelerationStructuresKHR-pInfos-parameter"

enum { BUILDS = 64, ROUNDS = 20 };

typedef VkAccelerationStructureBuildGeometryInfoKHR build_info;

static struct fixture fixture;

/* Many copies of one build, of handles that are not looked up at level parameters. */
static build_info *map_infos(const struct scene *scene)
{
    build_info *infos = mmap(NULL, BUILDS * sizeof(*infos), PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(infos, MAP_FAILED);
    for (uint32_t i = 0; i < BUILDS; i++) {
        infos[i] = scene->infos[INDEXED];
        infos[i].dstAccelerationStructure = (VkAccelerationStructureKHR)(uintptr_t)(1 + i);
    }
    return infos;
}

static void open_fixture(void)
{
    static const struct setup parameters = {.level = "parameters"};
    assert_null(fixture_open(&fixture, &platform, &parameters));
}

static void close_fixture(void)
{
    fixture_close(&fixture);
}

TEST_BETWEEN(test_infos_are_probed_anew, open_fixture, close_fixture)
{
    static const VkAccelerationStructureBuildRangeInfoKHR *ranges[BUILDS];
    struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
    for (uint32_t i = 0; i < BUILDS; i++)
        ranges[i] = scene->ranges[INDEXED];
    fixture.instance.messages.answer = VK_TRUE; /* nothing goes down */
    for (int round = 0; round < ROUNDS; round++) {
        build_info *infos = map_infos(scene);
        messages_clear(&fixture.instance.messages);
        scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, BUILDS, infos, ranges);
        assert_int_equal(messages_count(&fixture.instance.messages, ID, NULL), 0);
        munmap(infos, BUILDS * sizeof(*infos));
        messages_clear(&fixture.instance.messages);
        scene->vk->CmdBuildAccelerationStructuresKHR(scene->command_buffer, BUILDS, infos, ranges);
        assert_int_equal(messages_count(&fixture.instance.messages, ID, NULL), 1);
    }
    fixture.instance.messages.answer = VK_FALSE;
    scene_close(scene);
}
