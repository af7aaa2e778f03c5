// SPDX-License-Identifier: Apache-2.0
// Writes a value where it is told to.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

layout(local_size_x = 1) in;

layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Target
{
    uint value;
};

layout(push_constant) uniform Constants
{
    layout(offset = 16) uvec2 target;
    uint value;
};

void main()
{
    Target(target).value = value;
}
