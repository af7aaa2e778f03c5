/* SPDX-License-Identifier: Apache-2.0 */
/* Device memory: an address each, and real memory once it is mapped or a command uses it. */
#include "tests/null_driver/internal.h"

#include <pthread.h>
#include <string.h>
#include <sys/mman.h>

static _Atomic uint64_t allocated;

uint64_t null_driver_allocated(void)
{
    return atomic_load(&allocated);
}

/* Where nothing can be read, before mapped memory and behind it. */
static size_t gap_before(const struct object *memory)
{
    return memory->config->has_gaps ? (size_t)1 << 20 : 0;
}

static size_t gap_behind(const struct object *memory)
{
    return memory->config->has_gaps ? (size_t)1 << 34 : 0;
}

static unsigned char *map_host(const struct object *memory)
{
    const size_t before = gap_before(memory), size = memory->memory.size;
    unsigned char *all = mmap(NULL, before + size + gap_behind(memory), PROT_NONE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (all == MAP_FAILED)
        return NULL;
    mprotect(all + before, size, PROT_READ | PROT_WRITE);
    return all + before;
}

static void unmap_host(const struct object *memory)
{
    const size_t before = gap_before(memory);
    munmap((unsigned char *)memory->memory.host - before,
           before + memory->memory.size + gap_behind(memory));
}

/* Small memory without gaps is not unmapped: the system would interrupt all processors each time,
 * which took half of the time of tests that free much. */
enum { SPARES = 64, SPARE_MAX = 256 * 1024 };

static struct {
    unsigned char *bytes;
    size_t size;
} spares[SPARES];
static unsigned spare_count;
static pthread_mutex_t spares_lock = PTHREAD_MUTEX_INITIALIZER;

static unsigned char *take_spare(const struct object *memory)
{
    unsigned char *bytes = NULL;
    pthread_mutex_lock(&spares_lock);
    for (unsigned i = spare_count; i-- > 0 && !bytes && !memory->config->has_gaps;)
        if (spares[i].size == memory->memory.size) {
            bytes = spares[i].bytes;
            spares[i] = spares[--spare_count];
        }
    pthread_mutex_unlock(&spares_lock);
    if (bytes)
        memset(bytes, 0, memory->memory.size);
    return bytes;
}

static bool keep_spare(const struct object *memory)
{
    bool is_kept = false;
    if (memory->config->has_gaps || memory->memory.size > SPARE_MAX)
        return false;
    pthread_mutex_lock(&spares_lock);
    if (spare_count < SPARES) {
        spares[spare_count].bytes = memory->memory.host;
        spares[spare_count++].size = memory->memory.size;
        is_kept = true;
    }
    pthread_mutex_unlock(&spares_lock);
    return is_kept;
}

/* The loader unloads the driver with the last instance. */
__attribute__((destructor)) static void unmap_spares(void)
{
    while (spare_count > 0) {
        spare_count--;
        munmap(spares[spare_count].bytes, spares[spare_count].size);
    }
}

static void release_memory(struct object *memory)
{
    atomic_fetch_sub(&allocated, memory->memory.size);
    if (memory->memory.host != NULL && !memory->memory.imported && !keep_spare(memory))
        unmap_host(memory);
    address_remove_object(memory);
    address_release(memory->config, memory->memory.address, memory->memory.size);
}

static VkResult check(const struct null_driver_config *config, const VkMemoryAllocateInfo *info)
{
    const VkPhysicalDeviceMemoryProperties *memory = &config->memory;
    if (info->memoryTypeIndex >= memory->memoryTypeCount || info->allocationSize == 0)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    const uint32_t heap = memory->memoryTypes[info->memoryTypeIndex].heapIndex;
    if (info->allocationSize > memory->memoryHeaps[heap].size)
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return VK_SUCCESS;
}

static void import(struct object *memory, const VkMemoryAllocateInfo *info)
{
    const VkImportMemoryHostPointerInfoEXT *host =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT);
    if (host != NULL && host->pHostPointer != NULL) {
        memory->memory.host = host->pHostPointer;
        memory->memory.imported = true;
    }
}

static VkDeviceAddress replayed_address(const VkMemoryAllocateInfo *info)
{
    const VkMemoryOpaqueCaptureAddressAllocateInfo *replay =
        chain_find(info->pNext, VK_STRUCTURE_TYPE_MEMORY_OPAQUE_CAPTURE_ADDRESS_ALLOCATE_INFO);
    return replay != NULL ? replay->opaqueCaptureAddress : 0;
}

COMMAND(AllocateMemory)
{
    const struct null_driver_config *config = CONFIG(device);
    const VkResult result = check(config, pAllocateInfo);
    if (result != VK_SUCCESS)
        return result;
    struct object *memory =
        object_create(OBJECT(device), VK_OBJECT_TYPE_DEVICE_MEMORY, release_memory);
    if (memory == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const VkMemoryType *type = &config->memory.memoryTypes[pAllocateInfo->memoryTypeIndex];
    memory->memory.size = pAllocateInfo->allocationSize;
    memory->memory.host_visible = type->propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
    memory->memory.address = replayed_address(pAllocateInfo);
    if (memory->memory.address == 0)
        memory->memory.address = address_allocate(config, memory->memory.size);
    atomic_fetch_add(&allocated, memory->memory.size);
    import(memory, pAllocateInfo);
    address_add_object(memory, memory->memory.address, memory->memory.size);
    *pMemory = HANDLE(VkDeviceMemory, memory->handle);
    return VK_SUCCESS;
}

unsigned char *memory_bytes(struct object *memory, VkDeviceSize offset, VkDeviceSize *size)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of making them */
    if (offset >= memory->memory.size)
        return NULL;
    if (*size > memory->memory.size - offset)
        *size = memory->memory.size - offset;
    pthread_mutex_lock(&lock);
    if (memory->memory.host == NULL)
        memory->memory.host = take_spare(memory);
    if (memory->memory.host == NULL)
        memory->memory.host = map_host(memory);
    unsigned char *bytes = memory->memory.host;
    pthread_mutex_unlock(&lock);
    return bytes != NULL ? bytes + offset : NULL;
}

COMMAND(MapMemory2)
{
    struct object *memory = FIND(DEVICE_MEMORY, pMemoryMapInfo->memory);
    if (memory == NULL || !memory->memory.host_visible || memory->memory.is_mapped)
        return VK_ERROR_MEMORY_MAP_FAILED;
    VkDeviceSize size = VK_WHOLE_SIZE;
    unsigned char *bytes = memory_bytes(memory, pMemoryMapInfo->offset, &size);
    if (bytes == NULL)
        return VK_ERROR_MEMORY_MAP_FAILED;
    memory->memory.is_mapped = true;
    *ppData = bytes;
    return VK_SUCCESS;
}

COMMAND(UnmapMemory)
{
    struct object *of = FIND(DEVICE_MEMORY, memory);
    if (of != NULL)
        of->memory.is_mapped = false;
}

COMMAND(UnmapMemory2)
{
    null_UnmapMemory(device, pMemoryUnmapInfo->memory);
    return VK_SUCCESS;
}
