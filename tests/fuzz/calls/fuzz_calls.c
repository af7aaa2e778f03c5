/* SPDX-License-Identifier: Apache-2.0 */
/* The fuzz target: bytes become calls. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "../fuzz.h"
#include "calls.h"

enum { CALLS_MAX = 400 };

static void (*const all_calls[])(struct calls *calls) = {
#define CALL(name) call_##name,
    CALLS(CALL)
#undef CALL
};

/* ---- bytes */

uint8_t take(struct calls *calls)
{
    return calls->at < calls->end ? *calls->at++ : 0;
}

uint32_t take_word(struct calls *calls)
{
    uint32_t word = 0;
    for (unsigned i = 0; i < sizeof(word); i++)
        word |= (uint32_t)take(calls) << (8 * i);
    return word;
}

uint64_t take_offset(struct calls *calls)
{
    static const uint64_t offsets[] = {0,          256,
                                       64,         4,
                                       8,          16,
                                       24,         1024,
                                       4096,       16384,
                                       65536,      1,
                                       12,         100,
                                       255,        1 << 20,
                                       65535,      65528,
                                       (1 << 18),  UINT32_MAX,
                                       UINT64_MAX, UINT64_MAX - 255};
    return TAKE(calls, offsets);
}

uint64_t take_size(struct calls *calls)
{
    static const uint64_t sizes[] = {4096, 65536, 1 << 18, 1 << 20,    256,       64,
                                     24,   1,     100,     UINT32_MAX, 1ull << 40};
    return TAKE(calls, sizes);
}

uint32_t take_count(struct calls *calls)
{
    static const uint32_t counts[] = {1,    2,    3,    4,       8,          64,         0,
                                      1000, 4000, 5000, 1 << 20, UINT32_MAX, 0x55555556, 5};
    return TAKE(calls, counts);
}

uint64_t take_stride(struct calls *calls, uint64_t usual)
{
    const uint64_t wide = calls->is_host_build ? 1 << 16 : UINT32_MAX;
    const uint64_t strides[] = {usual, usual + 4, 0, 1, 2, 3, 8, 100, wide, UINT64_MAX};
    const uint64_t stride = TAKE(calls, strides);
    calls->has_stride_0 |= stride == 0;
    return stride;
}

static uint32_t at_most(uint32_t count, bool is_bounded)
{
    enum { SMALL = 5000 };
    return is_bounded && count > SMALL ? SMALL : count;
}

uint32_t take_build_count(struct calls *calls)
{
    return at_most(take_count(calls), calls->has_stride_0);
}

uint32_t take_first_vertex(struct calls *calls)
{
    return at_most(take_count(calls), calls->is_host_build);
}

VkDeviceAddress take_address(struct calls *calls, uint32_t slot)
{
    static const VkDeviceAddress wild[] = {0, 1, 256, UINT64_MAX, UINT64_MAX - 255, NOWHERE};
    uint8_t byte = take(calls);
    if (byte >= 240)
        return TAKE(calls, wild);
    const struct slot *buffer = &calls->slots[BUFFERS][(slot + byte) % SLOTS_MAX];
    bool is_from_end = byte >= 200;
    uint64_t offset = byte >= SLOTS_MAX ? take_offset(calls) : 0;
    return buffer->address + (is_from_end ? buffer->size - offset : offset);
}

void *take_pointer(struct calls *calls)
{
    static const uintptr_t wild[] = {0, 1, 8, UINTPTR_MAX, UINTPTR_MAX - 7, NOWHERE};
    uint8_t byte = take(calls);
    if (byte >= 240)
        return (void *)TAKE(calls, wild);
    uint64_t offset = byte ? take_offset(calls) % HOST_SIZE : 0;
    return calls->host + (byte >= 200 ? HOST_SIZE - offset : offset);
}

VkDeviceOrHostAddressConstKHR take_data(struct calls *calls, bool is_host, uint32_t slot)
{
    if (is_host)
        return (VkDeviceOrHostAddressConstKHR){.hostAddress = take_pointer(calls)};
    return (VkDeviceOrHostAddressConstKHR){.deviceAddress = take_address(calls, slot)};
}

/* ---- slots */

const uint8_t slot_counts[KINDS] = {
    [MEMORIES] = 4,   [BUFFERS] = SLOTS_MAX, [STRUCTURES] = SLOTS_MAX, [NV_STRUCTURES] = 3,
    [MICROMAPS] = 3,  [POOLS] = 2,           [COMMAND_BUFFERS] = 6,    [FENCES] = 3,
    [SEMAPHORES] = 3, [EVENTS] = 2,          [QUERY_POOLS] = 2,        [OPERATIONS] = 2,
};

struct slot *pick(struct calls *calls, enum kind kind)
{
    return &calls->slots[kind][take(calls) % slot_counts[kind]];
}

void keep(struct calls *calls, struct slot *slot, VkDeviceSize size, VkResult result)
{
    calls->status = result;
    if (result == VK_SUCCESS)
        *slot = (struct slot){.handle = (uint64_t)(uintptr_t)calls->created,
                              .is_alive = true,
                              .size = size,
                              .address = slot->address};
}

VkCommandBuffer pick_commands(struct calls *calls)
{
    return PICK(VkCommandBuffer, calls, COMMAND_BUFFERS);
}

VkCommandBuffer pick_any_commands(struct calls *calls)
{
    uint8_t byte = take(calls);
    if (byte >= 252)
        return take_pointer(calls);
    return HANDLE_OF(VkCommandBuffer,
                     &calls->slots[COMMAND_BUFFERS][byte % slot_counts[COMMAND_BUFFERS]]);
}

/* ---- the application's memory */

void *calls_allocate(size_t size)
{
    void *block = calloc(1, size ? size : 1);
    if (!block)
        abort();
    return block;
}

/* On both sides lies what no build can step over to reach other memory, which can be read but isn't
 * the application's, and which a sanitizer guards. */
static unsigned char *map_alone(size_t size)
{
    const size_t before = 1 << 20, behind = (size_t)1 << 34;
    unsigned char *bytes = mmap(NULL, before + size + behind, PROT_NONE,
                                MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (bytes == MAP_FAILED || mprotect(bytes + before, size, PROT_READ | PROT_WRITE) != 0)
        abort();
    return bytes + before;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static unsigned char *host, *result;
    static struct calls calls;
    if (!host) {
        host = map_alone(HOST_SIZE);
        result = map_alone(RESULT_SIZE);
    }
    memset(host, 0, HOST_SIZE);
    calls = (struct calls){.at = data, .end = data + size, .host = host, .result = result};
    if (!calls_open(&calls))
        return 0;
    for (int i = 0; i < CALLS_MAX && calls.at < calls.end; i++)
        TAKE(&calls, all_calls)(&calls);
    calls_close(&calls);
    return 0;
}
