/* SPDX-License-Identifier: Apache-2.0 */
/* Makes one mistake, by a call that record_build() makes. The arguments:
 *   device, indirect, host, nv: the command
 *   secondary: vkCmdBuildAccelerationStructuresKHR, in a secondary command buffer
 *   deferred: vkBuildAccelerationStructuresKHR, deferred
 *   parameters: the mistake is a parameter, which is found at the call
 *   execution: the dst is destroyed before the submission; on the host, an update is wrong
 *   content: the mistake is in the input data, and found when the submission has completed
 *   library=PATH: record_build() of that library, which is closed right after
 * The environment names the driver and the layer. */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "record_build.h"

enum { BOX_SIZE = 24 };

static struct fixture fixture;
static enum build_command command;
static const char *mistake, *library;
static bool is_deferred;

static void read_argument(const char *word)
{
    static const char *const commands[BUILD_COMMAND_COUNT] = {[COMMAND_DEVICE] = "device",
                                                              [COMMAND_INDIRECT] = "indirect",
                                                              [COMMAND_HOST] = "host",
                                                              [COMMAND_NV] = "nv"};
    if (strncmp(word, "library=", strlen("library=")) == 0)
        library = word + strlen("library=");
    else if (strcmp(word, "secondary") == 0)
        fixture.records_secondary = true;
    else if (strcmp(word, "deferred") == 0)
        is_deferred = true;
    else
        mistake = word;
    for (int i = 0; i < BUILD_COMMAND_COUNT; i++)
        if (strcmp(word, commands[i]) == 0)
            command = (enum build_command)i;
    if (is_deferred)
        command = COMMAND_HOST;
}

static struct scene *open_scene(bool in_secondary)
{
    fixture_open_by_environment(&fixture, command == COMMAND_NV ? "VK_NV_ray_tracing" : NULL);
    fixture.records_secondary = in_secondary;
    fixture.copies_inputs = true;
    return scene_open(&fixture, command);
}

static void prepare(struct scene *scene)
{
    if (strcmp(mistake, "content") == 0)
        ((float *)(void *)(scene->boxes.bytes + BOX_SIZE))[0] = 2.5f; /* minX of the second box */
    if (strcmp(mistake, "execution") == 0 && command == COMMAND_HOST)
        scene->ranges[UPDATE][0].primitiveCount--;
    scene_inputs_copy(scene, scene->command_buffer);
    if (is_deferred)
        GET(scene->vk->CreateDeferredOperationKHR(fixture.device, NULL,
                                                  &scene->deferred_operation));
    if (strcmp(mistake, "parameters") != 0)
        return;
    scene->info_count = 0;
    scene->nv.info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
                           VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;
}

__attribute__((always_inline)) static inline void
call_inlined(VkResult (*record)(const struct scene *), struct scene *scene)
{
    record(scene); /* caller */
}

__attribute__((noipa)) static void make_call(struct scene *scene)
{
    VkResult (*record)(const struct scene *) = record_build;
    void *opened = library ? dlopen(library, RTLD_NOW | RTLD_LOCAL) : NULL;
    if (opened)
        record = (VkResult(*)(const struct scene *))dlsym(opened, "record_build");
    if ((library && !opened) || !record)
        exit(3);
    call_inlined(record, scene); /* inliner */
    if (opened)
        dlclose(opened);
}

static void execute_in_primary(struct scene *scene)
{
    const VkCommandBuffer secondary = scene->command_buffer;
    scene_end(scene, secondary);
    scene->command_buffer =
        scene_command_buffer(scene, fixture_find_family(&fixture, VK_QUEUE_COMPUTE_BIT, 0));
    scene_begin(scene, scene->command_buffer, 0);
    scene->vk->CmdExecuteCommands(scene->command_buffer, 1, &secondary);
}

static void submit(struct scene *scene)
{
    if (fixture.records_secondary)
        execute_in_primary(scene);
    if (strcmp(mistake, "execution") == 0)
        scene_destroy(scene, command == COMMAND_NV
                                 ? (uint64_t)scene->nv.dst
                                 : (uint64_t)scene->infos[INDEXED].dstAccelerationStructure);
    scene_submit_call(scene);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        read_argument(argv[i]);
    struct scene *scene = open_scene(fixture.records_secondary);
    prepare(scene);
    make_call(scene);
    if (command != COMMAND_HOST && strcmp(mistake, "parameters") != 0)
        submit(scene);
    if (is_deferred)
        scene->vk->DestroyDeferredOperationKHR(fixture.device, scene->deferred_operation, NULL);
    scene_close(scene);
    fixture_close(&fixture);
    return 0;
}
