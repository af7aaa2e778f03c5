/* SPDX-License-Identifier: Apache-2.0 */
/* assay-scene export: one top-level structure as glTF 2.0. A bottom-level structure is a mesh, with
 * a primitive for each geometry; an instance is a node. What findings are about is red. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>
#include <vulkan/vulkan_core.h>

#include "src/base/array.h"
#include "src/bvh/input/formats.h"
#include "src/bvh/motion.h"
#include "src/scene/tool.h"
#include "src/view/names.h"

enum {
    INSTANCES_PER_NODE = 100, /* more share a node */
    FLOATS_PER_INSTANCE = 10, /* of EXT_mesh_gpu_instancing: translation, rotation, scale */
    BOX_CORNERS = 8,
    BOX_INDICES = 36,
    /* constants of glTF */
    ARRAY_BUFFER = 34962,
    ELEMENT_ARRAY_BUFFER = 34963,
    COMPONENT_UINT = 5125,
    COMPONENT_FLOAT = 5126,
};

/* What the file lacks, and why. Counts are in `extras` of the scene. */
#define LEFT_OUT_LIST(X)                                                                           \
    X(INACTIVE_PRIMITIVES, "inactive primitives")                                                  \
    X(NOT_FINITE, "primitives and instances with infinite coordinates")                            \
    X(NOT_IN_CAPTURE, "primitives whose data is not in the capture")                               \
    X(OTHER_GEOMETRIES, "geometries of other types or formats")                                    \
    X(LEFT_NULL_INSTANCES, "instances without a structure")                                        \
    X(LEFT_UNKNOWN, "instances that refer to no known structure")                                  \
    X(LEFT_DESTROYED, "instances that refer to a destroyed structure")                             \
    X(LEFT_NOT_BUILT, "instances of structures whose build is not in the capture")
#define NUMBER_OF(name, text) name,
#define TEXT_OF(name, text) text,
enum left_out { LEFT_OUT_LIST(NUMBER_OF) LEFT_OUT };
static const char *const left_out_names[] = {LEFT_OUT_LIST(TEXT_OF)};

/* What was last built or copied into a structure, and its meshes. */
struct structure_state {
    uint32_t build;     /* the command; CAPTURE_NONE: unknown */
    json_t *mesh;       /* once made; without an array `primitives` it is empty */
    int32_t index, red; /* of the mesh, and of its copy in red; -1: none */
    uint32_t instances; /* of this export */
    float *shared;      /* of the node that they share, FLOATS_PER_INSTANCE each; or NULL */
    uint32_t shared_count;
};

struct gltf {
    struct capture *capture;
    const struct export_options *options;
    struct capture_error *error;
    struct structure_state *states;
    uint8_t *bytes;
    size_t size, capacity;
    json_t *views, *accessors, *meshes, *nodes, *roots, *materials;
    uint64_t left_out[LEFT_OUT];
    bool has_instancing;
};

/* ---- the parts of a file */

static int append(json_t *array, json_t *object)
{
    json_array_append_new(array, object);
    return (int)json_array_size(array) - 1;
}

/* Adds bytes, a view of them and an accessor; returns its index. */
static int add_accessor(struct gltf *gltf, const void *bytes, size_t size, int target,
                        int component, const char *type, uint64_t count)
{
    if (gltf->size + size > gltf->capacity) {
        gltf->capacity = 2 * (gltf->size + size);
        gltf->bytes = capture_allocate(gltf->bytes, gltf->capacity, 1);
    }
    memcpy(gltf->bytes + gltf->size, bytes, size);
    json_t *view = json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)gltf->size,
                             "byteLength", (json_int_t)size);
    if (target)
        json_object_set_new(view, "target", json_integer(target));
    gltf->size += size; /* all elements have 4 bytes, so that each view is aligned */
    return append(gltf->accessors,
                  json_pack("{s:i, s:i, s:s, s:I}", "bufferView", append(gltf->views, view),
                            "componentType", component, "type", type, "count", (json_int_t)count));
}

static int add_positions(struct gltf *gltf, const float (*positions)[3], uint32_t count)
{
    float least[3], most[3];
    memcpy(least, positions[0], sizeof(least));
    memcpy(most, positions[0], sizeof(most));
    for (uint32_t i = 1; i < count; i++)
        for (int j = 0; j < 3; j++) {
            least[j] = fminf(least[j], positions[i][j]);
            most[j] = fmaxf(most[j], positions[i][j]);
        }
    const int accessor = add_accessor(gltf, positions, (size_t)count * sizeof(*positions),
                                      ARRAY_BUFFER, COMPONENT_FLOAT, "VEC3", count);
    json_object_update_new(json_array_get(gltf->accessors, (size_t)accessor),
                           json_pack("{s:[f,f,f], s:[f,f,f]}", "min", (double)least[0],
                                     (double)least[1], (double)least[2], "max", (double)most[0],
                                     (double)most[1], (double)most[2]));
    return accessor;
}

static int add_material(struct gltf *gltf, const char *name, double hue, double saturation)
{
    double color[3];
    for (int i = 0; i < 3; i++) {
        const double turn = fmod(hue * 6 + 5 - 2 * i, 6);
        color[i] = 0.8 * (1 - saturation * fmax(0, fmin(fmin(turn, 4 - turn), 1)));
    }
    return append(gltf->materials,
                  json_pack("{s:s, s:b, s:{s:[f,f,f,i], s:i, s:f}}", "name", name, "doubleSided", 1,
                            "pbrMetallicRoughness", "baseColorFactor", color[0], color[1], color[2],
                            1, "metallicFactor", 0, "roughnessFactor", 0.9));
}

/* Material 0 is red; others are as far from it as from each other. */
static int material_of(struct gltf *gltf, uint32_t structure, uint32_t flags)
{
    static const char *const names[] = {"not opaque", "opaque", "no duplicates",
                                        "opaque, no duplicates"};
    const struct captured_structure *captured = &gltf->capture->structures[structure];
    char name[32];
    snprintf(name, sizeof(name), "structure %" PRIu64, captured->id);
    const uint32_t known = flags & 3;
    const char *wanted = gltf->options->colors_flags ? names[known]
                         : captured->name            ? captured->name
                                                     : name;
    const double turn =
        gltf->options->colors_flags ? known / 4.0 : fmod((double)captured->id * 0.618034, 1);
    for (size_t i = 1; gltf->options->colors_flags && i < json_array_size(gltf->materials); i++)
        if (strcmp(json_string_value(json_object_get(json_array_get(gltf->materials, i), "name")),
                   wanted) == 0)
            return (int)i;
    return add_material(gltf, wanted, 0.12 + 0.76 * turn, 0.6);
}

static json_t *make_finding(const struct captured_finding *finding)
{
    json_t *object = json_pack("{s:s, s:s}", "id", finding->id, "message", finding->message);
    if (finding->primitive != CAPTURE_NONE)
        json_object_set_new(object, "primitive", json_integer(finding->primitive));
    return object;
}

/* Sets the findings about a build, or about one instance of it, in `extras` of an object. Returns
 * whether there are any. */
static bool set_findings(const struct gltf *gltf, json_t *extras, uint32_t command,
                         uint32_t instance)
{
    json_t *findings = json_array();
    for (uint32_t i = 0; i < gltf->capture->finding_count; i++) {
        const struct captured_finding *finding = &gltf->capture->findings[i];
        if (command != CAPTURE_NONE && finding->command == command &&
            (instance == CAPTURE_NONE || finding->primitive == instance))
            json_array_append_new(findings, make_finding(finding));
    }
    const bool has_findings = json_array_size(findings);
    if (has_findings)
        json_object_set(extras, "findings", findings);
    json_decref(findings);
    return has_findings;
}

/* ---- meshes */

/* The corners and triangles of a geometry, each list for itself: [1] has those of findings. */
struct soup {
    float (*positions)[3];
    uint32_t position_count, position_capacity;
    uint32_t *indices[2];
    uint32_t index_count[2], index_capacity[2];
};

static uint32_t add_position(struct soup *soup, const float position[3])
{
    if (!ARRAY_HAS_ROOM(soup->positions, soup->position_count, soup->position_capacity))
        capture_allocate(NULL, SIZE_MAX, 2);
    memcpy(soup->positions[soup->position_count], position, sizeof(*soup->positions));
    return soup->position_count++;
}

static void add_index(struct soup *soup, bool is_red, uint32_t index)
{
    if (!ARRAY_HAS_ROOM(soup->indices[is_red], soup->index_count[is_red],
                        soup->index_capacity[is_red]))
        capture_allocate(NULL, SIZE_MAX, 2);
    soup->indices[is_red][soup->index_count[is_red]++] = index;
}

/* The rows of an input; none if they are not in the capture. */
struct rows {
    const uint8_t *bytes;
    uint64_t count;
    uint32_t size;
    const struct captured_input *input;
};

static struct rows load(struct gltf *gltf, const struct captured_geometry *geometry,
                        enum capture_role role)
{
    struct rows rows = {.input = capture_input_of(geometry, role)};
    if (!rows.input || rows.input->data == CAPTURE_NONE)
        return rows;
    const struct captured_data *data = &gltf->capture->data[rows.input->data];
    rows.bytes = capture_load_data(gltf->capture, rows.input->data, gltf->error);
    rows.count = rows.bytes ? data->rows : 0;
    rows.size = data->row_size;
    return rows;
}

static const struct vertex_format *find_format(const char *name)
{
    for (int i = 1; name && i <= VK_FORMAT_D32_SFLOAT_S8_UINT; i++) {
        const struct value value = format((VkFormat)i);
        if (value.kind == VALUE_TEXT && strcmp(value.text, name) == 0)
            return vertex_format_find((VkFormat)i);
    }
    return NULL;
}

static uint32_t index_at(const struct rows *rows, uint64_t at)
{
    uint32_t index = 0;
    memcpy(&index, rows->bytes + at * rows->size, rows->size); /* of the lowest bytes */
    return index;
}

static bool is_finite(const float position[3])
{
    return isfinite(position[0]) && isfinite(position[1]) && isfinite(position[2]);
}

static void transform(const float matrix[12], float position[3])
{
    const double x = position[0], y = position[1], z = position[2];
    for (int i = 0; i < 3; i++)
        position[i] = (float)(matrix[4 * i] * x + matrix[4 * i + 1] * y + matrix[4 * i + 2] * z +
                              matrix[4 * i + 3]);
}

/* What corners of triangles need. `places` has the position of each row, once it is in the soup. */
struct triangles {
    const struct captured_geometry *geometry;
    const struct vertex_format *format;
    struct rows vertices, indices, transform;
    uint32_t *places;
};

/* Finds the row of a vertex. Returns false if it is not in the capture. */
static bool find_row(const struct triangles *triangles, uint64_t corner, uint64_t *row)
{
    const struct captured_geometry *geometry = triangles->geometry;
    const struct captured_input *input = triangles->vertices.input;
    const bool is_indexed = triangles->indices.input;
    if (!triangles->vertices.count || (is_indexed && corner >= triangles->indices.count))
        return false;
    const uint64_t vertex =
        (is_indexed ? index_at(&triangles->indices, corner) : corner) + geometry->first_vertex;
    const unsigned __int128 at =
        (is_indexed ? 0 : geometry->primitive_offset) + (unsigned __int128)vertex * input->stride;
    if (at < input->first || !input->stride)
        return false;
    *row = (uint64_t)((at - input->first) / input->stride);
    return *row < triangles->vertices.count;
}

/* Adds a triangle to the soup, or returns why it is left out. */
static enum left_out add_triangle(const struct triangles *triangles, struct soup *soup,
                                  uint64_t primitive, bool is_red)
{
    float positions[3][3];
    uint64_t rows[3];
    for (uint32_t i = 0; i < 3; i++) {
        if (!find_row(triangles, 3 * primitive + i, &rows[i]))
            return NOT_IN_CAPTURE;
        triangles->format->read(triangles->vertices.bytes + rows[i] * triangles->vertices.size,
                                positions[i]);
    }
    if (isnan(positions[0][0]) || isnan(positions[1][0]) || isnan(positions[2][0]))
        return INACTIVE_PRIMITIVES;
    for (int i = 0; i < 3; i++) {
        if (triangles->transform.count) {
            float matrix[12];
            memcpy(matrix, triangles->transform.bytes, sizeof(matrix));
            transform(matrix, positions[i]);
        }
        if (!is_finite(positions[i]))
            return NOT_FINITE;
    }
    for (int i = 0; i < 3; i++) {
        uint32_t *place = &triangles->places[rows[i]];
        if (*place == CAPTURE_NONE)
            *place = add_position(soup, positions[i]);
        add_index(soup, is_red, *place);
    }
    return LEFT_OUT;
}

static enum left_out add_box(const struct rows *boxes, struct soup *soup, uint64_t primitive,
                             bool is_red)
{
    static const uint8_t faces[BOX_INDICES] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6,
                                               0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                               0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    float box[2][3];
    if (primitive >= boxes->count)
        return NOT_IN_CAPTURE;
    memcpy(box, boxes->bytes + primitive * sizeof(box), sizeof(box));
    if (isnan(box[0][0]))
        return INACTIVE_PRIMITIVES;
    if (!is_finite(box[0]) || !is_finite(box[1]))
        return NOT_FINITE;
    const uint32_t first = soup->position_count;
    for (int i = 0; i < BOX_CORNERS; i++)
        add_position(soup, (const float[]){box[i & 1][0], box[i >> 1 & 1][1], box[i >> 2][2]});
    for (int i = 0; i < BOX_INDICES; i++)
        add_index(soup, is_red, first + faces[i]);
    return LEFT_OUT;
}

/* Whether findings are about a primitive of a geometry; a finding that names none is about all. */
static bool is_of_geometry(const struct captured_finding *finding, uint32_t command,
                           uint32_t geometry)
{
    return finding->command == command && finding->geometry == geometry;
}

/* Returns a flag for each of the first `count` primitives, and the findings, or NULL. */
static bool *find_red(const struct gltf *gltf, uint32_t command, uint32_t geometry, uint64_t count,
                      json_t **findings)
{
    bool *red = NULL;
    for (uint32_t i = 0; i < gltf->capture->finding_count; i++) {
        const struct captured_finding *finding = &gltf->capture->findings[i];
        if (!is_of_geometry(finding, command, geometry))
            continue;
        if (!red) {
            red = memset(capture_allocate(NULL, count, 1), 0, count);
            *findings = json_array();
        }
        if (finding->primitive == CAPTURE_NONE)
            memset(red, 1, count);
        else if (finding->primitive < count)
            red[finding->primitive] = true;
        json_array_append_new(*findings, make_finding(finding));
    }
    return red;
}

static void add_primitives(struct gltf *gltf, json_t *primitives, const struct soup *soup,
                           int material, uint32_t geometry, json_t *findings)
{
    if (!soup->position_count)
        return;
    const int positions =
        add_positions(gltf, (const float(*)[3])soup->positions, soup->position_count);
    for (int is_red = 0; is_red < 2; is_red++) {
        const uint32_t count = soup->index_count[is_red];
        if (!count)
            continue;
        const int indices = add_accessor(gltf, soup->indices[is_red], count * sizeof(uint32_t),
                                         ELEMENT_ARRAY_BUFFER, COMPONENT_UINT, "SCALAR", count);
        json_t *extras = json_pack("{s:i}", "geometry", geometry);
        if (is_red)
            json_object_set(extras, "findings", findings);
        json_array_append_new(primitives,
                              json_pack("{s:{s:i}, s:i, s:i, s:o}", "attributes", "POSITION",
                                        positions, "indices", indices, "material",
                                        is_red ? 0 : material, "extras", extras));
    }
}

static void add_geometry(struct gltf *gltf, uint32_t command, uint32_t index, json_t *primitives,
                         int material)
{
    const struct captured_geometry *geometry = &gltf->capture->commands[command].geometries[index];
    struct triangles triangles = {.geometry = geometry};
    struct rows boxes = {.bytes = NULL};
    uint64_t known = 0; /* primitives that have data */
    if (geometry->type == CAPTURE_TRIANGLES) {
        triangles.vertices = load(gltf, geometry, CAPTURE_VERTICES);
        triangles.indices = load(gltf, geometry, CAPTURE_INDICES);
        triangles.transform = load(gltf, geometry, CAPTURE_TRANSFORM);
        triangles.format = find_format(geometry->vertex_format);
        known = (triangles.indices.input ? triangles.indices.count : triangles.vertices.count) / 3;
    } else if (geometry->type == CAPTURE_AABBS) {
        boxes = load(gltf, geometry, CAPTURE_BOXES);
        known = boxes.count;
    }
    if (geometry->type != CAPTURE_AABBS &&
        (!triangles.format ||
         (triangles.vertices.count && triangles.vertices.size < triangles.format->size))) {
        gltf->left_out[OTHER_GEOMETRIES]++;
        return;
    }
    const uint64_t count = known < geometry->primitive_count ? known : geometry->primitive_count;
    gltf->left_out[NOT_IN_CAPTURE] += geometry->primitive_count - count;
    if (triangles.vertices.count) {
        triangles.places =
            capture_allocate(NULL, triangles.vertices.count, sizeof(*triangles.places));
        memset(triangles.places, 0xff, triangles.vertices.count * sizeof(*triangles.places));
    }
    struct soup soup = {.position_count = 0};
    json_t *findings = NULL;
    bool *red = find_red(gltf, command, index, count, &findings);
    for (uint64_t i = 0; i < count; i++) {
        const bool is_red = red && red[i];
        const enum left_out why = geometry->type == CAPTURE_AABBS
                                      ? add_box(&boxes, &soup, i, is_red)
                                      : add_triangle(&triangles, &soup, i, is_red);
        if (why != LEFT_OUT)
            gltf->left_out[why]++;
    }
    add_primitives(gltf, primitives, &soup, material, index, findings);
    json_decref(findings);
    free(red);
    free(soup.positions);
    free(soup.indices[0]);
    free(soup.indices[1]);
    free(triangles.places);
    for (uint32_t i = 0; i < geometry->input_count; i++)
        if (geometry->inputs[i].data != CAPTURE_NONE)
            capture_release_data(gltf->capture, geometry->inputs[i].data);
}

/* Returns the mesh of a structure, or of its copy in red, which are made at their first use; -1 if
 * nothing is in it. */
static int mesh_of(struct gltf *gltf, uint32_t structure, bool is_red)
{
    struct structure_state *state = &gltf->states[structure];
    if (!state->mesh) {
        const struct captured_command *build = &gltf->capture->commands[state->build];
        const struct captured_structure *captured = &gltf->capture->structures[structure];
        json_t *primitives = json_array();
        int material = -1;
        for (uint32_t i = 0; i < build->geometry_count; i++) {
            if (material < 0 || gltf->options->colors_flags)
                material = material_of(gltf, structure, build->geometries[i].flags);
            add_geometry(gltf, state->build, i, primitives, material);
        }
        json_t *extras = json_pack("{s:I, s:I}", "structure", (json_int_t)captured->id, "build",
                                   (json_int_t)build->n);
        set_findings(gltf, extras, state->build, CAPTURE_NONE);
        state->mesh = json_pack("{s:o, s:o}", "primitives", primitives, "extras", extras);
        if (captured->name)
            json_object_set_new(state->mesh, "name", json_string(captured->name));
        state->index =
            json_array_size(primitives) ? append(gltf->meshes, json_incref(state->mesh)) : -1;
        state->red = -1;
    }
    if (!is_red || state->index < 0)
        return state->index;
    if (state->red < 0) {
        json_t *copy = json_deep_copy(state->mesh), *primitive;
        size_t i;
        json_array_foreach(json_object_get(copy, "primitives"), i, primitive)
            json_object_set_new(primitive, "material", json_integer(0));
        state->red = append(gltf->meshes, copy);
    }
    return state->red;
}

/* ---- transforms */

/* A matrix as rotation * scale * inner rotation. glTF's nodes cannot shear, but two of them can. */
struct parts {
    double rotation[4], scale[3], inner[4]; /* quaternions x, y, z, w */
    bool has_inner;
};

/* `columns` are those of a rotation. */
static void quaternion_of(double columns[3][3], double to[4])
{
    const double(*c)[3] = (const double(*)[3])columns;
    const double squares[4] = {1 + c[0][0] - c[1][1] - c[2][2], 1 - c[0][0] + c[1][1] - c[2][2],
                               1 - c[0][0] - c[1][1] + c[2][2], 1 + c[0][0] + c[1][1] + c[2][2]};
    int largest = 0;
    for (int i = 1; i < 4; i++)
        largest = squares[i] > squares[largest] ? i : largest;
    const double products[4][4] = {
        {squares[0], c[0][1] + c[1][0], c[2][0] + c[0][2], c[1][2] - c[2][1]},
        {c[0][1] + c[1][0], squares[1], c[1][2] + c[2][1], c[2][0] - c[0][2]},
        {c[2][0] + c[0][2], c[1][2] + c[2][1], squares[2], c[0][1] - c[1][0]},
        {c[1][2] - c[2][1], c[2][0] - c[0][2], c[0][1] - c[1][0], squares[3]},
    };
    double length = 0;
    for (int i = 0; i < 4; i++)
        length += products[largest][i] * products[largest][i];
    for (int i = 0; i < 4; i++)
        to[i] = products[largest][i] / sqrt(length);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Makes the columns lengths and unit vectors that are a rotation; those of length 0 become what the
 * others leave. The columns are at right angles to each other. */
static void normalize(double columns[3][3], double lengths[3])
{
    double longest = 0;
    for (int i = 0; i < 3; i++) {
        lengths[i] = sqrt(dot(columns[i], columns[i]));
        longest = fmax(longest, lengths[i]);
    }
    int known = 0;
    for (int i = 0; i < 3; i++) {
        if (lengths[i] <= longest * 1e-12)
            lengths[i] = 0;
        for (int j = 0; j < 3; j++)
            columns[i][j] = lengths[i] > 0 ? columns[i][j] / lengths[i] : 0;
        known += lengths[i] > 0;
    }
    for (int i = 0; i < 3 && known < 2; i++) { /* any axis that differs most from the known one */
        double *column = columns[i];
        if (lengths[i] > 0)
            continue;
        const double *other = columns[lengths[(i + 1) % 3] > 0 ? (i + 1) % 3 : (i + 2) % 3];
        int axis = 0;
        for (int j = 1; j < 3; j++)
            axis = fabs(other[j]) < fabs(other[axis]) ? j : axis;
        column[axis] = 1;
        const double along = dot(column, other);
        for (int j = 0; j < 3; j++)
            column[j] -= along * other[j];
        const double length = sqrt(dot(column, column));
        for (int j = 0; j < 3; j++)
            column[j] /= length;
        known++;
    }
    for (int i = 0; i < 3; i++)
        if (dot(columns[i], columns[i]) < 0.5)
            cross(columns[(i + 1) % 3], columns[(i + 2) % 3], columns[i]);
    double normal[3];
    cross(columns[1], columns[2], normal);
    if (dot(normal, columns[0]) > 0)
        return;
    lengths[0] = -lengths[0];
    for (int j = 0; j < 3; j++)
        columns[0][j] = -columns[0][j];
}

/* Turns the columns, and those of `turned` with them, until they are at right angles: the one-sided
 * method of Jacobi, after Hestenes 1958. */
static bool make_orthogonal(double columns[3][3], double turned[3][3])
{
    enum { SWEEPS_MOST = 40 };
    /* Less than that is rounding of float, which needs no second node. */
    double most = 1e-6;
    bool is_turned = false;
    for (int sweep = 0; sweep < SWEEPS_MOST; sweep++) {
        bool is_done = true;
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                const double a = dot(columns[p], columns[p]), b = dot(columns[q], columns[q]),
                             c = dot(columns[p], columns[q]);
                if (fabs(c) <= most * sqrt(a) * sqrt(b))
                    continue;
                is_done = false;
                is_turned = true;
                most = 1e-14;
                const double angle = 0.5 * atan2(2 * c, a - b), s = sin(angle), k = cos(angle);
                for (int i = 0; i < 3; i++) {
                    const double x = columns[p][i], y = columns[q][i], u = turned[p][i],
                                 v = turned[q][i];
                    columns[p][i] = k * x + s * y;
                    columns[q][i] = k * y - s * x;
                    turned[p][i] = k * u + s * v;
                    turned[q][i] = k * v - s * u;
                }
            }
        if (is_done)
            break;
    }
    return is_turned;
}

static struct parts take_apart(const VkTransformMatrixKHR *matrix)
{
    struct parts parts;
    double columns[3][3], turned[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, rows[3][3];
    for (int i = 0; i < 9; i++)
        columns[i % 3][i / 3] = matrix->matrix[i / 3][i % 3];
    parts.has_inner = make_orthogonal(columns, turned);
    normalize(columns, parts.scale);
    quaternion_of(columns, parts.rotation);
    for (int i = 0; i < 9; i++)
        rows[i % 3][i / 3] = turned[i / 3][i % 3];
    quaternion_of(rows, parts.inner);
    return parts;
}

/* ---- nodes */

/* What an instance says, moving or not. */
struct placing {
    VkAccelerationStructureInstanceKHR instance; /* of motion, with the first matrix */
    uint32_t number;
};

/* Reads a row of instances. Returns false if its type of motion is unknown. */
static bool read_instance(const struct rows *rows, uint64_t at, struct placing *placing)
{
    VkAccelerationStructureMotionInstanceNV motion;
    struct motion_instance_record record = {.type = 0};
    struct instance_record first;
    placing->number = (uint32_t)at;
    const uint8_t *row = rows->bytes + at * rows->size;
    if (rows->size == sizeof(placing->instance)) {
        memcpy(&placing->instance, row, sizeof(placing->instance));
        return true;
    }
    memcpy(&motion, row, sizeof(motion));
    record.type = motion.type;
#define TAKE(from)                                                                                 \
    record.base.instance = (VkAccelerationStructureInstanceKHR)                                    \
    {                                                                                              \
        .instanceCustomIndex = (from).instanceCustomIndex, .mask = (from).mask,                    \
        .instanceShaderBindingTableRecordOffset = (from).instanceShaderBindingTableRecordOffset,   \
        .flags = (from).flags,                                                                     \
        .accelerationStructureReference = (from).accelerationStructureReference                    \
    }
    switch ((int)motion.type) {
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_STATIC_NV:
        placing->instance = motion.data.staticInstance;
        return true;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_MATRIX_MOTION_NV:
        TAKE(motion.data.matrixMotionInstance);
        record.at.matrix[0] = motion.data.matrixMotionInstance.transformT0;
        record.at.matrix[1] = motion.data.matrixMotionInstance.transformT1;
        break;
    case VK_ACCELERATION_STRUCTURE_MOTION_INSTANCE_TYPE_SRT_MOTION_NV:
        TAKE(motion.data.srtMotionInstance);
        record.at.srt[0] = motion.data.srtMotionInstance.transformT0;
        record.at.srt[1] = motion.data.srtMotionInstance.transformT1;
        break;
    default:
        return false;
    }
#undef TAKE
    motion_instance_at(&record, 0, &first);
    placing->instance = first.instance;
    return true;
}

static json_t *node_of(const double translation[3], const double rotation[4], const double scale[3])
{
    json_t *node =
        json_pack("{s:[f,f,f,f]}", "rotation", rotation[0], rotation[1], rotation[2], rotation[3]);
    if (scale)
        json_object_update_new(node, json_pack("{s:[f,f,f], s:[f,f,f]}", "translation",
                                               translation[0], translation[1], translation[2],
                                               "scale", scale[0], scale[1], scale[2]));
    return node;
}

static void add_node(struct gltf *gltf, uint32_t command, uint32_t structure,
                     const struct placing *placing)
{
    struct structure_state *state = &gltf->states[structure];
    const VkAccelerationStructureInstanceKHR *instance = &placing->instance;
    const struct parts parts = take_apart(&instance->transform);
    const float(*m)[4] = instance->transform.matrix;
    json_t *extras =
        json_pack("{s:i, s:i, s:i, s:i, s:i}", "instance", placing->number, "customIndex",
                  instance->instanceCustomIndex, "mask", instance->mask, "sbtOffset",
                  instance->instanceShaderBindingTableRecordOffset, "flags", instance->flags);
    const bool is_red = set_findings(gltf, extras, command, placing->number);
    if (!is_red && !parts.has_inner && !gltf->options->has_plain_nodes &&
        state->instances > INSTANCES_PER_NODE) {
        if (!state->shared)
            state->shared = capture_allocate(NULL, state->instances,
                                             FLOATS_PER_INSTANCE * sizeof(*state->shared));
        float *to = &state->shared[(size_t)FLOATS_PER_INSTANCE * state->shared_count++];
        for (int i = 0; i < 3; i++) {
            to[i] = m[i][3];
            to[7 + i] = (float)parts.scale[i];
        }
        for (int i = 0; i < 4; i++)
            to[3 + i] = (float)parts.rotation[i];
        json_decref(extras);
        return;
    }
    const double translation[3] = {m[0][3], m[1][3], m[2][3]};
    json_t *node = node_of(translation, parts.rotation, parts.scale), *holder = node;
    const int mesh = mesh_of(gltf, structure, is_red);
    if (gltf->capture->structures[structure].name)
        json_object_set_new(node, "name", json_string(gltf->capture->structures[structure].name));
    json_object_set_new(node, "extras", extras);
    if (parts.has_inner) {
        holder = node_of(NULL, parts.inner, NULL);
        json_object_set_new(node, "children",
                            json_pack("[i]", append(gltf->nodes, json_incref(holder))));
    }
    if (mesh >= 0)
        json_object_set_new(holder, "mesh", json_integer(mesh));
    if (parts.has_inner)
        json_decref(holder);
    append(gltf->roots, json_integer(append(gltf->nodes, node)));
}

/* Adds the node of instances that share one. */
static void add_shared(struct gltf *gltf, uint32_t structure)
{
    static const struct {
        const char *name, *type;
        int first, count;
    } attributes[] = {
        {"TRANSLATION", "VEC3", 0, 3}, {"ROTATION", "VEC4", 3, 4}, {"SCALE", "VEC3", 7, 3}};
    struct structure_state *state = &gltf->states[structure];
    const int mesh = mesh_of(gltf, structure, false);
    const size_t count = state->shared_count;
    if (mesh < 0)
        return;
    json_t *accessors = json_object();
    float *values = capture_allocate(NULL, count, 4 * sizeof(*values));
    for (int i = 0; i < 3; i++) {
        const size_t size = (size_t)attributes[i].count * sizeof(*values);
        for (size_t j = 0; j < count; j++)
            memcpy(&values[j * (size_t)attributes[i].count],
                   &state->shared[j * FLOATS_PER_INSTANCE + (size_t)attributes[i].first], size);
        json_object_set_new(accessors, attributes[i].name,
                            json_integer(add_accessor(gltf, values, count * size, 0,
                                                      COMPONENT_FLOAT, attributes[i].type, count)));
    }
    free(values);
    json_t *node = json_pack("{s:i, s:{s:{s:o}}, s:{s:I}}", "mesh", mesh, "extensions",
                             "EXT_mesh_gpu_instancing", "attributes", accessors, "extras",
                             "instances", (json_int_t)count);
    append(gltf->roots, json_integer(append(gltf->nodes, node)));
    gltf->has_instancing = true;
}

/* ---- the scene */

/* Finds what is in each structure once so many commands have been executed. What is destroyed
 * later stays: the reference of an instance says whether it was then. */
static void find_states(struct gltf *gltf, uint32_t command_count)
{
    for (uint32_t i = 0; i < gltf->capture->structure_count; i++)
        gltf->states[i] = (struct structure_state){.build = CAPTURE_NONE};
    for (uint32_t i = 0; i < command_count; i++) {
        const struct captured_command *command = &gltf->capture->commands[i];
        if (command->dst == CAPTURE_NONE)
            continue;
        struct structure_state *state = &gltf->states[command->dst];
        if (command->kind == CAPTURE_COMMAND_BUILD)
            state->build = i;
        else if (command->kind == CAPTURE_COMMAND_COPY)
            state->build =
                command->src == CAPTURE_NONE ? CAPTURE_NONE : gltf->states[command->src].build;
    }
}

static bool is_top(const struct gltf *gltf, uint32_t command)
{
    const struct captured_command *build = &gltf->capture->commands[command];
    return build->kind == CAPTURE_COMMAND_BUILD && build->geometry_count &&
           build->geometries[0].type == CAPTURE_INSTANCES;
}

/* Finds the structure to export. Returns false with an error. */
static bool find_top(struct gltf *gltf, uint32_t command_count, uint32_t *top)
{
    const char *wanted = gltf->options->tlas;
    const struct capture *capture = gltf->capture;
    *top = CAPTURE_NONE;
    for (uint32_t i = 0; i < capture->structure_count && wanted; i++) {
        char id[24];
        const struct captured_structure *structure = &capture->structures[i];
        snprintf(id, sizeof(id), "%" PRIu64, structure->id);
        if (gltf->states[i].build != CAPTURE_NONE &&
            (strcmp(id, wanted) == 0 || (structure->name && strcmp(structure->name, wanted) == 0)))
            *top = i;
    }
    for (uint32_t i = 0; i < command_count && !wanted; i++)
        if (capture->commands[i].dst != CAPTURE_NONE && is_top(gltf, i))
            *top = capture->commands[i].dst;
    if (*top == CAPTURE_NONE && wanted)
        snprintf(gltf->error->text, sizeof(gltf->error->text),
                 "%s: no structure with that name or id had been built by then", wanted);
    return *top != CAPTURE_NONE || !wanted;
}

/* Places a structure at the origin. */
static void add_alone(struct gltf *gltf, uint32_t structure)
{
    const struct placing placing = {
        .instance = {.transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, .mask = 0xff}};
    add_node(gltf, CAPTURE_NONE, structure, &placing);
}

/* Finds the structure of an instance, or returns why it is left out. */
static enum left_out find_structure(const struct gltf *gltf, const struct captured_command *build,
                                    const struct placing *placing, uint32_t *structure)
{
    const uint64_t address = placing->instance.accelerationStructureReference;
    const float(*m)[4] = placing->instance.transform.matrix;
    if (!address)
        return LEFT_NULL_INSTANCES;
    const struct captured_reference *reference = capture_reference_of(build, address);
    if (reference && reference->is_dead)
        return LEFT_DESTROYED;
    if (!reference || reference->structure == CAPTURE_NONE)
        return LEFT_UNKNOWN;
    *structure = reference->structure;
    for (int i = 0; i < 3; i++)
        if (!is_finite(m[i]) || !isfinite(m[i][3]))
            return NOT_FINITE;
    return gltf->states[*structure].build == CAPTURE_NONE ||
                   is_top(gltf, gltf->states[*structure].build)
               ? LEFT_NOT_BUILT
               : LEFT_OUT;
}

/* Counts the instances of each structure first, and then adds them. */
static void add_instances(struct gltf *gltf, uint32_t command)
{
    const struct captured_command *build = &gltf->capture->commands[command];
    const struct rows rows = load(gltf, &build->geometries[0], CAPTURE_INSTANCE_ROWS);
    const uint64_t asked = build->geometries[0].primitive_count,
                   count = rows.count < asked ? rows.count : asked;
    gltf->left_out[NOT_IN_CAPTURE] += asked - count;
    for (int is_adding = 0; is_adding < 2; is_adding++)
        for (uint64_t i = 0; i < count; i++) {
            struct placing placing;
            uint32_t structure = CAPTURE_NONE;
            const enum left_out why = read_instance(&rows, i, &placing)
                                          ? find_structure(gltf, build, &placing, &structure)
                                          : LEFT_UNKNOWN;
            if (why == LEFT_OUT && is_adding)
                add_node(gltf, command, structure, &placing);
            else if (why == LEFT_OUT)
                gltf->states[structure].instances++;
            else if (is_adding)
                gltf->left_out[why]++;
        }
    for (uint32_t i = 0; i < gltf->capture->structure_count; i++)
        if (gltf->states[i].shared)
            add_shared(gltf, i);
}

/* ---- the file */

static json_t *make_root(const struct gltf *gltf, uint32_t build)
{
    json_t *extras = json_object();
    for (uint32_t i = 0; i < LEFT_OUT; i++)
        if (gltf->left_out[i])
            json_object_set_new(extras, left_out_names[i],
                                json_integer((json_int_t)gltf->left_out[i]));
    extras = json_pack("{s:o}", "leftOut", extras);
    set_findings(gltf, extras, build, CAPTURE_NONE);
    json_t *scene = json_pack("{s:o}", "extras", extras);
    json_t *root = json_pack("{s:{s:s, s:s}, s:i, s:[O]}", "asset", "version", "2.0", "generator",
                             "assay-scene " ASSAY_VERSION, "scene", 0, "scenes", scene);
    const struct {
        const char *key;
        json_t *array;
    } arrays[] = {
        {"nodes", gltf->nodes},         {"meshes", gltf->meshes},
        {"materials", gltf->materials}, {"accessors", gltf->accessors},
        {"bufferViews", gltf->views},
    };
    for (size_t i = 0; i < sizeof(arrays) / sizeof(*arrays); i++)
        if (json_array_size(arrays[i].array)) /* glTF has no empty arrays */
            json_object_set(root, arrays[i].key, arrays[i].array);
    if (json_array_size(gltf->roots))
        json_object_set(scene, "nodes", gltf->roots);
    if (gltf->size)
        json_object_set_new(root, "buffers",
                            json_pack("[{s:I}]", "byteLength", (json_int_t)gltf->size));
    if (gltf->has_instancing)
        json_object_set_new(root, "extensionsUsed", json_pack("[s]", "EXT_mesh_gpu_instancing"));
    json_decref(scene);
    return root;
}

static bool write_glb(const struct gltf *gltf, uint32_t build, const char *path)
{
    json_t *root = make_root(gltf, build);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    const size_t length = text ? strlen(text) : 0, padded = (length + 3) / 4 * 4,
                 whole = 12 + 8 + padded + (gltf->size ? 8 + gltf->size : 0);
    const uint32_t head[] = {0x46546c67, 2, (uint32_t)whole, (uint32_t)padded, 0x4e4f534a},
                   binary[] = {(uint32_t)gltf->size, 0x004e4942};
    FILE *file = text && whole <= UINT32_MAX ? fopen(path, "wb") : NULL;
    bool is_written = file && fwrite(head, sizeof(head), 1, file) == 1 &&
                      fprintf(file, "%-*s", (int)padded, text) == (int)padded;
    if (is_written && gltf->size)
        is_written = fwrite(binary, sizeof(binary), 1, file) == 1 &&
                     fwrite(gltf->bytes, gltf->size, 1, file) == 1;
    if (file && fclose(file) != 0)
        is_written = false;
    free(text);
    if (!is_written)
        snprintf(gltf->error->text, sizeof(gltf->error->text), "%s: %s", path,
                 whole > UINT32_MAX ? "glTF's binary form has at most 4 GiB" : "cannot be written");
    return is_written;
}

bool export_gltf(struct capture *capture, const char *path, const struct export_options *options,
                 struct capture_error *error)
{
    uint32_t command_count = capture->command_count, top;
    if (options->at && !capture_find_point(capture, options->at, &command_count, error))
        return false;
    struct gltf gltf = {
        .capture = capture,
        .options = options,
        .error = error,
        .states = capture_allocate(NULL, capture->structure_count, sizeof(*gltf.states)),
        .views = json_array(),
        .accessors = json_array(),
        .meshes = json_array(),
        .nodes = json_array(),
        .roots = json_array(),
        .materials = json_array(),
    };
    error->text[0] = '\0';
    find_states(&gltf, command_count);
    bool is_done = find_top(&gltf, command_count, &top);
    if (is_done) {
        add_material(&gltf, "finding", 0, 1);
        for (uint32_t i = 0; i < capture->structure_count && top == CAPTURE_NONE; i++)
            if (gltf.states[i].build != CAPTURE_NONE)
                add_alone(&gltf, i);
        if (top != CAPTURE_NONE && is_top(&gltf, gltf.states[top].build))
            add_instances(&gltf, gltf.states[top].build);
        else if (top != CAPTURE_NONE)
            add_alone(&gltf, top);
        is_done = !error->text[0] &&
                  write_glb(&gltf, top == CAPTURE_NONE ? top : gltf.states[top].build, path);
    }
    for (uint32_t i = 0; i < capture->structure_count; i++) {
        json_decref(gltf.states[i].mesh);
        free(gltf.states[i].shared);
    }
    json_t *const arrays[] = {gltf.views, gltf.accessors, gltf.meshes,
                              gltf.nodes, gltf.roots,     gltf.materials};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(*arrays); i++)
        json_decref(arrays[i]);
    free(gltf.states);
    free(gltf.bytes);
    return is_done;
}
