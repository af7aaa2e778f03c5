/* SPDX-License-Identifier: Apache-2.0 */
/* An application for tests of assay-run. Each argument is a step:
 *   clean         a build call without a mistake
 *   mistake       one with a mistake
 *   scratch       one with another mistake, which the driver gets all the same
 *   name=NAME     the command buffer's debug name
 *   label=NAME    opens a label in the command buffer
 *   unlabel       closes it
 *   many=N        N times `mistake`
 *   submit        submits the command buffer, and waits: the last step, or before the next two
 *   abandon       destroys the instance and not the device, and ends
 *   leave         ends without destroying anything, as many applications do
 *   exit=N        the exit status
 *   signal=N      sends that signal to itself
 * It has a messenger, as most applications have. The environment names the driver and the layer. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/player/scene/scene.h"

enum { NOT_A_STEP = 3 }; /* the exit status */

static struct fixture fixture;
static struct scene *scene;

static void open_scene(void)
{
    if (scene != NULL)
        return;
    fixture_open_by_environment(&fixture, NULL);
    fixture.instance.messages.answer = VK_TRUE;
    scene = scene_open(&fixture, COMMAND_DEVICE);
}

static void end(int status)
{
    if (scene != NULL) {
        scene_close(scene);
        fixture_close(&fixture);
    }
    exit(status);
}

static void submit(void)
{
    VkQueue queue;
    open_scene();
    fixture.vk.GetDeviceQueue(fixture.device, 0, 0, &queue);
    GET(fixture.vk.EndCommandBuffer(scene->command_buffer));
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1,
                 .pCommandBuffers = &scene->command_buffer);
    GET(fixture.vk.QueueSubmit(queue, 1, &info, VK_NULL_HANDLE));
    GET(fixture.vk.QueueWaitIdle(queue));
}

static void abandon_device(void)
{
    open_scene();
    fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance,
                                                      fixture.instance.messenger, NULL);
    fixture.instance.vk.DestroyInstance(fixture.instance.instance, NULL);
    _exit(0);
}

static void build(uint32_t info_count)
{
    open_scene();
    const uint32_t valid = scene->info_count;
    scene->info_count = info_count < valid ? info_count : valid;
    scene_call(scene);
    scene->info_count = valid;
}

static void build_with_misaligned_scratch(void)
{
    open_scene();
    fixture.instance.messages.answer = VK_FALSE;
    scene->infos[0].scratchData.deviceAddress++;
    scene_call(scene);
    scene->infos[0].scratchData.deviceAddress--;
    fixture.instance.messages.answer = VK_TRUE;
}

static void set_name(const char *name)
{
    open_scene();
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, info, .objectType = VK_OBJECT_TYPE_COMMAND_BUFFER,
                 .objectHandle = (uint64_t)(uintptr_t)scene->command_buffer, .pObjectName = name);
    GET(scene->vk->SetDebugUtilsObjectNameEXT(fixture.device, &info));
}

static void open_label(const char *name)
{
    open_scene();
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = name);
    scene->vk->CmdBeginDebugUtilsLabelEXT(scene->command_buffer, &label);
}

static bool is(const char *name, const char *other)
{
    return strcmp(name, other) == 0;
}

static void carry_out(const char *step)
{
    char name[16];
    snprintf(name, sizeof(name), "%.*s", (int)strcspn(step, "="), step);
    const char *argument = strchr(step, '=') ? strchr(step, '=') + 1 : "";
    if (is(name, "clean"))
        build(UINT32_MAX);
    else if (is(name, "mistake"))
        build(0);
    else if (is(name, "many"))
        for (int i = atoi(argument); i > 0; i--)
            build(0);
    else if (is(name, "scratch"))
        build_with_misaligned_scratch();
    else if (is(name, "name"))
        set_name(argument);
    else if (is(name, "label"))
        open_label(argument);
    else if (is(name, "unlabel"))
        scene->vk->CmdEndDebugUtilsLabelEXT(scene->command_buffer);
    else if (is(name, "submit"))
        submit();
    else if (is(name, "abandon"))
        abandon_device();
    else if (is(name, "leave"))
        _exit(0);
    else if (is(name, "signal"))
        raise(atoi(argument));
    else if (is(name, "exit"))
        end(atoi(argument));
    else
        end(NOT_A_STEP);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        carry_out(argv[i]);
    end(0);
}
