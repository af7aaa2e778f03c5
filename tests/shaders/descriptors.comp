/* SPDX-License-Identifier: Apache-2.0 */
/* Writes the buffer of a descriptor, and knows no addresses. */
#version 460

layout(local_size_x = 1) in;

layout(set = 0, binding = 0, std430) buffer Results
{
    uint results[];
};

void main()
{
    results[0] = atomicAdd(results[1], 1);
}
