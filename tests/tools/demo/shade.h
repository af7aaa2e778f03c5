/* SPDX-License-Identifier: Apache-2.0 */
/* scene.comp once more, in C: what it computes beside rays. Same names, same order. */
#ifndef DEMO_SHADE_H
#define DEMO_SHADE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "scene.h"

#define SHADE_FAR 1e4f
#define SHADE_REACH 1.6f

/* Lanes 0 to 2; the compiler's vectors have no name without a typedef. */
typedef float vec3 __attribute__((vector_size(16)));

static inline float dot(vec3 a, vec3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline vec3 normalize(vec3 a)
{
    return a / sqrtf(dot(a, a));
}

struct surface {
    float t; /* negative: the sky */
    vec3 normal;
    vec3 colour;
    float shine;
};

/* What shading reads, with the inverse of each instance's transform. */
struct shade_scene {
    const uint32_t *indices;
    const float *normals;
    const VkAabbPositionsKHR *boxes;
    const VkAccelerationStructureInstanceKHR *instances;
    float inverse[16][3][3];
    uint32_t vertex_count;
};
void shade_scene_open(struct shade_scene *shading, const struct scene *scene);

/* The point or the direction in an instance's space. */
vec3 shade_to_object(const struct shade_scene *shading, uint32_t instance, vec3 of, bool is_point);

/* The nearest distance along the ray, in the box's space, that is above zero, or -1. */
float shade_box(const struct shade_scene *shading, uint32_t primitive, vec3 origin, vec3 direction);

/* The surfaces that a ray met, described; both face it. */
struct shade_meeting {
    vec3 origin, direction;
    uint32_t instance, primitive;
    float t, u, v;
};
struct surface shade_mesh(const struct shade_scene *shading, const struct shade_meeting *meeting);
struct surface shade_field(const struct shade_scene *shading, const struct shade_meeting *meeting);
/* The plain where it is nearer. */
void shade_plain(vec3 origin, vec3 direction, struct surface *hit);

struct vec2 {
    float x, y;
};
struct vec2 shade_chance(uint32_t pixel, uint32_t stream, uint32_t i);
vec3 shade_to_sun(struct vec2 u);
vec3 shade_around(vec3 axis, struct vec2 u);
vec3 shade_sky(vec3 direction);

/* Light that came to a surface: of the sun, if it isn't hidden, and from around. */
struct shade_light {
    float facing; /* the sun */
    bool in_sun, in_open;
    vec3 around;
};
vec3 shade_lit(const struct surface *hit, vec3 direction, const struct shade_light *from);
float shade_mirror(const struct surface *hit, vec3 direction);

vec3 shade_camera(void);
vec3 shade_camera_ray(float x, float y, uint32_t width, uint32_t height);
uint32_t shade_encode(vec3 colour);

#endif
