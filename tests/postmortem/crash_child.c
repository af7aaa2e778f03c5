/* SPDX-License-Identifier: Apache-2.0 */
/* Runs children, and looks at what is left of them. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { BUFFER_SIZE = 1 << 16 };

char output[OUTPUT_SIZE];
int status;

void crash(const struct crash *crash)
{
    PLAN_FAULT(.kind = NULL_DRIVER_CRASH, .at = NULL_DRIVER_AT_BUILD,
               .skips_copies = crash->skips_copies, .signal = crash->signal,
               .in_thread = crash->in_thread);
    VkCommandBuffer commands = scene_record_boxes(0, 1);
    scene_submit(commands);
}

void open_at(const char *level)
{
    SCENE_OPEN(.settings.level = level, .boxes_size = BUFFER_SIZE, .structure_size = BUFFER_SIZE,
               .has_tlas = true);
    fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance,
                                                      fixture.instance.messenger, NULL);
    fixture.instance.messenger = VK_NULL_HANDLE;
    scene_invalidate_box(0);
}

void build_with_wild_reference(void)
{
    open_at(NULL);
    struct device_buffer instances = scene_input(BUFFER_SIZE);
    scene_write_instance(&instances, true);
    ((VkAccelerationStructureInstanceKHR *)instances.bytes)->accelerationStructureReference =
        0x123456789000;
    VkCommandBuffer commands = fixture_begin(&fixture, 0);
    scene_build_instance(commands, instances.address, false);
    scene_submit(commands);
    fixture.vk.DeviceWaitIdle(fixture.device);
    _exit(HANDLED);
}

void expect_ending(const struct ending *ending)
{
    const int number = ending->signal;
    if (number ? !WIFSIGNALED(status) || WTERMSIG(status) != number
               : !WIFEXITED(status) || WEXITSTATUS(status) != HANDLED)
        fail_msg("status 0x%x, output: %s", (unsigned)status, output);
    for (const char *const *text = ending->says; *text; text++)
        assert_has(output, *text);
    if (ending->lacks)
        assert_lacks(output, ending->lacks);
}

void run(void (*child)(void), const char *setting, const char *value)
{
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    const pid_t pid = fork();
    if (pid == 0) {
        const int numbers[] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT};
        for (size_t i = 0; i < ARRAY_COUNT(numbers); i++)
            signal(numbers[i], SIG_DFL); /* cmocka and sanitizers have theirs */
        setrlimit(RLIMIT_CORE, &(struct rlimit){0});
        dup2(ends[1], STDERR_FILENO);
        setenv("VK_ASSAY_VALIDATION_CRASH_REPORT", "true", 1);
        if (setting)
            setenv(setting, value, 1);
        child();
        _exit(0);
    }
    close(ends[1]);
    size_t length = 0;
    ssize_t got;
    while ((got = read(ends[0], output + length, sizeof(output) - 1 - length)) > 0)
        length += (size_t)got;
    output[length] = '\0';
    char *emulator = strstr(output, "qemu: uncaught target signal");
    if (emulator) /* under scripts/platforms aarch64; its message is the last */
        *emulator = '\0';
    close(ends[0]);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_lacks(output, "ThreadSanitizer: ");
}
