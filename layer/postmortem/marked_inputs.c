/* SPDX-License-Identifier: Apache-2.0 */
/* Executions that wait for their completion, and those whose submitting call has not returned. */
#include "layer/postmortem/marked_inputs.h"

#include "layer/execution/input_check_run.h"
#include "layer/execution/input_checks.h"
#include "layer/execution/submitted_builds.h"
#include "layer/snapshots/coverage_warnings.h"

bool marked_inputs_read(struct layer_device *device, const char *when)
{
    struct missed_executions missed = {0};
    struct ran_execution ran;
    if (!device->input_checks)
        return true;
    bool is_free = input_checks_read_marked(device->input_checks, when);
    for (uint32_t n = 0; submitted_builds_find_unrun(device->submitted_builds, n, &ran); n++) {
        ran.device = device;
        if (ran.execution)
            input_checks_read(&ran, when, &missed);
        submitted_builds_release_unrun(&ran);
    }
    return is_free;
}
