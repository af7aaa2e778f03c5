/* SPDX-License-Identifier: Apache-2.0 */
/* Accesses memory through an address, in the way that a definition names. Each variant writes a
 * buffer of a descriptor. */
#version 460
#extension GL_EXT_buffer_reference : require

layout(local_size_x = 1) in;

layout(buffer_reference) buffer Node;
layout(buffer_reference, std430, buffer_reference_align = 16) buffer Node
{
    uint values[4];
    Node next;
};

layout(set = 0, binding = 0, std430) buffer Results
{
    uint results[];
};

#ifdef TEXELS
layout(set = 0, binding = 1, rgba8) uniform writeonly imageBuffer texels;
#endif

layout(push_constant, std430) uniform Constants
{
    Node first;
    uint count;
};

uint sum_of(Node node)
{
    uint sum = 0;
    for (uint i = 0; i < count; i++) {
        sum += node.values[i & 3];
        node = sum > 7 ? node : node.next;
    }
    return sum;
}

void write(Node node)
{
    node.values[1] = count;
}

void main()
{
    Node chosen = first;
    for (uint i = 0; i < count; i++)
        chosen = chosen.next;
#ifdef READS
    results[0] = sum_of(chosen);
#endif
#ifdef STORES
    chosen.values[count & 3] = 1;
#endif
#ifdef CALLS
    write(chosen);
#endif
#ifdef COUNTS
    results[1] = atomicAdd(chosen.values[0], 1);
#endif
#ifdef LINKS
    chosen.next = first;
#endif
#ifdef TEXELS
    imageStore(texels, 0, vec4(1));
#endif
    results[2] = count;
}
