/* SPDX-License-Identifier: Apache-2.0 */
/* Validates the inputs of micromap builds and the indices into micromaps, of builds that have
 * executed. */
#ifndef ASSAY_CHECK_CONTENT_MICROMAP_H
#define ASSAY_CHECK_CONTENT_MICROMAP_H

#include "src/check/content/content.h"

/* Validates the micromap data of a geometry. `chained` is a copy of its chained structures. `used`
 * is the last build, at that time, of the micromap that it uses; NULL if unknown. */
struct built;
void content_check_micromaps(struct walk *walk, const struct range_view *range,
                             const struct input_memory *memory, const struct chained_input *chained,
                             const struct built *used);

/* Validates a host build of a micromap. Its triangles are at a device address and are read through
 * the host's mapping, if there is one. */
void check_host_micromap(struct walk *walk, const struct geometry_view *geometry);

#endif
