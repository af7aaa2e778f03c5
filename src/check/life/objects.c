/* SPDX-License-Identifier: Apache-2.0 */
/* Looks up the structures and micromaps that a call names. */
#include "src/check/life/life.h"
#include "src/state/resources/nv_shape.h"

/* What the facts of structures and of micromaps share. */
#define TAKE_FACTS(object, facts)                                                                  \
    do {                                                                                           \
        (object)->id = (facts)->id;                                                                \
        (object)->alive = (facts)->alive;                                                          \
        (object)->type = (uint32_t)(facts)->type;                                                  \
        (object)->create_flags = (facts)->create_flags;                                            \
        (object)->size = (facts)->size;                                                            \
        (object)->buffer = (facts)->buffer;                                                        \
        (object)->buffer_id = (facts)->buffer_id;                                                  \
        (object)->buffer_is_destroyed = (facts)->buffer_is_destroyed;                              \
        (object)->backed = (facts)->backed;                                                        \
        (object)->is_sparse = (facts)->is_sparse;                                                  \
        (object)->host_visible = (facts)->host_visible;                                            \
        (object)->multi_instance = (facts)->multi_instance;                                        \
    } while (false)

static void find_accel(struct check_context *context, struct life_object *object)
{
    struct accel_facts facts;
    resources_look_up_accel(context->resources,
                            (VkAccelerationStructureKHR)(uintptr_t)object->handle, &facts);
    TAKE_FACTS(object, &facts);
    object->details_known = facts.details_known;
    object->by_address = facts.by_address;
    object->span = memory_span_of(facts.memory, facts.begin, facts.size);
}

static void find_micromap(struct check_context *context, struct life_object *object)
{
    struct micromap_facts facts;
    resources_find_micromap(context->resources, (VkMicromapEXT)(uintptr_t)object->handle, &facts);
    TAKE_FACTS(object, &facts);
    object->details_known = facts.alive == YES;
    object->span = facts.span;
}

static enum tristate is_backed(enum nv_binding binding)
{
    return binding == NV_BINDING_UNKNOWN ? UNKNOWN : binding == NV_BOUND ? YES : NO;
}

static void find_nv_accel(struct check_context *context, struct life_object *object)
{
    struct nv_accel_facts facts;
    resources_look_up_nv_accel(context->resources,
                               (VkAccelerationStructureNV)(uintptr_t)object->handle, &facts);
    object->id = facts.id;
    object->alive = facts.alive;
    object->details_known = facts.sizes.known && facts.created;
    if (facts.created) {
        object->type = (uint32_t)facts.created->type;
        object->create_flags = facts.created->flags;
    }
    object->size = facts.sizes.object;
    object->backed = is_backed(facts.binding);
    object->span = facts.span;
    nv_shape_release(facts.created);
}

struct life_object check_find_object(struct check_context *context, VkObjectType type,
                                     uint64_t handle)
{
    struct life_object object = {.object_type = type, .handle = handle};
    enum resource_kind kind = RESOURCE_ACCEL;
    if (context->level < LEVEL_STATE)
        return object;
    switch ((int)type) {
    case VK_OBJECT_TYPE_MICROMAP_EXT:
        kind = RESOURCE_MICROMAP;
        find_micromap(context, &object);
        break;
    case VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_NV:
        kind = RESOURCE_ACCEL_NV;
        find_nv_accel(context, &object);
        break;
    default:
        find_accel(context, &object);
        break;
    }
    if (handle && object.alive == NO)
        object.of_another_device = context->hooks->of_another_device(context->user, kind, handle);
    return object;
}
