/* SPDX-License-Identifier: Apache-2.0 */
/* The objects of the application. */
#include "application_parts.h"

enum { INPUT_SIZE = 65536, ALIAS_SIZE = 256 };

static void create_set(struct application *app, struct set *set, unsigned n)
{
    set->memory = allocate(app, 2 * ACCEL_SIZE, DEVICE_MEMORY);
    set->buffer =
        create_buffer(app, ACCEL_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    if (n % 2) /* before its buffer is bound */
        set->accel = create_accel(app, set->buffer, 0, ACCEL_SIZE,
                                  VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    if (n % 3)
        CALL(app, BindBufferMemory2, app->device, 1,
             &MAKE(VkBindBufferMemoryInfo, .buffer = set->buffer, .memory = set->memory));
    else
        bind_buffer(app, set->buffer, set->memory, 0);
    if (!set->accel)
        set->accel = create_accel(app, set->buffer, 0, ACCEL_SIZE,
                                  VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    create_commands(app, &set->pool, &set->primary, &set->secondary);
}

static void name_set(struct application *app, const struct set *set, unsigned n)
{
    name_object(app, VK_OBJECT_TYPE_BUFFER, (uint64_t)set->buffer, "buffer", n);
    name_object(app, VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)set->memory, "memory", n);
    name_object(app, VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)set->accel, "tree", n);
    name_object(app, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)set->primary, "frame", n);
    name_object(app, VK_OBJECT_TYPE_BUFFER, (uint64_t)set->buffer, "renamed buffer", n);
}

static void destroy_set(struct application *app, struct set *set, unsigned n)
{
    app->vk.DestroyAccelerationStructureKHR(app->device, set->accel, NULL);
    app->vk.DestroyBuffer(app->device, set->buffer, NULL);
    app->vk.FreeMemory(app->device, set->memory, NULL);
    if (n % 2) {
        app->vk.FreeCommandBuffers(app->device, set->pool, 1, &set->primary);
        app->vk.FreeCommandBuffers(app->device, set->pool, 1, &set->secondary);
    }
    app->vk.DestroyCommandPool(app->device, set->pool, NULL);
}

/* Each alias lies where the builds read, or where they have their scratch, and is too small and of
 * the wrong usage for either, which does not matter as long as the large buffers are there. */
static void create_inputs(struct application *app)
{
    app->memory = allocate(app, INPUT_SIZE + (SETS + 1) * SCRATCH_SIZE, DEVICE_MEMORY);
    app->inputs = create_buffer(
        app, INPUT_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR, 0);
    app->scratch = create_buffer(app, SETS * SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 0);
    bind_buffer(app, app->inputs, app->memory, 0);
    bind_buffer(app, app->scratch, app->memory, INPUT_SIZE);
    for (unsigned i = 0; i < SETS; i++) {
        app->aliases[i] = create_buffer(app, ALIAS_SIZE, VK_BUFFER_USAGE_TRANSFER_DST_BIT, 0);
        bind_buffer(app, app->aliases[i], app->memory, i % 2 ? INPUT_SIZE + i * SCRATCH_SIZE : 0);
        address_of(app, app->aliases[i]);
    }
    app->input_address = address_of(app, app->inputs);
    app->scratch_address = address_of(app, app->scratch);
}

static void destroy_inputs(struct application *app)
{
    for (unsigned i = 0; i < SETS; i++)
        app->vk.DestroyBuffer(app->device, app->aliases[i], NULL);
    app->vk.DestroyBuffer(app->device, app->scratch, NULL);
    app->vk.DestroyBuffer(app->device, app->inputs, NULL);
    app->vk.FreeMemory(app->device, app->memory, NULL);
}

/* Its pages are bound in reverse, one by one, and some anew. */
static void create_sparse(struct application *app)
{
    VkSparseMemoryBind binds[SPARSE_PAGES + 2];
    app->pages = allocate(app, SPARSE_PAGES * SPARSE_PAGE, DEVICE_MEMORY);
    app->sparse = create_buffer(app, SPARSE_PAGES * SPARSE_PAGE,
                                VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                                VK_BUFFER_CREATE_SPARSE_BINDING_BIT);
    for (unsigned i = 0; i < SPARSE_PAGES + 2; i++)
        binds[i] = (VkSparseMemoryBind){
            .resourceOffset = (VkDeviceSize)(i % SPARSE_PAGES) * SPARSE_PAGE,
            .size = SPARSE_PAGE,
            .memory = app->pages,
            .memoryOffset = (VkDeviceSize)(SPARSE_PAGES - 1 - i % SPARSE_PAGES) * SPARSE_PAGE};
    const VkSparseBufferMemoryBindInfo buffer = {
        .buffer = app->sparse, .bindCount = SPARSE_PAGES + 2, .pBinds = binds};
    CALL(app, QueueBindSparse, app->queue, 1,
         &MAKE(VkBindSparseInfo, .bufferBindCount = 1, .pBufferBinds = &buffer), VK_NULL_HANDLE);
    app->in_pages = create_accel(app, app->sparse, SPARSE_PAGE - ACCEL_SIZE / 2, 2 * SPARSE_PAGE,
                                 VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void destroy_sparse(struct application *app)
{
    app->vk.DestroyAccelerationStructureKHR(app->device, app->in_pages, NULL);
    app->vk.DestroyBuffer(app->device, app->sparse, NULL);
    app->vk.FreeMemory(app->device, app->pages, NULL);
}

static void create_tails(struct application *app)
{
    app->tails_memory = allocate(app, 4 * ACCEL_SIZE, DEVICE_MEMORY);
    app->tails = create_buffer(app, 3 * ACCEL_SIZE,
                               VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    bind_buffer(app, app->tails, app->tails_memory, 0);
    for (unsigned i = 0; i < 2; i++)
        app->with_tails[i] = create_accel(app, app->tails, i * ACCEL_SIZE, 2 * ACCEL_SIZE,
                                          VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void destroy_tails(struct application *app)
{
    for (unsigned i = 0; i < 2; i++)
        app->vk.DestroyAccelerationStructureKHR(app->device, app->with_tails[i], NULL);
    app->vk.DestroyBuffer(app->device, app->tails, NULL);
    app->vk.FreeMemory(app->device, app->tails_memory, NULL);
}

void create_objects(struct application *app)
{
    CALL(app, CreateSemaphore, app->device, &MAKE(VkSemaphoreCreateInfo), NULL, &app->semaphore);
    for (unsigned n = 0; n < SETS; n++) {
        create_set(app, &app->sets[n], n);
        name_set(app, &app->sets[n], n);
    }
    app->queries = create_queries(app, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    create_inputs(app);
    create_sparse(app);
    create_tails(app);
    create_nv(app);
    create_micromaps(app);
}

void destroy_objects(struct application *app)
{
    app->vk.DeviceWaitIdle(app->device);
    app->vk.DestroySemaphore(app->device, app->semaphore, NULL);
    destroy_micromaps(app);
    destroy_nv(app);
    destroy_tails(app);
    destroy_sparse(app);
    destroy_inputs(app);
    app->vk.DestroyQueryPool(app->device, app->queries, NULL);
    for (unsigned n = 0; n < SETS; n++)
        destroy_set(app, &app->sets[n], n);
}
