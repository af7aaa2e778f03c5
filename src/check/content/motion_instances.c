/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the instances of builds with motion. */
#include <string.h>

#include "src/bvh/input/source.h"
#include "src/check/content/content.h"
#include "src/view/motion_instance.h"

static void check_instance(struct content *content, struct motion_instance_view *view)
{
    const uint32_t index = view->index;
    struct motion_instance_common common = {0};
    bool is_known = motion_instance_common(&view->instance, &common);
    struct instance_use other, *use = content_find_use(content, common.reference, &other);
    view->referenced = &use->referenced;
    content_count_use(use, index);
    content_walk_motion_instance(content, view);
    if (motion_instance_is(&view->instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV)) {
        content_check_instance(content, index, !view->is_packed,
                               &view->instance.data.staticInstance);
    } else if (is_known) {
        content_check_reference(content, index, common.reference, view->referenced);
    }
    if (motion_instance_is(&view->instance,
                           VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV)) {
        const VkAccelerationStructureMatrixMotionInstanceNV *moving =
            &view->instance.data.matrixMotionInstance;
        content_check_transform(content, index, common.reference, &moving->transformT0);
        content_check_transform(content, index, common.reference, &moving->transformT1);
    }
}

void content_read_motion_instance(struct content *content, uint32_t index, const void *bytes)
{
    struct motion_instance_view view = {.geometry = content->range->geometry, .index = index};
    memcpy(&view.instance, bytes, sizeof(view.instance));
    check_instance(content, &view);
}

void content_read_motion_data(struct content *content, uint32_t index, uint32_t type,
                              const void *bytes)
{
    struct motion_instance_view view = {
        .geometry = content->range->geometry, .index = index, .is_packed = true};
    view.instance.type = (VkAccelerationStructureMotionInstanceTypeNV)type;
    memcpy(&view.instance.data, bytes, source_motion_size(type));
    check_instance(content, &view);
}
