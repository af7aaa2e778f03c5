/* SPDX-License-Identifier: Apache-2.0 */
/* Shades a pixel with ray queries: meshes, spheres and boxes on a plain under a low sun. */
#version 460
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform accelerationStructureEXT top;
layout(set = 0, binding = 1, std430) writeonly buffer Pixels { uint pixels[]; };
layout(set = 0, binding = 2, std430) readonly buffer Indices { uint indices[]; };
layout(set = 0, binding = 3, std430) readonly buffer Normals { float normals[]; };
layout(set = 0, binding = 4, std430) readonly buffer Boxes { float boxes[]; };
layout(push_constant) uniform Push {
    uint width;
    uint height;
    uint vertex_count;
    uint grid; /* grid x grid samples a pixel */
}
push;

#define FUNCTION
#define struct_surface surface
#define struct_light light
#include "shading.glsl"

void box_corners(uint primitive, out vec3 low, out vec3 high) {
    uint at = 6u * primitive;
    low = vec3(boxes[at], boxes[at + 1u], boxes[at + 2u]);
    high = vec3(boxes[at + 3u], boxes[at + 4u], boxes[at + 5u]);
}

/* ---- rays */

vec3 mesh_normal(uint primitive, uint custom, vec2 bary) {
    uint set = (custom & TWISTED_BIT) != 0u ? push.vertex_count : 0u;
    vec3 sum = vec3(0.0);
    vec3 weights = vec3(1.0 - bary.x - bary.y, bary);
    for (uint corner = 0u; corner < 3u; ++corner) {
        uint at = 3u * (set + indices[3u * primitive + corner]);
        sum += weights[corner] * vec3(normals[at], normals[at + 1u], normals[at + 2u]);
    }
    return sum;
}

/* The nearest surface up to `limit`; with `any`, whichever is found first, not described. */
bool trace(vec3 origin, vec3 direction, float limit, bool any, out surface hit) {
    hit = surface(-1.0, vec3(0.0), vec3(0.0), 0.0);
    rayQueryEXT query;
    uint flags = any ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT;
    rayQueryInitializeEXT(query, top, flags, 0xFF, origin, 0.0, direction, limit);
    while (rayQueryProceedEXT(query)) {
        if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionAABBEXT)
            continue;
        uint box = uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        vec3 low, high;
        box_corners(box, low, high);
        float t = box_intersect(box_is_solid(box), low, high,
                                rayQueryGetIntersectionObjectRayOriginEXT(query, false),
                                rayQueryGetIntersectionObjectRayDirectionEXT(query, false));
        float nearest = limit;
        if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT)
            nearest = rayQueryGetIntersectionTEXT(query, true);
        if (t > 0.0 && t < nearest)
            rayQueryGenerateIntersectionEXT(query, t);
    }
    uint type = rayQueryGetIntersectionTypeEXT(query, true);
    if (type == gl_RayQueryCommittedIntersectionNoneEXT)
        return false;
    if (any)
        return true;

    hit.t = rayQueryGetIntersectionTEXT(query, true);
    uint primitive = uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    vec3 normal;
    if (type == gl_RayQueryCommittedIntersectionTriangleEXT) {
        uint custom = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true));
        vec2 bary = rayQueryGetIntersectionBarycentricsEXT(query, true);
        normal = mesh_normal(primitive, custom, bary);
        hit.colour = mesh_colour(custom & 0xffu);
        hit.shine = 0.05;
    } else {
        vec3 at = rayQueryGetIntersectionObjectRayOriginEXT(query, true) +
                  hit.t * rayQueryGetIntersectionObjectRayDirectionEXT(query, true);
        vec3 low, high;
        box_corners(primitive, low, high);
        normal = box_normal(box_is_solid(primitive), low, high, at);
        hit.colour = field_colour(primitive);
        hit.shine = field_shine(primitive);
    }
    /* Normals take the inverse transposed: the row vector on the left of world-to-object. */
    hit.normal = normalize(normal * mat3(rayQueryGetIntersectionWorldToObjectEXT(query, true)));
    if (dot(hit.normal, direction) > 0.0)
        hit.normal = -hit.normal;
    return true;
}

bool is_hidden(vec3 origin, vec3 direction, float limit) {
    surface unused;
    return trace(origin, direction, limit, true, unused);
}

/* ---- light */

/* What a camera ray or a mirrored one meets, the plain included. */
surface look(vec3 origin, vec3 direction) {
    surface hit;
    trace(origin, direction, FAR, false, hit);
    float plain = direction.y < 0.0 ? -origin.y / direction.y : -1.0;
    if (plain > 0.0 && (hit.t < 0.0 || plain < hit.t))
        hit = surface(plain, vec3(0.0, 1.0, 0.0), vec3(0.55, 0.50, 0.44), 0.0);
    return hit;
}

vec3 shade(surface hit, vec3 at, vec3 direction, vec2 u_sun, vec2 u_sky) {
    vec3 above = at + hit.normal * 2e-3;
    vec3 sunwards = to_sun(u_sun);
    light from;
    from.facing = max(dot(hit.normal, sunwards), 0.0);
    from.in_sun = from.facing > 0.0 && !is_hidden(above, sunwards, FAR);
    from.around = cosine_direction(hit.normal, u_sky);
    from.in_open = from.around.y >= 0.0 && !is_hidden(above, from.around, REACH);
    return lit(hit, direction, from);
}

vec3 radiance(vec3 origin, vec3 direction, uint pixel, uint i) {
    vec3 sum = vec3(0.0);
    float weight = 1.0;
    for (uint bounce = 0u; bounce < 2u; ++bounce) {
        surface hit = look(origin, direction);
        if (hit.t < 0.0)
            return sum + weight * sky(direction);
        vec3 at = origin + hit.t * direction;
        float mirror = bounce == 1u ? 0.0 : mirror_share(hit, direction);
        vec2 u_sun = chance(pixel, 2u * bounce, i);
        vec2 u_sky = chance(pixel, 2u * bounce + 1u, i);
        sum += weight * (1.0 - mirror) * shade(hit, at, direction, u_sun, u_sky);
        weight *= mirror;
        if (weight < 0.01)
            return sum;
        origin = at + hit.normal * 2e-3;
        direction = reflect(direction, hit.normal);
    }
    return sum;
}

/* ---- the picture */

uint encode(vec3 colour) {
    colour = colour * (2.51 * colour + 0.03) / (colour * (2.43 * colour + 0.59) + 0.14);
    colour = pow(clamp(colour, 0.0, 1.0), vec3(1.0 / 2.2));
    return packUnorm4x8(vec4(colour, 1.0));
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= push.width || at.y >= push.height)
        return;
    uint pixel = at.y * push.width + at.x;

    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < push.grid * push.grid; ++i) {
        vec2 within = (vec2(i % push.grid, i / push.grid) + 0.5) / float(push.grid);
        vec2 place = vec2(at) + within;
        vec3 direction = camera_ray(place.x, place.y, push.width, push.height);
        sum += radiance(CAMERA, direction, pixel, i);
    }
    pixels[pixel] = encode(sum / float(push.grid * push.grid));
}
