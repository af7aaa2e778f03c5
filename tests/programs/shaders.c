/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of programs that run shaders:
 *
 *     shade PLACE COUNT NUMBER    a dispatch, which writes COUNT floats of a value
 *     trace TOP                   a dispatch with a ray query; with VK_KHR_ray_query
 *     rays                        vkCmdTraceRaysKHR without a pipeline: only null
 *     draw                        vkCmdDraw without a pipeline: only null
 *     probe STRUCTURE [hits | misses]     vkTraceRaysASSAY of one ray along x: only cpu */
#include "play.h"
#include "tests/fixture/trace.h"

#include <stdlib.h>

static const uint32_t shade_words[] = {
#include "shade_comp.h"
};
static const uint32_t trace_words[] = {
#include "trace_comp.h"
};

/* The constants of both shaders. */
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
    GET(play->vk.CreatePipelineLayout(play->device,
                                      &MAKE(VkPipelineLayoutCreateInfo, .pushConstantRangeCount = 1,
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

static void probe(struct play *play, char **words)
{
    const PFN_vkTraceRaysASSAY trace_rays =
        (PFN_vkTraceRaysASSAY)play->fixture.get_device_proc_addr(play->device, "vkTraceRaysASSAY");
    const AssayRay ray = {
        .origin = {-1, 0.25f, 0.25f}, .direction = {1, 0, 0}, .tMax = 1000, .cullMask = 0xff};
    AssayHit hit = {0};
    const AssayTraceInfo info = trace_info((uint64_t)play_object(play, words[1])->structure,
                                           ASSAY_ACCURACY_FAST, 1, &ray, &hit);
    if (!trace_rays && play->is_scarce)
        return; /* the library that reads settings may lose one without a word */
    PLAY_REQUIRE(play, trace_rays != NULL);
    play_note(play, trace_rays(play->device, &info));
    if (!words[2] || hit.isHit == play_is(words[2], "hits") || play->is_scarce)
        return;
    play_say(play, "the ray hits %s\n", hit.isHit ? "something" : "nothing");
    play->outcome = OUTCOME_FAILED;
}

bool play_shader(struct play *play, char **words)
{
    const VkStridedDeviceAddressRegionKHR none = {0};
    if (play_is(words[0], "shade"))
        shade(play, words);
    else if (play_is(words[0], "trace"))
        trace(play, words[1]);
    else if (play_is(words[0], "rays"))
        play->vk.CmdTraceRaysKHR(play_commands(play), &none, &none, &none, &none, 1, 1, 1);
    else if (play_is(words[0], "probe"))
        probe(play, words);
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
        play->shaders[i] = (struct play_shader){0};
    }
}
