/* SPDX-License-Identifier: Apache-2.0 */
/* address_space_test PLATFORM LEVEL: RLIMIT_AS, so that all allocations fail from some point on.
 * The application may get errors, which end it. The layer must neither crash nor report what is
 * valid. */
#define _GNU_SOURCE /* dladdr, REG_RIP */
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <ucontext.h>
#include <unistd.h>

#include "tests/loader/loader_test.h"

enum {
    CHILDREN = 40,
    STEP = 48 << 10, /* bytes more for each child */
    SCENES = 60,     /* more than fit */
    LAYER_CRASHED = 99,
    FALSE_FINDING = 98,
    CHILD_ENDS = 120, /* seconds */
};

static struct fixture fixture;

/* What the test itself and the driver do without memory does not matter. */
static void crash(int number, siginfo_t *info, void *context)
{
    Dl_info of = {0};
    void *at = NULL;
#if defined(__x86_64__)
    at = (void *)((ucontext_t *)context)->uc_mcontext.gregs[REG_RIP];
#elif defined(__aarch64__)
    at = (void *)((ucontext_t *)context)->uc_mcontext.pc;
#endif
    _exit(dladdr(at, &of) && strstr(of.dli_fname, "VkLayer_assay") ? LAYER_CRASHED : 0);
}

static void limit_address_space(size_t more)
{
    long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%ld", &pages), 1);
    fclose(file);
    const rlim_t size = (rlim_t)(pages * sysconf(_SC_PAGESIZE)) + more;
    assert_int_equal(setrlimit(RLIMIT_AS, &(struct rlimit){size, size}), 0);
}

static void end_without_messages(void)
{
    bool is_wrong = false;
    for (uint32_t i = 0; i < messages_kept(&fixture.instance.messages); i++)
        is_wrong |= strncmp(fixture.instance.messages.items[i].id, "VUID-", 5) == 0;
    _exit(is_wrong ? FALSE_FINDING : 0);
}

static void live(const struct setup *setup, size_t more)
{
    const struct sigaction action = {.sa_sigaction = crash, .sa_flags = SA_SIGINFO};
    assert_null(fixture_open(&fixture, &platform, setup));
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDERR_FILENO);
    sigaction(SIGSEGV, &action, NULL);
    sigaction(SIGBUS, &action, NULL);
    atexit(end_without_messages);
    limit_address_space(more);
    for (int i = 0; i < SCENES; i++) {
        struct scene *scene = scene_open(&fixture, COMMAND_DEVICE);
        scene_call(scene);
        scene_submit_call(scene);
    }
    exit(0);
}

TEST(test_address_space)
{
    const struct setup setup = {.level = unit_test_arguments[1]};
    for (size_t i = 0; i < CHILDREN; i++) {
        int status = 0;
        fflush(NULL);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            alarm(CHILD_ENDS);
            live(&setup, i * STEP);
        }
        assert_int_equal(waitpid(child, &status, 0), child);
        if (WIFSIGNALED(status) && WTERMSIG(status) != SIGABRT)
            fail_msg("%zu bytes more: signal %d", i * STEP, WTERMSIG(status));
        if (WIFEXITED(status) && WEXITSTATUS(status) == LAYER_CRASHED)
            fail_msg("%zu bytes more: the layer crashes", i * STEP);
        if (WIFEXITED(status) && WEXITSTATUS(status) == FALSE_FINDING)
            fail_msg("%zu bytes more: a finding about valid calls", i * STEP);
    }
}
