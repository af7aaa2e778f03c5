/* SPDX-License-Identifier: Apache-2.0 */
/* layer/snapshots/guard/guard.comp, carried out for one invocation after the other. */
#include "internal.h"

enum {
    POINTERS = 1,
    MOTION = 2,
    NV = 4,
    PARTITIONS = 8,
    CLUSTERS = 16,
    MOTION_STRIDE = 160,
    MOTION_SIZE = 152,
    WORDS_MAX = 40,
};
#define UNLIMITED UINT32_MAX

struct constants {
    uint64_t gate, references, order, range, pointers, elements;
    uint32_t count, flags;
};

struct order {
    uint64_t source, ranges, places, indirect;
    uint32_t readable, range_count, limit, can_read_range, place_count;
    uint32_t replaced, first_replaced, unreadable, is_done;
};

struct reference_entry {
    uint64_t reference;
    uint32_t built, kinds;
};

struct guarding {
    struct constants constants;
    struct order order;
    bool is_open;
};

/* ---- ranges and instances */

bool ranges_contain(VkDeviceAddress ranges, uint32_t count, VkDeviceAddress address,
                    VkDeviceSize size)
{
    for (uint32_t i = 0; i < count; i++) {
        VkDeviceAddress range[2];
        if (!address_read(ranges + i * sizeof(range), range, sizeof(range)))
            return false;
        if (range[0] <= address && address < range[1])
            return size <= range[1] - address;
    }
    return false;
}

uint32_t instance_words(uint32_t type)
{
    static const uint32_t words[] = {16, 28, 36};
    return type < COUNT_OF(words) ? words[type] : 0;
}

/* ---- references */

static bool is_within(VkDeviceAddress ranges, uint32_t count, VkDeviceAddress address,
                      VkDeviceSize size)
{
    return count == UNLIMITED || ranges_contain(ranges, count, address, size);
}

static bool is_in_table(const struct guarding *guard, uint64_t reference)
{
    struct {
        uint32_t current, known_kinds;
    } header;
    struct {
        uint64_t entries;
        uint32_t mask, unused;
    } table;
    const uint32_t kind = guard->constants.flags & NV ? 2 : 1;
    if (!address_read(guard->constants.references, &header, sizeof(header)) ||
        (header.known_kinds & kind) == 0)
        return true;
    if (!address_read(guard->constants.references + 16 + header.current * sizeof(table), &table,
                      sizeof(table)))
        return true;
    uint32_t hash = (uint32_t)reference * 0x9e3779b1u ^ (uint32_t)(reference >> 32) * 0x85ebca77u;
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    hash ^= hash >> 16;
    struct reference_entry entry;
    for (uint32_t i = 0; i <= table.mask; i++) {
        if (!address_read(table.entries + ((hash + i) & table.mask) * sizeof(entry), &entry,
                          sizeof(entry)) ||
            entry.reference == 0)
            return false;
        if (entry.reference == reference)
            return (entry.kinds & kind) != 0 && (kind == 2 || entry.built <= guard->order.limit);
    }
    return false;
}

static bool is_valid(const struct guarding *guard, uint64_t reference)
{
    return reference == 0 || is_in_table(guard, reference) ||
           is_within(guard->order.places, guard->order.place_count, reference, 1);
}

/* Replaces the reference at a word, and writes the element. */
static void write_element(struct guarding *guard, uint32_t index, uint32_t *element, uint32_t words,
                          uint32_t reference_word, VkDeviceAddress to)
{
    uint64_t reference = 0;
    if (reference_word + 1 < words)
        memcpy(&reference, &element[reference_word], sizeof(reference));
    if (!is_valid(guard, reference)) {
        memset(&element[reference_word], 0, sizeof(reference));
        guard->order.replaced++;
        if (index < guard->order.first_replaced)
            guard->order.first_replaced = index;
    }
    address_write(to, element, words * sizeof(*element));
}

/* ---- elements */

static void copy_pointed(struct guarding *guard, uint32_t index, VkDeviceAddress from,
                         VkDeviceAddress to)
{
    uint32_t element[WORDS_MAX] = {0}, type = 0, words = 16;
    if (guard->constants.flags & MOTION) {
        type = (uint32_t)from & 15;
        from -= type;
        words = instance_words(type);
    }
    const VkDeviceAddress pointer = (words != 0 ? to : from) + type;
    address_write(guard->constants.pointers + index * sizeof(pointer), &pointer, sizeof(pointer));
    if (words == 0)
        return;
    if (from == 0 ||
        !is_within(guard->order.ranges, guard->order.range_count, from, words * sizeof(*element)) ||
        !address_read(from, element, words * sizeof(*element)))
        guard->order.unreadable++;
    write_element(guard, index, element, words, words - 2, to);
}

static void copy_next(struct guarding *guard, uint32_t index, VkDeviceAddress source,
                      uint32_t readable)
{
    const bool has_pointers = guard->constants.flags & POINTERS;
    const bool has_motion = guard->constants.flags & MOTION;
    const VkDeviceSize stride = has_pointers ? 8 : has_motion ? MOTION_STRIDE : 64;
    const VkDeviceSize size = has_motion && !has_pointers ? MOTION_SIZE : stride;
    const VkDeviceAddress to =
        guard->constants.elements + index * (has_motion ? MOTION_STRIDE : 64);
    uint32_t element[WORDS_MAX] = {0};
    const bool is_there = guard->is_open &&
                          (readable == UNLIMITED || index * stride + size <= readable) &&
                          address_read(source + index * stride, element, size);
    if (!is_there) {
        guard->order.unreadable += guard->is_open;
        address_write(to, element, has_motion ? sizeof(element) : 64);
        if (has_pointers)
            address_write(guard->constants.pointers + index * sizeof(to), &to, sizeof(to));
    } else if (has_pointers) {
        VkDeviceAddress from;
        memcpy(&from, element, sizeof(from));
        copy_pointed(guard, index, from, to);
    } else if (has_motion) {
        const uint32_t words = instance_words(element[0]);
        write_element(guard, index, element, MOTION_SIZE / 4, words != 0 ? words : WORDS_MAX, to);
    } else {
        write_element(guard, index, element, 16, 14, to);
    }
}

/* ---- partitioned structures */

enum {
    OPERATIONS = 3,
    EXPLICIT_BOUNDS = 16,
    ROOM_ALIGNMENT = 16,
    WRITE_SIZE = sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV),
    UPDATE_SIZE = sizeof(VkPartitionedAccelerationStructureUpdateInstanceDataNV),
};

static bool is_whole(const struct order *order,
                     const VkBuildPartitionedAccelerationStructureIndirectCommandNV *operation,
                     uint32_t count, VkDeviceSize size)
{
    const VkDeviceAddress start = operation->argData.startAddress;
    const VkDeviceSize stride = operation->argData.strideInBytes;
    if (order->range_count == UNLIMITED)
        return true;
    return (stride == 0 || count - 1 <= (UINT64_MAX - start - size) / stride) &&
           ranges_contain(order->ranges, order->range_count, start, (count - 1) * stride + size);
}

/* The build reads no structure of an instance with explicit bounds, or that is updated. */
static void copy_partitioned(struct guarding *guard, bool is_update, uint32_t *element,
                             uint32_t words, VkDeviceAddress to)
{
    const struct order order = guard->order;
    if (is_update || element[21] & EXPLICIT_BOUNDS) {
        guard->order.limit = UNLIMITED;
        if (guard->constants.flags & CLUSTERS)
            guard->order.place_count = UNLIMITED;
    }
    write_element(guard, element[is_update ? 0 : 22], element, words, words - 2, to);
    guard->order.limit = order.limit;
    guard->order.place_count = order.place_count;
}

/* Returns the bytes of the copies that it takes. */
static uint32_t copy_operation(struct guarding *guard, VkDeviceAddress from, VkDeviceAddress to,
                               VkDeviceAddress target, uint32_t room)
{
    VkBuildPartitionedAccelerationStructureIndirectCommandNV operation = {0};
    address_read(from, &operation, sizeof(operation));
    const bool is_update =
        operation.opType == VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_UPDATE_INSTANCE_NV;
    const uint32_t size = is_update ? UPDATE_SIZE : WRITE_SIZE;
    if (!is_update &&
        operation.opType != VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV) {
        address_write(to, &operation, sizeof(operation));
        return 0;
    }
    uint32_t count = operation.argCount < room / size ? operation.argCount : room / size;
    if (count != 0 && !is_whole(&guard->order, &operation, count, size)) {
        guard->order.unreadable += count;
        count = 0;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t element[WORDS_MAX] = {0};
        address_read(operation.argData.startAddress + i * operation.argData.strideInBytes, element,
                     size);
        copy_partitioned(guard, is_update, element, size / sizeof(*element), target + i * size);
    }
    operation.argCount = count;
    operation.argData = (VkStridedDeviceAddressNV){target, size};
    address_write(to, &operation, sizeof(operation));
    return (uint32_t)align_up((VkDeviceSize)count * size, ROOM_ALIGNMENT);
}

static void copy_operations(struct guarding *guard)
{
    const VkDeviceSize size = sizeof(VkBuildPartitionedAccelerationStructureIndirectCommandNV);
    uint32_t used = 0, copied = 0;
    if (guard->is_open && guard->order.can_read_range)
        address_read(guard->order.indirect, &used, sizeof(used));
    used = used < OPERATIONS ? used : OPERATIONS;
    if (used > guard->order.readable / size)
        used = guard->order.readable / size;
    address_write(guard->constants.range, &used, sizeof(used));
    const uint32_t room = (uint32_t)align_up(
        (VkDeviceSize)guard->constants.count * (WRITE_SIZE + UPDATE_SIZE) + ROOM_ALIGNMENT,
        ROOM_ALIGNMENT);
    for (uint32_t i = 0; i < used; i++)
        copied += copy_operation(guard, guard->order.source + i * size,
                                 guard->constants.pointers + i * size,
                                 guard->constants.elements + copied, room - copied);
}

static void copy_instances(struct guarding *guard)
{
    VkAccelerationStructureBuildRangeInfoKHR given = {0}, range = {0};
    uint32_t used = guard->constants.count, readable = guard->order.readable;
    VkDeviceAddress source = guard->order.source;
    if (guard->constants.range != 0) {
        if (guard->is_open && guard->order.can_read_range)
            address_read(guard->order.indirect, &given, sizeof(given));
        used = given.primitiveCount < used ? given.primitiveCount : used;
        source += given.primitiveOffset;
        if (readable != UNLIMITED)
            readable -= readable < given.primitiveOffset ? readable : given.primitiveOffset;
        range.primitiveCount = used;
        address_write(guard->constants.range, &range, sizeof(range));
    }
    for (uint32_t i = 0; i < used; i++)
        copy_next(guard, i, source, readable);
}

void guard_execute(const struct dispatch *dispatch)
{
    struct guarding guard = {0};
    uint32_t gate = 0;
    memcpy(&guard.constants, dispatch->constants, sizeof(guard.constants));
    address_read(guard.constants.gate, &gate, sizeof(gate));
    guard.is_open = gate != 0;
    if (guard.is_open && !address_read(guard.constants.order, &guard.order, sizeof(guard.order)))
        return;
    if (guard.constants.flags & PARTITIONS)
        copy_operations(&guard);
    else
        copy_instances(&guard);
    guard.order.is_done = 1;
    if (guard.is_open)
        address_write(
            guard.constants.order + offsetof(struct order, replaced), &guard.order.replaced,
            offsetof(struct order, is_done) + sizeof(uint32_t) - offsetof(struct order, replaced));
}
