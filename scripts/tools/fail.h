/* SPDX-License-Identifier: Apache-2.0 */
/* Ends a tool that can't go on. */
#ifndef TOOLS_FAIL_H
#define TOOLS_FAIL_H

#include <stddef.h>
#include <stdnoreturn.h>
#include <vulkan/vulkan_core.h>

/* Ends the process with one line on stderr. */
noreturn void tool_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The same unless the result is VK_SUCCESS. */
void tool_check(VkResult result, const char *call);

/* The same of a command in a dispatch table: TOOL_CALL(gpu->calls, CreateFence, gpu->device, ...).
 */
#define TOOL_CALL(table, name, ...) tool_check((table).name(__VA_ARGS__), "vk" #name)

/* Zeroed, never NULL. */
void *tool_alloc(size_t count, size_t size);

#endif
