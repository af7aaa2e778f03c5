/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of programs that run shaders:
 *
 *     shade PLACE COUNT NUMBER    a dispatch, which writes COUNT floats of a value
 *     dispatch                    once more, with what is bound
 *     trace TOP                   a dispatch with a ray query; with VK_KHR_ray_query
 *     trace set TOP [TOP]         the same with a descriptor set in which the first one is used;
 *                                 on a device on which no `trace TOP` is
 *     trace set                   with the last such set
 *     trace pushed TOP [TOP]      with pushed descriptors; with VK_KHR_push_descriptor
 *     rays [none | indirect]      vkCmdTraceRaysKHR without a pipeline: only null
 *     condition begin PLACE [inverted]        conditional rendering, with its extension
 *     condition end
 *     draw                        vkCmdDraw without a pipeline: only null */
#include "play.h"

#include <stdlib.h>

static const uint32_t shade_words[] = {
#include "shade_comp.h"
};
static const uint32_t trace_words[] = {
#include "trace_comp.h"
};

static const uint32_t trace_set_words[] = {
#include "trace_set_comp.h"
};

enum { SETS = 16, SET_BINDINGS = 2 };

/* The constants of shaders. */
struct constants {
    VkDeviceAddress address;
    uint32_t count;
    float number;
};

/* Creates a pipeline, unless the program has it already. */
static void make_pipeline(struct play *play, struct play_shader *shader, const uint32_t *words,
                          size_t size)
{
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(struct constants)};
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
        play->device, &MAKE(VkShaderModuleCreateInfo, .codeSize = size, .pCode = words), NULL,
        &module));
    const STRUCT(VkComputePipelineCreateInfo, info,
                 .stage =
                     MAKE(VkPipelineShaderStageCreateInfo, .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                          .module = module, .pName = "main"),
                 .layout = shader->layout);
    GET(play->vk.CreateComputePipelines(play->device, VK_NULL_HANDLE, 1, &info, NULL,
                                        &shader->pipeline));
    play->vk.DestroyShaderModule(play->device, module, NULL);
}

static void dispatch(struct play *play, const struct play_shader *shader,
                     const struct constants *constants)
{
    const VkCommandBuffer commands = play_commands(play);
    play->vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shader->pipeline);
    play->vk.CmdPushConstants(commands, shader->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                              sizeof(*constants), constants);
    play->vk.CmdDispatch(commands, 1, 1, 1);
}

static void shade(struct play *play, char **words)
{
    struct play_shader *shader = &play->shaders[PLAY_SHADE];
    make_pipeline(play, shader, shade_words, sizeof(shade_words));
    dispatch(play, shader,
             &(struct constants){play_address(play, words[1]), (uint32_t)atoi(words[2]),
                                 (float)atof(words[3])});
}

static void trace(struct play *play, const char *name)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE];
    const STRUCT(VkAccelerationStructureDeviceAddressInfoKHR, info,
                 .accelerationStructure = play_object(play, name)->structure);
    make_pipeline(play, shader, trace_words, sizeof(trace_words));
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

/* The layout has two bindings. */
static void make_layout(struct play *play, struct play_shader *shader,
                        VkDescriptorSetLayoutCreateFlags flags)
{
    const VkDescriptorSetLayoutBinding bindings[SET_BINDINGS] = {
        {0, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL},
        {1, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, VK_SHADER_STAGE_COMPUTE_BIT, NULL}};
    if (!shader->set)
        GET(play->vk.CreateDescriptorSetLayout(play->device,
                                               &MAKE(VkDescriptorSetLayoutCreateInfo,
                                                     .flags = flags, .bindingCount = SET_BINDINGS,
                                                     .pBindings = bindings),
                                               NULL, &shader->set));
}

/* The pool has so many sets as a program needs. */
static void make_sets(struct play *play, struct play_shader *shader)
{
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR,
                                       SETS * SET_BINDINGS};
    make_layout(play, shader, 0);
    if (!shader->pool)
        GET(play->vk.CreateDescriptorPool(play->device,
                                          &MAKE(VkDescriptorPoolCreateInfo, .maxSets = SETS,
                                                .poolSizeCount = 1, .pPoolSizes = &size),
                                          NULL, &shader->pool));
}

/* Writes to a set, or pushes if that is null. */
static void write_top(struct play *play, const struct play_shader *shader, VkDescriptorSet set,
                      uint32_t binding, const char *name)
{
    const STRUCT(VkWriteDescriptorSetAccelerationStructureKHR, top, .accelerationStructureCount = 1,
                 .pAccelerationStructures = &play_object(play, name)->structure);
    const STRUCT(VkWriteDescriptorSet, write, .pNext = &top, .dstSet = set, .dstBinding = binding,
                 .descriptorCount = 1,
                 .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR);
    if (set)
        play->vk.UpdateDescriptorSets(play->device, 1, &write, 0, NULL);
    else
        play->vk.CmdPushDescriptorSetKHR(play_commands(play), VK_PIPELINE_BIND_POINT_COMPUTE,
                                         shader->layout, 0, 1, &write);
}

static void make_set(struct play *play, struct play_shader *shader, char **names)
{
    GET(play->vk.AllocateDescriptorSets(play->device,
                                        &MAKE(VkDescriptorSetAllocateInfo,
                                              .descriptorPool = shader->pool,
                                              .descriptorSetCount = 1, .pSetLayouts = &shader->set),
                                        &shader->last_set));
    for (uint32_t i = 0; names[i]; i++)
        write_top(play, shader, shader->last_set, i, names[i]);
}

static void trace_set(struct play *play, char **names)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE_SET];
    make_sets(play, shader);
    make_pipeline(play, shader, trace_set_words, sizeof(trace_set_words));
    if (names[0])
        make_set(play, shader, names);
    play->vk.CmdBindDescriptorSets(play_commands(play), VK_PIPELINE_BIND_POINT_COMPUTE,
                                   shader->layout, 0, 1, &shader->last_set, 0, NULL);
    dispatch(play, shader, &(struct constants){.count = 0});
}

static void trace_pushed(struct play *play, char **names)
{
    struct play_shader *shader = &play->shaders[PLAY_TRACE_PUSHED];
    make_layout(play, shader, VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT);
    make_pipeline(play, shader, trace_set_words, sizeof(trace_set_words));
    for (uint32_t i = 0; names[i]; i++)
        write_top(play, shader, VK_NULL_HANDLE, i, names[i]);
    dispatch(play, shader, &(struct constants){.count = 0});
}

bool play_shader(struct play *play, char **words)
{
    const VkStridedDeviceAddressRegionKHR none = {0};
    if (play_is(words[0], "shade"))
        shade(play, words);
    else if (play_is(words[0], "dispatch"))
        play->vk.CmdDispatch(play_commands(play), 1, 1, 1);
    else if (play_is(words[0], "trace") && play_is(words[1], "set"))
        trace_set(play, words + 2);
    else if (play_is(words[0], "trace") && play_is(words[1], "pushed"))
        trace_pushed(play, words + 2);
    else if (play_is(words[0], "trace"))
        trace(play, words[1]);
    else if (play_is(words[0], "rays") && words[1] && play_is(words[1], "indirect"))
        play->vk.CmdTraceRaysIndirectKHR(play_commands(play), &none, &none, &none, &none, 0);
    else if (play_is(words[0], "rays"))
        play->vk.CmdTraceRaysKHR(play_commands(play), &none, &none, &none, &none, words[1] ? 0 : 1,
                                 1, 1);
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
