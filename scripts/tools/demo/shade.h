/* SPDX-License-Identifier: Apache-2.0 */
/* What scene.comp computes beside rays, in C. */
#ifndef DEMO_SHADE_H
#define DEMO_SHADE_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h> /* uint */
#include <tgmath.h>

#include "scene.h"

/* ---- what shading.glsl has of GLSL; vectors have a name that is a constructor's, too */

typedef float vec2 __attribute__((vector_size(8)));
typedef float vec3 __attribute__((vector_size(16))); /* lanes 0 to 2 */
#define vec2(x, y) ((vec2){x, y})
#define vec3(x, y, z) ((vec3){x, y, z, 0})

#define max(a, b) fmaxf(a, b)
#define min(a, b) fminf(a, b)

static inline float dot(vec3 a, vec3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline vec3 normalize(vec3 a)
{
    return a / sqrtf(dot(a, a));
}

static inline vec3 mix(vec3 a, vec3 b, float t)
{
    return a * (1 - t) + b * t;
}

static inline float fract(float x)
{
    return x - floorf(x);
}

static inline vec3 cross(vec3 a, vec3 b)
{
    return vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

#define FUNCTION static inline
#define struct_surface struct surface
#define struct_light struct light
#include "shading.glsl"

/* ---- the scene */

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
uint32_t shade_encode(vec3 colour);

#endif
