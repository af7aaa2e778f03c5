/* SPDX-License-Identifier: Apache-2.0 */
/* The descriptor update templates of a device that have descriptors of structures. The table has
 * its own lock. */
#ifndef ASSAY_STATE_RESOURCES_UPDATE_TEMPLATES_H
#define ASSAY_STATE_RESOURCES_UPDATE_TEMPLATES_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

struct update_templates;

/* The entries of a template that are about structures. Immutable. */
struct update_template {
    uint32_t count;
    VkDescriptorUpdateTemplateEntry entries[];
};

/* Returns NULL if memory runs out. All functions accept NULL. */
struct update_templates *update_templates_create(void);
void update_templates_destroy(struct update_templates *templates);

/* Keeps a template of descriptor sets with structures. If memory runs out, it is unknown. */
void update_templates_add(struct update_templates *templates, VkDescriptorUpdateTemplate handle,
                          const VkDescriptorUpdateTemplateCreateInfo *info);
void update_templates_remove(struct update_templates *templates, VkDescriptorUpdateTemplate handle);
/* Returns NULL if the template is unknown, or has no structures. It lives until it is removed. */
const struct update_template *update_templates_find(struct update_templates *templates,
                                                    VkDescriptorUpdateTemplate handle);

#endif
