/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that buffers share, so that they have the same address. */
#ifndef SNAPSHOTS_SHARED_MEMORY_H
#define SNAPSHOTS_SHARED_MEMORY_H

#include "tests/snapshots/fixture.h"

enum { MEMORY_SIZE = 1 << 16, LURES = 4 };

/* Mapped, and all zeros. */
struct memory {
    VkDeviceMemory handle;
    unsigned char *bytes;
};
struct memory memory_allocate(const struct fixture *fixture);
void memory_free(const struct fixture *fixture, const struct memory *memory);

/* A buffer at the begin of a memory, which builds may read. */
struct placed {
    VkBuffer handle;
    VkDeviceAddress address;
};
struct placed memory_place(const struct fixture *fixture, const struct memory *memory,
                           VkDeviceSize size);
void memory_destroy(const struct fixture *fixture, const struct placed *placed);

/* Buffers that a driver may put where a destroyed one was: who still uses the destroyed buffer's
 * handle reads their memory. */
struct lures {
    struct memory memory;
    struct placed buffers[LURES];
};
void lures_lay(const struct fixture *fixture, struct lures *lures);
void lures_free(const struct fixture *fixture, const struct lures *lures);

#endif
