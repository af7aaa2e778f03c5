/* SPDX-License-Identifier: Apache-2.0 */
/* Signal handlers, and the thread that validates for them. */
#define _GNU_SOURCE
#include "layer/postmortem/crash.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "layer/postmortem/crash_output.h"
#include "layer/postmortem/marked_inputs.h"
#include "layer/postmortem/pending_list.h"
#include "src/report/ids/message_id.h"
#include "src/report/message.h"

enum { SIGNALS = 4, DEVICES_MAX = 16, VALIDATION_MILLISECONDS = 3000, PAUSE_MILLISECONDS = 10 };
enum { REQUEST_VALIDATION = 'v', REQUEST_END = 'e', REPLY_DONE = 'd', REPLY_FAILED = 'f' };

static const char event_id[] = "ASSAY-crash";

static const struct {
    int number;
    const char *name;
} signals[SIGNALS] = {
    {SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"}, {SIGFPE, "SIGFPE"}, {SIGABRT, "SIGABRT"}};

static struct {
    pthread_mutex_t lock; /* of the members up to `devices`; the handler only reads them */
    struct sigaction previous[SIGNALS];
    /* The actions below handlers of the application that may call the layer's, though the layer's
     * are not installed any more. */
    struct sigaction below[SIGNALS];
    bool has_below[SIGNALS];
    int32_t id_number;
    pid_t process;
    pthread_t thread;
    bool has_thread;
    int requests[2], replies[2]; /* pipes to the thread, and from it */

    struct {
        struct layer_device *_Atomic device;
        struct crash_output output;
    } devices[DEVICES_MAX];
    atomic_bool reported; /* one report for each process */
    atomic_bool is_busy;  /* a handler reports */
    _Atomic pid_t thread_id, reporter_id;
    char text[MESSAGE_SIZE];
} crash = {.lock = PTHREAD_MUTEX_INITIALIZER};

static pid_t own_id(void)
{
    return (pid_t)syscall(SYS_gettid);
}

/* ---- the thread */

static char validate(void)
{
    char reply = REPLY_DONE;
    for (int i = 0; i < DEVICES_MAX; i++) {
        struct layer_device *device = atomic_load(&crash.devices[i].device);
        if (!device)
            continue;
        reporter_silence_callbacks(device->instance->reporter);
        if (!marked_inputs_read(device, "read when the process crashed"))
            reply = REPLY_FAILED;
    }
    return reply;
}

static void *wait_for_requests(void *unused)
{
    char request;
    (void)unused;
    atomic_store(&crash.thread_id, own_id());
    while (read(crash.requests[0], &request, 1) == 1 && request == REQUEST_VALIDATION) {
        const char reply = validate();
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
static bool let_thread_validate(void)
{
    struct pollfd reply = {.fd = crash.replies[0], .events = POLLIN};
    char answer = REQUEST_VALIDATION;
    return crash.has_thread && write(crash.requests[1], &answer, 1) == 1 &&
           poll(&reply, 1, VALIDATION_MILLISECONDS) == 1 &&
           read(crash.replies[0], &answer, 1) == 1 && answer == REPLY_DONE;
}

/* ---- the report */

static void append_signal(struct text_buffer *text, int index, const siginfo_t *info)
{
    text_append_plain(text, "The process received ");
    text_append_plain(text, signals[index].name);
    if (info->si_code > 0) {
        text_append_plain(text, index < 2 ? " for address " : " at instruction ");
        text_append_hex(text, (uint64_t)(uintptr_t)info->si_addr);
    }
    text_append_plain(text, ". ");
}

/* Returns whether the device has builds that may be incomplete. */
static bool report_device(int i, int signal, const siginfo_t *info)
{
    const struct layer_device *device = atomic_load(&crash.devices[i].device);
    struct text_buffer text;
    if (!device)
        return false;
    text_begin(&text, crash.text, sizeof(crash.text));
    append_signal(&text, signal, info);
    if (!pending_list_append(device, false, &text))
        return false;
    crash_output_write(&crash.devices[i].output, event_id, crash.id_number, crash.text);
    return device->input_checks;
}

static void report(int signal, const siginfo_t *info)
{
    bool has_inputs[DEVICES_MAX], has_any = false;
    for (int i = 0; i < DEVICES_MAX; i++) {
        has_inputs[i] = report_device(i, signal, info);
        has_any |= has_inputs[i];
    }
    if (!has_any || let_thread_validate())
        return;
    for (int i = 0; i < DEVICES_MAX; i++)
        if (has_inputs[i])
            crash_output_write(&crash.devices[i].output, event_id, crash.id_number,
                               "The inputs of these builds that had been copied could not be "
                               "validated, or not all of them.");
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
    while (left-- && atomic_load(&crash.is_busy) && atomic_load(&crash.reporter_id) != own_id())
        poll(NULL, 0, PAUSE_MILLISECONDS);
}

static void report_once(int signal, const siginfo_t *info)
{
    if (crash.process != getpid())
        return; /* a child has no device */
    if (atomic_exchange(&crash.reported, true)) {
        wait_for_reporter();
        return;
    }
    atomic_store(&crash.reporter_id, own_id());
    atomic_store(&crash.is_busy, true);
    report(signal, info);
    atomic_store(&crash.is_busy, false);
}

/* Reports, then puts the previous action back. A fault happens again when the handler returns; a
 * signal that was sent is sent again. So the previous handler is called as if there had been no
 * other: on its stack, with its mask, and with the same information. */
static void handle(int number, siginfo_t *info, void *context)
{
    const int error = errno, signal = index_of(number);
    const struct sigaction *next = &crash.previous[signal];
    struct sigaction current;
    (void)context;
    if (sigaction(number, NULL, &current) == 0 && current.sa_sigaction != handle &&
        crash.has_below[signal])
        next = &crash.below[signal];
    if (!ignores(next, info)) {
        report_once(signal, info);
        sigaction(number, next, NULL);
        if (was_sent(info))
            syscall(SYS_rt_tgsigqueueinfo, getpid(), own_id(), number, info);
    }
    errno = error;
}

/* ---- installation */

/* A child process has the handlers of its parent, but neither its thread nor its devices. */
static void leave_parent(void)
{
    if (!crash.process || crash.process == getpid())
        return;
    pthread_mutex_init(&crash.lock, NULL);
    crash.has_thread = false;
    for (int i = 0; i < DEVICES_MAX; i++)
        atomic_store(&crash.devices[i].device, NULL);
    atomic_store(&crash.reported, false);
    atomic_store(&crash.is_busy, false);
}

/* The slot of a device, or of none if it is NULL. Returns DEVICES_MAX if there is no such slot. */
static int find_slot(const struct layer_device *device)
{
    int i = 0;
    while (i < DEVICES_MAX && atomic_load(&crash.devices[i].device) != device)
        i++;
    return i;
}

static bool has_devices(void)
{
    bool has_any = false;
    for (int i = 0; i < DEVICES_MAX; i++)
        has_any |= atomic_load(&crash.devices[i].device) != NULL;
    return has_any;
}

static void install(void)
{
    struct sigaction own = {.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER};
    own.sa_sigaction = handle;
    sigemptyset(&own.sa_mask);
    crash.process = getpid();
    crash.id_number = message_id_number(event_id);
    start_thread();
    for (int i = 0; i < SIGNALS; i++) {
        struct sigaction before;
        if (sigaction(signals[i].number, &own, &before) == 0 && before.sa_sigaction != handle)
            crash.previous[i] = before;
    }
}

static bool are_equal(const struct sigaction *a, const struct sigaction *b)
{
    return a->sa_sigaction == b->sa_sigaction;
}

/* The application's handler may call the layer's, which it replaced: the library stays. */
static void stay_loaded(void)
{
    Dl_info info;
    if (dladdr((void *)(uintptr_t)handle, &info))
        dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
}

static void uninstall(void)
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
            stay_loaded();
        }
    }
    end_thread();
}

static bool is_wanted(const struct layer_device *device)
{
    const struct reporter *reporter = device->instance->reporter;
    return reporter_settings(reporter)->crash_report && reporter_has_warnings(reporter) &&
           device->submitted_builds;
}

void crash_add_device(struct layer_device *device)
{
    if (!is_wanted(device))
        return;
    leave_parent();
    pthread_mutex_lock(&crash.lock);
    if (!has_devices())
        install();
    int i = find_slot(NULL);
    if (i < DEVICES_MAX) {
        struct crash_output *output = &crash.devices[i].output;
        output->descriptor = reporter_log_descriptor(device->instance->reporter, &output->is_json);
        atomic_store(&crash.devices[i].device, device);
    }
    pthread_mutex_unlock(&crash.lock);
}

void crash_remove_device(struct layer_device *device)
{
    if (!is_wanted(device) || crash.process != getpid())
        return;
    pthread_mutex_lock(&crash.lock);
    int i = find_slot(device);
    if (i < DEVICES_MAX)
        atomic_store(&crash.devices[i].device, NULL);
    if (i < DEVICES_MAX && !has_devices())
        uninstall();
    pthread_mutex_unlock(&crash.lock);
    while (atomic_load(&crash.is_busy)) /* a handler may use the device */
        poll(NULL, 0, PAUSE_MILLISECONDS);
}
