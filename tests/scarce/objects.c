/* SPDX-License-Identifier: Apache-2.0 */
/* The objects of the application. */
#include "application_parts.h"

enum { INPUT_SIZE = 65536, ALIAS_SIZE = 256 };

static void create_set(struct set *set, unsigned n)
{
    set->memory = allocate(2 * ACCEL_SIZE, DEVICE_MEMORY);
    set->buffer =
        create_buffer(ACCEL_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, 0);
    if (n % 2) /* before its buffer is bound */
        set->accel = create_accel(set->buffer, 0, ACCEL_SIZE,
                                  VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    if (n % 3)
        CALL(BindBufferMemory2, device, 1,
             &MAKE(VkBindBufferMemoryInfo, .buffer = set->buffer, .memory = set->memory));
    else
        bind_buffer(set->buffer, set->memory, 0);
    if (!set->accel)
        set->accel = create_accel(set->buffer, 0, ACCEL_SIZE,
                                  VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    create_commands(&set->pool, &set->primary, &set->secondary);
}

static void name_set(const struct set *set, unsigned n)
{
    name_object(VK_OBJECT_TYPE_BUFFER, (uint64_t)set->buffer, "buffer", n);
    name_object(VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)set->memory, "memory", n);
    name_object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)set->accel, "tree", n);
    name_object(VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)set->primary, "frame", n);
    name_object(VK_OBJECT_TYPE_BUFFER, (uint64_t)set->buffer, "renamed buffer", n);
}

/* Each alias lies where the builds read, or where they have their scratch, and is too small and of
 * the wrong usage for either, which does not matter as long as the large buffers are there. */
static void create_inputs(void)
{
    const VkDeviceMemory memory = allocate(INPUT_SIZE + (SETS + 1) * SCRATCH_SIZE, DEVICE_MEMORY);
    const VkBuffer inputs = create_buffer(
        INPUT_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR, 0);
    const VkBuffer scratch =
        create_buffer(SETS * SCRATCH_SIZE, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 0);
    bind_buffer(inputs, memory, 0);
    bind_buffer(scratch, memory, INPUT_SIZE);
    for (unsigned i = 0; i < SETS; i++) {
        const VkBuffer alias = create_buffer(ALIAS_SIZE, VK_BUFFER_USAGE_TRANSFER_DST_BIT, 0);
        bind_buffer(alias, memory, i % 2 ? INPUT_SIZE + i * SCRATCH_SIZE : 0);
        address_of(alias);
    }
    app.input_address = address_of(inputs);
    app.scratch_address = address_of(scratch);
}

/* Its pages are bound in reverse, one by one, and some anew. */
static void create_sparse(void)
{
    VkSparseMemoryBind binds[SPARSE_PAGES + 2];
    const VkDeviceMemory pages = allocate(SPARSE_PAGES * SPARSE_PAGE, DEVICE_MEMORY);
    const VkBuffer sparse = create_buffer(SPARSE_PAGES * SPARSE_PAGE,
                                          VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
                                          VK_BUFFER_CREATE_SPARSE_BINDING_BIT);
    for (unsigned i = 0; i < SPARSE_PAGES + 2; i++)
        binds[i] = (VkSparseMemoryBind){
            .resourceOffset = (VkDeviceSize)(i % SPARSE_PAGES) * SPARSE_PAGE,
            .size = SPARSE_PAGE,
            .memory = pages,
            .memoryOffset = (VkDeviceSize)(SPARSE_PAGES - 1 - i % SPARSE_PAGES) * SPARSE_PAGE};
    const VkSparseBufferMemoryBindInfo buffer = {
        .buffer = sparse, .bindCount = SPARSE_PAGES + 2, .pBinds = binds};
    CALL(QueueBindSparse, queue, 1,
         &MAKE(VkBindSparseInfo, .bufferBindCount = 1, .pBufferBinds = &buffer), VK_NULL_HANDLE);
    app.in_pages = create_accel(sparse, SPARSE_PAGE - ACCEL_SIZE / 2, 2 * SPARSE_PAGE,
                                VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

static void create_tails(void)
{
    const VkBuffer tails = create_bound_buffer(
        3 * ACCEL_SIZE, VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, DEVICE_MEMORY);
    for (unsigned i = 0; i < 2; i++)
        app.with_tails[i] = create_accel(tails, i * ACCEL_SIZE, 2 * ACCEL_SIZE,
                                         VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
}

void create_objects(void)
{
    CREATE(Semaphore, &MAKE(VkSemaphoreCreateInfo), &app.semaphore);
    for (unsigned n = 0; n < SETS; n++) {
        create_set(&app.sets[n], n);
        name_set(&app.sets[n], n);
    }
    app.queries = create_queries(VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR);
    create_inputs();
    create_sparse();
    create_tails();
    create_nv();
    create_micromaps();
}
