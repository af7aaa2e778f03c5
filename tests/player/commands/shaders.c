/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of programs that run shaders:
 *
 *     shade PLACE COUNT NUMBER    a dispatch, which writes COUNT floats of a value
 *     shade set PLACE COUNT NUMBER            the same to the buffer of a descriptor set
 *     dispatch                    once more, with what is bound
 *     trace TOP                   a dispatch with a ray query; with VK_KHR_ray_query
 *     trace set TOP [TOP]         the same with a descriptor set in which the first one is used;
 *                                 on a device on which no `trace TOP` is
 *     trace set                   with the last such set
 *     trace if COUNT set [TOP]    by a shader that traces if its push constant is not 0
 *     trace disabled set [TOP]    by the same shader, whose specialization never traces
 *     trace pushed TOP [TOP]      with pushed descriptors; with VK_KHR_push_descriptor
 *     rays COUNT TOP              vkCmdTraceRaysKHR with a descriptor set; its shader traces if
 *                                 its push constant is not 0: only null
 *     rays [none | indirect]      with what is bound: one ray, none, or a size in memory
 *     condition begin PLACE [inverted]        conditional rendering, with its extension
 *     condition end
 *     draw                        vkCmdDraw without a pipeline: only null */
#include "tests/player/play.h"

#include <stdlib.h>

#include "rays_rgen.h"
#include "shade_comp.h"
#include "shade_set_comp.h"
#include "trace_comp.h"
#include "trace_if_comp.h"
#include "trace_set_comp.h"

/* A binding has as many pushed descriptors as the layer tracks structures of a command. */
enum { SETS = 16, SET_BINDINGS = 2, PUSHED = 16 };

/* The constants of shaders. */
struct constants {
    VkDeviceAddress address;
    uint32_t count;
    float number;
};

/* The code of a pipeline's only shader. */
struct code {
    const uint32_t *words;
    size_t size;
    VkShaderStageFlagBits stage;
    const VkSpecializationInfo *constants;
};

#define CODE_OF(array) .words = array, .size = sizeof(array)

static void create_pipeline(struct play *play, struct play_shader *shader, const struct code *code,
                            const VkPipelineShaderStageCreateInfo *stage)
{
    const STRUCT(VkComputePipelineCreateInfo, compute, .stage = *stage, .layout = shader->layout);
    const STRUCT(VkRayTracingShaderGroupCreateInfoKHR, group,
                 .type = VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR,
                 .closestHitShader = VK_SHADER_UNUSED_KHR, .anyHitShader = VK_SHADER_UNUSED_KHR,
                 .intersectionShader = VK_SHADER_UNUSED_KHR);
    const STRUCT(VkRayTracingPipelineCreateInfoKHR, rays, .stageCount = 1, .pStages = stage,
                 .groupCount = 1, .pGroups = &group, .maxPipelineRayRecursionDepth = 1,
                 .layout = shader->layout);
    if (code->stage == VK_SHADER_STAGE_COMPUTE_BIT)
        GET(play->vk.CreateComputePipelines(play->device, VK_NULL_HANDLE, 1, &compute, NULL,
                                            &shader->pipeline));
    else
        GET(play->vk.CreateRayTracingPipelinesKHR(play->device, VK_NULL_HANDLE, VK_NULL_HANDLE, 1,
                                                  &rays, NULL, &shader->pipeline));
}

/* Creates a pipeline, unless the program has it already. */
static void make_pipeline(struct play *play, struct play_shader *shader, const struct code *code)
{
    const VkPushConstantRange range = {code->stage, 0, sizeof(struct constants)};
    VkShaderModule module;
    if (shader->pipeline)
        return;
    GET(play->vk.CreatePipelineLayout(
        play->device,
        &MAKE(VkPipelineLayoutCreateInfo, .setLayoutCount = shader->set != VK_NULL_HANDLE,
              .pSetLayouts = &shader->set, .pushConstantRangeCount = 1,
              .pPushConstantRanges = &range),
        NULL, &shader->layout));
    GET(play->vk.CreateShaderModule(
        play->device, &MAKE(VkShaderModuleCreateInfo, .codeSize = code->size, .pCode = code->words),
        NULL, &module));
    create_pipeline(play, shader, code,
                    &MAKE(VkPipelineShaderStageCreateInfo, .stage = code->stage, .module = module,
                          .pName = "main", .pSpecializationInfo = code->constants));
    play->vk.DestroyShaderModule(play->device, module, NULL);
}

static VkPipelineBindPoint point_of(VkShaderStageFlagBits stage)
{
    return stage == VK_SHADER_STAGE_COMPUTE_BIT ? VK_PIPELINE_BIND_POINT_COMPUTE
                                                : VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR;
}

static void bind(struct play *play, const struct play_shader *shader, VkShaderStageFlagBits stage,
                 const struct constants *constants)
{
    const VkCommandBuffer commands = play_commands(play);
    play->vk.CmdBindPipeline(commands, point_of(stage), shader->pipeline);
    play->vk.CmdPushConstants(commands, shader->layout, stage, 0, sizeof(*constants), constants);
}

static void dispatch(struct play *play, const struct play_shader *shader,
                     const struct constants *constants)
{
    bind(play, shader, VK_SHADER_STAGE_COMPUTE_BIT, constants);
    play->vk.CmdDispatch(play_commands(play), 1, 1, 1);
}

static void shade(struct play *play, char **words)
{
    struct play_shader *shader = &play->shaders[PLAY_SHADE];
    make_pipeline(play, shader,
                  &(struct code){CODE_OF(shade_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT});
    dispatch(play, shader,
             &(struct constants){play_address(play, words[1]), (uint32_t)atoi(words[2]),
                                 (float)atof(words[3])});
}

static void trace(struct play *play, const char *name)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE];
    const STRUCT(VkAccelerationStructureDeviceAddressInfoKHR, info,
                 .accelerationStructure = play_object(play, name)->structure);
    make_pipeline(play, shader,
                  &(struct code){CODE_OF(trace_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT});
    dispatch(play, shader,
             &(struct constants){.address = play->vk.GetAccelerationStructureDeviceAddressKHR(
                                     play->device, &info)});
}

static void set_condition(struct play *play, char **words)
{
    VkDeviceSize offset = 0;
    if (play_is(words[1], "begin"))
        play->vk.CmdBeginConditionalRenderingEXT(
            play_commands(play),
            &MAKE(VkConditionalRenderingBeginInfoEXT,
                  .buffer = play_place(play, words[2], &offset)->buffer.handle, .offset = offset,
                  .flags = play_is(words[3], "inverted") ? VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT
                                                         : 0));
    else
        play->vk.CmdEndConditionalRenderingEXT(play_commands(play));
}

/* The layout has two bindings, of arrays if its sets are pushed. */
static void make_layout(struct play *play, struct play_shader *shader, VkDescriptorType type,
                        VkShaderStageFlags stages, VkDescriptorSetLayoutCreateFlags flags)
{
    const uint32_t count = flags ? PUSHED : 1;
    const VkDescriptorSetLayoutBinding bindings[SET_BINDINGS] = {{0, type, count, stages, NULL},
                                                                 {1, type, count, stages, NULL}};
    if (!shader->set)
        GET(play->vk.CreateDescriptorSetLayout(play->device,
                                               &MAKE(VkDescriptorSetLayoutCreateInfo,
                                                     .flags = flags, .bindingCount = SET_BINDINGS,
                                                     .pBindings = bindings),
                                               NULL, &shader->set));
}

/* The pool has so many sets as a program needs. */
static void make_sets(struct play *play, struct play_shader *shader, VkDescriptorType type,
                      VkShaderStageFlags stages)
{
    const VkDescriptorPoolSize size = {type, SETS * SET_BINDINGS};
    make_layout(play, shader, type, stages, 0);
    if (!shader->pool)
        GET(play->vk.CreateDescriptorPool(play->device,
                                          &MAKE(VkDescriptorPoolCreateInfo, .maxSets = SETS,
                                                .poolSizeCount = 1, .pPoolSizes = &size),
                                          NULL, &shader->pool));
}

/* Writes to a set, or pushes if that is null. */
static void write_top(struct play *play, const struct play_shader *shader, VkDescriptorSet set,
                      uint32_t binding, uint32_t element, const char *name)
{
    const STRUCT(VkWriteDescriptorSetAccelerationStructureKHR, top, .accelerationStructureCount = 1,
                 .pAccelerationStructures = &play_object(play, name)->structure);
    const STRUCT(VkWriteDescriptorSet, write, .pNext = &top, .dstSet = set, .dstBinding = binding,
                 .dstArrayElement = element, .descriptorCount = 1,
                 .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR);
    if (set)
        play->vk.UpdateDescriptorSets(play->device, 1, &write, 0, NULL);
    else
        play->vk.CmdPushDescriptorSetKHR(play_commands(play), VK_PIPELINE_BIND_POINT_COMPUTE,
                                         shader->layout, 0, 1, &write);
}

static void allocate_set(struct play *play, struct play_shader *shader)
{
    GET(play->vk.AllocateDescriptorSets(play->device,
                                        &MAKE(VkDescriptorSetAllocateInfo,
                                              .descriptorPool = shader->pool,
                                              .descriptorSetCount = 1, .pSetLayouts = &shader->set),
                                        &shader->last_set));
}

/* Makes a set of the structures, unless there are none: then the last set is bound again. */
static void bind_tops(struct play *play, struct play_shader *shader, const struct code *code,
                      char **names)
{
    make_sets(play, shader, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, code->stage);
    make_pipeline(play, shader, code);
    if (names[0])
        allocate_set(play, shader);
    for (uint32_t i = 0; names[i]; i++)
        write_top(play, shader, shader->last_set, i, 0, names[i]);
    play->vk.CmdBindDescriptorSets(play_commands(play), point_of(code->stage), shader->layout, 0, 1,
                                   &shader->last_set, 0, NULL);
}

static void trace_set(struct play *play, char **names)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE_SET];
    bind_tops(play, shader,
              &(struct code){CODE_OF(trace_set_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT}, names);
    dispatch(play, shader, &(struct constants){.count = 0});
}

static void trace_if(struct play *play, uint32_t count, bool is_enabled, char **names)
{
    const VkBool32 enabled = is_enabled;
    const VkSpecializationMapEntry entry = {0, 0, sizeof(enabled)};
    const VkSpecializationInfo constants = {1, &entry, sizeof(enabled), &enabled};
    struct play_shader *shader = &play->shaders[is_enabled ? PLAY_TRACE_IF : PLAY_TRACE_DISABLED];
    bind_tops(play, shader,
              &(struct code){CODE_OF(trace_if_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                             .constants = &constants},
              names);
    dispatch(play, shader, &(struct constants){.count = count});
}

static void trace_pushed(struct play *play, char **names)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE_PUSHED];
    make_layout(play, shader, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
                VK_SHADER_STAGE_COMPUTE_BIT, VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT);
    make_pipeline(play, shader,
                  &(struct code){CODE_OF(trace_set_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT});
    for (uint32_t i = 0; names[i]; i++)
        for (uint32_t element = 0; element < PUSHED; element++)
            write_top(play, shader, VK_NULL_HANDLE, i, element, names[i]);
    dispatch(play, shader, &(struct constants){.count = 0});
}

/* `shade set PLACE COUNT NUMBER` */
static void shade_set(struct play *play, char **words)
{
    struct play_shader *shader = &play->shaders[PLAY_SHADE_SET];
    VkDescriptorBufferInfo buffer = {.range = VK_WHOLE_SIZE};
    buffer.buffer = play_place(play, words[2], &buffer.offset)->buffer.handle;
    make_sets(play, shader, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT);
    make_pipeline(play, shader,
                  &(struct code){CODE_OF(shade_set_comp), .stage = VK_SHADER_STAGE_COMPUTE_BIT});
    allocate_set(play, shader);
    play->vk.UpdateDescriptorSets(
        play->device, 1,
        &MAKE(VkWriteDescriptorSet, .dstSet = shader->last_set, .descriptorCount = 1,
              .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &buffer),
        0, NULL);
    play->vk.CmdBindDescriptorSets(play_commands(play), VK_PIPELINE_BIND_POINT_COMPUTE,
                                   shader->layout, 0, 1, &shader->last_set, 0, NULL);
    dispatch(
        play, shader,
        &(struct constants){.count = (uint32_t)atoi(words[3]), .number = (float)atof(words[4])});
}

static void trace_rays(struct play *play, uint32_t width)
{
    const VkStridedDeviceAddressRegionKHR none = {0};
    play->vk.CmdTraceRaysKHR(play_commands(play), &none, &none, &none, &none, width, 1, 1);
}

static void rays(struct play *play, char **words)
{
    const VkStridedDeviceAddressRegionKHR none = {0};
    struct play_shader *shader = &play->shaders[PLAY_RAYS];
    const struct code code = {CODE_OF(rays_rgen), .stage = VK_SHADER_STAGE_RAYGEN_BIT_KHR};
    if (words[1] && play_is(words[1], "indirect")) {
        play->vk.CmdTraceRaysIndirectKHR(play_commands(play), &none, &none, &none, &none, 0);
    } else if (!words[1] || play_is(words[1], "none")) {
        trace_rays(play, words[1] ? 0 : 1);
    } else {
        bind_tops(play, shader, &code, words + 2);
        bind(play, shader, code.stage, &(struct constants){.count = (uint32_t)atoi(words[1])});
        trace_rays(play, 1);
    }
}

static void trace_words_of(struct play *play, char **words)
{
    if (play_is(words[1], "set"))
        trace_set(play, words + 2);
    else if (play_is(words[1], "if"))
        trace_if(play, (uint32_t)atoi(words[2]), true, words + 4);
    else if (play_is(words[1], "disabled"))
        trace_if(play, 1, false, words + 3);
    else if (play_is(words[1], "pushed"))
        trace_pushed(play, words + 2);
    else
        trace(play, words[1]);
}

bool play_shader(struct play *play, char **words)
{
    if (play_is(words[0], "shade") && play_is(words[1], "set"))
        shade_set(play, words);
    else if (play_is(words[0], "shade"))
        shade(play, words);
    else if (play_is(words[0], "dispatch"))
        play->vk.CmdDispatch(play_commands(play), 1, 1, 1);
    else if (play_is(words[0], "trace"))
        trace_words_of(play, words);
    else if (play_is(words[0], "rays"))
        rays(play, words);
    else if (play_is(words[0], "condition"))
        set_condition(play, words);
    else if (play_is(words[0], "draw"))
        play->vk.CmdDraw(play_commands(play), 3, 1, 0, 0);
    else
        return false;
    return true;
}

void play_destroy_shaders(struct play *play)
{
    for (unsigned i = 0; i < PLAY_SHADERS; i++) {
        play->vk.DestroyPipeline(play->device, play->shaders[i].pipeline, NULL);
        play->vk.DestroyPipelineLayout(play->device, play->shaders[i].layout, NULL);
        play->vk.DestroyDescriptorPool(play->device, play->shaders[i].pool, NULL);
        play->vk.DestroyDescriptorSetLayout(play->device, play->shaders[i].set, NULL);
        play->shaders[i] = (struct play_shader){0};
    }
}
