// SPDX-License-Identifier: Apache-2.0
// Traces a ray: for the nearest triangle, or for the distances of all, of which the nearest are kept in order.
#version 460
#extension GL_EXT_ray_query : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

layout(local_size_x = 64) in;
layout(set = 0, binding = 0) uniform accelerationStructureEXT top;

const uint MOST = 24; // ANSWER_MOST
const uint CLOSEST = 0;

struct Ray
{
    vec3 origin;
    float t_min;
    vec3 direction;
    float t_max;
};
struct Answer
{
    uint count;
    float t[MOST];
};
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rays
{
    Ray at[];
};
layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer Answers
{
    Answer at[];
};
layout(push_constant) uniform Constants
{
    uvec2 rays, answers;
    uint count, mode;
};

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count)
        return;
    Ray ray = Rays(rays).at[i];
    rayQueryEXT query;
    if (mode == CLOSEST) {
        rayQueryInitializeEXT(query, top, gl_RayFlagsOpaqueEXT, 0xff, ray.origin, ray.t_min, ray.direction, ray.t_max);
        while (rayQueryProceedEXT(query)) {
        }
        bool is_hit = rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionTriangleEXT;
        Answers(answers).at[i].count = is_hit ? 1 : 0;
        Answers(answers).at[i].t[0] = is_hit ? rayQueryGetIntersectionTEXT(query, true) : 0;
        return;
    }
    float t[MOST];
    uvec3 found[MOST]; // a driver may report a candidate more than once
    uint hits = 0;
    rayQueryInitializeEXT(query, top, gl_RayFlagsNoOpaqueEXT, 0xff, ray.origin, ray.t_min, ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
        if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT)
            continue;
        uvec3 which = uvec3(rayQueryGetIntersectionInstanceIdEXT(query, false),
                            rayQueryGetIntersectionGeometryIndexEXT(query, false),
                            rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        bool is_new = true;
        for (uint n = 0; n < min(hits, MOST); n++)
            is_new = is_new && found[n] != which;
        if (!is_new)
            continue;
        float distance = rayQueryGetIntersectionTEXT(query, false);
        uint place = min(hits, MOST);
        hits++;
        while (place > 0 && t[place - 1] > distance) {
            if (place < MOST) {
                t[place] = t[place - 1];
                found[place] = found[place - 1];
            }
            place--;
        }
        if (place < MOST) {
            t[place] = distance;
            found[place] = which;
        }
    }
    Answers(answers).at[i].count = hits;
    for (uint n = 0; n < min(hits, MOST); n++)
        Answers(answers).at[i].t[n] = t[n];
}
