/* SPDX-License-Identifier: Apache-2.0 */
/* Subdivides displaced triangles and reads their parts. */
#include "src/bvh/input/displaced.h"

#include <math.h>
#include <string.h>

#include "src/bvh/input/displacement.h"
#include "src/bvh/micromap.h"

enum builder_result displaced_count(const struct builder_displacement *displacement,
                                    uint32_t triangles, struct displaced_counts *counts)
{
    uint64_t displaced = 0;
    for (uint32_t i = 0; displacement && i < displacement->usage_count; i++) {
        const VkMicromapUsageEXT *usage = &displacement->usages[i];
        if (displacement_bytes(usage->format, usage->subdivisionLevel) == 0)
            return BUILDER_UNKNOWN_FORMAT;
        displaced += usage->count;
        counts->parts += (uint64_t)usage->count << 2 * usage->subdivisionLevel;
        counts->points +=
            (uint64_t)usage->count * displacement_vertex_count(usage->subdivisionLevel);
        if (counts->parts > BUILDER_MAX_PRIMITIVES)
            return BUILDER_TOO_MANY_PRIMITIVES;
    }
    uint64_t others = displaced < triangles ? triangles - displaced : 0;
    counts->bases += triangles;
    counts->parts += others;
    counts->points += 3 * others;
    return counts->parts > BUILDER_MAX_PRIMITIVES ? BUILDER_TOO_MANY_PRIMITIVES : BUILDER_OK;
}

/* An array with one element per vertex. */
struct vertex_array {
    const struct vertex_format *format;
    const uint8_t *data;
    uint64_t stride, limit;
};

static struct vertex_array open_array(VkFormat format, const void *data, uint64_t size,
                                      uint64_t stride)
{
    struct vertex_array array = {vertex_format_find(format), data, stride, 0};
    if (data && array.format)
        array.limit = source_elements_in(size, array.format->size, stride);
    return array;
}

static bool read_element(const struct vertex_array *array, uint64_t index, float to[3])
{
    if (index >= array->limit)
        return false;
    array->format->read(array->data + array->stride * index, to);
    return true;
}

/* The inputs that subdivide the triangles of a geometry. */
struct subdivision {
    const struct builder_displacement *displacement;
    struct source untransformed; /* the source without its transform, at time 0 */
    struct vertex_array vectors, biases;
    struct micromap_indices indices;
    uint64_t flags;       /* number of readable flags */
    const void *micromap; /* NULL if unresolved */
    uint32_t first_vertex;
};

/* A base triangle: its vertices at times 0 and 1, and their displacement vectors. */
struct displaced_triangle {
    double position[2][3][3], vector[3][3];
    uint32_t format, level, edges;
    const uint8_t *blocks;
};

static bool read_vectors(const struct subdivision *subdivision, const uint64_t index[3],
                         struct displaced_triangle *to)
{
    for (int i = 0; i < 3; i++) {
        float vector[3], bias[3] = {0, 1, 0};
        uint64_t vertex = index[i] + subdivision->first_vertex;
        if (!read_element(&subdivision->vectors, vertex, vector) ||
            (subdivision->displacement->biases_and_scales &&
             !read_element(&subdivision->biases, vertex, bias)))
            return false;
        for (int axis = 0; axis < 3; axis++) {
            double along = vector[axis];
            to->position[0][i][axis] += along * bias[0];
            to->position[1][i][axis] += along * bias[0];
            to->vector[i][axis] = along * bias[1];
        }
    }
    return true;
}

static bool read_edges(const struct subdivision *subdivision, uint32_t triangle,
                       struct displaced_triangle *to)
{
    const struct builder_displacement *from = subdivision->displacement;
    to->edges = 0;
    if (!from->flags)
        return true;
    if (triangle >= subdivision->flags)
        return false;
    to->edges = ((const uint8_t *)from->flags)[from->flags_stride * triangle] & 7;
    return true;
}

static enum source_state read_positions(const struct source *untransformed, uint32_t triangle,
                                        double to[3][3])
{
    struct triangle_record record;
    enum source_state found = source_triangle(untransformed, triangle, &record);
    const float *corners[3] = {record.a, record.b, record.c};
    for (int i = 0; found == SOURCE_ACTIVE && i < 9; i++)
        to[i / 3][i % 3] = corners[i / 3][i % 3];
    return found;
}

static enum source_state read_displaced_triangle(const struct subdivision *subdivision,
                                                 uint32_t triangle, struct displaced_triangle *to)
{
    uint64_t index[3];
    enum source_state found =
        read_positions(&subdivision->untransformed, triangle, to->position[0]);
    if (found != SOURCE_ACTIVE)
        return found;
    memcpy(to->position[1], to->position[0], sizeof(to->position[0]));
    if (subdivision->untransformed.motion_vertices) {
        struct source then = subdivision->untransformed;
        then.vertices = then.motion_vertices;
        found = read_positions(&then, triangle, to->position[1]);
    }
    if (found != SOURCE_ACTIVE)
        return found;
    uint64_t number = source_micromap_index(&subdivision->indices, triangle) +
                      subdivision->displacement->base_triangle;
    to->blocks = subdivision->micromap
                     ? micromap_displacement(subdivision->micromap, number, &to->format, &to->level)
                     : NULL;
    return to->blocks && source_corners(&subdivision->untransformed, triangle, index) &&
                   read_vectors(subdivision, index, to) && read_edges(subdivision, triangle, to)
               ? SOURCE_ACTIVE
               : SOURCE_OUT_OF_RANGE;
}

/* Skips vertices of weight 0, which may hold any value. */
static double weighted(const double of[3][3], int axis, const double weights[3])
{
    double sum = 0;
    for (int i = 0; i < 3; i++)
        if (weights[i] != 0)
            sum += weights[i] * of[i][axis];
    return sum;
}

/* Computes the vertices of all microtriangles. Returns false if one is NaN. */
static bool place_points(const struct source *source,
                         const struct displaced_triangle *displaced_triangle, int time,
                         const uint16_t *values, struct displaced_point *to)
{
    uint32_t edge = 1u << displaced_triangle->level;
    for (uint32_t v = 0; v <= edge; v++)
        for (uint32_t u = 0; u + v <= edge; u++, to++) {
            const double weights[3] = {(double)(edge - u - v) / edge, (double)u / edge,
                                       (double)v / edge};
            double value = *values++ / (double)DISPLACEMENT_ONE, point[3];
            for (int axis = 0; axis < 3; axis++)
                point[axis] = weighted(displaced_triangle->position[time], axis, weights) +
                              weighted(displaced_triangle->vector, axis, weights) * value;
            if (isnan(point[0]) || isnan(point[1]) || isnan(point[2]))
                return false;
            for (int axis = 0; axis < 3; axis++)
                to->at[axis] = (float)point[axis];
            if (source->has_transform)
                source_transform(&source->transform, point, to->at);
            for (int axis = 0; axis < 3; axis++)
                to->at[axis] += 0.0f;
        }
    return true;
}

/* Subdivides a displaced triangle into `room`, which is large enough for any triangle. */
static enum source_state displace(const struct source *source,
                                  const struct displaced_triangle *displaced_triangle,
                                  const struct displaced_room *room)
{
    uint16_t values[DISPLACEMENT_MAX_VERTICES];
    displacement_decode(displaced_triangle->format, displaced_triangle->level,
                        displaced_triangle->blocks, values);
    return place_points(source, displaced_triangle, 0, values, room->points) &&
                   (!room->motion_points ||
                    place_points(source, displaced_triangle, 1, values, room->motion_points))
               ? SOURCE_ACTIVE
               : SOURCE_UNDEFINED;
}

/* Copies an undisplaced triangle. */
static enum source_state copy_undisplaced(const struct source *source, uint32_t triangle,
                                          const struct displaced_room *room)
{
    struct motion_triangle_record record;
    enum source_state found = room->motion_points
                                  ? source_motion_triangle(source, triangle, &record)
                                  : source_triangle(source, triangle, &record.at[0]);
    for (int time = 0; found == SOURCE_ACTIVE && time <= (room->motion_points ? 1 : 0); time++) {
        struct displaced_point *to = time == 0 ? room->points : room->motion_points;
        memcpy(to[0].at, record.at[time].a, sizeof(to->at));
        memcpy(to[1].at, record.at[time].b, sizeof(to->at));
        memcpy(to[2].at, record.at[time].c, sizeof(to->at));
    }
    return found;
}

static bool is_displaced(const struct subdivision *subdivision, uint32_t triangle)
{
    return subdivision->displacement && subdivision->displacement->micromap &&
           source_micromap_index(&subdivision->indices, triangle) < SOURCE_SPECIAL;
}

static bool has_room(const struct displaced_room *room, uint32_t level)
{
    return room->left.parts >= 1u << 2 * level &&
           room->left.points >= displacement_vertex_count(level);
}

/* Subdivides a triangle. Returns false if the room does not suffice. */
static bool subdivide(const struct source *source, const struct subdivision *subdivision,
                      uint32_t triangle, struct displaced_room *room, struct displaced_base *base)
{
    struct displaced_triangle displaced_triangle;
    enum source_state found = SOURCE_ACTIVE;
    bool has_displacement = is_displaced(subdivision, triangle);
    if (has_displacement)
        found = read_displaced_triangle(subdivision, triangle, &displaced_triangle);
    uint32_t level = has_displacement && found == SOURCE_ACTIVE ? displaced_triangle.level : 0;
    if (!has_room(room, level))
        return false;
    if (!has_displacement)
        found = copy_undisplaced(source, triangle, room);
    else if (found == SOURCE_ACTIVE)
        found = displace(source, &displaced_triangle, room);
    base->found = (uint8_t)found;
    base->level = found == SOURCE_ACTIVE ? (uint8_t)level : 0;
    base->edges =
        has_displacement && found == SOURCE_ACTIVE ? (uint8_t)displaced_triangle.edges : 0;
    return true;
}

static bool open_subdivision(struct subdivision *subdivision, const struct source *source,
                             const struct builder_resolver *micromaps)
{
    const struct builder_displacement *from = subdivision->displacement;
    subdivision->untransformed = *source;
    subdivision->untransformed.has_transform = subdivision->untransformed.is_plain = false;
    subdivision->vectors =
        open_array(from->vector_format, from->vectors, from->vectors_size, from->vector_stride);
    subdivision->biases = open_array(from->bias_and_scale_format, from->biases_and_scales,
                                     from->biases_and_scales_size, from->bias_and_scale_stride);
    subdivision->flags = source_elements_in(from->flags_size, 1, from->flags_stride);
    if (!from->micromap)
        return true;
    if (micromaps->find)
        subdivision->micromap = micromaps->find(micromaps->context, from->micromap);
    return source_open_indices(&subdivision->indices, from->index_type, from->base_triangle,
                               from->indices, from->indices_size, from->index_stride,
                               source->count);
}

bool displaced_cut(struct source *source, const struct builder_displacement *displacement,
                   uint32_t first_vertex, const struct builder_resolver *micromaps,
                   struct displaced_room *room, uint32_t *base)
{
    struct subdivision subdivision = {.displacement = displacement, .first_vertex = first_vertex};
    uint32_t parts = 0, points = 0;
    *base = 0;
    source->bases = room->bases;
    source->points = room->points;
    source->motion_points = room->motion_points;
    source->base_count = source->count;
    if (displacement && !open_subdivision(&subdivision, source, micromaps))
        return false;
    for (; *base < source->base_count; (*base)++, room->bases++) {
        *room->bases = (struct displaced_base){.first = parts, .point = points};
        if (!subdivide(source, &subdivision, *base, room, room->bases))
            return false;
        uint32_t level = room->bases->level, count = displacement_vertex_count(level);
        parts += 1u << 2 * level;
        points += count;
        room->points += count;
        if (room->motion_points)
            room->motion_points += count;
        room->left.parts -= 1u << 2 * level;
        room->left.points -= count;
    }
    source->count = parts;
    return true;
}

uint32_t displaced_base_of(const struct source *source, uint32_t number)
{
    uint32_t low = 0, high = source->base_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (source->bases[middle].first <= number)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void fill_triangle(const struct displaced_point *points, const struct displaced_base *base,
                          const struct displacement_corner corners[3],
                          struct triangle_record *triangle)
{
    float *to[3] = {triangle->a, triangle->b, triangle->c};
    for (int i = 0; i < 3; i++)
        memcpy(to[i],
               points[base->point + displacement_place(base->level, corners[i].u, corners[i].v)].at,
               sizeof(triangle->a));
}

/* Reads the positions of a part at time 0 and, if `then` is not NULL, at time 1. */
static enum source_state read_part(const struct source *source, uint32_t number,
                                   struct displaced_part *part, struct triangle_record *now,
                                   struct triangle_record *then)
{
    const struct displaced_base *base = &source->bases[number];
    struct displacement_corner corners[3];
    if (base->found != SOURCE_ACTIVE)
        return (enum source_state)base->found;
    part->level = base->level;
    part->edges = base->edges;
    displacement_microtriangle(base->level, part->index, base->edges, corners);
    fill_triangle(source->points, base, corners, now);
    now->primitive = number;
    if (!then)
        return SOURCE_ACTIVE;
    fill_triangle(source->motion_points, base, corners, then);
    then->primitive = number;
    return SOURCE_ACTIVE;
}

enum source_state displaced_read_part(const struct source *source, uint32_t base,
                                      struct displaced_part part, struct displaced_record *record)
{
    record->part = part;
    return read_part(source, base, &record->part, &record->triangle, NULL);
}

enum source_state displaced_read_motion_part(const struct source *source, uint32_t base,
                                             struct displaced_part part,
                                             struct motion_displaced_record *record)
{
    record->part = part;
    return read_part(source, base, &record->part, &record->triangle.at[0], &record->triangle.at[1]);
}

static struct displaced_part part_of(const struct source *source, uint32_t base, uint32_t number)
{
    return (struct displaced_part){.index = (uint16_t)(number - source->bases[base].first)};
}

enum source_state displaced_read(const struct source *source, uint32_t number,
                                 struct displaced_record *record)
{
    uint32_t base = displaced_base_of(source, number);
    return displaced_read_part(source, base, part_of(source, base, number), record);
}

enum source_state displaced_read_motion(const struct source *source, uint32_t number,
                                        struct motion_displaced_record *record)
{
    uint32_t base = displaced_base_of(source, number);
    return displaced_read_motion_part(source, base, part_of(source, base, number), record);
}

bool displaced_level_matches(const struct source *source, uint32_t base, struct displaced_part part)
{
    return source->bases[base].found != SOURCE_ACTIVE || source->bases[base].level == part.level;
}

void displaced_barycentrics(struct displaced_part part, float *u, float *v)
{
    struct displacement_corner corners[3];
    displacement_microtriangle(part.level, part.index, part.edges, corners);
    const double weights[3] = {1.0 - *u - *v, *u, *v};
    double x = 0, y = 0;
    for (int i = 0; i < 3; i++) {
        x += weights[i] * corners[i].u;
        y += weights[i] * corners[i].v;
    }
    *u = (float)(x / (1u << part.level));
    *v = (float)(y / (1u << part.level));
}
