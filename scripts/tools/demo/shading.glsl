/* SPDX-License-Identifier: Apache-2.0 */
/* Shading, in the words that GLSL (scene.comp) and C (shade.h) have in common. Both define FUNCTION;
 * what GLSL has of vectors, shade.h has, too. */

#define FAR 1e4f
#define REACH 1.6f /* of rays that look for what is close by */
#define TWISTED_BIT 0x100u
#define SUN normalize(vec3(-0.74f, 0.50f, 0.30f))
#define SUN_COLOUR vec3(3.1f, 2.65f, 2.05f)
#define SUN_SIZE 0.035f
#define CAMERA vec3(0.0f, 1.85f, 7.2f)

struct surface {
    float t; /* negative: the sky */
    vec3 normal;
    vec3 colour;
    float shine;
};

/* Light that comes to a surface: of the sun, unless it is hidden, and from around. */
struct light {
    float facing; /* the sun */
    bool in_sun;
    bool in_open;
    vec3 around;
};

/* ---- chance: a low-discrepancy sequence, turned by a hash a pixel */

FUNCTION uint hash(uint x)
{
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
    return (x >> 22) ^ x;
}

FUNCTION vec2 chance(uint pixel, uint stream, uint i)
{
    uint h = hash(pixel * 4u + stream);
    float low = h & 0xffffu;
    float high = h >> 16;
    float at = i;
    return vec2(fract(low / 65536.0f + at * 0.7548776662f),
                fract(high / 65536.0f + at * 0.5698402910f));
}

/* A direction around `axis`, as likely as its cosine. */
FUNCTION vec3 cosine_direction(vec3 axis, vec2 u)
{
    float z = 1.0f - 2.0f * u[0];
    float r = sqrt(max(0.0f, 1.0f - z * z));
    float phi = 6.2831853f * u[1];
    return normalize(axis * 1.0001f + vec3(r * cos(phi), r * sin(phi), z));
}

/* ---- boxes: most hold a sphere, some are solid */

FUNCTION bool box_is_solid(uint primitive)
{
    return primitive % 4u == 3u;
}

/* The nearest distance along the ray that is above zero, or -1. */
FUNCTION float box_intersect(bool is_solid, vec3 low, vec3 high, vec3 origin, vec3 direction)
{
    float near = -1e30f;
    float last = 1e30f;
    if (is_solid) {
        for (int i = 0; i < 3; ++i) {
            float inverse = 1.0f / direction[i];
            float a = (low[i] - origin[i]) * inverse;
            float b = (high[i] - origin[i]) * inverse;
            near = max(near, min(a, b));
            last = min(last, max(a, b));
        }
        if (near > last)
            return -1.0f;
    } else {
        vec3 centre = 0.5f * (low + high);
        float radius = 0.5f * (high[0] - low[0]);
        float scale = dot(direction, direction);
        float towards = dot(centre - origin, direction) / scale;
        vec3 beside = origin + towards * direction - centre;
        float inside = (radius * radius - dot(beside, beside)) / scale;
        if (inside < 0.0f)
            return -1.0f;
        near = towards - sqrt(inside);
        last = towards + sqrt(inside);
    }
    return near > 0.0f ? near : last;
}

FUNCTION vec3 box_normal(bool is_solid, vec3 low, vec3 high, vec3 at)
{
    vec3 from_centre = at - 0.5f * (low + high);
    if (!is_solid)
        return from_centre;
    vec3 normal = vec3(0.0f, 0.0f, 0.0f);
    float largest = 0.0f;
    for (int i = 0; i < 3; ++i)
        largest = max(largest, max(from_centre[i], -from_centre[i]));
    for (int i = 0; i < 3; ++i)
        if (max(from_centre[i], -from_centre[i]) >= largest)
            normal[i] = from_centre[i] < 0.0f ? -1.0f : 1.0f;
    return normal;
}

/* ---- colours */

FUNCTION vec3 mesh_colour(uint material)
{
    vec3 colours[5];
    colours[0] = vec3(0.80f, 0.76f, 0.70f);
    colours[1] = vec3(0.16f, 0.42f, 0.46f);
    colours[2] = vec3(0.72f, 0.28f, 0.16f);
    colours[3] = vec3(0.82f, 0.58f, 0.18f);
    colours[4] = vec3(0.36f, 0.26f, 0.46f);
    return colours[material < 4u ? material : 4u];
}

FUNCTION vec3 field_colour(uint primitive)
{
    float low = hash(primitive) & 0xffffu;
    float h = low / 65536.0f;
    vec3 warm = mix(vec3(0.85f, 0.55f, 0.20f), vec3(0.75f, 0.22f, 0.14f), fract(h * 7.0f));
    vec3 cool = mix(vec3(0.12f, 0.36f, 0.44f), vec3(0.60f, 0.68f, 0.64f), fract(h * 13.0f));
    return h < 0.45f ? warm : cool;
}

FUNCTION float field_shine(uint primitive)
{
    return box_is_solid(primitive) ? 0.03f : 0.08f;
}

/* ---- light */

FUNCTION vec3 to_sun(vec2 u)
{
    return normalize(SUN + SUN_SIZE * (cosine_direction(SUN, u) - SUN));
}

FUNCTION vec3 sky(vec3 direction)
{
    float up = min(max(direction[1], 0.0f), 1.0f);
    vec3 colour = mix(vec3(0.72f, 0.56f, 0.42f), vec3(0.12f, 0.28f, 0.56f), pow(up, 0.55f));
    return colour + SUN_COLOUR * 0.25f * pow(max(dot(direction, SUN), 0.0f), 24.0f);
}

FUNCTION vec3 lit(struct_surface hit, vec3 direction, struct_light from)
{
    vec3 light = vec3(0.0f, 0.0f, 0.0f);
    if (from.in_sun)
        light = SUN_COLOUR * from.facing;
    if (from.around[1] < 0.0f)
        light += vec3(0.34f, 0.28f, 0.22f); /* from the sunlit plain */
    else if (from.in_open)
        light += sky(from.around) * 0.85f;
    else
        light += vec3(0.06f, 0.05f, 0.045f);
    vec3 colour = hit.colour * light * 0.5f;
    /* Far ground fades into the horizon. */
    float haze = 1.0f - exp(-max(hit.t - 9.0f, 0.0f) * 0.035f);
    return mix(colour, sky(vec3(direction[0], 0.0f, direction[2])), haze);
}

FUNCTION float mirror_share(struct_surface hit, vec3 direction)
{
    float grazing = pow(1.0f - max(-dot(hit.normal, direction), 0.0f), 5.0f);
    return hit.shine > 0.0f ? hit.shine + (0.5f - hit.shine) * grazing : 0.0f;
}

/* ---- camera */

FUNCTION vec3 camera_ray(float x, float y, float width, float height)
{
    vec3 forward = normalize(vec3(0.0f, -1.05f, -7.2f));
    vec3 right = normalize(cross(forward, vec3(0.0f, 1.0f, 0.0f)));
    vec3 up = cross(right, forward);
    float across = (2.0f * x - width) / height * 0.30f;
    float down = (2.0f * y - height) / height * 0.30f;
    return normalize(forward + across * right - down * up);
}
