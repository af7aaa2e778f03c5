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

#include "src/scene/contents.h"
#include "src/scene/tool.h"

enum {
    INSTANCES_PER_NODE = 100, /* more share a node */
    FLOATS_PER_INSTANCE = 10, /* of EXT_mesh_gpu_instancing: translation, rotation, scale */
    /* constants of glTF */
    ARRAY_BUFFER = 34962,
    ELEMENT_ARRAY_BUFFER = 34963,
    COMPONENT_UINT = 5125,
    COMPONENT_FLOAT = 5126,
};

/* The meshes of a structure. */
struct structure_state {
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
    uint32_t *builds; /* of contents_find_builds() */
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

/* Adds the primitives of a geometry that are red, or the others. */
static void add_primitives(struct gltf *gltf, json_t *primitives, const struct mesh *mesh,
                           const bool *red, bool is_red, int positions, json_t *extras,
                           int material)
{
    uint32_t *indices = capture_allocate(NULL, mesh->index_count, sizeof(*indices));
    uint32_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        if ((red && red[mesh->primitives[i]]) != is_red)
            continue;
        memcpy(&indices[count], &mesh->indices[(size_t)i * mesh->each],
               mesh->each * sizeof(*indices));
        count += mesh->each;
    }
    if (count) {
        const int accessor = add_accessor(gltf, indices, count * sizeof(*indices),
                                          ELEMENT_ARRAY_BUFFER, COMPONENT_UINT, "SCALAR", count);
        json_array_append_new(primitives, json_pack("{s:{s:i}, s:i, s:i, s:O}", "attributes",
                                                    "POSITION", positions, "indices", accessor,
                                                    "material", material, "extras", extras));
    }
    free(indices);
}

static void add_geometry(struct gltf *gltf, uint32_t command, uint32_t index, json_t *primitives,
                         int material)
{
    const struct captured_geometry *geometry = &gltf->capture->commands[command].geometries[index];
    struct mesh mesh = mesh_read(gltf->capture, geometry, gltf->left_out, gltf->error);
    if (mesh.position_count) {
        json_t *findings = NULL, *extras = json_pack("{s:i}", "geometry", index);
        bool *red = find_red(gltf, command, index,
                             mesh.primitives[mesh.primitive_count - 1] + (uint64_t)1, &findings);
        const int positions =
            add_positions(gltf, (const float(*)[3])mesh.positions, mesh.position_count);
        add_primitives(gltf, primitives, &mesh, red, false, positions, extras, material);
        json_t *red_extras = json_pack("{s:i, s:O?}", "geometry", index, "findings", findings);
        add_primitives(gltf, primitives, &mesh, red, true, positions, red_extras, 0);
        json_decref(extras);
        json_decref(red_extras);
        json_decref(findings);
        free(red);
    }
    mesh_release(&mesh);
}

/* Returns the mesh of a structure, or of its copy in red, which are made at their first use; -1 if
 * nothing is in it. */
static int mesh_of(struct gltf *gltf, uint32_t structure, bool is_red)
{
    struct structure_state *state = &gltf->states[structure];
    if (!state->mesh) {
        const struct captured_command *build = &gltf->capture->commands[gltf->builds[structure]];
        const struct captured_structure *captured = &gltf->capture->structures[structure];
        json_t *primitives = json_array();
        int material = -1;
        for (uint32_t i = 0; i < build->geometry_count; i++) {
            if (material < 0 || gltf->options->colors_flags)
                material = material_of(gltf, structure, build->geometries[i].flags);
            add_geometry(gltf, gltf->builds[structure], i, primitives, material);
        }
        json_t *extras = json_pack("{s:I, s:I}", "structure", (json_int_t)captured->id, "build",
                                   (json_int_t)build->n);
        set_findings(gltf, extras, gltf->builds[structure], CAPTURE_NONE);
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

static void add_node(struct gltf *gltf, uint32_t command, const struct placing *placing)
{
    const uint32_t structure = placing->structure;
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

/* Places a structure at the origin. */
static void add_alone(struct gltf *gltf, uint32_t structure)
{
    const struct placing placing = {
        .instance = {.transform = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}, .mask = 0xff},
        .structure = structure};
    add_node(gltf, CAPTURE_NONE, &placing);
}

/* Counts the instances of each structure first, and then adds them. */
static void add_instances(struct gltf *gltf, uint32_t command)
{
    uint32_t count;
    struct placing *placings =
        contents_read_instances(gltf->capture, gltf->builds, &gltf->capture->commands[command],
                                &count, gltf->left_out, gltf->error);
    for (uint32_t i = 0; i < count; i++)
        gltf->states[placings[i].structure].instances++;
    for (uint32_t i = 0; i < count; i++)
        add_node(gltf, command, &placings[i]);
    free(placings);
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
    memset(gltf.states, 0, capture->structure_count * sizeof(*gltf.states));
    gltf.builds = contents_find_builds(capture, command_count);
    bool is_done =
        contents_find_top(capture, gltf.builds, command_count, options->tlas, &top, error);
    if (is_done) {
        add_material(&gltf, "finding", 0, 1);
        for (uint32_t i = 0; i < capture->structure_count && top == CAPTURE_NONE; i++)
            if (gltf.builds[i] != CAPTURE_NONE)
                add_alone(&gltf, i);
        if (top != CAPTURE_NONE && contents_is_top(capture, gltf.builds[top]))
            add_instances(&gltf, gltf.builds[top]);
        else if (top != CAPTURE_NONE)
            add_alone(&gltf, top);
        is_done =
            !error->text[0] && write_glb(&gltf, top == CAPTURE_NONE ? top : gltf.builds[top], path);
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
    free(gltf.builds);
    free(gltf.bytes);
    return is_done;
}
