/* SPDX-License-Identifier: Apache-2.0 */
/* The records of acceleration structures of VK_NV_ray_tracing, which are bound to memory directly,
 * without a buffer; and reference-counted copies of VkAccelerationStructureInfoNV. */
#include <stdlib.h>
#include <string.h>

#include "src/base/readable.h"
#include "src/model/geometry.h"
#include "src/state/resources/nv_shape.h"
#include "src/state/resources/records.h"

struct nv_counts nv_counts_of(const VkGeometryNV *geometry)
{
    const VkGeometryTrianglesNV *triangles = &geometry->geometry.triangles;
    if (type_is_triangles(geometry->geometryType))
        return (struct nv_counts){.vertices = triangles->vertexCount,
                                  .indices = triangles->indexCount};
    if (type_is_aabbs(geometry->geometryType))
        return (struct nv_counts){.aabbs = geometry->geometry.aabbs.numAABBs};
    return (struct nv_counts){0};
}

struct nv_shape *nv_shape_create(const VkAccelerationStructureInfoNV *info)
{
    struct readable_cache readable_pages = {0};
    size_t count = info->geometryCount;
    if (!readable(&readable_pages, info->pGeometries, count * sizeof(*info->pGeometries)))
        return NULL;
    struct nv_shape *shape = malloc(sizeof(*shape) + count * sizeof(shape->geometries[0]));
    if (!shape)
        return NULL;
    atomic_init(&shape->references, 1);
    shape->type = info->type;
    shape->flags = info->flags;
    shape->instance_count = info->instanceCount;
    shape->geometry_count = info->geometryCount;
    for (size_t i = 0; i < count; i++) {
        VkGeometryNV geometry; /* the application's array may be misaligned */
        memcpy(&geometry, &info->pGeometries[i], sizeof(geometry));
        shape->geometries[i] = nv_counts_of(&geometry);
    }
    return shape;
}

struct nv_shape *nv_shape_share(struct nv_shape *shape)
{
    if (shape)
        atomic_fetch_add_explicit(&shape->references, 1, memory_order_relaxed);
    return shape;
}

void nv_shape_release(struct nv_shape *shape)
{
    /* Acquire and release: the thread that frees the shape must see the other threads' accesses
     * done. */
    if (shape && atomic_fetch_sub_explicit(&shape->references, 1, memory_order_acq_rel) == 1)
        free(shape);
}

/* ---- The records of acceleration structures of VK_NV_ray_tracing, which are bound to memory
 * directly, without a buffer. */

static bool lacks_memory(const struct nv_accel_record *accel)
{
    return accel->memory && !accel->memory->alive;
}

static void unbind(struct nv_accel_record *accel)
{
    if (lacks_memory(accel) && accel->reference)
        accel->reference->without_memory--;
    memory_record_release(accel->memory);
    accel->memory = NULL;
}

static void free_record(void *record)
{
    struct nv_accel_record *accel = record;
    unbind(accel);
    nv_shape_release(accel->created);
    free(accel);
}

void resources_release_nv(struct resources *resources)
{
    handle_table_drop(&resources->nv_accels, free_record);
    handle_table_drop(&resources->nv_references, free);
    free(resources->past_nv_references.items);
}

/* A value has no structure any more. */
static void retire_nv_record(struct resources *resources, uint64_t value, uint64_t destroyed_at)
{
    struct past_references *past = &resources->past_nv_references;
    const struct past_reference oldest = past_references_add(past, value, destroyed_at);
    const struct nv_reference_record *record =
        oldest.value ? handle_table_find(&resources->nv_references, oldest.value) : NULL;
    if (!record || record->alive || record->destroyed_at != oldest.destroyed_at)
        return;
    past->forgotten_at = oldest.destroyed_at;
    free(handle_table_remove(&resources->nv_references, oldest.value));
}

/* Returns the id of the removed record, or 0. */
static uint64_t remove_record(struct resources *resources, uint64_t handle)
{
    struct nv_accel_record *accel = handle_table_remove(&resources->nv_accels, handle);
    if (!accel)
        return 0;
    uint64_t id = accel->id;
    resources_count_destroyed(resources);
    if (accel->reference && --accel->reference->alive == 0) {
        accel->reference->destroyed_at = resources_destroy_count(resources);
        retire_nv_record(resources, accel->value, accel->reference->destroyed_at);
    }
    resources_note_reference(resources, accel->value, true);
    free_record(accel);
    return id;
}

void resources_add_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                            struct nv_shape *created, const struct nv_size_facts *sizes)
{
    struct nv_accel_record *accel = malloc(sizeof(*accel));
    if (accel)
        *accel = (struct nv_accel_record){.bound = NO, .sizes = *sizes, .created = created};
    reader_lock_write(&resources->lock);
    remove_record(resources, handle_number(handle));
    if (accel)
        accel->id = ++resources->last_id;
    bool published =
        resources_publish(resources, &resources->nv_accels, handle_number(handle), accel);
    reader_lock_write_done(&resources->lock);
    if (!published) {
        nv_shape_release(created);
        free(accel);
    }
}

uint64_t resources_remove_nv_accel(struct resources *resources, VkAccelerationStructureNV handle)
{
    reader_lock_write(&resources->lock);
    uint64_t id = remove_record(resources, handle_number(handle));
    reader_lock_write_done(&resources->lock);
    return id;
}

static struct nv_accel_record *find_nv_record(const struct resources *resources,
                                              VkAccelerationStructureNV handle)
{
    return handle_table_find(&resources->nv_accels, handle_number(handle));
}

void resources_bind_nv_accel(struct resources *resources, VkAccelerationStructureNV handle,
                             VkDeviceMemory memory, VkDeviceSize offset, bool instances_differ)
{
    reader_lock_write(&resources->lock);
    struct nv_accel_record *accel = find_nv_record(resources, handle);
    if (accel) {
        unbind(accel);
        accel->memory = handle_table_find(&resources->memories, handle_number(memory));
        accel->memory_offset = offset;
        accel->instances_differ = instances_differ;
        accel->bound = accel->memory ? YES : UNKNOWN;
        if (accel->memory)
            accel->memory->references++;
        resources_note_reference(resources, accel->value, true);
    }
    reader_lock_write_done(&resources->lock);
}

void resources_forget_nv_binding(struct resources *resources, VkAccelerationStructureNV handle)
{
    reader_lock_write(&resources->lock);
    struct nv_accel_record *accel = find_nv_record(resources, handle);
    if (accel) {
        unbind(accel);
        accel->bound = UNKNOWN;
    }
    reader_lock_write_done(&resources->lock);
}

struct freed_memory {
    struct resources *resources;
    const struct memory_record *memory;
};

static void note_freed_memory(void *record, void *context)
{
    const struct nv_accel_record *accel = record;
    const struct freed_memory *freed = context;
    if (accel->memory != freed->memory)
        return;
    if (accel->reference)
        accel->reference->without_memory++;
    resources_note_reference(freed->resources, accel->value, true);
}

void nv_accel_records_end_memory(struct resources *resources, const struct memory_record *memory)
{
    handle_table_each(&resources->nv_accels, note_freed_memory,
                      &(struct freed_memory){resources, memory});
}

/* Returns whether the structure exceeds its memory. A memory size of 0 means imported memory of
 * unknown size. */
static bool is_cut_short(const struct nv_accel_record *accel)
{
    VkDeviceSize size = accel->memory->size, offset = accel->memory_offset;
    return accel->sizes.known && size && (offset > size || size - offset < accel->sizes.object);
}

static enum nv_binding binding_of(const struct nv_accel_record *accel)
{
    if (accel->bound != YES)
        return accel->bound == NO ? NV_UNBOUND : NV_BINDING_UNKNOWN;
    if (!accel->memory->alive)
        return NV_MEMORY_FREED;
    return is_cut_short(accel) ? NV_MEMORY_TOO_SMALL : NV_BOUND;
}

static struct memory_span span_of(const struct nv_accel_record *accel)
{
    if (binding_of(accel) != NV_BOUND || accel->instances_differ || !accel->sizes.known)
        return (struct memory_span){0};
    return (struct memory_span){accel->memory->handle, accel->memory_offset,
                                accel->memory_offset + accel->sizes.object};
}

void resources_find_nv_accel(const struct resources *resources, VkAccelerationStructureNV handle,
                             struct nv_accel_facts *facts)
{
    const struct nv_accel_record *accel = find_nv_record(resources, handle);
    *facts = (struct nv_accel_facts){.handle = handle};
    if (!handle)
        return;
    if (!accel) {
        facts->alive = unknown_is_set(&resources->unknown) ? UNKNOWN : NO;
        return;
    }
    facts->alive = YES;
    facts->id = accel->id;
    facts->binding = binding_of(accel);
    facts->memory = accel->memory ? accel->memory->handle : VK_NULL_HANDLE;
    facts->span = span_of(accel);
    facts->sizes = accel->sizes;
    facts->created = nv_shape_share(accel->created);
}

/* ---- references from instances */

static enum nv_reference level_of(const struct nv_accel_record *accel)
{
    if (!accel || !accel->created)
        return NV_REFERENCE_UNKNOWN;
    return accel->created->type == VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_NV
               ? NV_REFERENCE_TOP_LEVEL
               : NV_REFERENCE_BOTTOM_LEVEL;
}

/* If there is no memory, marks the state incomplete and returns NULL. */
static struct nv_reference_record *
find_or_add_nv_reference(struct resources *resources, uint64_t reference, enum nv_reference level)
{
    struct nv_reference_record *record = handle_table_find(&resources->nv_references, reference);
    if (record) {
        if (record->level != level)
            record->level = NV_REFERENCE_UNKNOWN;
        return record;
    }
    record = malloc(sizeof(*record));
    if (record)
        *record = (struct nv_reference_record){.level = level};
    if (record && handle_table_set(&resources->nv_references, reference, record))
        return record;
    free(record);
    resources_become_unknown(resources);
    return NULL;
}

/* If structures of both levels had a reference, its level is unknown. */
void resources_add_nv_reference(struct resources *resources, VkAccelerationStructureNV handle,
                                uint64_t reference)
{
    if (!reference)
        return;
    reader_lock_write(&resources->lock);
    struct nv_accel_record *accel = find_nv_record(resources, handle);
    struct nv_reference_record *record =
        find_or_add_nv_reference(resources, reference, level_of(accel));
    if (record && (!accel || accel->reference != record)) {
        record->alive++;
        record->without_memory += accel && lacks_memory(accel);
    }
    if (accel) {
        accel->reference = record;
        accel->value = reference;
    }
    resources_note_reference(resources, reference, true);
    reader_lock_write_done(&resources->lock);
}

void resources_forget_nv_references(struct resources *resources)
{
    reader_lock_write(&resources->lock);
    unknown_set(&resources->nv_unknown, UNKNOWN_NV_REFERENCES);
    reader_lock_write_done(&resources->lock);
}

static enum nv_reference level_at(const struct nv_reference_record *record, uint64_t destroy_count)
{
    bool is_destroyed = !record->alive && record->destroyed_at <= destroy_count;
    return is_destroyed && record->level != NV_REFERENCE_TOP_LEVEL ? NV_REFERENCE_DESTROYED
                                                                   : record->level;
}

enum nv_reference resources_find_nv_reference(struct resources *resources, uint64_t reference,
                                              uint64_t destroy_count)
{
    unsigned token = resources_begin_reading(resources);
    const struct nv_reference_record *record =
        handle_table_find(&resources->nv_references, reference);
    bool is_forgotten = resources->past_nv_references.forgotten_at > destroy_count;
    enum nv_reference found = unknown_is_set(&resources->unknown) ||
                                      unknown_is_set(&resources->nv_unknown) || is_forgotten
                                  ? NV_REFERENCE_UNKNOWN
                                  : NV_REFERENCE_INVALID;
    if (record && !is_forgotten)
        found = level_at(record, destroy_count);
    resources_end_reading(resources, token);
    return found;
}
