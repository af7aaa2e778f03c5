// SPDX-License-Identifier: Apache-2.0
// Copies the elements to which an array of device addresses points, as a build would read them. If
// an address lies outside all readable ranges of memory, its element becomes zeros: an inactive
// instance.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

layout(local_size_x = 64) in;

layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer Addresses
{
    uvec2 at[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Ranges
{
    uvec4 at[]; // begin and end
};
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Source
{
    uint at[];
};
layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Target
{
    uint at[];
};

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Gate
{
    uint is_open;
};

layout(push_constant) uniform Constants
{
    uvec2 gate, addresses, ranges, target;
    uint count, range_count;
    uint words; // words of an element; of the largest one if elements have types
    uint typed; // whether the low 4 bits of an address are a VkAccelerationStructureMotionInstanceTypeNV
    uint first, stride; // of the addresses among words of 8 bytes
    uint parts;         // consecutive elements behind each address
    uint reserved;
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

// Whether all of an element lies in one range. Ranges are in ascending order, and do not touch.
bool is_readable(uvec2 address, uint words)
{
    Ranges sorted = Ranges(ranges);
    uint low = 0, high = range_count;
    while (low < high) {
        uint middle = (low + high) / 2;
        if (is_at_most(sorted.at[middle].xy, address))
            low = middle + 1;
        else
            high = middle;
    }
    return low > 0 && (address.x & 3) == 0 &&
           is_at_most(plus(address, words * 4), sorted.at[low - 1].zw);
}

// Words of static, matrix and SRT motion instances.
uint words_of(uint type)
{
    return type == 0 ? 16 : type == 1 ? 28 : type == 2 ? 36 : 0;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count || Gate(gate).is_open == 0) // src/snapshots/recording.h
        return;
    uvec2 address = Addresses(addresses).at[first + i / parts * stride];
    uint there = words;
    if (typed != 0) {
        there = words_of(address.x & 15);
        address.x &= ~15;
    }
    address = plus(address, i % parts * words * 4);
    if (!is_readable(address, there))
        there = 0;
    for (uint word = 0; word < words; word++)
        Target(target).at[i * words + word] = word < there ? Source(address).at[word] : 0;
}
