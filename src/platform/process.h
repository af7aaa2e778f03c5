/* SPDX-License-Identifier: Apache-2.0 */
/* The process: its id, its privileges, its program, its environment, and the debugger. */
#ifndef ASSAY_PLATFORM_PROCESS_H
#define ASSAY_PLATFORM_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A signal handler may call it. */
uint64_t process_id(void);

/* Returns whether the process has elevated privileges: programs with the set-user-ID or
 * set-group-ID bit, or with file capabilities. The user who starts such a process chooses its
 * environment and current folder, and must not gain the privileges of the process through them.
 * Windows has no such programs: a process of an administrator has that user's environment. */
bool process_is_elevated(void);

/* Writes the path of the process's executable; "" if it is unknown. */
void process_executable(char *path, size_t size);

/* Returns the value of a variable of the environment, or NULL. The value is valid until the
 * variable changes. */
const char *process_variable(const char *name);

/* Calls `visit` with each variable of the environment, as NAME=VALUE. */
void process_environment(void (*visit)(void *context, const char *variable), void *context);

/* Stops in the debugger. Without one, the process ends unless it handles the signal (SIGTRAP) or
 * exception (breakpoint). */
void process_break(void);

/* Writes to the debugger's output, if the system has one. */
#ifdef _WIN32
enum { PROCESS_HAS_DEBUGGER_OUTPUT = true };
#else
enum { PROCESS_HAS_DEBUGGER_OUTPUT = false };
#endif
void process_write_to_debugger(const char *text);

/* Keeps the library that contains `address` in memory until the process ends. */
void process_keep_library(const void *address);

/* Lets the system clear whole pages of memory in the child of a fork. If the system cannot, or has
 * no forks, the pages stay as they are. */
void process_clear_on_fork(void *pages, size_t size);

#endif
