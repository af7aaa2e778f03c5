/* SPDX-License-Identifier: Apache-2.0 */
/* Shades a pixel with ray queries: meshes, spheres and boxes on a plain under a low sun. */
#version 460
#extension GL_EXT_ray_query : require

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

const float far = 1e4;
const float reach = 1.6; /* of rays that look for what is close by */
const uint twisted_bit = 0x100;
const vec3 sun = normalize(vec3(-0.74, 0.50, 0.30));
const vec3 sun_colour = vec3(3.1, 2.65, 2.05);
const float sun_size = 0.035;

/* ---- chance: a low-discrepancy sequence, turned by a hash a pixel */

uint hash(uint x) {
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
    return (x >> 22) ^ x;
}

vec2 chance(uint pixel, uint stream, uint i) {
    uint h = hash(pixel * 4u + stream);
    vec2 turn = vec2(float(h & 0xffffu), float(h >> 16)) / 65536.0;
    return fract(turn + float(i) * vec2(0.7548776662, 0.5698402910));
}

/* A direction around `axis`, as likely as its cosine. */
vec3 cosine_direction(vec3 axis, vec2 u) {
    float z = 1.0 - 2.0 * u.x;
    float r = sqrt(max(0.0, 1.0 - z * z));
    float phi = 6.2831853 * u.y;
    return normalize(axis * 1.0001 + vec3(r * cos(phi), r * sin(phi), z));
}

/* ---- boxes: most hold a sphere, some are solid */

bool box_is_solid(uint primitive) { return primitive % 4u == 3u; }

void box_corners(uint primitive, out vec3 low, out vec3 high) {
    uint at = 6u * primitive;
    low = vec3(boxes[at], boxes[at + 1u], boxes[at + 2u]);
    high = vec3(boxes[at + 3u], boxes[at + 4u], boxes[at + 5u]);
}

/* The nearest distance along the ray that is above zero, or -1. */
float box_intersect(uint primitive, vec3 origin, vec3 direction) {
    vec3 low, high;
    box_corners(primitive, low, high);
    float near, last;
    if (box_is_solid(primitive)) {
        vec3 inverse = 1.0 / direction;
        vec3 a = (low - origin) * inverse;
        vec3 b = (high - origin) * inverse;
        vec3 first = min(a, b);
        vec3 second = max(a, b);
        near = max(first.x, max(first.y, first.z));
        last = min(second.x, min(second.y, second.z));
        if (near > last)
            return -1.0;
    } else {
        vec3 centre = 0.5 * (low + high);
        float radius = 0.5 * (high.x - low.x);
        float scale = dot(direction, direction);
        float towards = dot(centre - origin, direction) / scale;
        vec3 beside = origin + towards * direction - centre;
        float inside = (radius * radius - dot(beside, beside)) / scale;
        if (inside < 0.0)
            return -1.0;
        near = towards - sqrt(inside);
        last = towards + sqrt(inside);
    }
    return near > 0.0 ? near : last;
}

vec3 box_normal(uint primitive, vec3 at) {
    vec3 low, high;
    box_corners(primitive, low, high);
    vec3 from_centre = at - 0.5 * (low + high);
    if (!box_is_solid(primitive))
        return from_centre;
    vec3 part = abs(from_centre);
    float largest = max(part.x, max(part.y, part.z));
    return sign(from_centre) * vec3(greaterThanEqual(part, vec3(largest)));
}

/* ---- rays */

struct surface {
    float t; /* negative: the sky */
    vec3 normal;
    vec3 colour;
    float shine;
};

vec3 mesh_colour(uint material) {
    const vec3 colours[5] =
        vec3[](vec3(0.80, 0.76, 0.70), vec3(0.16, 0.42, 0.46), vec3(0.72, 0.28, 0.16),
               vec3(0.82, 0.58, 0.18), vec3(0.36, 0.26, 0.46));
    return colours[min(material, 4u)];
}

vec3 field_colour(uint primitive) {
    float h = float(hash(primitive) & 0xffffu) / 65536.0;
    vec3 warm = mix(vec3(0.85, 0.55, 0.20), vec3(0.75, 0.22, 0.14), fract(h * 7.0));
    vec3 cool = mix(vec3(0.12, 0.36, 0.44), vec3(0.60, 0.68, 0.64), fract(h * 13.0));
    return h < 0.45 ? warm : cool;
}

vec3 mesh_normal(uint primitive, uint custom, vec2 bary) {
    uint set = (custom & twisted_bit) != 0u ? push.vertex_count : 0u;
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
        float t = box_intersect(uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false)),
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
        normal = box_normal(primitive, at);
        hit.colour = field_colour(primitive);
        hit.shine = box_is_solid(primitive) ? 0.03 : 0.08;
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

vec3 sky(vec3 direction) {
    float up = clamp(direction.y, 0.0, 1.0);
    vec3 colour = mix(vec3(0.72, 0.56, 0.42), vec3(0.12, 0.28, 0.56), pow(up, 0.55));
    return colour + sun_colour * 0.25 * pow(max(dot(direction, sun), 0.0), 24.0);
}

/* What a camera ray or a mirrored one meets, the plain included. */
surface look(vec3 origin, vec3 direction) {
    surface hit;
    trace(origin, direction, far, false, hit);
    float plain = direction.y < 0.0 ? -origin.y / direction.y : -1.0;
    if (plain > 0.0 && (hit.t < 0.0 || plain < hit.t))
        hit = surface(plain, vec3(0.0, 1.0, 0.0), vec3(0.55, 0.50, 0.44), 0.0);
    return hit;
}

vec3 shade(surface hit, vec3 at, vec3 direction, vec2 u_sun, vec2 u_sky) {
    vec3 above = at + hit.normal * 2e-3;
    vec3 to_sun = normalize(sun + sun_size * (cosine_direction(sun, u_sun) - sun));
    float facing = max(dot(hit.normal, to_sun), 0.0);
    vec3 light = vec3(0.0);
    if (facing > 0.0 && !is_hidden(above, to_sun, far))
        light += sun_colour * facing;

    vec3 around = cosine_direction(hit.normal, u_sky);
    if (around.y < 0.0)
        light += vec3(0.34, 0.28, 0.22); /* from the sunlit plain */
    else if (!is_hidden(above, around, reach))
        light += sky(around) * 0.85;
    else
        light += vec3(0.06, 0.05, 0.045);

    vec3 colour = hit.colour * light * 0.5;
    /* Far ground fades into the horizon. */
    float haze = 1.0 - exp(-max(hit.t - 9.0, 0.0) * 0.035);
    return mix(colour, sky(vec3(direction.x, 0.0, direction.z)), haze);
}

vec3 radiance(vec3 origin, vec3 direction, uint pixel, uint i) {
    vec3 sum = vec3(0.0);
    float weight = 1.0;
    for (uint bounce = 0u; bounce < 2u; ++bounce) {
        surface hit = look(origin, direction);
        if (hit.t < 0.0)
            return sum + weight * sky(direction);
        vec3 at = origin + hit.t * direction;
        float grazing = pow(1.0 - max(-dot(hit.normal, direction), 0.0), 5.0);
        float mirror = hit.shine > 0.0 ? hit.shine + (0.5 - hit.shine) * grazing : 0.0;
        if (bounce == 1u)
            mirror = 0.0;
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

/* ---- camera */

vec3 camera_ray(vec2 at) {
    const vec3 eye_to_target = vec3(0.0, -1.05, -7.2);
    vec3 forward = normalize(eye_to_target);
    vec3 right = normalize(cross(forward, vec3(0.0, 1.0, 0.0)));
    vec3 up = cross(right, forward);
    vec2 size = vec2(push.width, push.height);
    vec2 plane = (2.0 * at - size) / size.y * 0.30;
    return normalize(forward + plane.x * right - plane.y * up);
}

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
        sum += radiance(vec3(0.0, 1.85, 7.2), camera_ray(vec2(at) + within), pixel, i);
    }
    pixels[pixel] = encode(sum / float(push.grid * push.grid));
}
