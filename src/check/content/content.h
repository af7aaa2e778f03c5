/* SPDX-License-Identifier: Apache-2.0 */
/* Reading the input data of builds for the rules about it, from wherever that can be read. */
#ifndef ASSAY_CHECK_CONTENT_CONTENT_H
#define ASSAY_CHECK_CONTENT_CONTENT_H

#include "src/base/handle_table.h"
#include "src/check/walk/walk.h"
#include "src/snapshots/chained_input.h"
#include "src/snapshots/memory.h"
#include "src/view/content_view.h"

/* At level CONTENT: puts the data of a geometry of a host build to its rules. What can't be read,
 * and ranges that are not known, others speak of. */
void check_host_inputs(struct walk *walk, const struct range_view *range);

/* The same of a geometry whose data is elsewhere. `chained`: a copy of what was chained to it;
 * NULL: its own chain is there. */
void content_check_geometry(struct walk *walk, const struct range_view *range,
                            const struct input_memory *memory, const struct chained_input *chained);

/* The data of one geometry, on its way through the rules. Each rule speaks of it once. */
struct content {
    struct walk *walk;
    const struct range_view *range; /* with its build range */
    const struct input_memory *memory;
    const struct chained_input *chained; /* NULL: the geometry's own chain says it */
    bool has_gaps;                       /* of an instance nothing is known */
    bool wants[RULE_COUNT];
};

/* All bytes of `count` elements of `size` bytes, `stride` apart, from an offset on; NULL where any
 * can't be read, or where there are none. */
const uint8_t *content_find(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                            uint64_t offset, uint64_t count, uint64_t stride, uint64_t size);

/* All that can be read of them. */
uint64_t content_find_some(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                           uint64_t offset, uint64_t count, uint64_t stride, uint64_t size,
                           const void **bytes);

/* Where the first vertex is, from the data's begin on. */
uint64_t content_vertex_offset(const VkAccelerationStructureBuildRangeInfoKHR *range,
                               uint32_t index_size, uint64_t stride);
/* Opens what was found, each array from its offset on, for the builder's readers. */
struct builder_geometry;
struct source;
bool content_open_source(const struct content *content, const struct builder_geometry *described,
                         struct source *source);
/* One of several of `size` bytes each. */
uint32_t content_read_index(const uint8_t *indices, uint32_t size, uint64_t position);

/* Of a geometry of spheres or linear swept spheres. */
void content_read_radii(struct content *content);

/* Of a geometry of instances, and of one that was read with motion. */
void content_read_instances(struct content *content,
                            const VkAccelerationStructureGeometryInstancesDataKHR *instances);
void content_read_motion_instance(struct content *content, uint32_t index, const void *bytes);
/* The same of one whose data alone was read. */
void content_read_motion_data(struct content *content, uint32_t index, uint32_t type,
                              const void *bytes);

/* What an instance refers to, by that member of it; nothing where that isn't known. */
void content_find_reference(struct content *content, uint64_t reference,
                            struct accel_facts *referenced);
/* What goes for instances of any kind. Without reference they are inactive, and what else is in
 * them doesn't matter. */
void content_check_reference(struct content *content, uint32_t index,
                             const struct accel_facts *referenced);
void content_check_transform(struct content *content, uint32_t index, uint64_t reference,
                             const VkTransformMatrixKHR *matrix);
void content_check_instance(struct content *content, uint32_t index, bool has_motion,
                            const VkAccelerationStructureInstanceKHR *instance);

/* Keeps what later updates are measured by: of all, of triangles and boxes, and of one instance. */
void content_keep_count(struct content *content);
void content_keep(struct content *content);
void content_keep_instance(struct content *content, uint32_t index, uint64_t reference);
void content_keep_unknown_instance(struct content *content);
void content_forget_inputs(struct walk *walk); /* once the build was seen */

/* All structures that instances of the build in hand refer to, each once. */
struct instance_uses {
    struct accel_facts *items;
    uint32_t count, capacity;
    struct handle_table places; /* in `items`, from 1 */
};
void content_forget_instances(struct instance_uses *instances);
void content_free_instances(struct instance_uses *instances);

/* Each walks the rows of its subject. */
void content_walk_indices(struct content *content, const struct indices_view *indices);
void content_walk_box(struct content *content, const struct box_view *box);
void content_walk_instance(struct content *content, const struct instance_view *instance);
void content_walk_nv_instance(struct content *content, const struct nv_instance_view *nv_instance);
void content_walk_instance_pointer(struct content *content,
                                   const struct instance_pointer_view *instance_pointer);
void content_walk_reference(struct content *content, const struct reference_view *reference);
void content_walk_motion_instance(struct content *content,
                                  const struct motion_instance_view *motion_instance);
void content_walk_micromap_triangle(struct content *content,
                                    const struct micromap_triangle_view *micromap_triangle);
void content_walk_opacity_index(struct content *content,
                                const struct opacity_index_view *opacity_index);
void content_walk_radius(struct content *content, const struct radius_view *radius);
void content_walk_transform(struct content *content, const struct transform_view *transform);

#endif
