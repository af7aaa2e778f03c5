/* SPDX-License-Identifier: Apache-2.0 */
/* Setting crash_report: the report when the process gets SIGSEGV, SIGBUS, SIGFPE or SIGABRT.
 *
 * The first device with the setting (16 at most) installs the handlers, and the last one puts the
 * application's back. A handler that the application has installed meanwhile stays; the layer's
 * library then stays in memory, because that handler may call the layer's.
 *
 * The handler itself neither allocates nor waits for a lock: it lists the builds that the device
 * may be executing. The inputs that had been copied are validated by a thread that waits for this;
 * the handler gives it a few seconds, because the thread may need a lock that the crash left taken.
 */
#ifndef ASSAY_LAYER_POSTMORTEM_CRASH_H
#define ASSAY_LAYER_POSTMORTEM_CRASH_H

#include "layer/layer.h"

/* Called when a device was created, and before it is destroyed. Do nothing if the instance has not
 * set crash_report, or below level EXECUTION. */
void crash_add_device(struct layer_device *device);
void crash_remove_device(struct layer_device *device);

#endif
