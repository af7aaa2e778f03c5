/* SPDX-License-Identifier: Apache-2.0 */
/* Reading what micromaps are built from and used by, of builds that have executed. */
#ifndef ASSAY_CHECK_CONTENT_MICROMAP_H
#define ASSAY_CHECK_CONTENT_MICROMAP_H

#include "src/check/content/content.h"

/* Of a geometry, by what was chained to it. `used`: what the micromap that it uses was built with
 * by then; NULL where that isn't known. */
struct built;
void content_check_micromaps(struct walk *walk, const struct range_view *range,
                             const struct input_memory *memory, const struct chained_input *chained,
                             const struct built *used);

/* The same of a host build of a micromap: its triangles are at a device address, and can be read
 * where the host has that mapped. */
void check_host_micromap(struct walk *walk, const struct geometry_view *geometry);

#endif
