/* SPDX-License-Identifier: Apache-2.0 */
/* A device whose next layer is the test: commands of backend cpu are called directly. */
#ifndef CPU_BACKEND_BELOW_H
#define CPU_BACKEND_BELOW_H

#include "layer/cpu/overlay.h"
#include "tests/fixture/make.h"
#include "vulkan_commands.h"

extern struct cpu_overlay *const below;

/* A command of the driver, as the test plays it: PLAYED(CmdSetEvent) { ... }. The parameters have
 * their names of the registry. */
#define PLAYED(name) PLAY_##name
#define PLAY(result, name, ...)                                                                    \
    static VKAPI_ATTR result VKAPI_CALL play_##name(__VA_ARGS__);                                  \
    __attribute__((constructor)) static void add_##name(void)                                      \
    {                                                                                              \
        below->down.name = play_##name;                                                            \
    }                                                                                              \
    static VKAPI_ATTR result VKAPI_CALL play_##name(__VA_ARGS__)

/* One that is only counted, and succeeds. */
#define COUNTED(name)                                                                              \
    PLAYED(name)                                                                                   \
    {                                                                                              \
        calls++;                                                                                   \
        return VK_SUCCESS;                                                                         \
    }
extern unsigned calls;

/* Any dispatchable handle of the device. */
#define DEVICE ((VkDevice)(uintptr_t)1)
#define COMMAND_BUFFER ((VkCommandBuffer)(uintptr_t)3)

enum { MANY = 500 }; /* more than fit on the stack */

/* A call that the backend refuses. */
#define REFUSED(call) assert_int_equal(call, VK_ERROR_VALIDATION_FAILED_EXT)

/* The last command that cpu_report_unsupported() got, and the number of calls. */
extern const char *refused_command;
extern unsigned refusals;

void below_clear(void); /* `calls` and the refusals */

#endif
