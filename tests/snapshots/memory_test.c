/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs of uploads, copies, dispatches and builds, played by two devices, with the layer
 * at level content and without it: the application's memory is the same after each submission, and
 * what is valid stays without a message. */
#include "tests/snapshots/memory_fixture.h"
#include "tests/snapshots/scene.h"

#include <stdlib.h>
#include <string.h>

#include "../state/random.h"

enum { PROGRAMS = 12, SUBMISSIONS = 8, STEPS = 24 };

static struct memory_fixture memory_fixtures[2]; /* with the layer, and without it */

/* ---- steps: what each does is drawn once, and recorded in both memory_fixtures */

static float random_coordinate(struct random *random)
{
    return (float)random_below(random, 2001) / 1000 - 1;
}

static void write_inputs(struct random *random, unsigned char *bytes)
{
    float *vertices = (float *)bytes;
    uint32_t *indices = (uint32_t *)(bytes + INDICES_AT);
    VkAabbPositionsKHR *boxes = (VkAabbPositionsKHR *)(bytes + BOXES_AT);
    for (int i = 0; i < 3 * VERTICES; i++)
        vertices[i] = random_coordinate(random);
    for (int i = 0; i < INDICES; i++)
        indices[i] = random_below(random, VERTICES);
    for (int i = 0; i < BOXES; i++) {
        float x = random_coordinate(random);
        boxes[i] = (VkAabbPositionsKHR){x, x, x, x + 1, x + 1, x + 1};
    }
}

/* As a build needs it, of what came before; and of what comes next, as if nobody else read. */
static void barrier(const struct memory_fixture *memory_fixture, bool is_before_build)
{
    const VkMemoryBarrier memory = VK(
        MemoryBarrier,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                         VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
        .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                         VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
    const VkPipelineStageFlags others =
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const VkPipelineStageFlags build = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    memory_fixture->fixture.vk.CmdPipelineBarrier(
        memory_fixture->commands, is_before_build ? others | build : build,
        is_before_build ? build : others | build, 0, 1, &memory, 0, NULL, 0, NULL);
}

static void build(const struct memory_fixture *memory_fixture, VkAccelerationStructureKHR dst,
                  VkAccelerationStructureTypeKHR type,
                  const VkAccelerationStructureGeometryKHR *geometry,
                  const VkAccelerationStructureBuildRangeInfoKHR *range)
{
    const VkAccelerationStructureBuildGeometryInfoKHR info =
        VK(AccelerationStructureBuildGeometryInfoKHR, .type = type, .dstAccelerationStructure = dst,
           .geometryCount = 1, .pGeometries = geometry,
           .scratchData.deviceAddress =
               (memory_fixture->scratch.address + 255) & ~(VkDeviceAddress)255);
    barrier(memory_fixture, true);
    memory_fixture->fixture.vk.CmdBuildAccelerationStructuresKHR(memory_fixture->commands, 1, &info,
                                                                 &range);
    barrier(memory_fixture, false);
}

struct step {
    int kind;
    uint32_t buffer, other, blas, first, count;
    float values[8];
};

static void build_triangles(const struct memory_fixture *memory_fixture, const struct step *step)
{
    const VkDeviceAddress address = memory_fixture->inputs[step->buffer].address;
    const bool has_indices = step->first % 2;
    const VkAccelerationStructureGeometryKHR geometry =
        VK(AccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
           .geometry.triangles =
               VK(AccelerationStructureGeometryTrianglesDataKHR,
                  .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT, .vertexStride = 12,
                  .vertexData.deviceAddress = address, .maxVertex = VERTICES - 1,
                  .indexType = has_indices ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_NONE_KHR,
                  .indexData.deviceAddress = has_indices ? address + INDICES_AT : 0));
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = 1 + step->count % 8,
        .primitiveOffset = 12 * (step->first % 8),
    };
    build(memory_fixture, memory_fixture->blases[step->blas],
          VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, &geometry, &range);
}

static void build_boxes(const struct memory_fixture *memory_fixture, const struct step *step)
{
    const VkAccelerationStructureGeometryKHR geometry =
        VK(AccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_AABBS_KHR,
           .geometry.aabbs =
               VK(AccelerationStructureGeometryAabbsDataKHR,
                  .data.deviceAddress = memory_fixture->inputs[step->buffer].address + BOXES_AT,
                  .stride = sizeof(VkAabbPositionsKHR)));
    const VkAccelerationStructureBuildRangeInfoKHR range = {
        .primitiveCount = 1 + step->count % 8, .primitiveOffset = 24 * (step->first % 8)};
    build(memory_fixture, memory_fixture->blases[step->blas],
          VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, &geometry, &range);
}

static void build_instances(const struct memory_fixture *memory_fixture, const struct step *step)
{
    const bool by_pointers = step->first % 2;
    const VkAccelerationStructureGeometryKHR geometry =
        VK(AccelerationStructureGeometryKHR, .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
           .geometry.instances =
               VK(AccelerationStructureGeometryInstancesDataKHR, .arrayOfPointers = by_pointers,
                  .data.deviceAddress =
                      memory_fixture->instances.address + (by_pointers ? POINTERS_AT : 0)));
    const VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount =
                                                                1 + step->count % INSTANCES};
    build(memory_fixture, memory_fixture->tlas, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
          &geometry, &range);
}

/* The pipeline was bound, and the other constants were pushed, when the command buffer began: with
 * a layout that may be another, but is compatible. */
static void dispatch(const struct memory_fixture *memory_fixture, const struct step *step)
{
    memory_fixture->fixture.vk.CmdPushConstants(
        memory_fixture->commands, memory_fixture->layouts[step->count % 2],
        VK_SHADER_STAGE_COMPUTE_BIT, offsetof(struct constants, value), 4, step->values);
    memory_fixture->fixture.vk.CmdDispatch(memory_fixture->commands, 1, 1, 1);
}

/* Writes come after writes of the same bytes, too. */
static void wait_for_writes(const struct memory_fixture *memory_fixture)
{
    const VkPipelineStageFlags stages =
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const VkMemoryBarrier memory = VK(
        MemoryBarrier, .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                         VK_ACCESS_SHADER_WRITE_BIT);
    memory_fixture->fixture.vk.CmdPipelineBarrier(memory_fixture->commands, stages, stages, 0, 1,
                                                  &memory, 0, NULL, 0, NULL);
}

/* Of the commands here dispatches depend on it. */
static void end_condition(struct memory_fixture *memory_fixture)
{
    if (memory_fixture->is_conditional)
        memory_fixture->fixture.vk.CmdEndConditionalRenderingEXT(memory_fixture->commands);
    memory_fixture->is_conditional = false;
}

static void begin_or_end_condition(struct memory_fixture *memory_fixture, const struct step *step)
{
    const VkConditionalRenderingBeginInfoEXT begin =
        VK(ConditionalRenderingBeginInfoEXT, .buffer = memory_fixture->conditions.handle,
           .offset = step->count % 2 * sizeof(uint32_t),
           .flags = step->first % 2 ? VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT : 0);
    if (memory_fixture->is_conditional ||
        !instance_fixture_has_conditions(&memory_fixture->fixture.instance)) {
        end_condition(memory_fixture);
        return;
    }
    memory_fixture->fixture.vk.CmdBeginConditionalRenderingEXT(memory_fixture->commands, &begin);
    memory_fixture->is_conditional = true;
}

static void record(struct memory_fixture *memory_fixture, const struct step *step)
{
    const VkuDeviceDispatchTable *vk = &memory_fixture->fixture.vk;
    const VkDeviceSize at = step->first % (VERTICES - 8) * 12;
    const VkBufferCopy region = {at, at, step->count % 8 * 12 + 12};
    switch (step->kind) {
    case 0:
        wait_for_writes(memory_fixture);
        vk->CmdUpdateBuffer(memory_fixture->commands, memory_fixture->inputs[step->buffer].handle,
                            at, sizeof(step->values), step->values);
        break;
    case 1:
        wait_for_writes(memory_fixture);
        vk->CmdFillBuffer(memory_fixture->commands, memory_fixture->inputs[step->buffer].handle,
                          INDICES_AT + step->first % (INDICES / 2) * 4, step->count % 8 * 4 + 4,
                          step->count % VERTICES);
        break;
    case 2:
        wait_for_writes(memory_fixture);
        vk->CmdCopyBuffer(memory_fixture->commands, memory_fixture->inputs[0].handle,
                          memory_fixture->inputs[step->other].handle, 1, &region);
        break;
    case 3:
        wait_for_writes(memory_fixture);
        dispatch(memory_fixture, step);
        break;
    case 4:
        build_boxes(memory_fixture, step);
        break;
    case 5:
        build_instances(memory_fixture, step);
        break;
    case 8:
        begin_or_end_condition(memory_fixture, step);
        break;
    default:
        build_triangles(memory_fixture, step);
        break;
    }
}

static struct step draw(struct random *random)
{
    struct step step = {
        .kind = (int)random_below(random, 9),
        .buffer = random_below(random, BUFFERS),
        .other = 1 + random_below(random, BUFFERS - 1),
        .blas = random_below(random, BLASES),
        .first = random_below(random, 1000),
        .count = random_below(random, 1000),
    };
    for (int i = 0; i < 8; i++)
        step.values[i] = random_coordinate(random);
    return step;
}

/* ---- programs */

static void begin(struct memory_fixture *memory_fixture, uint32_t word)
{
    const struct constants constants = {.other = {1, 2, 3, 4},
                                        .target = memory_fixture->inputs[1].address + word * 4};
    memory_fixture->commands = fixture_begin(&memory_fixture->fixture, 0);
    memory_fixture->fixture.vk.CmdBindPipeline(
        memory_fixture->commands, VK_PIPELINE_BIND_POINT_COMPUTE, memory_fixture->fill);
    memory_fixture->fixture.vk.CmdPushConstants(
        memory_fixture->commands, memory_fixture->layouts[0], VK_SHADER_STAGE_COMPUTE_BIT, 0,
        sizeof(constants), &constants);
}

static void expect_same_memory(void)
{
    for (int i = 0; i < BUFFERS; i++)
        assert_memory_equal(memory_fixtures[0].inputs[i].bytes, memory_fixtures[1].inputs[i].bytes,
                            SIZE);
    for (int w = 0; w < 2; w++)
        assert_memory_equal(memory_fixtures[w].instances.bytes,
                            memory_fixtures[w].instances_written,
                            sizeof(memory_fixtures[w].instances_written));
    fixture_expect_silence(&memory_fixtures[0].fixture);
}

static void play(struct random *random, uint32_t steps, bool builds_all)
{
    struct step drawn[STEPS];
    uint32_t word = random_below(random, 3 * VERTICES);
    for (uint32_t i = 0; i < steps; i++) {
        drawn[i] = draw(random);
        if (builds_all)
            drawn[i] = (struct step){.kind = 7, .blas = i};
    }
    for (int w = 0; w < 2; w++) {
        begin(&memory_fixtures[w], word);
        for (uint32_t i = 0; i < steps; i++)
            record(&memory_fixtures[w], &drawn[i]);
        end_condition(&memory_fixtures[w]);
        fixture_finish(&memory_fixtures[w].fixture, memory_fixtures[w].commands);
    }
    expect_same_memory();
}

TEST(test_memory_is_the_same)
{
    struct random random = random_of("memory_test");
    for (int program = 0; program < PROGRAMS; program++) {
        memory_fixture_open(&memory_fixtures[0], &platform, true);
        memory_fixture_open(&memory_fixtures[1], &platform, false);
        for (int i = 0; i < BUFFERS; i++) {
            write_inputs(&random, memory_fixtures[0].inputs[i].bytes);
            memcpy(memory_fixtures[1].inputs[i].bytes, memory_fixtures[0].inputs[i].bytes, SIZE);
        }
        play(&random, BLASES, true);
        for (int i = 0; i < SUBMISSIONS; i++)
            play(&random, STEPS, false);
        memory_fixture_close(&memory_fixtures[0]);
        memory_fixture_close(&memory_fixtures[1]);
    }
}
