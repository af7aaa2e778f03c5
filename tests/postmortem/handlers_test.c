/* SPDX-License-Identifier: Apache-2.0 */
/* Signal handlers of the application beside the layer's. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <string.h>
#include <unistd.h>

static struct sigaction before; /* the action that a later handler replaced */
static char alternate_stack[1 << 16];

static void say(const char *text)
{
    if (write(STDERR_FILENO, text, strlen(text)) < 0)
        _exit(1);
}

static bool is_on_alternate_stack(void)
{
    const char *frame = __builtin_frame_address(0); /* ASan may move locals to the heap */
    return frame >= alternate_stack && frame < alternate_stack + sizeof(alternate_stack);
}

/* Exits if all is as without the layer. */
static void end_process(int number, siginfo_t *info, void *context)
{
    sigset_t mask;
    sigprocmask(SIG_BLOCK, NULL, &mask);
    say("handler of the application");
    _exit(number == SIGSEGV && info->si_addr == (void *)16 && context &&
                  sigismember(&mask, SIGUSR1) && sigismember(&mask, SIGSEGV) &&
                  is_on_alternate_stack()
              ? HANDLED
              : 1);
}

static void handle_signal(int number, void (*handler)(int, siginfo_t *, void *), int flags)
{
    struct sigaction action = {.sa_flags = SA_SIGINFO | flags};
    const stack_t stack = {.ss_sp = alternate_stack, .ss_size = sizeof(alternate_stack)};
    action.sa_sigaction = handler;
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGUSR1);
    sigaltstack(&stack, NULL);
    sigaction(number, &action, &before);
}

static void crash_with_earlier_handler(void)
{
    handle_signal(SIGSEGV, end_process, SA_ONSTACK);
    open_at(NULL);
    crash(0, false, false);
}

TEST(test_earlier_handler)
{
    run(crash_with_earlier_handler, NULL, NULL);
    expect_output("ASSAY-crash");
    expect_output("minX");
    if (!WIFEXITED(status) || WEXITSTATUS(status) != HANDLED)
        fail_msg("status 0x%x: %s", (unsigned)status, output);
}

static void crash_with_later_handler(void)
{
    open_at(NULL);
    handle_signal(SIGSEGV, end_process, SA_ONSTACK);
    crash(0, false, false);
}

/* It replaced the layer's. */
TEST(test_later_handler)
{
    run(crash_with_later_handler, NULL, NULL);
    expect_no_output("ASSAY-crash");
    assert_int_equal(WEXITSTATUS(status), HANDLED);
}

static void pass_on(int number, siginfo_t *info, void *context)
{
    say("passes on\n");
    if (before.sa_flags & SA_SIGINFO)
        before.sa_sigaction(number, info, context);
}

static void crash_with_handler_that_passes_on(void)
{
    open_at(NULL);
    handle_signal(SIGSEGV, pass_on, 0);
    crash(0, false, false);
}

TEST(test_handler_that_passes_on)
{
    run(crash_with_handler_that_passes_on, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output("ASSAY-crash");
}

/* The handler passes the signal on to the layer's, though its instance is gone. */
static void crash_after_the_instance(void)
{
    open_at(NULL);
    handle_signal(SIGSEGV, pass_on, 0);
    scene_close();
    raise(SIGSEGV);
}

TEST(test_handler_outlives_the_instance)
{
    run(crash_after_the_instance, NULL, NULL);
    expect_signal(SIGSEGV);
    expect_output("passes on");
    expect_no_output("ASSAY-crash");
}

static void crash_ignored(void)
{
    signal(SIGFPE, SIG_IGN);
    open_at(NULL);
    crash(SIGFPE, false, false);
    _exit(HANDLED);
}

TEST(test_ignored_signal)
{
    run(crash_ignored, NULL, NULL);
    expect_no_output("ASSAY-crash");
    assert_int_equal(WEXITSTATUS(status), HANDLED);
}

static void return_from(int number, siginfo_t *info, void *context)
{
    say("returns\n");
}

static void crash_with_handler_for_once(void)
{
    handle_signal(SIGFPE, return_from, SA_RESETHAND);
    open_at(NULL);
    crash(SIGFPE, false, false);
    raise(SIGFPE);
}

TEST(test_handler_for_once)
{
    run(crash_with_handler_for_once, NULL, NULL);
    expect_output("ASSAY-crash");
    expect_output("returns");
    expect_signal(SIGFPE);
}

static bool are_equal(const struct sigaction *a, const struct sigaction *b)
{
    bool equal = a->sa_sigaction == b->sa_sigaction && a->sa_flags == b->sa_flags;
    for (int number = 1; number < 32; number++)
        equal = equal && sigismember(&a->sa_mask, number) == sigismember(&b->sa_mask, number);
    return equal;
}

static void open_often(void)
{
    handle_signal(SIGSEGV, end_process, SA_ONSTACK | SA_NODEFER);
    struct sigaction first, last;
    sigaction(SIGSEGV, NULL, &first);
    for (int i = 0; i < 20; i++) {
        open_at("execution");
        scene_close();
        sigaction(SIGSEGV, NULL, &last);
        if (!are_equal(&first, &last))
            _exit(1);
        sigaction(SIGABRT, NULL, &last);
        if (last.sa_handler != SIG_DFL)
            _exit(2);
    }
    _exit(HANDLED);
}

TEST(test_handlers_are_put_back)
{
    run(open_often, NULL, NULL);
    assert_int_equal(WEXITSTATUS(status), HANDLED);
}
