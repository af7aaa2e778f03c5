/* SPDX-License-Identifier: Apache-2.0 */
/* Signal handlers of the application beside the layer's. */
#include "tests/postmortem/crash_child.h"

#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
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
    close_device();
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
    submit_box();
    fill_stack(1 << 12);
}

/* ---- faults of protected pages */

enum { PAGE = 1 << 12 };

static char *page;
static sigjmp_buf place;

static void unprotect(int number, siginfo_t *info, void *context)
{
    sigset_t mask;
    sigprocmask(SIG_BLOCK, NULL, &mask);
    if (info->si_addr != page || !context || !sigismember(&mask, SIGUSR1) ||
        !sigismember(&mask, SIGSEGV) || !is_on_alternate_stack())
        _exit(1);
    mprotect(page, PAGE, PROT_READ | PROT_WRITE);
    say("unprotects\n");
}

/* On the thread's own stack. */
static void jump(int number, siginfo_t *info, void *context)
{
    if (is_on_alternate_stack())
        _exit(1);
    siglongjmp(place, 1);
}

static void give_up(int number, siginfo_t *info, void *context)
{
    signal(SIGSEGV, SIG_DFL);
    say("gives up\n");
}

/* Opens a device with pending builds, behind a handler. */
static void open_behind(void (*handler)(int, siginfo_t *, void *), int flags)
{
    handle_signal(SIGSEGV, handler, flags);
    page = mmap(NULL, 2 * PAGE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    open_at(NULL);
    submit_box();
}

static void write_to_page(void)
{
    mprotect(page, PAGE, PROT_READ);
    *(volatile char *)page = 1;
}

static void write_to_protected_pages(void)
{
    open_behind(unprotect, SA_ONSTACK);
    write_to_page();
    write_to_page();
    _exit(HANDLED);
}

/* The thread sanitizer lets no handler interrupt itself, and no child start threads; nor does qemu
 * 7.2 let a child. */
#if !defined(__SANITIZE_THREAD__) && !defined(EMULATED)
#define HAS_ALL_TESTS
#endif

#ifdef HAS_ALL_TESTS
static void crash_in_a_child_with_a_device(void)
{
    open_at(NULL);
    const pid_t child = fork();
    if (child == 0) {
        open_at(NULL);
        CRASH(.signal = 0);
    }
    waitpid(child, &status, 0);
    _exit(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV ? HANDLED : 1);
}

/* Accesses the second page, and so is called again, when the first one is accessed. */
static void unprotect_both(int number, siginfo_t *info, void *context)
{
    if (info->si_addr == page)
        *(volatile char *)(page + PAGE) = 1;
    mprotect(info->si_addr, PAGE, PROT_READ | PROT_WRITE);
    say("unprotects\n");
}

static void fault_in_a_handler(void)
{
    open_behind(unprotect_both, SA_ONSTACK | SA_NODEFER);
    write_to_page();
    _exit(HANDLED);
}
#endif

static void crash_after_a_protected_page(void)
{
    open_behind(unprotect, SA_ONSTACK);
    write_to_page();
    CRASH(.signal = SIGABRT);
}

static void jump_from_a_protected_page(void)
{
    open_behind(jump, 0);
    for (volatile int i = 0; i < 2; i++)
        if (!sigsetjmp(place, 1))
            write_to_page();
    sigset_t mask;
    sigprocmask(SIG_BLOCK, NULL, &mask);
    _exit(sigismember(&mask, SIGSEGV) ? 1 : HANDLED);
}

static void give_up_a_protected_page(void)
{
    open_behind(give_up, 0);
    write_to_page();
}

static void return_once_from_a_protected_page(void)
{
    open_behind(return_from, SA_RESETHAND);
    write_to_page();
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
        close_device();
        sigaction(SIGSEGV, NULL, &last);
        if (!are_equal(&first, &last))
            _exit(1);
        sigaction(SIGABRT, NULL, &last);
        if (last.sa_handler != SIG_DFL)
            _exit(2);
    }
    _exit(HANDLED);
}

/* The handler has no place for the last devices. */
static void crash_with_many_devices(void)
{
    open_at(NULL);
    const STRUCT(VkPhysicalDeviceAccelerationStructureFeaturesKHR, features,
                 .accelerationStructure = VK_TRUE);
    static const char *const extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
    VkDevice device;
    VkuDeviceDispatchTable vk;
    for (int i = 0; i < 20; i++)
        GET(instance_fixture_create_device(&play.fixture, &features, extensions,
                                           ARRAY_COUNT(extensions), &device, &vk));
    vk.DestroyDevice(device, NULL);
    CRASH(.signal = 0);
}

static void crash_without_stderr(void)
{
    open_at(NULL);
    close(STDERR_FILENO);
    CRASH(.signal = 0);
}

/* The device is the parent's, whose builds are none of the child's. */
static void crash_in_a_child(void)
{
    open_at(NULL);
    submit_box();
    const pid_t child = fork();
    if (child == 0)
        raise(SIGSEGV);
    waitpid(child, &status, 0);
    _exit(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV ? HANDLED : 1);
}

static pthread_barrier_t together;

static void *crash_together(void *unused)
{
    pthread_barrier_wait(&together);
    raise(SIGSEGV);
    return unused;
}

/* The first one's report is whole, though the others' faults would end the process. */
static void crash_in_several_threads(void)
{
    enum { THREADS = 4 };
    pthread_t thread;
    open_at(NULL);
    submit_box();
    pthread_barrier_init(&together, NULL, THREADS);
    for (int i = 1; i < THREADS; i++)
        pthread_create(&thread, NULL, crash_together, NULL);
    crash_together(NULL);
}

static const struct row {
    const char *test;
    void (*child)(void);
    struct ending ending;
} rows[] = {
    {"test_earlier_handler", crash_with_earlier_handler, {0, "ASSAY-crash...minX"}},
    /* It replaced the layer's. */
    {"test_later_handler", crash_with_later_handler, {.lacks = "ASSAY-crash"}},
    {"test_handler_that_passes_on", crash_with_handler_that_passes_on, {SIGSEGV, "ASSAY-crash"}},
    {"test_handler_outlives_the_instance",
     crash_after_the_instance,
     {SIGSEGV, "passes on", "ASSAY-crash"}},
    {"test_ignored_signal", crash_ignored, {.lacks = "ASSAY-crash"}},
    {"test_handler_for_once", crash_with_handler_for_once, {SIGFPE, "ASSAY-crash...returns"}},
    {"test_full_stack", crash_with_full_stack, {SIGSEGV, "ASSAY-crash"}},
    {"test_protected_pages",
     write_to_protected_pages,
     {0, "unprotects\nunprotects", "ASSAY-crash"}},
#ifdef HAS_ALL_TESTS
    {"test_child_with_a_device", crash_in_a_child_with_a_device, {0, "ASSAY-crash...minX"}},
    {"test_fault_in_a_handler", fault_in_a_handler, {0, "unprotects\nunprotects", "ASSAY-crash"}},
#endif
    {"test_crash_after_a_protected_page",
     crash_after_a_protected_page,
     {SIGABRT, "unprotects...ASSAY-crash"}},
    {"test_jump_from_a_protected_page", jump_from_a_protected_page, {.lacks = "ASSAY-crash"}},
    {"test_protected_page_given_up", give_up_a_protected_page, {SIGSEGV, "gives up...ASSAY-crash"}},
    {"test_protected_page_with_a_handler_for_once",
     return_once_from_a_protected_page,
     {SIGSEGV, "returns...ASSAY-crash"}},
    {"test_handlers_are_put_back", open_often, {0}},
    {"test_no_stderr", crash_without_stderr, {SIGSEGV, .lacks = "ASSAY-crash"}},
    {"test_child", crash_in_a_child, {.lacks = "ASSAY-crash"}},
    {"test_several_threads", crash_in_several_threads, {SIGSEGV, "ASSAY-crash...minX"}},
    {"test_many_devices", crash_with_many_devices, {SIGSEGV, "ASSAY-crash", "runtime error"}},
};

TEST_OF_ROWS(test_handlers, rows, const struct row *row, unit_test_nothing)
{
    run(row->child, NULL, NULL);
    expect_ending(&row->ending);
}
