/* SPDX-License-Identifier: Apache-2.0 */
/* Random programs of uploads, copies, dispatches and builds, played by two devices, with the layer
 * at level content and without it: the application's memory is the same after each submission, and
 * what is valid stays without a message. */
#include "tests/snapshots/scene.h"

#include <string.h>

#include "tests/unit/random.h"

enum { PROGRAMS = 12, SUBMISSIONS = 8, STEPS = 24 };

/* ---- a device with what programs work on, all of which the host can read */

enum {
    BUFFERS = 3,
    VERTICES = 64, /* in each buffer: of 3 floats, then */
    INDICES = 96,  /* each below VERTICES, */
    BOXES = 16,
    INDICES_AT = VERTICES * 12,
    BOXES_AT = INDICES_AT + INDICES * 4,
    INPUT_SIZE = BOXES_AT + BOXES * sizeof(VkAabbPositionsKHR),
    BLASES = 4,
    INSTANCES = 6,
    POINTERS_AT = INSTANCES * sizeof(VkAccelerationStructureInstanceKHR),
    STRUCTURE_SIZE = 1 << 16,
    SCRATCH_SIZE = 1 << 18,
};

/* As fill.comp has them, behind what other constants there are. */
struct constants {
    uint32_t other[4];
    uint64_t target;
    uint32_t value;
};

struct player {
    struct fixture fixture;
    struct device_buffer inputs[BUFFERS], instances, structures, scratch;
    struct device_buffer conditions; /* two words: one that is false, and one that is true */
    bool is_conditional;             /* the command buffer that is recorded */
    unsigned char instances_written[POINTERS_AT + INSTANCES * 8]; /* by the host, alone */
    VkAccelerationStructureKHR blases[BLASES], tlas;
    VkPipelineLayout layouts[2]; /* with the same push constants: compatible */
    VkPipeline fill;
    VkCommandBuffer commands;
};

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
static void player_open(struct player *player, bool has_layer)
{
    const VkBufferUsageFlags input =
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
        VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const struct instance_settings settings = {.level = "content", .without_layer = !has_layer};
    struct fixture *own = &player->fixture;
    fixture_open(own, &platform, &settings);
    for (int i = 0; i < BUFFERS; i++)
        player->inputs[i] =
            fixture_buffer(own, INPUT_SIZE,
                           input | (i ? 0 : (VkBufferUsageFlags)VK_BUFFER_USAGE_TRANSFER_SRC_BIT));
    player->instances = fixture_buffer(own, sizeof(player->instances_written), input);
    player->scratch = fixture_buffer(own, SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    player->structures = fixture_buffer(own, (BLASES + 1) * STRUCTURE_SIZE,
                                        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR);
    for (int i = 0; i < BLASES; i++)
        player->blases[i] =
            fixture_structure(own, &player->structures, i * STRUCTURE_SIZE, STRUCTURE_SIZE,
                              VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    player->tlas = fixture_structure(own, &player->structures, BLASES * STRUCTURE_SIZE,
                                     STRUCTURE_SIZE, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
    player->conditions = fixture_buffer(own, 2 * sizeof(uint32_t),
                                        instance_fixture_has_conditions(&own->instance)
                                            ? VK_BUFFER_USAGE_CONDITIONAL_RENDERING_BIT_EXT
                                            : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    ((uint32_t *)player->conditions.bytes)[1] = 1;
    write_instances(player);
    for (int i = 0; i < 2; i++)
        player->layouts[i] =
            constants_layout_create(&own->vk, own->device, 0, sizeof(struct constants));
    player->fill = compute_pipeline_create(&own->vk, own->device, player->layouts[0], fill_code,
                                           sizeof(fill_code));
}

static void player_close(struct player *player)
{
    const struct fixture *own = &player->fixture;
    own->vk.DestroyPipeline(own->device, player->fill, NULL);
    for (int i = 0; i < 2; i++)
        own->vk.DestroyPipelineLayout(own->device, player->layouts[i], NULL);
    fixture_close(&player->fixture);
}

static struct player players[2]; /* with the layer, and without it */

/* ---- steps: what each does is drawn once, and recorded in both players */

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

/* The barrier that a build needs: for what came before it, and for what comes next. */
static void barrier(const struct player *player, bool is_before_build)
{
    const STRUCT(VkMemoryBarrier, memory,
                 .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                                  VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                 .dstAccessMask = VK_ACCESS_SHADER_READ_BIT |
                                  VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                                  VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
    const VkPipelineStageFlags others =
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const VkPipelineStageFlags build = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    player->fixture.vk.CmdPipelineBarrier(
        player->commands, is_before_build ? others | build : build,
        is_before_build ? build : others | build, 0, 1, &memory, 0, NULL, 0, NULL);
}

static void build(struct player *player, VkAccelerationStructureKHR dst,
                  VkAccelerationStructureTypeKHR type, struct fixture_build *of)
{
    of->info.type = type;
    of->info.dstAccelerationStructure = dst;
    of->info.scratchData.deviceAddress = (player->scratch.address + 255) & ~(VkDeviceAddress)255;
    barrier(player, true);
    fixture_build(&player->fixture, player->commands, of);
    barrier(player, false);
}

struct step {
    int kind;
    uint32_t buffer, other, blas, first, count;
    float values[8];
};

static void build_triangles(struct player *player, const struct step *step)
{
    const VkDeviceAddress address = player->inputs[step->buffer].address;
    const bool has_indices = step->first % 2;
    struct fixture_build triangles = {
        .geometry = triangles_geometry(address, VERTICES - 1,
                                       has_indices ? VK_INDEX_TYPE_UINT32 : VK_INDEX_TYPE_NONE_KHR,
                                       has_indices ? address + INDICES_AT : 0),
        .range = {.primitiveCount = 1 + step->count % 8,
                  .primitiveOffset = 12 * (step->first % 8)}};
    build(player, player->blases[step->blas], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
          &triangles);
}

static void build_boxes(struct player *player, const struct step *step)
{
    struct fixture_build boxes = {
        .geometry = boxes_geometry(player->inputs[step->buffer].address + BOXES_AT,
                                   sizeof(VkAabbPositionsKHR)),
        .range = {.primitiveCount = 1 + step->count % 8,
                  .primitiveOffset = 24 * (step->first % 8)}};
    build(player, player->blases[step->blas], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
          &boxes);
}

static void build_instances(struct player *player, const struct step *step)
{
    const bool by_pointers = step->first % 2;
    struct fixture_build instances = {
        .geometry = instances_geometry(player->instances.address + (by_pointers ? POINTERS_AT : 0),
                                       by_pointers),
        .range.primitiveCount = 1 + step->count % INSTANCES};
    build(player, player->tlas, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, &instances);
}

/* The pipeline was bound, and the other constants were pushed, when the command buffer began: with
 * a layout that may be another, but is compatible. */
static void dispatch(const struct player *player, const struct step *step)
{
    player->fixture.vk.CmdPushConstants(player->commands, player->layouts[step->count % 2],
                                        VK_SHADER_STAGE_COMPUTE_BIT,
                                        offsetof(struct constants, value), 4, step->values);
    player->fixture.vk.CmdDispatch(player->commands, 1, 1, 1);
}

/* Writes come after writes of the same bytes, too. */
static void wait_for_writes(const struct player *player)
{
    const VkPipelineStageFlags stages =
        VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    const STRUCT(VkMemoryBarrier, memory,
                 .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT,
                 .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT |
                                  VK_ACCESS_SHADER_WRITE_BIT);
    player->fixture.vk.CmdPipelineBarrier(player->commands, stages, stages, 0, 1, &memory, 0, NULL,
                                          0, NULL);
}

/* Dispatches are the only commands here that depend on the condition. */
static void end_condition(struct player *player)
{
    if (player->is_conditional)
        player->fixture.vk.CmdEndConditionalRenderingEXT(player->commands);
    player->is_conditional = false;
}

static void begin_or_end_condition(struct player *player, const struct step *step)
{
    const STRUCT(VkConditionalRenderingBeginInfoEXT, begin, .buffer = player->conditions.handle,
                 .offset = step->count % 2 * sizeof(uint32_t),
                 .flags = step->first % 2 ? VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT : 0);
    if (player->is_conditional || !instance_fixture_has_conditions(&player->fixture.instance)) {
        end_condition(player);
        return;
    }
    player->fixture.vk.CmdBeginConditionalRenderingEXT(player->commands, &begin);
    player->is_conditional = true;
}

static void record(struct player *player, const struct step *step)
{
    const VkuDeviceDispatchTable *vk = &player->fixture.vk;
    const VkDeviceSize at = step->first % (VERTICES - 8) * 12;
    const VkBufferCopy region = {at, at, step->count % 8 * 12 + 12};
    if (step->kind <= 3) /* it writes, too */
        wait_for_writes(player);
    switch (step->kind) {
    case 0:
        vk->CmdUpdateBuffer(player->commands, player->inputs[step->buffer].handle, at,
                            sizeof(step->values), step->values);
        break;
    case 1:
        vk->CmdFillBuffer(player->commands, player->inputs[step->buffer].handle,
                          INDICES_AT + step->first % (INDICES / 2) * 4, step->count % 8 * 4 + 4,
                          step->count % VERTICES);
        break;
    case 2:
        vk->CmdCopyBuffer(player->commands, player->inputs[0].handle,
                          player->inputs[step->other].handle, 1, &region);
        break;
    case 3:
        dispatch(player, step);
        break;
    case 4:
        build_boxes(player, step);
        break;
    case 5:
        build_instances(player, step);
        break;
    case 8:
        begin_or_end_condition(player, step);
        break;
    default:
        build_triangles(player, step);
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

static void begin(struct player *player, uint32_t word)
{
    const struct constants constants = {.other = {1, 2, 3, 4},
                                        .target = player->inputs[1].address + word * 4};
    player->commands = fixture_begin(&player->fixture, 0);
    player->fixture.vk.CmdBindPipeline(player->commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                       player->fill);
    player->fixture.vk.CmdPushConstants(player->commands, player->layouts[0],
                                        VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(constants),
                                        &constants);
}

static void expect_same_memory(void)
{
    for (int i = 0; i < BUFFERS; i++)
        assert_memory_equal(players[0].inputs[i].bytes, players[1].inputs[i].bytes, INPUT_SIZE);
    for (int w = 0; w < 2; w++)
        assert_memory_equal(players[w].instances.bytes, players[w].instances_written,
                            sizeof(players[w].instances_written));
    fixture_expect_silence(&players[0].fixture);
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
        begin(&players[w], word);
        for (uint32_t i = 0; i < steps; i++)
            record(&players[w], &drawn[i]);
        end_condition(&players[w]);
        fixture_finish(&players[w].fixture, players[w].commands);
    }
    expect_same_memory();
}

TEST(test_memory_is_the_same)
{
    struct random random = random_of("memory_test");
    for (int program = 0; program < PROGRAMS; program++) {
        player_open(&players[0], true);
        player_open(&players[1], false);
        for (int i = 0; i < BUFFERS; i++) {
            write_inputs(&random, players[0].inputs[i].bytes);
            memcpy(players[1].inputs[i].bytes, players[0].inputs[i].bytes, INPUT_SIZE);
        }
        play(&random, BLASES, true);
        for (int i = 0; i < SUBMISSIONS; i++)
            play(&random, STEPS, false);
        player_close(&players[0]);
        player_close(&players[1]);
    }
}
