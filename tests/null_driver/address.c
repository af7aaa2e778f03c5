/* SPDX-License-Identifier: Apache-2.0 */
/* Device addresses: upwards from a base, so that none is given out twice unless asked for. */
#include "internal.h"

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
