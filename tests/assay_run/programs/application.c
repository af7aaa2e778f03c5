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
 *   fork          the steps that follow are those of a child, for which the parent waits
 *   outlive       they are those of a child that has an instance and goes on after the parent's end
 *   exec          a new program in the same process carries out the steps that follow
 * It has a messenger, as most applications have. The environment names the driver and the layer. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/player/scene/scene.h"

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

static void close_scene(void)
{
    if (scene == NULL)
        return;
    scene_close(scene);
    fixture_close(&fixture);
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

/* Returns in the child. */
static void fork_child(void)
{
    int status = 0;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0)
        return;
    waitpid(child, &status, 0);
    exit(WEXITSTATUS(status));
}

/* Returns in the child, which has an instance, after the parent's end. */
static void outlive_parent(void)
{
    int opened[2], ended[2];
    char byte = 0;
    if (pipe(opened) != 0 || pipe(ended) != 0)
        exit(3);
    fflush(NULL);
    if (fork() != 0) {
        close(opened[1]);
        exit(read(opened[0], &byte, 1) == 1 ? 0 : 3);
    }
    close(ended[1]);
    open_scene();
    if (write(opened[1], &byte, 1) != 1 || read(ended[0], &byte, 1) != 0)
        exit(3);
    usleep(300000); /* assay-run sees the end, too */
}

static const char *argument_of(const char *step, const char *name)
{
    const size_t length = strlen(name);
    return strncmp(step, name, length) == 0 && step[length] == '=' ? step + length + 1 : NULL;
}

static bool carry_out_with_argument(const char *step)
{
    const char *argument;
    if ((argument = argument_of(step, "name"))) {
        set_name(argument);
    } else if ((argument = argument_of(step, "label"))) {
        open_label(argument);
    } else if ((argument = argument_of(step, "many"))) {
        for (int i = atoi(argument); i > 0; i--)
            build(0);
    } else if ((argument = argument_of(step, "exit"))) {
        close_scene();
        exit(atoi(argument));
    } else if ((argument = argument_of(step, "signal"))) {
        raise(atoi(argument));
    } else {
        return false;
    }
    return true;
}

static void carry_out(char **argv, int i)
{
    const char *step = argv[i];
    if (strcmp(step, "clean") == 0)
        build(UINT32_MAX);
    else if (strcmp(step, "mistake") == 0)
        build(0);
    else if (strcmp(step, "scratch") == 0)
        build_with_misaligned_scratch();
    else if (strcmp(step, "unlabel") == 0)
        scene->vk->CmdEndDebugUtilsLabelEXT(scene->command_buffer);
    else if (strcmp(step, "submit") == 0)
        submit();
    else if (strcmp(step, "abandon") == 0)
        abandon_device();
    else if (strcmp(step, "leave") == 0)
        _exit(0);
    else if (strcmp(step, "fork") == 0)
        fork_child();
    else if (strcmp(step, "outlive") == 0)
        outlive_parent();
    else if (strcmp(step, "exec") == 0 && argv[i + 1] != NULL) {
        argv[i] = argv[0];
        execv("/proc/self/exe", argv + i);
    } else if (!carry_out_with_argument(step)) {
        fprintf(stderr, "not a step: %s\n", step);
        exit(3);
    }
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        carry_out(argv, i);
    close_scene();
    return 0;
}
