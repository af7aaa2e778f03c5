/* SPDX-License-Identifier: Apache-2.0 */
/* Reads instances, with and without motion, and finds the structures that they refer to. */
#include <stdlib.h>
#include <string.h>

#include "src/base/array.h"
#include "src/bvh/expansion.h"
#include "src/bvh/input/source.h"
#include "src/check/content/content.h"
#include "src/state/builds/structures.h"

enum {
    PREFETCHED = 16,   /* instances ahead of the current one are fetched from memory */
    READ_AT_ONCE = 256 /* instances are hashed, then checked while they are in the cache */
};

/* ---- referenced structures */

void content_forget_instances(struct instance_uses *instances)
{
    instances->count = 0;
    handle_table_release(&instances->indices);
}

void content_free_instances(struct instance_uses *instances)
{
    if (!instances)
        return;
    content_forget_instances(instances);
    free(instances->items);
    free(instances);
}

/* Returns NULL if there is no memory. */
static struct instance_use *add_use(struct instance_uses *uses, uint64_t reference,
                                    const struct instance_use *use)
{
    if (!ARRAY_HAS_ROOM(uses->items, uses->count, uses->capacity) ||
        !handle_table_set(&uses->indices, reference, (void *)(uintptr_t)(uses->count + 1)))
        return NULL;
    uses->items[uses->count] = *use;
    return &uses->items[uses->count++];
}

/* Structures that alias memory may share an address, so all addresses must be known.
 * `destroy_count`: see resources_find_referenced(). */
static void look_up_address(const struct check_context *context, uint64_t reference,
                            uint64_t destroy_count, struct accel_facts *referenced)
{
    if (context->hooks->query_addresses)
        context->hooks->query_addresses(context->user);
    resources_find_referenced(context->resources, reference, destroy_count, referenced);
}

/* The reference is a handle in host builds, else a device address. */
static void look_up_reference(const struct content *content, uint64_t reference,
                              struct accel_facts *referenced)
{
    const struct check_context *context = content->walk->context;
    if (content->range->geometry->build->call->command == COMMAND_HOST)
        resources_look_up_accel(context->resources,
                                (VkAccelerationStructureKHR)(uintptr_t)reference, referenced);
    else
        look_up_address(context, reference, context->destroy_count, referenced);
}

static struct instance_use *find_use(const struct content *content, uint64_t reference)
{
    const struct instance_uses *uses = content->walk->instances;
    uintptr_t found = uses ? (uintptr_t)handle_table_find(&uses->indices, reference) : 0;
    return found ? &uses->items[found - 1] : NULL;
}

static struct instance_use *find_new_use(struct content *content, uint64_t reference,
                                         struct instance_use *other)
{
    struct walk *walk = content->walk;
    *other = (struct instance_use){0};
    if (!reference || content->range->geometry->build->call->command == COMMAND_NV)
        return other;
    look_up_reference(content, reference, &other->referenced);
    if (!walk->instances)
        walk->instances = calloc(1, sizeof(*walk->instances));
    struct instance_use *added = walk->instances && other->referenced.alive == YES
                                     ? add_use(walk->instances, reference, other)
                                     : NULL;
    content->has_strays |= !added;
    return added ? added : other;
}

struct instance_use *content_find_use(struct content *content, uint64_t reference,
                                      struct instance_use *other)
{
    struct instance_use *use = find_use(content, reference);
    return use ? use : find_new_use(content, reference, other);
}

void content_count_use(struct instance_use *use, uint32_t index)
{
    if (!use->count++)
        use->first = index;
}

/* ---- one instance */

void content_check_reference(struct content *content, uint32_t index, uint64_t reference,
                             const struct accel_facts *referenced)
{
    const struct check_context *context = content->walk->context;
    struct reference_view view = {
        .geometry = content->range->geometry, .instance = index, .referenced = referenced};
    if (referenced->alive == YES)
        content_walk_reference(content, &view);
    else if (referenced->alive == UNKNOWN && reference && context->hooks->refers_to_destroyed)
        context->hooks->refers_to_destroyed(context->user, view.geometry->build->index, index,
                                            reference);
}

void content_check_transform(struct content *content, uint32_t index, uint64_t reference,
                             const VkTransformMatrixKHR *matrix)
{
    struct transform_view view = {.geometry = content->range->geometry,
                                  .is_of_instance = true,
                                  .instance = index,
                                  .matrix = *matrix};
    if (reference)
        content_walk_transform(content, &view);
}

/* Finds the structure whose handle was written in place of its address, or the other way round. */
static VkAccelerationStructureKHR find_confused(const struct content *content, uint64_t reference)
{
    const struct check_context *context = content->walk->context;
    struct accel_facts facts;
    if (content->range->geometry->build->call->command == COMMAND_HOST)
        look_up_address(context, reference, resources_destroy_count(context->resources), &facts);
    else
        resources_look_up_accel(context->resources,
                                (VkAccelerationStructureKHR)(uintptr_t)reference, &facts);
    return facts.alive == YES ? facts.handle : VK_NULL_HANDLE;
}

static void check_nv_reference(struct content *content, uint32_t index,
                               const VkAccelerationStructureInstanceKHR *instance)
{
    const uint64_t reference = instance->accelerationStructureReference;
    if (!reference || content->range->geometry->build->call->command != COMMAND_NV)
        return;
    struct resources *resources = content->walk->context->resources;
    struct nv_instance_view view = {
        .geometry = content->range->geometry,
        .index = index,
        .reference = reference,
        .refers_to = resources_find_nv_reference(resources, reference,
                                                 content->walk->context->destroy_count),
        .is_handle = resources_find_id(resources, RESOURCE_ACCEL_NV, reference) != 0,
        .instance = instance};
    if (view.refers_to == NV_REFERENCE_INVALID && !view.is_handle)
        view.look = content_look_of_instance(content, instance);
    content_walk_nv_instance(content, &view);
}

static enum tristate find_disabling(const struct content *content,
                                    const struct accel_facts *referenced)
{
    const struct walk *walk = content->walk;
    return referenced->alive == YES
               ? structures_allow_disabling(walk->context->structures, referenced->id, walk->point)
               : UNKNOWN;
}

/* Evaluates all rules about an instance, except the one about its transform. */
static void check_flags_and_reference(struct content *content, uint32_t index, bool has_motion,
                                      const VkAccelerationStructureInstanceKHR *instance,
                                      const struct accel_facts *referenced)
{
    struct instance_view view = {.geometry = content->range->geometry,
                                 .index = index,
                                 .has_motion = has_motion,
                                 .instance = *instance,
                                 .referenced = referenced};
    const struct check_context *context = content->walk->context;
    uint64_t reference = instance->accelerationStructureReference;
    if (referenced->alive == NO) {
        view.confused = find_confused(content, reference);
        view.look = content_look_of_instance(content, instance);
        view.may_be_placed =
            content->range->geometry->build->call->command != COMMAND_HOST &&
            places_may_hold(context->places, PLACE_BOTTOM_LEVEL, reference, context->destroy_count);
        if (view.may_be_placed && context->hooks->on_placed_reference)
            context->hooks->on_placed_reference(context->user,
                                                content->range->geometry->build->index, reference);
    }
    if (instance->flags & VK_GEOMETRY_INSTANCE_DISABLE_OPACITY_MICROMAPS_BIT_KHR)
        view.allows_disabling = find_disabling(content, referenced);
    content_walk_instance(content, &view);
    content_check_reference(content, index, reference, referenced);
    check_nv_reference(content, index, instance);
}

void content_check_instance(struct content *content, uint32_t index, bool has_motion,
                            const VkAccelerationStructureInstanceKHR *instance)
{
    struct instance_use other;
    check_flags_and_reference(
        content, index, has_motion, instance,
        &content_find_use(content, instance->accelerationStructureReference, &other)->referenced);
    content_check_transform(content, index, instance->accelerationStructureReference,
                            &instance->transform);
}

/* Never 0. */
static uint64_t checked_mark(const struct content *content,
                             const VkAccelerationStructureInstanceKHR *instance)
{
    const struct instance_uses *uses = content->walk->instances;
    return ((uint64_t)(uses ? uses->geometry : 0) + 1) << 8 | instance->flags;
}

static void check_other_instance(struct content *content, uint32_t index,
                                 const VkAccelerationStructureInstanceKHR *instance,
                                 struct instance_use *use)
{
    const uint64_t violations = content->violations;
    check_flags_and_reference(content, index, false, instance, &use->referenced);
    if (content->violations == violations)
        use->checked = checked_mark(content, instance);
}

/* If the estimate of a determinant has a sign, the transform is invertible.
 *
 * Most instances refer to a structure that an earlier instance of the geometry refers to, with the
 * same flags. If that one was valid, they are, except for their transforms. */
static void check_plain_instance(struct content *content, uint32_t index,
                                 const VkAccelerationStructureInstanceKHR *instance)
{
    const uint64_t reference = instance->accelerationStructureReference;
    struct instance_use other, *use = find_use(content, reference);
    if (!use)
        use = find_new_use(content, reference, &other);
    if (use->checked != checked_mark(content, instance))
        check_other_instance(content, index, instance, use);
    content_count_use(use, index);
    if (!determinant_estimate(&instance->transform))
        content_check_transform(content, index, reference, &instance->transform);
}

static void read_instance(struct content *content, uint32_t index, const void *bytes)
{
    VkAccelerationStructureInstanceKHR instance;
    memcpy(&instance, bytes, sizeof(instance));
    check_plain_instance(content, index, &instance);
    for (struct build_reader *reader = content->walk->readers; reader; reader = reader->next)
        if (reader->on_instance)
            reader->on_instance(reader, content, &instance);
    content_retain_instance(content, index, instance.accelerationStructureReference);
}

/* ---- all instances of a geometry */

/* Device builds need 16-byte alignment; host builds need none. */
static bool is_aligned_pointer(const struct content *content, VkDeviceAddress address)
{
    return content->range->geometry->build->call->command == COMMAND_HOST || address % 16 == 0;
}

/* Whether no memory that the build could read was at an address, of which `bytes` were read. What
 * is nowhere now was nowhere when the build executed if nothing was destroyed since the submission.
 */
static bool leads_nowhere(const struct content *content, VkDeviceAddress address,
                          const uint8_t *bytes)
{
    const struct check_context *context = content->walk->context;
    struct address_facts facts;
    if (!address)
        return true;
    if (content->range->geometry->build->call->command == COMMAND_HOST)
        return !bytes;
    if (bytes || resources_destroy_count(context->resources) != context->destroy_count)
        return false;
    resources_look_up_address(context->resources, address, &facts);
    return facts.status == ADDRESS_NOWHERE;
}

/* `bytes`: what was read behind the pointer. */
static void check_pointer(struct content *content, uint32_t index, VkDeviceAddress address,
                          const uint8_t *bytes)
{
    const bool is_aligned = is_aligned_pointer(content, address);
    struct instance_pointer_view view = {
        .geometry = content->range->geometry,
        .index = index,
        .address = address,
        .leads_nowhere = is_aligned && leads_nowhere(content, address, bytes),
        .is_host = content->range->geometry->build->call->command == COMMAND_HOST};
    if (!is_aligned || view.leads_nowhere)
        view.look = content_look_of_pointers(content);
    content_walk_instance_pointer(content, &view);
}

/* Skips instances whose pointer is invalid. */
static void read_pointed_instance(struct content *content, uint32_t index,
                                  VkDeviceOrHostAddressConstKHR to)
{
    const uint64_t size = sizeof(VkAccelerationStructureInstanceKHR);
    const uint8_t *bytes = is_aligned_pointer(content, to.deviceAddress)
                               ? content_find(content, to, 0, 1, 0, size)
                               : NULL;
    check_pointer(content, index, to.deviceAddress, bytes);
    if (bytes)
        read_instance(content, index, bytes);
    else
        content_retain_unknown_instance(content);
}

/* Pointers to instances with motion have the type in their low bits, and point to the structure of
 * that type without its header. */
static void read_typed_instance(struct content *content, uint32_t index,
                                VkDeviceOrHostAddressConstKHR to)
{
    const uint32_t type = (uint32_t)(to.deviceAddress % 16);
    const uint64_t size = source_motion_size(type);
    to.deviceAddress -= type;
    const uint8_t *bytes = size ? content_find(content, to, 0, 1, 0, size) : NULL;
    if (size)
        check_pointer(content, index, to.deviceAddress, bytes);
    if (bytes)
        content_read_motion_data(content, index, type, bytes);
}

static void read_array_of_pointers(struct content *content,
                                   void (*read)(struct content *content, uint32_t index,
                                                VkDeviceOrHostAddressConstKHR to))
{
    const struct geometry_input *pointers = content_input(content, INPUT_INSTANCES);
    VkDeviceOrHostAddressConstKHR to = {.deviceAddress = 0};
    const uint8_t *next = content_find_input(content, pointers);
    content->has_gaps |= !next;
    content->elements = (struct content_elements){next, next ? pointers->count * sizeof(to) : 0};
    for (uint32_t i = 0; next && i < pointers->count; i++, next += sizeof(to)) {
        memcpy(&to, next, sizeof(to));
        read(content, i, to);
    }
}

static void read_motion_instances(struct content *content)
{
    const struct geometry_input *instances = content_input(content, INPUT_INSTANCES);
    const uint8_t *next = content_find_input(content, instances);
    for (uint32_t i = 0; next && i < instances->count; i++, next += instances->stride)
        content_read_motion_instance(content, i, next);
}

static void read_some_instances(struct content *content, uint32_t first,
                                const struct content_elements *some)
{
    const size_t size = sizeof(VkAccelerationStructureInstanceKHR);
    const uint8_t *const end = some->bytes + some->size;
    if (content->walk->context->hooks->on_read)
        content->hash = content_hash(some, content->hash);
    for (const uint8_t *next = some->bytes; next < end; next += size) {
        __builtin_prefetch(next + PREFETCHED * size); /* processors do not, across pages */
        read_instance(content, first++, next);
    }
}

static void read_plain_instances(struct content *content)
{
    const struct geometry_input *instances = content_input(content, INPUT_INSTANCES);
    const size_t size = sizeof(VkAccelerationStructureInstanceKHR);
    const uint8_t *bytes = content_find_input(content, instances);
    const uint32_t count = bytes ? (uint32_t)instances->count : 0;
    content->has_gaps |= !bytes;
    content->elements = (struct content_elements){bytes, count * size};
    for (uint32_t i = 0; i < count; i += READ_AT_ONCE) {
        const uint32_t left = count - i;
        const struct content_elements some = {bytes + i * size,
                                              (left < READ_AT_ONCE ? left : READ_AT_ONCE) * size};
        read_some_instances(content, i, &some);
    }
}

/* Skips host pointers to instances with motion. Instances have no motion without the extension. */
void content_read_instances(struct content *content)
{
    const struct build_view *build = content->range->geometry->build;
    const bool has_pointers = has_instance_pointers(content->range->geometry->geometry);
    if (content->walk->instances)
        content->walk->instances->geometry++;
    if (!(build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_MOTION_BIT_NV)) {
        if (has_pointers)
            read_array_of_pointers(content, read_pointed_instance);
        else
            read_plain_instances(content);
        content->walk->references_are_known =
            !content->range->range->primitiveCount || (!content->has_gaps && !content->has_strays);
    } else if (build->call->device->extension.motion_blur_nv && !has_pointers) {
        read_motion_instances(content);
    } else if (build->call->device->extension.motion_blur_nv &&
               build->call->command != COMMAND_HOST) {
        read_array_of_pointers(content, read_typed_instance);
    }
}
