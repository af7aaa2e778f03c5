/* SPDX-License-Identifier: Apache-2.0 */
/* A device that is not published, under the intercepts that record hazards. Commands that these
 * forward do nothing. The hazard entries of a command buffer are compared as text. */
#ifndef ASSAY_TESTS_RECORDING_DEVICE_H
#define ASSAY_TESTS_RECORDING_DEVICE_H

#include "layer/hazards/builds.h"
#include "observers.h"
#include "tests/fixture/make.h"
#include "tests/state/command_fixture.h"
#include "tests/state/fixture.h"

extern struct layer_device device;
extern uint32_t forwarded; /* number of commands that went on */

/* Memory 1 has buffers 1 and 2, of 0x1000 bytes each, at offsets 0 and 0x1000. Their addresses are
 * the offsets plus BUFFERS. Buffer 3 is not bound. Structures 1 and 2 take bytes [0, 0x200) and
 * [0x200, 0x400) of buffer 1. Command buffer 1 is recording, and queue families 0 and 1 exist. */
enum { BUFFERS = 0x100000 };
void device_open(void);
void device_close(void);

#define RECORDING_TEST(name) TEST_BETWEEN(name, device_open, device_close)

/* Fails unless the hazard entries of command buffer 1, or of the last host command, are `text`. One
 * line for each:
 *     vkCmdCopyBuffer            a command; "*N+P": N builds from position P; "!": reads references
 *      T< src buffer1 0:40       access, role, object, bytes begin:end of memory 1, in hex
 *     barrier 2 BA:ab>B:c all    the first of two: stages with accesses, and bytes
 *     set 7 C, reset 7, wait 7*2
 * Stages are B(uild), A(ccel copy), C(opy), F(ill), M(icromap), H(ost); accesses are numbered a, b
 * ... as in enum access_kind. "*" stands for all stages, or all accesses. */
void expect(const char *text);
void expect_host(const char *text);
/* Those of a journal. */
void expect_journal(const struct journal *journal, const char *text);

/* Builds, as far as the checks and the recorder go. The sizes of every build are 0x100 for the
 * structure, and 0x40 for scratch, 0x20 in updates. */
struct build_parameters_of_call {
    const VkAccelerationStructureBuildGeometryInfoKHR *info;
    const VkAccelerationStructureBuildRangeInfoKHR *ranges;
    bool skip;
};
void build(const struct build_parameters_of_call *parameters);
#define BUILD(...) build(&(struct build_parameters_of_call){__VA_ARGS__})

#endif
