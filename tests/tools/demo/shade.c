/* SPDX-License-Identifier: Apache-2.0 */
/* Shading on the CPU, as scene.comp does it. */
#include "shade.h"

#include <assert.h>

#include "layout.h"

static vec3 v3(float x, float y, float z)
{
    return (vec3){x, y, z, 0};
}

static vec3 all(float x)
{
    return v3(x, x, x);
}

static vec3 mix(vec3 a, vec3 b, float t)
{
    return a * (1 - t) + b * t;
}

static float fract(float x)
{
    return x - floorf(x);
}

static vec3 cross(vec3 a, vec3 b)
{
    return v3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static vec3 sun(void)
{
    return normalize(v3(-0.74f, 0.50f, 0.30f));
}

static vec3 sun_colour(void)
{
    return v3(3.1f, 2.65f, 2.05f);
}

#define SUN_SIZE 0.035f

/* ---- chance */

static uint32_t hash(uint32_t x)
{
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28) + 4u)) ^ x) * 277803737u;
    return (x >> 22) ^ x;
}

struct vec2 shade_chance(uint32_t pixel, uint32_t stream, uint32_t i)
{
    uint32_t h = hash(pixel * 4u + stream);
    return (struct vec2){fract((float)(h & 0xffffu) / 65536.0f + (float)i * 0.7548776662f),
                         fract((float)(h >> 16) / 65536.0f + (float)i * 0.5698402910f)};
}

vec3 shade_around(vec3 axis, struct vec2 u)
{
    float z = 1 - 2 * u.x;
    float r = sqrtf(fmaxf(0, 1 - z * z));
    float phi = 6.2831853f * u.y;
    return normalize(axis * 1.0001f + v3(r * cosf(phi), r * sinf(phi), z));
}

/* ---- spaces */

static void invert(const VkTransformMatrixKHR *transform, float inverse[3][3])
{
    const float(*m)[4] = transform->matrix;
    vec3 a = v3(m[0][0], m[0][1], m[0][2]), b = v3(m[1][0], m[1][1], m[1][2]);
    vec3 c = v3(m[2][0], m[2][1], m[2][2]);
    vec3 columns[3] = {cross(b, c), cross(c, a), cross(a, b)};
    float determinant = dot(a, columns[0]);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            inverse[row][column] = columns[column][row] / determinant;
}

void shade_scene_open(struct shade_scene *shading, const struct scene *scene)
{
    static_assert(LAYOUT_INSTANCE_COUNT <= 16, "room for the inverses");
    *shading = (struct shade_scene){
        .indices = scene->indices.data,
        .normals = scene->normals.data,
        .boxes = scene->boxes.data,
        .instances = scene->instances.data,
        .vertex_count = scene->vertex_count,
    };
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        invert(&shading->instances[i].transform, shading->inverse[i]);
}

vec3 shade_to_object(const struct shade_scene *shading, uint32_t instance, vec3 of, bool is_point)
{
    const float(*m)[4] = shading->instances[instance].transform.matrix;
    const float(*inverse)[3] = shading->inverse[instance];
    if (is_point)
        of -= v3(m[0][3], m[1][3], m[2][3]);
    vec3 to = all(0);
    for (int row = 0; row < 3; ++row)
        to[row] = dot(of, v3(inverse[row][0], inverse[row][1], inverse[row][2]));
    return to;
}

/* Normals take the inverse transposed. Turned to face the ray. */
static vec3 world_normal(const struct shade_scene *shading, const struct shade_meeting *meeting,
                         vec3 normal)
{
    const float(*inverse)[3] = shading->inverse[meeting->instance];
    vec3 to = all(0);
    for (int row = 0; row < 3; ++row)
        to += normal[row] * v3(inverse[row][0], inverse[row][1], inverse[row][2]);
    to = normalize(to);
    return dot(to, meeting->direction) > 0 ? -to : to;
}

/* ---- boxes */

static bool box_is_solid(uint32_t primitive)
{
    return primitive % 4 == 3;
}

static void box_corners(const struct shade_scene *shading, uint32_t primitive, vec3 *low,
                        vec3 *high)
{
    const VkAabbPositionsKHR *box = &shading->boxes[primitive];
    *low = v3(box->minX, box->minY, box->minZ);
    *high = v3(box->maxX, box->maxY, box->maxZ);
}

static bool meet_slabs(vec3 low, vec3 high, vec3 origin, vec3 direction, float *near, float *last)
{
    *near = -INFINITY;
    *last = INFINITY;
    for (int i = 0; i < 3; ++i) {
        float inverse = 1 / direction[i];
        float a = (low[i] - origin[i]) * inverse, b = (high[i] - origin[i]) * inverse;
        *near = fmaxf(*near, fminf(a, b));
        *last = fminf(*last, fmaxf(a, b));
    }
    return *near <= *last;
}

static bool meet_sphere(vec3 low, vec3 high, vec3 origin, vec3 direction, float *near, float *last)
{
    vec3 centre = 0.5f * (low + high);
    float radius = 0.5f * (high[0] - low[0]);
    float scale = dot(direction, direction);
    float towards = dot(centre - origin, direction) / scale;
    vec3 beside = origin + towards * direction - centre;
    float inside = (radius * radius - dot(beside, beside)) / scale;
    if (inside < 0)
        return false;
    *near = towards - sqrtf(inside);
    *last = towards + sqrtf(inside);
    return true;
}

float shade_box(const struct shade_scene *shading, uint32_t primitive, vec3 origin, vec3 direction)
{
    vec3 low, high;
    float near, last;
    box_corners(shading, primitive, &low, &high);
    if (!(box_is_solid(primitive) ? meet_slabs : meet_sphere)(low, high, origin, direction, &near,
                                                              &last))
        return -1;
    return near > 0 ? near : last;
}

static vec3 box_normal(const struct shade_scene *shading, uint32_t primitive, vec3 at)
{
    vec3 low, high;
    box_corners(shading, primitive, &low, &high);
    vec3 from_centre = at - 0.5f * (low + high);
    if (!box_is_solid(primitive))
        return from_centre;
    float largest =
        fmaxf(fabsf(from_centre[0]), fmaxf(fabsf(from_centre[1]), fabsf(from_centre[2])));
    vec3 normal = all(0);
    for (int i = 0; i < 3; ++i)
        if (fabsf(from_centre[i]) >= largest)
            normal[i] = from_centre[i] < 0 ? -1 : 1;
    return normal;
}

/* ---- surfaces */

struct surface shade_mesh(const struct shade_scene *shading, const struct shade_meeting *meeting)
{
    static const vec3 colours[5] = {{0.80f, 0.76f, 0.70f},
                                    {0.16f, 0.42f, 0.46f},
                                    {0.72f, 0.28f, 0.16f},
                                    {0.82f, 0.58f, 0.18f},
                                    {0.36f, 0.26f, 0.46f}};
    uint32_t custom = shading->instances[meeting->instance].instanceCustomIndex;
    uint32_t material = custom & 0xff,
             set = custom & LAYOUT_TWISTED_BIT ? shading->vertex_count : 0;
    const float weights[3] = {1 - meeting->u - meeting->v, meeting->u, meeting->v};
    vec3 normal = all(0);
    for (uint32_t corner = 0; corner < 3; ++corner) {
        uint32_t at = 3 * (set + shading->indices[3 * meeting->primitive + corner]);
        normal += weights[corner] *
                  v3(shading->normals[at], shading->normals[at + 1], shading->normals[at + 2]);
    }
    return (struct surface){.t = meeting->t,
                            .normal = world_normal(shading, meeting, normal),
                            .colour = colours[material < 4 ? material : 4],
                            .shine = 0.05f};
}

static vec3 field_colour(uint32_t primitive)
{
    float h = (float)(hash(primitive) & 0xffffu) / 65536.0f;
    vec3 warm = mix(v3(0.85f, 0.55f, 0.20f), v3(0.75f, 0.22f, 0.14f), fract(h * 7));
    vec3 cool = mix(v3(0.12f, 0.36f, 0.44f), v3(0.60f, 0.68f, 0.64f), fract(h * 13));
    return h < 0.45f ? warm : cool;
}

struct surface shade_field(const struct shade_scene *shading, const struct shade_meeting *meeting)
{
    vec3 origin = shade_to_object(shading, meeting->instance, meeting->origin, true);
    vec3 direction = shade_to_object(shading, meeting->instance, meeting->direction, false);
    vec3 normal = box_normal(shading, meeting->primitive, origin + meeting->t * direction);
    return (struct surface){.t = meeting->t,
                            .normal = world_normal(shading, meeting, normal),
                            .colour = field_colour(meeting->primitive),
                            .shine = box_is_solid(meeting->primitive) ? 0.03f : 0.08f};
}

void shade_plain(vec3 origin, vec3 direction, struct surface *hit)
{
    float plain = direction[1] < 0 ? -origin[1] / direction[1] : -1;
    if (plain > 0 && (hit->t < 0 || plain < hit->t))
        *hit = (struct surface){
            .t = plain, .normal = v3(0, 1, 0), .colour = v3(0.55f, 0.50f, 0.44f), .shine = 0};
}

/* ---- light */

vec3 shade_to_sun(struct vec2 u)
{
    return normalize(sun() + SUN_SIZE * (shade_around(sun(), u) - sun()));
}

vec3 shade_sky(vec3 direction)
{
    float up = fminf(fmaxf(direction[1], 0), 1);
    vec3 colour = mix(v3(0.72f, 0.56f, 0.42f), v3(0.12f, 0.28f, 0.56f), powf(up, 0.55f));
    return colour + sun_colour() * 0.25f * powf(fmaxf(dot(direction, sun()), 0), 24);
}

vec3 shade_lit(const struct surface *hit, vec3 direction, const struct shade_light *from)
{
    vec3 light = from->in_sun ? sun_colour() * from->facing : all(0);
    if (from->around[1] < 0)
        light += v3(0.34f, 0.28f, 0.22f); /* from the sunlit plain */
    else if (from->in_open)
        light += shade_sky(from->around) * 0.85f;
    else
        light += v3(0.06f, 0.05f, 0.045f);
    vec3 colour = hit->colour * light * 0.5f;
    float haze = 1 - expf(-fmaxf(hit->t - 9, 0) * 0.035f);
    return mix(colour, shade_sky(v3(direction[0], 0, direction[2])), haze);
}

float shade_mirror(const struct surface *hit, vec3 direction)
{
    float grazing = powf(1 - fmaxf(-dot(hit->normal, direction), 0), 5);
    return hit->shine > 0 ? hit->shine + (0.5f - hit->shine) * grazing : 0;
}

/* ---- camera */

vec3 shade_camera(void)
{
    return v3(0, 1.85f, 7.2f);
}

vec3 shade_camera_ray(float x, float y, uint32_t width, uint32_t height)
{
    vec3 forward = normalize(v3(0, -1.05f, -7.2f));
    vec3 right = normalize(cross(forward, v3(0, 1, 0)));
    vec3 up = cross(right, forward);
    float across = (2 * x - (float)width) / (float)height * 0.30f;
    float down = (2 * y - (float)height) / (float)height * 0.30f;
    return normalize(forward + across * right - down * up);
}

uint32_t shade_encode(vec3 colour)
{
    uint32_t pixel = 0xff000000u;
    colour = colour * (2.51f * colour + 0.03f) / (colour * (2.43f * colour + 0.59f) + 0.14f);
    for (int i = 0; i < 3; ++i) {
        float value = powf(fminf(fmaxf(colour[i], 0), 1), 1 / 2.2f);
        pixel |= (uint32_t)lrintf(value * 255) << 8 * i;
    }
    return pixel;
}
