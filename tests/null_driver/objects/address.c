/* SPDX-License-Identifier: Apache-2.0 */
/* Device addresses: upwards from a base, so that none is given out twice unless asked for; and what
 * they lead to. */
#include "tests/null_driver/internal.h"

#include <stdlib.h>

enum { PAGE = 64 * 1024, MAX_FREED = 256 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* may be taken under object.c's */
static VkDeviceAddress next_address = 0x100000000000;
static struct {
    VkDeviceAddress address;
    VkDeviceSize size;
} freed[MAX_FREED]; /* the last ones, where addresses are recycled */
static size_t freed_count;

VkDeviceAddress address_allocate(const struct null_driver_config *config, VkDeviceSize size)
{
    /* Absurd sizes are cut, so that they cannot use up the address space. */
    const VkDeviceSize most = (VkDeviceSize)1 << 40;
    const VkDeviceSize rounded = align_up(size < most ? size : most, PAGE);
    VkDeviceAddress address = 0;
    pthread_mutex_lock(&lock);
    const bool recycle = config != NULL && config->recycle_addresses;
    for (size_t i = recycle ? freed_count : 0; i-- > 0 && address == 0;) {
        if (freed[i].size == rounded) {
            address = freed[i].address;
            freed[i] = freed[--freed_count];
        }
    }
    if (address == 0) {
        address = next_address;
        next_address += rounded + PAGE;
    }
    pthread_mutex_unlock(&lock);
    return address;
}

void address_release(const struct null_driver_config *config, VkDeviceAddress address,
                     VkDeviceSize size)
{
    if (!config->recycle_addresses || address == 0)
        return;
    pthread_mutex_lock(&lock);
    if (freed_count < MAX_FREED) {
        freed[freed_count].address = address;
        freed[freed_count++].size = align_up(size, PAGE);
    }
    pthread_mutex_unlock(&lock);
}

void address_start_over(VkDeviceAddress first)
{
    pthread_mutex_lock(&lock);
    next_address = first;
    freed_count = 0;
    pthread_mutex_unlock(&lock);
}

/* ---- what has an address */

static struct placed {
    VkDeviceAddress begin, end;
    const struct object *object; /* so that it can be removed */
    uint64_t handle;
    bool is_buffer;
} * placed; /* in ascending order */
static size_t placed_count, placed_capacity;

/* The first one that begins behind the address. */
static size_t find_behind(VkDeviceAddress address)
{
    size_t low = 0, high = placed_count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (placed[middle].begin <= address)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool reserve(void)
{
    if (placed_count < placed_capacity)
        return true;
    const size_t capacity = placed_capacity != 0 ? placed_capacity * 2 : 256;
    struct placed *grown = driver_allocate(placed, capacity * sizeof(*grown));
    if (grown == NULL)
        return false;
    placed = grown;
    placed_capacity = capacity;
    return true;
}

void address_add_object(const struct object *object, VkDeviceAddress address, VkDeviceSize size)
{
    pthread_mutex_lock(&lock);
    if (address != 0 && size != 0 && reserve()) {
        const size_t at = find_behind(address);
        memmove(&placed[at + 1], &placed[at], (placed_count++ - at) * sizeof(*placed));
        placed[at] = (struct placed){.begin = address,
                                     .end = address + size,
                                     .object = object,
                                     .handle = object->handle,
                                     .is_buffer = object->type == VK_OBJECT_TYPE_BUFFER};
    }
    pthread_mutex_unlock(&lock);
}

void address_remove_object(const struct object *object)
{
    pthread_mutex_lock(&lock);
    size_t at = 0;
    while (at < placed_count && placed[at].object != object)
        at++;
    if (at < placed_count) {
        memmove(&placed[at], &placed[at + 1], (placed_count - at - 1) * sizeof(*placed));
        placed_count--;
    }
    if (placed_count == 0) {
        free(placed); /* leak checkers look when all is gone */
        placed = NULL;
        placed_capacity = 0;
    }
    pthread_mutex_unlock(&lock);
}

unsigned char *address_bytes(VkDeviceAddress address, VkDeviceSize *size)
{
    struct placed found = {0};
    pthread_mutex_lock(&lock);
    const size_t behind = find_behind(address);
    if (behind > 0 && address < placed[behind - 1].end)
        found = placed[behind - 1];
    pthread_mutex_unlock(&lock);
    const VkDeviceSize offset = address - found.begin;
    if (found.is_buffer)
        return buffer_bytes(HANDLE(VkBuffer, found.handle), offset, size);
    struct object *memory = object_find(found.handle, VK_OBJECT_TYPE_DEVICE_MEMORY);
    return memory != NULL ? memory_bytes(memory, offset, size) : NULL;
}
