/* SPDX-License-Identifier: Apache-2.0 */
/* The filter of exceptions that nothing handles, and the thread that validates for it. */
#include "src/platform/crash_handler.h"

#include <pthread.h>
#include <stdatomic.h>
#include <windows.h>

#include "src/platform/process.h"

enum { VALIDATION_MILLISECONDS = 3000, PAUSE_MILLISECONDS = 10 };

static struct {
    struct crash_hooks hooks;
    LPTOP_LEVEL_EXCEPTION_FILTER previous;
    pthread_t thread;
    bool has_thread;
    HANDLE request, reply;
    atomic_bool ends;          /* the request is to end */
    atomic_bool is_valid;      /* the reply */
    _Atomic DWORD reporter_id; /* the thread that reports, once for each process; 0: none yet */
    atomic_bool is_reported;   /* it has */
} crash;

/* ---- the thread */

static void *wait_for_requests(void *unused)
{
    (void)unused;
    while (WaitForSingleObject(crash.request, INFINITE) == WAIT_OBJECT_0 &&
           !atomic_load(&crash.ends)) {
        atomic_store(&crash.is_valid, crash.hooks.validate());
        SetEvent(crash.reply);
    }
    return NULL;
}

/* Without the thread, inputs are not validated. */
static void start_thread(void)
{
    crash.request = CreateEventW(NULL, FALSE, FALSE, NULL);
    crash.reply = CreateEventW(NULL, FALSE, FALSE, NULL);
    atomic_store(&crash.ends, false);
    crash.has_thread = crash.request && crash.reply &&
                       pthread_create(&crash.thread, NULL, wait_for_requests, NULL) == 0;
}

static void end_thread(void)
{
    if (crash.has_thread) {
        atomic_store(&crash.ends, true);
        SetEvent(crash.request);
        pthread_join(crash.thread, NULL);
    }
    crash.has_thread = false;
    if (crash.request)
        CloseHandle(crash.request);
    if (crash.reply)
        CloseHandle(crash.reply);
}

bool crash_handler_validate(void)
{
    return crash.has_thread && SetEvent(crash.request) &&
           WaitForSingleObject(crash.reply, VALIDATION_MILLISECONDS) == WAIT_OBJECT_0 &&
           atomic_load(&crash.is_valid);
}

/* ---- the filter */

static const char *name_of(DWORD code)
{
    static const struct {
        DWORD code;
        const char *name;
    } names[] = {
        {EXCEPTION_ACCESS_VIOLATION, "EXCEPTION_ACCESS_VIOLATION"},
        {EXCEPTION_IN_PAGE_ERROR, "EXCEPTION_IN_PAGE_ERROR"},
        {EXCEPTION_STACK_OVERFLOW, "EXCEPTION_STACK_OVERFLOW"},
        {EXCEPTION_ILLEGAL_INSTRUCTION, "EXCEPTION_ILLEGAL_INSTRUCTION"},
        {EXCEPTION_INT_DIVIDE_BY_ZERO, "EXCEPTION_INT_DIVIDE_BY_ZERO"},
        {EXCEPTION_BREAKPOINT, "EXCEPTION_BREAKPOINT"},
    };
    for (unsigned i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        if (names[i].code == code)
            return names[i].name;
    return "an exception";
}

static struct crash_event event_of(const EXCEPTION_RECORD *record)
{
    const bool is_of_memory = record->ExceptionCode == EXCEPTION_ACCESS_VIOLATION ||
                              record->ExceptionCode == EXCEPTION_IN_PAGE_ERROR;
    return (struct crash_event){
        .name = name_of(record->ExceptionCode),
        .has_address = true,
        .is_of_instruction = !is_of_memory,
        .address = is_of_memory ? record->ExceptionInformation[1]
                                : (uint64_t)(uintptr_t)record->ExceptionAddress,
    };
}

static bool is_reporting(void)
{
    return atomic_load(&crash.reporter_id) && !atomic_load(&crash.is_reported);
}

/* Another thread's filter would end the process before this one has written its report. */
static void wait_for_reporter(void)
{
    int left = 2 * VALIDATION_MILLISECONDS / PAUSE_MILLISECONDS;
    while (left-- && is_reporting() && atomic_load(&crash.reporter_id) != GetCurrentThreadId())
        Sleep(PAUSE_MILLISECONDS);
}

static LONG WINAPI filter(EXCEPTION_POINTERS *exception)
{
    if (!atomic_compare_exchange_strong(&crash.reporter_id, &(DWORD){0}, GetCurrentThreadId())) {
        wait_for_reporter();
    } else {
        const struct crash_event event = event_of(exception->ExceptionRecord);
        crash.hooks.report(&event);
        atomic_store(&crash.is_reported, true);
    }
    return crash.previous ? crash.previous(exception) : EXCEPTION_CONTINUE_SEARCH;
}

/* ---- installation */

void crash_handler_install(const struct crash_hooks *hooks)
{
    crash.hooks = *hooks;
    start_thread();
    LPTOP_LEVEL_EXCEPTION_FILTER before = SetUnhandledExceptionFilter(filter);
    if (before != filter)
        crash.previous = before;
}

void crash_handler_uninstall(void)
{
    LPTOP_LEVEL_EXCEPTION_FILTER current = SetUnhandledExceptionFilter(crash.previous);
    if (current != filter) {
        SetUnhandledExceptionFilter(current);
        process_keep_library((const void *)(uintptr_t)filter);
    }
    end_thread();
}

/* Windows has no forks. */
bool crash_handler_is_of_parent(void)
{
    return false;
}

void crash_handler_leave_parent(void) {}

void crash_handler_wait(void)
{
    while (is_reporting())
        Sleep(PAUSE_MILLISECONDS);
}
