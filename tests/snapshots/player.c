/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs of builds, structures, and a shader that writes. */
#include "tests/snapshots/player.h"

#include <string.h>

static const uint32_t fill_code[] = {
#include "fill_comp.h"
};

static void write_instances(struct player *player)
{
    VkAccelerationStructureInstanceKHR instances[INSTANCES] = {0};
    uint64_t pointers[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        for (int j = 0; j < 3; j++)
            instances[i].transform.matrix[j][j] = 1;
        instances[i].mask = 0xff;
        instances[i].accelerationStructureReference = structure_address(
            &player->fixture.vk, player->fixture.device, player->blases[i % BLASES]);
        pointers[i] = player->instances.address + i * sizeof(instances[0]);
    }
    memcpy(player->instances_written, instances, sizeof(instances));
    memcpy(player->instances_written + POINTERS_AT, pointers, sizeof(pointers));
    memcpy(player->instances.bytes, player->instances_written, sizeof(player->instances_written));
}

/* Only the first of the inputs can be copied from by the application. */
void player_open(struct player *player, const struct platform *platform, bool has_layer)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const struct instance_settings settings = {.level = "content", .without_layer = !has_layer};
    struct fixture *fixture = &player->fixture;
    fixture_open(fixture, platform, &settings);
    for (int i = 0; i < BUFFERS; i++)
        player->inputs[i] = fixture_buffer(
            fixture, SIZE, input | (i ? 0 : (VkBufferUsageFlags)VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
    player->instances = fixture_buffer(fixture, sizeof(player->instances_written), input);
    player->scratch = fixture_buffer(fixture, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    player->structures = fixture_buffer(fixture, (BLASES + 1) * STRUCTURE_SIZE,
                                        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    for (int i = 0; i < BLASES; i++)
        player->blases[i] =
            fixture_structure(fixture, &player->structures, i * STRUCTURE_SIZE, STRUCTURE_SIZE,
                              VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    player->tlas = fixture_structure(fixture, &player->structures, BLASES * STRUCTURE_SIZE,
                                     STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    player->conditions = fixture_buffer(fixture, 2 * sizeof(uint32_t),
                                        instance_fixture_has_conditions(&fixture->instance)
                                            ? VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT
                                            : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    ((uint32_t *)player->conditions.bytes)[1] = 1;
    write_instances(player);
    for (int i = 0; i < 2; i++)
        player->layouts[i] =
            constants_layout_create(&fixture->vk, fixture->device, 0, sizeof(struct constants));
    player->fill = compute_pipeline_create(&fixture->vk, fixture->device, player->layouts[0],
                                           fill_code, sizeof(fill_code));
}

void player_close(struct player *player)
{
    const struct fixture *fixture = &player->fixture;
    fixture->vk.DestroyPipeline(fixture->device, player->fill, NULL);
    for (int i = 0; i < 2; i++)
        fixture->vk.DestroyPipelineLayout(fixture->device, player->layouts[i], NULL);
    fixture_close(&player->fixture);
}
