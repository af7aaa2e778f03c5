/* SPDX-License-Identifier: Apache-2.0 */
/* Signal handlers of the application beside the layer's. */
#include "tests/postmortem/crash_child.h"

#include <signal.h>
#include <string.h>
#include <sys/resource.h>
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
    CRASH(.signal = 0);
}

static void crash_with_later_handler(void)
{
    open_at(NULL);
    handle_signal(SIGSEGV, end_process, SA_ONSTACK);
    CRASH(.signal = 0);
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
    CRASH(.signal = 0);
}

/* The handler passes the signal on to the layer's, though its instance is gone. */
static void crash_after_the_instance(void)
{
    open_at(NULL);
    handle_signal(SIGSEGV, pass_on, 0);
    scene_close();
    raise(SIGSEGV);
}

static void crash_ignored(void)
{
    signal(SIGFPE, SIG_IGN);
    open_at(NULL);
    CRASH(.signal = SIGFPE);
    _exit(HANDLED);
}

static void return_from(int number, siginfo_t *info, void *context)
{
    say("returns\n");
}

static void crash_with_handler_for_once(void)
{
    handle_signal(SIGFPE, return_from, SA_RESETHAND);
    open_at(NULL);
    CRASH(.signal = SIGFPE);
    raise(SIGFPE);
}

static int fill_stack(int left)
{
    volatile char frame[1 << 16] = {0};
    return left ? fill_stack(left - 1) + frame[left % 2] : 0;
}

/* The handler finds no room on the thread's own stack. */
static void crash_with_full_stack(void)
{
    struct rlimit limit;
    getrlimit(RLIMIT_STACK, &limit);
    limit.rlim_cur = 8 << 20; /* less than fill_stack() fills */
    setrlimit(RLIMIT_STACK, &limit);
    handle_signal(SIGFPE, return_from, SA_ONSTACK);
    open_at(NULL);
    scene_submit(scene_record_boxes(0, 1));
    fill_stack(1 << 12);
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

static const struct row {
    const char *test;
    void (*child)(void);
    struct ending ending;
} rows[] = {
    {"test_earlier_handler", crash_with_earlier_handler, {0, {"ASSAY-crash", "minX"}}},
    /* It replaced the layer's. */
    {"test_later_handler", crash_with_later_handler, {.lacks = "ASSAY-crash"}},
    {"test_handler_that_passes_on", crash_with_handler_that_passes_on, {SIGSEGV, {"ASSAY-crash"}}},
    {"test_handler_outlives_the_instance",
     crash_after_the_instance,
     {SIGSEGV, {"passes on"}, "ASSAY-crash"}},
    {"test_ignored_signal", crash_ignored, {.lacks = "ASSAY-crash"}},
    {"test_handler_for_once", crash_with_handler_for_once, {SIGFPE, {"ASSAY-crash", "returns"}}},
    {"test_full_stack", crash_with_full_stack, {SIGSEGV, {"ASSAY-crash"}}},
    {"test_handlers_are_put_back", open_often, {0}},
};

TEST_OF_ROWS(test_handlers, rows, const struct row *row, unit_test_nothing)
{
    run(row->child, NULL, NULL);
    expect_ending(&row->ending);
}
