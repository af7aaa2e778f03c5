/* SPDX-License-Identifier: Apache-2.0 */
/* One compute shader on the device of a test program. What fails unexpectedly ends the test. */
#ifndef ASSAY_TESTS_SNAPSHOTS_SHADER_H
#define ASSAY_TESTS_SNAPSHOTS_SHADER_H

#include "tests/fixture/objects.h"
#include "tests/unit/unit_test.h"

void shader_open(const uint32_t *code, size_t code_size, uint32_t constants_size);
void shader_close(void);

/* Creates a buffer that shaders access by its address, and that shader_close() destroys. */
struct device_buffer shader_buffer(VkDeviceSize size);
/* Executes the shader, and waits. */
void shader_run(const void *constants, uint32_t constants_size, uint32_t groups);

#endif
