// SPDX-License-Identifier: Apache-2.0
// Traces a ray: first for the nearest triangle, then for all candidates, of which none is committed,
// so that all triangles at a shared edge are recorded.
#version 460
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require
#include "data.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform accelerationStructureEXT top;
void trace_closest(uint i, Ray ray)
{
    Hit hit = Hit(0, 0, 0, 0, 0, 0, 0, 0);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top, gl_RayFlagsOpaqueEXT, 0xff, ray.origin, ray.t_min,
                          ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
    }
    if (rayQueryGetIntersectionTypeEXT(query, true) ==
        gl_RayQueryCommittedIntersectionTriangleEXT) {
        vec2 at = rayQueryGetIntersectionBarycentricsEXT(query, true);
        hit.t = rayQueryGetIntersectionTEXT(query, true);
        hit.u = at.x;
        hit.v = at.y;
        hit.kind = HIT | (rayQueryGetIntersectionFrontFaceEXT(query, true) ? FRONT : 0);
        hit.geometry = rayQueryGetIntersectionGeometryIndexEXT(query, true);
        hit.primitive = rayQueryGetIntersectionPrimitiveIndexEXT(query, true);
        hit.instance = rayQueryGetIntersectionInstanceIdEXT(query, true);
    }
    Answers(answers).at[i].closest = hit;
}

// Returns whether a candidate is recorded already: a driver may report it more than once.
bool is_recorded(uint i, uint count, Hit hit)
{
    for (uint j = 0; j < min(count, ROOM); j++) {
        Hit other = Answers(answers).at[i].candidates[j];
        if (other.geometry == hit.geometry && other.primitive == hit.primitive &&
            other.instance == hit.instance)
            return true;
    }
    return false;
}

void trace_candidates(uint i, Ray ray)
{
    uint count = 0;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top, gl_RayFlagsNoOpaqueEXT, 0xff, ray.origin, ray.t_min,
                          ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
        Hit hit = Hit(0, 0, 0, HIT | AABB, 0, 0, 0, 0);
        hit.geometry = rayQueryGetIntersectionGeometryIndexEXT(query, false);
        hit.primitive = rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        hit.instance = rayQueryGetIntersectionInstanceIdEXT(query, false);
        if (rayQueryGetIntersectionTypeEXT(query, false) ==
            gl_RayQueryCandidateIntersectionTriangleEXT) {
            vec2 at = rayQueryGetIntersectionBarycentricsEXT(query, false);
            hit.t = rayQueryGetIntersectionTEXT(query, false);
            hit.u = at.x;
            hit.v = at.y;
            hit.kind = HIT | (rayQueryGetIntersectionFrontFaceEXT(query, false) ? FRONT : 0);
        }
        if (is_recorded(i, count, hit))
            continue;
        if (count < ROOM)
            Answers(answers).at[i].candidates[count] = hit;
        count++;
    }
    Answers(answers).at[i].candidate_count = count;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count)
        return;
    Ray ray = Rays(rays).at[i];
    trace_closest(i, ray);
    trace_candidates(i, ray);
}
