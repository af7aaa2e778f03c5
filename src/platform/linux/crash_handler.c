/* SPDX-License-Identifier: Apache-2.0 */
/* Signal handlers, and the thread that validates for them. */
#define _GNU_SOURCE
#include "src/platform/crash_handler.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "src/platform/process.h"

enum { SIGNALS = 4, VALIDATION_MILLISECONDS = 3000, PAUSE_MILLISECONDS = 10 };
enum { HAS_REPORTED = -1 };
enum { REQUEST_VALIDATION = 'v', REQUEST_END = 'e', REPLY_DONE = 'd', REPLY_FAILED = 'f' };

static const struct {
    int number;
    const char *name;
} signals[SIGNALS] = {
    {SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"}, {SIGFPE, "SIGFPE"}, {SIGABRT, "SIGABRT"}};

static struct {
    struct crash_hooks hooks;
    struct sigaction previous[SIGNALS];
    /* The actions below handlers of the application that may call the layer's, though the layer's
     * are not installed any more. */
    struct sigaction below[SIGNALS];
    bool has_below[SIGNALS];
    uint64_t process;
    pthread_t thread;
    bool has_thread;
    int requests[2], replies[2]; /* pipes to the thread, and from it */
    _Atomic pid_t thread_id;
    /* The thread that reports, once for each process; 0: none yet; HAS_REPORTED: it has. */
    _Atomic pid_t reporter_id;
} crash;

static pid_t own_id(void)
{
    return (pid_t)syscall(SYS_gettid);
}

/* ---- the thread */

static void *wait_for_requests(void *unused)
{
    char request;
    (void)unused;
    atomic_store(&crash.thread_id, own_id());
    while (read(crash.requests[0], &request, 1) == 1 && request == REQUEST_VALIDATION) {
        const char reply = crash.hooks.validate() ? REPLY_DONE : REPLY_FAILED;
        if (write(crash.replies[1], &reply, 1) != 1)
            break;
    }
    return NULL;
}

static void close_pipe(int ends[2])
{
    close(ends[0]);
    close(ends[1]);
}

/* Without the thread, inputs are not validated. */
static void start_thread(void)
{
    sigset_t all, before;
    crash.has_thread = false;
    if (pipe2(crash.requests, O_CLOEXEC) != 0)
        return;
    if (pipe2(crash.replies, O_CLOEXEC) != 0) {
        close_pipe(crash.requests);
        return;
    }
    sigfillset(&all);
    for (int i = 0; i < SIGNALS; i++)
        sigdelset(&all, signals[i].number);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    crash.has_thread = pthread_create(&crash.thread, NULL, wait_for_requests, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (crash.has_thread)
        return;
    close_pipe(crash.requests);
    close_pipe(crash.replies);
}

static void end_thread(void)
{
    const char request = REQUEST_END;
    if (!crash.has_thread)
        return;
    if (write(crash.requests[1], &request, 1) == 1)
        pthread_join(crash.thread, NULL);
    close_pipe(crash.requests);
    close_pipe(crash.replies);
    crash.has_thread = false;
}

/* Returns false if the thread failed, or did not answer in time. */
bool crash_handler_validate(void)
{
    struct pollfd reply = {.fd = crash.replies[0], .events = POLLIN};
    char answer = REQUEST_VALIDATION;
    return crash.has_thread && write(crash.requests[1], &answer, 1) == 1 &&
           poll(&reply, 1, VALIDATION_MILLISECONDS) == 1 &&
           read(crash.replies[0], &answer, 1) == 1 && answer == REPLY_DONE;
}

/* ---- the handler */

static int index_of(int number)
{
    int i = 0;
    while (i < SIGNALS - 1 && signals[i].number != number)
        i++;
    return i;
}

static bool was_sent(const siginfo_t *info)
{
    return info->si_code <= 0;
}

static bool ignores(const struct sigaction *action, const siginfo_t *info)
{
    return !(action->sa_flags & SA_SIGINFO) && action->sa_handler == SIG_IGN && was_sent(info);
}

/* Such faults are common with tools that track writes by protecting pages, such as gfxreconstruct,
 * and runtimes of languages: their handler lets the access happen. */
static bool is_of_protected_page(int number, const siginfo_t *info)
{
    return number == SIGSEGV && (info->si_code == SEGV_ACCERR || info->si_code == SEGV_PKUERR);
}

static bool is_function(const struct sigaction *action)
{
    return action->sa_handler != SIG_DFL && action->sa_handler != SIG_IGN;
}

static bool is_reporting(void)
{
    return atomic_load(&crash.reporter_id) > 0;
}

/* Another thread's handler would end the process before this one has written its report. */
static void wait_for_reporter(void)
{
    if (own_id() == atomic_load(&crash.thread_id)) {
        const char reply = REPLY_FAILED;
        if (write(crash.replies[1], &reply, 1) == 1)
            for (;;)
                pause();
    }
    int left = 2 * VALIDATION_MILLISECONDS / PAUSE_MILLISECONDS;
    while (left-- && is_reporting() && atomic_load(&crash.reporter_id) != own_id())
        poll(NULL, 0, PAUSE_MILLISECONDS);
}

static void report_once(int signal, const siginfo_t *info)
{
    const struct crash_event event = {
        .name = signals[signal].name,
        .has_address = info->si_code > 0,
        .is_of_instruction = signal >= 2,
        .address = (uint64_t)(uintptr_t)info->si_addr,
    };
    if (crash.process != process_id())
        return; /* a child has no device */
    if (!atomic_compare_exchange_strong(&crash.reporter_id, &(pid_t){0}, own_id())) {
        wait_for_reporter();
        return;
    }
    crash.hooks.report(&event);
    atomic_store(&crash.reporter_id, HAS_REPORTED);
}

/* Calls the previous handler with the mask that it would have without the layer. The handler may
 * jump elsewhere instead of returning. */
static void call_previous(const struct sigaction *previous, int number, siginfo_t *info,
                          void *context)
{
    const struct sigaction action = *previous;
    sigset_t mask = action.sa_mask;
    if (!(action.sa_flags & SA_NODEFER))
        sigaddset(&mask, number);
    if (action.sa_flags & SA_RESETHAND && previous == &crash.previous[index_of(number)])
        crash.previous[index_of(number)].sa_handler = SIG_DFL;
    pthread_sigmask(SIG_BLOCK, &mask, NULL);
    if (action.sa_flags & SA_SIGINFO)
        action.sa_sigaction(number, info, context);
    else
        action.sa_handler(number);
}

/* Lets the previous handler handle a fault. Returns false if the handler has chosen the default
 * action, with which the fault ends the process. */
static bool is_handled(const struct sigaction *previous, int number, siginfo_t *info, void *context)
{
    struct sigaction chosen;
    call_previous(previous, number, info, context);
    return sigaction(number, NULL, &chosen) != 0 || is_function(&chosen);
}

/* Reports, then puts the previous action back. A fault happens again when the handler returns; a
 * signal that was sent is sent again. So the previous handler is called as if there had been no
 * other: on its stack, with its mask, and with the same information. A fault of a protected page is
 * reported only if the previous handler leaves it to the default action. */
static void handle(int number, siginfo_t *info, void *context)
{
    const int error = errno, signal = index_of(number);
    const struct sigaction *next = &crash.previous[signal];
    struct sigaction current;
    if (sigaction(number, NULL, &current) == 0 && current.sa_sigaction != handle &&
        crash.has_below[signal])
        next = &crash.below[signal];
    if (is_of_protected_page(number, info) && is_function(next)) {
        if (!is_handled(next, number, info, context))
            report_once(signal, info);
    } else if (!ignores(next, info)) {
        report_once(signal, info);
        sigaction(number, next, NULL);
        if (was_sent(info))
            syscall(SYS_rt_tgsigqueueinfo, getpid(), own_id(), number, info);
    }
    errno = error;
}

/* ---- installation */

void crash_handler_install(const struct crash_hooks *hooks)
{
    struct sigaction own = {.sa_sigaction = handle};
    sigemptyset(&own.sa_mask);
    crash.process = process_id();
    crash.hooks = *hooks;
    start_thread();
    for (int i = 0; i < SIGNALS; i++) {
        struct sigaction before;
        if (sigaction(signals[i].number, NULL, &before) != 0)
            continue;
        if (before.sa_sigaction != handle)
            crash.previous[i] = before;
        /* A handler that is called from the layer's is on the stack that it expects. */
        own.sa_flags = SA_SIGINFO | SA_NODEFER |
                       (is_function(&crash.previous[i]) ? crash.previous[i].sa_flags & SA_ONSTACK
                                                        : SA_ONSTACK);
        sigaction(signals[i].number, &own, NULL);
    }
}

static bool are_equal(const struct sigaction *a, const struct sigaction *b)
{
    return a->sa_sigaction == b->sa_sigaction;
}

void crash_handler_uninstall(void)
{
    for (int i = 0; i < SIGNALS; i++) {
        struct sigaction current;
        if (sigaction(signals[i].number, NULL, &current) != 0)
            continue;
        if (current.sa_sigaction == handle) {
            sigaction(signals[i].number, &crash.previous[i], NULL);
        } else if (!are_equal(&current, &crash.previous[i])) {
            crash.below[i] = crash.previous[i];
            crash.has_below[i] = true;
            process_keep_library((void *)(uintptr_t)handle);
        }
    }
    end_thread();
}

bool crash_handler_is_of_parent(void)
{
    return crash.process && crash.process != process_id();
}

void crash_handler_leave_parent(void)
{
    crash.has_thread = false;
    atomic_store(&crash.reporter_id, 0);
}

void crash_handler_wait(void)
{
    while (is_reporting())
        poll(NULL, 0, PAUSE_MILLISECONDS);
}
