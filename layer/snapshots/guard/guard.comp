// SPDX-License-Identifier: Apache-2.0
// Copies the instances of a build, and replaces references that are not in the table of live,
// built structures by 0. The build reads the copy. Of a build of a partitioned structure, it copies
// the operations and the arrays of instances to which these lead.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

layout(local_size_x = 64) in;

const uint POINTERS = 1; // the source is an array of pointers to instances
const uint MOTION = 2;   // instances of VK_NV_ray_tracing_motion_blur
const uint NV = 4;       // references are values of vkGetAccelerationStructureHandleNV
const uint PARTITIONS = 8; // the source is the operations of a partitioned structure
const uint CLUSTERS = 16;  // structures without a handle may be built later

const uint KIND_KHR = 1, KIND_NV = 2; // of entries
const uint UNLIMITED = ~0u;

layout(buffer_reference, std430, buffer_reference_align = 8) buffer Order
{ // struct guard_order of recorded_build.h
    uvec2 source, ranges, places, indirect;
    uint readable; // bytes at the source; UNLIMITED: all
    uint range_count; // UNLIMITED: anything behind a pointer can be read
    uint limit; // structures built up to this count are built
    uint can_read_range; // the range of an indirect build
    uint place_count; // ranges in which structures without a handle may be; UNLIMITED: anywhere
    uint replaced, first_replaced, unreadable, is_done;
};
struct Entry {
    uvec2 reference;
    uint built, kinds;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Entries
{
    Entry at[];
};
struct Table {
    uvec2 entries;
    uint mask, unused;
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer References
{ // struct references_header of references.c
    uint current, known_kinds, unused[2];
    Table tables[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Ranges
{
    uvec4 at[]; // begin and end
};
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Source
{
    uint at[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Source4
{
    uvec4 at[];
};
layout(buffer_reference, std430, buffer_reference_align = 8) writeonly buffer Target
{
    uint at[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) writeonly buffer Target4
{
    uvec4 at[];
};
layout(buffer_reference, std430, buffer_reference_align = 8) writeonly buffer Pointers
{
    uvec2 at[];
};
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Gate
{
    uint is_open;
};

layout(push_constant) uniform Constants
{
    uvec2 gate, references, order;
    uvec2 range;    // the indirect build reads its range here, or the number of operations
    uvec2 pointers; // the build reads its pointers or its operations here
    uvec2 elements; // and its instances here
    uint count, flags; // partitions: there is room for so many elements of each size
};

bool is_at_most(uvec2 a, uvec2 b)
{
    return a.y < b.y || (a.y == b.y && a.x <= b.x);
}

uvec2 plus(uvec2 a, uint bytes)
{
    uint carry;
    uint low = uaddCarry(a.x, bytes, carry);
    return uvec2(low, a.y + carry);
}

// a + index * stride. `is_beyond`: that is more than 64 bits.
uvec2 strided(uvec2 a, uint index, uvec2 stride, out bool is_beyond)
{
    uint high, low, highest, middle, carry, carried, overflow;
    umulExtended(index, stride.x, high, low);
    umulExtended(index, stride.y, highest, middle);
    high = uaddCarry(high, middle, overflow);
    low = uaddCarry(a.x, low, carry);
    high = uaddCarry(high, carry, carried);
    overflow |= carried;
    high = uaddCarry(a.y, high, carried);
    is_beyond = (highest | overflow | carried) != 0;
    return uvec2(low, high);
}

uvec2 element_at(uvec2 a, uint index, uint size)
{
    bool is_beyond;
    return strided(a, index, uvec2(size, 0), is_beyond);
}

// ---- references

// Read once by each invocation.
bool checks_references = false;
uvec2 table_entries;
uint table_mask, table_kind, built_limit, place_count;

// Returns the end of the range that has an address; 0: there is none. Ranges are in ascending
// order, and do not touch.
uvec2 end_of_range(uvec2 list, uint count, uvec2 address)
{
    uint low = 0, high = count;
    Ranges sorted = Ranges(list);
    while (low < high) {
        uint middle = (low + high) / 2;
        if (is_at_most(sorted.at[middle].xy, address))
            low = middle + 1;
        else
            high = middle;
    }
    uvec2 end = low == 0 ? uvec2(0) : sorted.at[low - 1].zw;
    return is_at_most(end, address) ? uvec2(0) : end;
}

// Whether all of the bytes lie in one range, or the ranges are unknown.
bool is_within(uvec2 list, uint count, uvec2 address, uint bytes)
{
    if (count == UNLIMITED)
        return true;
    uvec2 end = end_of_range(list, count, address);
    return end != uvec2(0) && is_at_most(plus(address, bytes), end);
}

void open_table()
{
    References table = References(references);
    table_kind = (flags & NV) != 0 ? KIND_NV : KIND_KHR;
    checks_references = (table.known_kinds & table_kind) != 0;
    Table current = table.tables[table.current];
    table_entries = current.entries;
    table_mask = current.mask;
    built_limit = table_kind == KIND_NV ? UNLIMITED : Order(order).limit;
    place_count = Order(order).place_count;
}

bool is_in_table(uvec2 reference)
{
    uint hash = reference.x * 0x9e3779b1u ^ reference.y * 0x85ebca77u; // hash_of() of references.c
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    hash ^= hash >> 16;
    for (uint i = 0; i <= table_mask; i++) {
        Entry entry = Entries(table_entries).at[(hash + i) & table_mask];
        if (entry.reference == reference)
            return (entry.kinds & table_kind) != 0 && entry.built <= built_limit;
        if (entry.reference == uvec2(0))
            return false;
    }
    return false;
}

bool is_valid(uvec2 reference)
{
    return reference == uvec2(0) || !checks_references || is_in_table(reference) ||
           is_within(Order(order).places, place_count, reference, 1);
}

void note_replaced(uint index)
{
    atomicAdd(Order(order).replaced, 1);
    atomicMin(Order(order).first_replaced, index);
}

// ---- elements

// Words of static, matrix and SRT motion instances, without the header of 2 words.
uint words_of(uint type)
{
    return type == 0 ? 16 : type == 1 ? 28 : type == 2 ? 36 : 0;
}

uint word_at(uvec2 address, uint word)
{
    uint skipped = address.x & 3; // only a build that breaks a rule has such an address
    Source source = Source(uvec2(address.x - skipped, address.y));
    uint value = source.at[word] >> (8 * skipped);
    if (skipped != 0)
        value |= source.at[word + 1] << (8 * (4 - skipped));
    return value;
}

void clear(uvec2 to, uint words)
{
    for (uint i = 0; i < words; i++)
        Target(to).at[i] = 0;
}

// `reference_word`: the first of the two words of the reference; UNLIMITED: its place is unknown.
void copy_element(uint index, uvec2 from, uvec2 to, uint words, uint reference_word)
{
    bool replaces = false;
    if (reference_word != UNLIMITED) {
        uvec2 reference =
            uvec2(word_at(from, reference_word), word_at(from, reference_word + 1));
        replaces = !is_valid(reference);
        if (replaces)
            note_replaced(index);
    }
    for (uint i = 0; i < words; i++) {
        bool is_reference = i == reference_word || i == reference_word + 1;
        Target(to).at[i] = replaces && is_reference ? 0 : word_at(from, i);
    }
}

// An aligned VkAccelerationStructureInstanceKHR.
void copy_instance(uint index, uvec2 from, uvec2 to)
{
    uvec4 last = Source4(from).at[3];
    if (!is_valid(last.zw)) {
        note_replaced(index);
        last.zw = uvec2(0);
    }
    for (uint i = 0; i < 3; i++)
        Target4(to).at[i] = Source4(from).at[i];
    Target4(to).at[3] = last;
}

// VkAccelerationStructureMotionInstanceNV: 38 words, each 40 words behind the one before.
void copy_motion_instance(uint index, uvec2 from, uvec2 to)
{
    uint words = words_of(word_at(from, 0));
    copy_element(index, from, to, 38, words != 0 ? words : UNLIMITED); // = words + 2 - 2
}

void copy_pointed(uint index, uvec2 source, uvec2 to)
{
    uvec2 from = uvec2(word_at(source, 2 * index), word_at(source, 2 * index + 1));
    uint type = 0, words = 16;
    if ((flags & MOTION) != 0) {
        type = from.x & 15;
        from.x &= ~15;
        words = words_of(type);
    }
    if (words == 0) { // a type that the layer does not know: the build reads it as it is
        Pointers(pointers).at[index] = uvec2(from.x | type, from.y);
        return;
    }
    Pointers(pointers).at[index] = uvec2(to.x | type, to.y);
    if (from == uvec2(0) || !is_within(Order(order).ranges, Order(order).range_count, from, words * 4)) {
        atomicAdd(Order(order).unreadable, 1);
        clear(to, words);
    } else {
        copy_element(index, from, to, words, words - 2);
    }
}

void copy_next(uint index, uvec2 source, uint readable)
{
    bool has_pointers = (flags & POINTERS) != 0, has_motion = (flags & MOTION) != 0;
    uint size = has_pointers ? 8 : has_motion ? 160 : 64;
    uint read = has_motion && !has_pointers ? 152 : size;
    uvec2 to = element_at(elements, index, has_motion ? 160 : 64);
    uint high, low;
    umulExtended(index, size, high, low);
    if (readable != UNLIMITED && (high != 0 || low > readable || readable - low < read)) {
        atomicAdd(Order(order).unreadable, 1);
        clear(to, has_motion ? 40 : 16);
        if (has_pointers)
            Pointers(pointers).at[index] = to;
    } else if (has_pointers) {
        copy_pointed(index, source, to);
    } else if (has_motion) {
        copy_motion_instance(index, element_at(source, index, size), to);
    } else if ((source.x & 15) == 0) {
        copy_instance(index, element_at(source, index, size), to);
    } else {
        copy_element(index, element_at(source, index, size), to, 16, 14);
    }
}

// ---- partitioned structures

const uint OPERATIONS = 3; // as many as there are opTypes
const uint WRITE = 0, UPDATE = 1;
const uint EXPLICIT_BOUNDS = 16; // in word 21 of a VkPartitionedAccelerationStructureWriteInstanceDataNV

// Bytes of an element; 0: it has no reference.
uint element_size(uint type)
{
    return type == WRITE ? 104 : type == UPDATE ? 16 : 0;
}

// The build reads no structure of an instance with explicit bounds, or that is updated. So it may
// be built later.
void copy_partitioned(uint type, uvec2 from, uvec2 to)
{
    bool is_later = type == UPDATE || (word_at(from, 21) & EXPLICIT_BOUNDS) != 0;
    built_limit = is_later ? UNLIMITED : Order(order).limit;
    place_count = is_later && (flags & CLUSTERS) != 0 ? UNLIMITED : Order(order).place_count;
    uint instance = word_at(from, type == UPDATE ? 0 : 22), words = element_size(type) / 4;
    copy_element(instance, from, to, words, words - 2);
}

// Returns how many elements of an array can be copied to `room` bytes: without the memory, none.
uint count_copied(uint given, uint size, uvec2 start, uvec2 stride, uint room)
{
    uint count = min(given, room / size), readable = Order(order).range_count;
    if (count == 0 || readable == UNLIMITED)
        return count;
    uvec2 end = end_of_range(Order(order).ranges, readable, start);
    bool is_beyond;
    uvec2 last = strided(start, count - 1, stride, is_beyond);
    bool is_readable = !is_beyond && end != uvec2(0) && !is_at_most(end, last) &&
                       is_at_most(plus(last, size), end);
    if (!is_readable && gl_GlobalInvocationID.x == 0)
        atomicAdd(Order(order).unreadable, count);
    return is_readable ? count : 0;
}

// VkBuildPartitionedAccelerationStructureIndirectCommandNV: opType, argCount, and where the array
// begins, and its stride. Returns how many bytes of the copies it takes.
uint copy_operation(uvec2 from, uvec2 to, uvec2 target, uint room)
{
    uint first = gl_GlobalInvocationID.x, step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    uint type = word_at(from, 0), size = element_size(type);
    uvec2 start = uvec2(word_at(from, 2), word_at(from, 3));
    uvec2 stride = uvec2(word_at(from, 4), word_at(from, 5));
    if (size == 0) {
        if (first < 6)
            Target(to).at[first] = word_at(from, first);
        return 0;
    }
    uint count = count_copied(word_at(from, 1), size, start, stride, room);
    if (first == 0) {
        Target(to).at[0] = type;
        Target(to).at[1] = count;
        Target(to).at[2] = target.x;
        Target(to).at[3] = target.y;
        Target(to).at[4] = size;
        Target(to).at[5] = 0;
    }
    for (uint index = first; index < count; index += step) {
        bool is_beyond;
        copy_partitioned(type, strided(start, index, stride, is_beyond),
                         element_at(target, index, size));
    }
    return (count * size + 15) & ~15;
}

void copy_operations(bool is_open)
{
    uint used = 0;
    if (is_open && Order(order).can_read_range != 0)
        used = min(min(word_at(Order(order).indirect, 0), OPERATIONS), Order(order).readable / 24);
    if (gl_GlobalInvocationID.x == 0)
        Target(range).at[0] = used;
    uint room = (count * (104 + 16) + 31) & ~15, copied = 0; // as record_partitions() has it
    for (uint i = 0; i < used; i++)
        copied += copy_operation(plus(Order(order).source, i * 24), plus(pointers, i * 24),
                                 plus(elements, copied), room - copied);
    if (is_open && gl_GlobalInvocationID.x == 0)
        Order(order).is_done = 1;
}

// ---- all of them

void main()
{
    uint first = gl_GlobalInvocationID.x, step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
    bool is_open = Gate(gate).is_open != 0; // src/snapshots/recording.h
    bool is_indirect = range != uvec2(0);
    uint used = is_open || !is_indirect ? count : 0, readable = 0;
    uvec2 source = uvec2(0);
    if (is_open)
        open_table();
    if ((flags & PARTITIONS) != 0) {
        copy_operations(is_open);
        return;
    }
    if (is_open) {
        source = Order(order).source;
        readable = Order(order).readable;
    }
    if (is_open && is_indirect) {
        Source given = Source(Order(order).indirect);
        used = Order(order).can_read_range != 0 ? min(given.at[0], count) : 0;
        uint offset = used != 0 ? given.at[1] : 0;
        source = plus(source, offset);
        readable = readable == UNLIMITED ? UNLIMITED : readable - min(readable, offset);
    }
    if (is_indirect && first < 4)
        Target(range).at[first] = first == 0 ? used : 0;
    for (uint index = first; index < used; index += step) {
        if (is_open) {
            copy_next(index, source, readable);
            continue;
        }
        uvec2 to = element_at(elements, index, (flags & MOTION) != 0 ? 160 : 64);
        clear(to, (flags & MOTION) != 0 ? 40 : 16);
        if ((flags & POINTERS) != 0)
            Pointers(pointers).at[index] = to;
    }
    if (is_open && first == 0)
        Order(order).is_done = 1;
}
