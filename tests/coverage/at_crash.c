/* SPDX-License-Identifier: Apache-2.0 */
/* Where coverage is measured, a process that a fault ends writes its counts before. This library's
 * counts are its own, so that it has a handler of its own: below the layer's, as it is there first.
 */
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>

enum { SIGNALS = 4 };
static const int signals[SIGNALS] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT};

void __gcov_dump(void);

/* See at_exit.c. */
__attribute__((visibility("default"))) void assay_write_counts(void);
void assay_write_counts(void)
{
    __gcov_dump();
}

/* The fault happens again when this returns; a signal that was sent is sent again. */
static void write_counts(int number, siginfo_t *info, void *context)
{
    (void)context;
    signal(number, SIG_DFL);
    __gcov_dump();
    if (info->si_code <= 0)
        raise(number);
}

__attribute__((constructor)) static void install(void)
{
    for (int i = 0; i < SIGNALS; i++) {
        struct sigaction own = {.sa_sigaction = write_counts, .sa_flags = SA_SIGINFO | SA_ONSTACK};
        struct sigaction before;
        if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler == SIG_DFL)
            sigaction(signals[i], &own, NULL);
    }
}

__attribute__((destructor)) static void uninstall(void)
{
    struct sigaction current;
    for (int i = 0; i < SIGNALS; i++)
        if (sigaction(signals[i], NULL, &current) == 0 && current.sa_sigaction == write_counts)
            signal(signals[i], SIG_DFL);
}
