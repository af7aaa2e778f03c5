/* SPDX-License-Identifier: Apache-2.0 */
/* Objects that only the hazard check tracks: formats of images, and dependencies of render passes.
 * Has a lock of its own. */
#ifndef ASSAY_LAYER_HAZARDS_OBJECTS_H
#define ASSAY_LAYER_HAZARDS_OBJECTS_H

#include "src/hazards/scopes.h"
#include "src/view/formats.h"

struct hazard_objects;

/* Returns NULL if memory runs out. */
struct hazard_objects *hazard_objects_create(void);
/* Both accept NULL, as all functions here do: no object is known then. */
void hazard_objects_destroy(struct hazard_objects *objects);

/* If memory runs out, the object is unknown. */
void hazard_objects_add_image(struct hazard_objects *objects, VkImage image, VkFormat format);
void hazard_objects_remove_image(struct hazard_objects *objects, VkImage image);
/* Returns VK_FORMAT_UNDEFINED if the image is unknown. */
VkFormat hazard_objects_format(struct hazard_objects *objects, VkImage image);

struct subpass_dependency {
    uint32_t src, dst; /* subpasses, or VK_SUBPASS_EXTERNAL */
    struct dependency dependency;
};

/* Copies the dependencies. */
void hazard_objects_add_render_pass(struct hazard_objects *objects, VkRenderPass render_pass,
                                    const struct subpass_dependency *dependencies, uint32_t count);
void hazard_objects_remove_render_pass(struct hazard_objects *objects, VkRenderPass render_pass);
/* Returns the dependencies, which live until the render pass is destroyed; `*count` of them.
 * Returns NULL if the render pass is unknown. */
const struct subpass_dependency *hazard_objects_dependencies(struct hazard_objects *objects,
                                                             VkRenderPass render_pass,
                                                             uint32_t *count);

#endif
