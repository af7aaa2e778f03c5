/* SPDX-License-Identifier: Apache-2.0 */
/* The process. */
#include "src/platform/process.h"

#include <stdlib.h>
#include <string.h>

#include "src/platform/threads.h"
#include "src/platform/windows/text.h"

uint64_t process_id(void)
{
    return GetCurrentProcessId();
}

bool process_is_elevated(void)
{
    return false;
}

void process_executable(char *path, size_t size)
{
    wchar_t wide[WIDE_PATH_SIZE];
    DWORD length = GetModuleFileNameW(NULL, wide, WIDE_PATH_SIZE);
    path[0] = '\0';
    if (length > 0 && length < WIDE_PATH_SIZE)
        text_from_wide(wide, path, size);
}

/* ---- the environment, past the copy that the C library has: applications may have another one */

struct variable {
    struct variable *next;
    char *value;
    char name[];
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of the list */
static struct variable *variables; /* all that were ever read; freed only if a value changes */

static char *read_variable(const wchar_t *name)
{
    DWORD length = GetEnvironmentVariableW(name, NULL, 0);
    wchar_t *wide = length ? malloc(length * sizeof(*wide)) : NULL;
    char *value = NULL;
    if (wide && GetEnvironmentVariableW(name, wide, length) < length) {
        int size = WideCharToMultiByte(CP_UTF8, 0, wide, -1, NULL, 0, NULL, NULL);
        value = size > 0 ? malloc((size_t)size) : NULL;
        if (value)
            WideCharToMultiByte(CP_UTF8, 0, wide, -1, value, size, NULL, NULL);
    }
    free(wide);
    return value;
}

/* A value that was returned stays as it is: callers may hold it. */
static const char *keep_value(const char *name, char *value)
{
    for (struct variable *at = variables; at; at = at->next)
        if (strcmp(at->name, name) == 0 && strcmp(at->value, value) == 0) {
            free(value);
            return at->value;
        }
    struct variable *added = malloc(sizeof(*added) + strlen(name) + 1);
    if (!added) {
        free(value);
        return NULL;
    }
    strcpy(added->name, name);
    added->value = value;
    added->next = variables;
    variables = added;
    return value;
}

const char *process_variable(const char *name)
{
    wchar_t wide[WIDE_PATH_SIZE];
    char *value = text_to_wide(name, wide, WIDE_PATH_SIZE) ? read_variable(wide) : NULL;
    if (!value)
        return NULL;
    pthread_mutex_lock(&lock);
    const char *kept = keep_value(name, value);
    pthread_mutex_unlock(&lock);
    return kept;
}

void process_environment(void (*visit)(void *context, const char *variable), void *context)
{
    wchar_t *all = GetEnvironmentStringsW();
    char variable[WIDE_PATH_SIZE];
    for (const wchar_t *at = all; at && *at; at += wcslen(at) + 1) {
        text_from_wide(at, variable, sizeof(variable));
        visit(context, variable);
    }
    if (all)
        FreeEnvironmentStringsW(all);
}

/* ---- debugger, libraries */

void process_break(void)
{
    DebugBreak();
}

void process_write_to_debugger(const char *text)
{
    OutputDebugStringA(text);
}

void process_keep_library(const void *address)
{
    HMODULE module;
    GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_PIN,
                       (LPCWSTR)address, &module);
}

/* Windows has no forks. */
void process_clear_on_fork(void *pages, size_t size)
{
    (void)pages;
    (void)size;
}
