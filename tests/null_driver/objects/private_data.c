/* SPDX-License-Identifier: Apache-2.0 */
/* Private data: each slot keeps the values that were set, in no order. */
#include "tests/null_driver/internal.h"

#include <stdlib.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of all slots' values */

static void release_slot(struct object *slot)
{
    free(slot->private_data.values);
}

ON_CREATION(CreatePrivateDataSlot)
{
    object->release = release_slot;
}

static struct private_value *find(const struct object *slot, VkObjectType type, uint64_t handle)
{
    for (size_t i = 0; i < slot->private_data.count; i++) {
        struct private_value *value = &slot->private_data.values[i];
        if (value->type == type && value->handle == handle)
            return value;
    }
    return NULL;
}

static VkResult set(struct object *slot, const struct private_value *new)
{
    struct private_value *value = find(slot, new->type, new->handle);
    if (value == NULL) {
        struct private_value *values = driver_allocate(
            slot->private_data.values, (slot->private_data.count + 1) * sizeof(*values));
        if (values == NULL)
            return VK_ERROR_OUT_OF_HOST_MEMORY;
        slot->private_data.values = values;
        value = &values[slot->private_data.count++];
    }
    *value = *new;
    return VK_SUCCESS;
}

COMMAND(SetPrivateData)
{
    struct object *slot = FIND(PRIVATE_DATA_SLOT, privateDataSlot);
    if (slot == NULL)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    const struct private_value value = {objectType, objectHandle, data};
    pthread_mutex_lock(&lock);
    const VkResult result = set(slot, &value);
    pthread_mutex_unlock(&lock);
    return result;
}

COMMAND(GetPrivateData)
{
    const struct object *slot = FIND(PRIVATE_DATA_SLOT, privateDataSlot);
    pthread_mutex_lock(&lock);
    const struct private_value *value = slot != NULL ? find(slot, objectType, objectHandle) : NULL;
    *pData = value != NULL ? value->value : 0;
    pthread_mutex_unlock(&lock);
}
