/* SPDX-License-Identifier: Apache-2.0 */
/* A device whose next layer is the test: commands of backend cpu are called directly. */
#ifndef CPU_BACKEND_BELOW_H
#define CPU_BACKEND_BELOW_H

#include "layer/cpu/overlay.h"
#include "tests/cpu_backend/info.h"

/* The test puts its commands into `below->next`. */
extern struct cpu_overlay *const below;

/* Any dispatchable handle of the device. */
#define DEVICE ((VkDevice)(uintptr_t)1)
#define QUEUE ((VkQueue)(uintptr_t)2)
#define COMMAND_BUFFER ((VkCommandBuffer)(uintptr_t)3)

/* What cpu_report_unsupported() was last told, and how often; the test clears it. */
extern const char *refused_command;
extern unsigned refusals;

#endif
