// SPDX-License-Identifier: Apache-2.0
// Rays and answers, in the layout of src/compare/rays.h.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

const uint ROOM = 14;
const uint HIT = 1, AABB = 2, FRONT = 4;

struct Ray
{
    vec3 origin;
    float t_min;
    vec3 direction;
    float t_max;
};
struct Hit
{
    float t, u, v;
    uint kind, geometry, primitive, instance, spare;
};
struct Answer
{
    Hit closest;
    uint candidate_count;
    uint spare[7];
    Hit candidates[ROOM];
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rays
{
    Ray at[];
};
layout(buffer_reference, std430, buffer_reference_align = 16) buffer Answers
{
    Answer at[];
};

layout(push_constant) uniform Constants
{
    uvec2 rays, answers;
    uint count;
};
