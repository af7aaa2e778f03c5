/* SPDX-License-Identifier: Apache-2.0 */
/* Runs children, and looks at what is left of them. */
#include "tests/postmortem/crash_child.h"

#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

char output[OUTPUT_SIZE];
int status;
struct play play;
static struct program program;
static struct platform platform;

const char *unit_test_open(const char *name)
{
    const char *missing = platform_open(&platform, name ? name : "null");
    if (!missing)
        dlclose(platform.layer); /* where coverage is measured, children load it with a handler */
    return missing;
}

void open_at(const char *level)
{
    play = (struct play){.platform = &platform, .level = level ? level : "content"};
    if (!play_begin(&play, &program))
        _exit(1);
    struct instance_fixture *instance = &play.fixture;
    instance->vk.DestroyDebugUtilsMessengerEXT(instance->instance, instance->messenger, NULL);
    instance->messenger = VK_NULL_HANDLE;
    execute_line("init V1 box");
}

void close_device(void)
{
    play_end(&play);
    play_close(&play);
}

void execute_line(const char *text)
{
    play_text(&play, &program, "%s", text);
}

void submit_box(void)
{
    execute_line("c0: " BUILD_BOX);
    execute_line("submit c0");
}

void plan_crash(const struct crash *crash)
{
    platform.null_driver.plan_fault(&(struct null_driver_fault){.kind = NULL_DRIVER_CRASH,
                                                                .at = NULL_DRIVER_AT_BUILD,
                                                                .number = crash->number,
                                                                .skips_copies = crash->skips_copies,
                                                                .signal = crash->signal,
                                                                .in_thread = crash->in_thread});
}

void crash(const struct crash *crash)
{
    plan_crash(crash);
    submit_box();
}

void expect_ending(const struct ending *ending)
{
    const int number = ending->signal;
    if (number ? !WIFSIGNALED(status) || WTERMSIG(status) != number
               : !WIFEXITED(status) || WEXITSTATUS(status) != HANDLED)
        fail_msg("status 0x%x, output: %s", (unsigned)status, output);
    if (ending->says)
        assert_parts(output, ending->says);
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
