// SPDX-License-Identifier: Apache-2.0
// Copies bytes between device addresses: one workgroup for each copy order. A source may have any
// alignment. The shader only reads words that contain a byte of the source.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

layout(local_size_x = 128) in; // the most that each device supports

struct CopyOrder { // struct copy_order of recorded_build.h
    uvec2 source, target, left;
    uint size, is_done;
};
layout(buffer_reference, std430, buffer_reference_align = 8) buffer CopyOrders
{
    CopyOrder at[];
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
    uvec2 gate, orders;
};

void main()
{
    if (Gate(gate).is_open == 0) // src/snapshots/recording.h
        return;
    CopyOrder order = CopyOrders(orders).at[gl_WorkGroupID.x];
    uint size = order.left.y != 0 || order.left.x > order.size ? order.size : order.left.x;
    uint skipped = order.source.x & 3; // bytes of the first word in front of the source
    uint end = skipped + size;
    Source source = Source(uvec2(order.source.x - skipped, order.source.y));
    Target target = Target(order.target);
    for (uint word = gl_LocalInvocationID.x; word * 4 < size; word += gl_WorkGroupSize.x) {
        uint value = source.at[word] >> (8 * skipped);
        if (skipped != 0 && (word + 1) * 4 < end)
            value |= source.at[word + 1] << (8 * (4 - skipped));
        target.at[word] = value;
    }
    memoryBarrierBuffer();
    barrier();
    if (gl_LocalInvocationID.x == 0)
        CopyOrders(orders).at[gl_WorkGroupID.x].is_done = 1;
}
