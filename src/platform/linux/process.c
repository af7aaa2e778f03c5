/* SPDX-License-Identifier: Apache-2.0 */
/* The process. */
#define _GNU_SOURCE /* dladdr, environ */
#include "src/platform/process.h"

#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

uint64_t process_id(void)
{
    return (uint64_t)getpid();
}

bool process_is_elevated(void)
{
    return getauxval(AT_SECURE) != 0;
}

void process_executable(char *path, size_t size)
{
    ssize_t length = readlink("/proc/self/exe", path, size - 1);
    path[length > 0 ? length : 0] = '\0';
}

const char *process_variable(const char *name)
{
    return getenv(name);
}

void process_environment(void (*visit)(void *context, const char *variable), void *context)
{
    for (char **variable = environ; variable && *variable; variable++)
        visit(context, *variable);
}

void process_break(void)
{
    raise(SIGTRAP);
}

void process_write_to_debugger(const char *text)
{
    (void)text;
}

void process_keep_library(const void *address)
{
    Dl_info info;
    if (dladdr(address, &info))
        dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
}

void process_clear_on_fork(void *pages, size_t size)
{
    madvise(pages, size, MADV_WIPEONFORK);
}
