/* SPDX-License-Identifier: Apache-2.0 */
/* The arrays that builds read, as rows of NumPy arrays. */
#ifndef ASSAY_CAPTURE_ARRAYS_H
#define ASSAY_CAPTURE_ARRAYS_H

#include "src/capture/folder.h"
#include "src/model/build_parameters.h"
#include "src/model/inputs.h"
#include "src/snapshots/memory.h"

/* What lines call an input. */
const char *capture_role_name(enum input_role role);

/* Memory for rows that do not follow each other in the application's memory. The caller frees
 * `bytes`. */
struct capture_room {
    unsigned char *bytes;
    uint64_t size;
};

/* Sets the counts of inputs that other inputs choose: of centers and radii by indices, up to the
 * largest one, and of the bytes of micromaps by their triangles; 0 if these cannot be read. */
void capture_count_chosen(const struct input_memory *memory, const struct build_parameters *build,
                          uint32_t geometry, uint32_t primitives, struct geometry_input *inputs,
                          uint32_t count);

/* Reads the rows of an input, as many as can be read. They are valid until the next call with this
 * room, and as long as the memory. Returns false if there are none, or without memory. */
bool capture_array_read(const struct input_memory *memory, bool has_motion,
                        const VkAccelerationStructureGeometryKHR *geometry,
                        const struct chained_input *chained, const struct geometry_input *input,
                        struct capture_room *room, struct capture_array *array);

#endif
