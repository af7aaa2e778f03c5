/* SPDX-License-Identifier: Apache-2.0 */
/* Shading on the CPU, as scene.comp does it. */
#include "shade.h"

#include <assert.h>

/* ---- spaces */

static void invert(const VkTransformMatrixKHR *transform, float inverse[3][3])
{
    const float(*m)[4] = transform->matrix;
    vec3 a = vec3(m[0][0], m[0][1], m[0][2]), b = vec3(m[1][0], m[1][1], m[1][2]);
    vec3 c = vec3(m[2][0], m[2][1], m[2][2]);
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
        of -= vec3(m[0][3], m[1][3], m[2][3]);
    vec3 to = vec3(0, 0, 0);
    for (int row = 0; row < 3; ++row)
        to[row] = dot(of, vec3(inverse[row][0], inverse[row][1], inverse[row][2]));
    return to;
}

/* Normals take the inverse transposed. Turned to face the ray. */
static vec3 world_normal(const struct shade_scene *shading, const struct shade_meeting *meeting,
                         vec3 normal)
{
    const float(*inverse)[3] = shading->inverse[meeting->instance];
    vec3 to = vec3(0, 0, 0);
    for (int row = 0; row < 3; ++row)
        to += normal[row] * vec3(inverse[row][0], inverse[row][1], inverse[row][2]);
    to = normalize(to);
    return dot(to, meeting->direction) > 0 ? -to : to;
}

/* ---- boxes */

static void box_corners(const struct shade_scene *shading, uint32_t primitive, vec3 *low,
                        vec3 *high)
{
    const VkAabbPositionsKHR *box = &shading->boxes[primitive];
    *low = vec3(box->minX, box->minY, box->minZ);
    *high = vec3(box->maxX, box->maxY, box->maxZ);
}

float shade_box(const struct shade_scene *shading, uint32_t primitive, vec3 origin, vec3 direction)
{
    vec3 low, high;
    box_corners(shading, primitive, &low, &high);
    return box_intersect(box_is_solid(primitive), low, high, origin, direction);
}

/* ---- surfaces */

struct surface shade_mesh(const struct shade_scene *shading, const struct shade_meeting *meeting)
{
    uint32_t custom = shading->instances[meeting->instance].instanceCustomIndex;
    uint32_t material = custom & 0xff,
             set = custom & LAYOUT_TWISTED_BIT ? shading->vertex_count : 0;
    const float weights[3] = {1 - meeting->u - meeting->v, meeting->u, meeting->v};
    vec3 normal = vec3(0, 0, 0);
    for (uint32_t corner = 0; corner < 3; ++corner) {
        uint32_t at = 3 * (set + shading->indices[3 * meeting->primitive + corner]);
        normal += weights[corner] *
                  vec3(shading->normals[at], shading->normals[at + 1], shading->normals[at + 2]);
    }
    return (struct surface){.t = meeting->t,
                            .normal = world_normal(shading, meeting, normal),
                            .colour = mesh_colour(material),
                            .shine = 0.05f};
}

struct surface shade_field(const struct shade_scene *shading, const struct shade_meeting *meeting)
{
    vec3 origin = shade_to_object(shading, meeting->instance, meeting->origin, true);
    vec3 direction = shade_to_object(shading, meeting->instance, meeting->direction, false);
    vec3 low, high;
    box_corners(shading, meeting->primitive, &low, &high);
    vec3 normal =
        box_normal(box_is_solid(meeting->primitive), low, high, origin + meeting->t * direction);
    return (struct surface){.t = meeting->t,
                            .normal = world_normal(shading, meeting, normal),
                            .colour = field_colour(meeting->primitive),
                            .shine = field_shine(meeting->primitive)};
}

void shade_plain(vec3 origin, vec3 direction, struct surface *hit)
{
    float plain = direction[1] < 0 ? -origin[1] / direction[1] : -1;
    if (plain > 0 && (hit->t < 0 || plain < hit->t))
        *hit = (struct surface){
            .t = plain, .normal = vec3(0, 1, 0), .colour = vec3(0.55f, 0.50f, 0.44f), .shine = 0};
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
