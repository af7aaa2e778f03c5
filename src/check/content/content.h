/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the input data of builds, from host memory or from snapshots, and evaluates the rules about
 * it. A `struct content` lives on the stack of its caller. */
#ifndef ASSAY_CHECK_CONTENT_CONTENT_H
#define ASSAY_CHECK_CONTENT_CONTENT_H

#include "src/base/handle_table.h"
#include "src/check/walk/walk.h"
#include "src/model/inputs.h"
#include "src/snapshots/memory.h"
#include "src/view/content_view.h"

/* Both functions need the environment of src/base/float_environment.h. */

/* Evaluates, at level CONTENT, the rules about the data of a geometry of a host build. Other rules
 * report unreadable data and unknown build ranges. */
void check_host_inputs(struct walk *walk, const struct range_view *range);

struct content;

/* Consumes the data of one executed build while it is read, besides the rules. A function may be
 * NULL. In inputs that are kept for later updates (content->retained) it may set `kept`, which
 * updates of the structure then have, too. */
struct build_reader {
    struct build_reader *next; /* another one of the same build */
    /* Called before the instances of a geometry, for each of them, and after each geometry. */
    void (*on_instances)(struct build_reader *reader, struct content *content);
    void (*on_instance)(struct build_reader *reader, struct content *content,
                        const VkAccelerationStructureInstanceKHR *instance);
    void (*on_geometry)(struct build_reader *reader, struct content *content);
    void (*end)(struct build_reader *reader); /* the build was read; frees the reader */
};

/* Evaluates the rules about the data of a geometry, which `memory` provides. `chained` is a copy of
 * the chained structures, or NULL. */
void content_check_geometry(struct walk *walk, const struct range_view *range,
                            const struct input_memory *memory, const struct chained_input *chained);

/* The findings about the data of one geometry. Each rule has one at most, which is about the first
 * element that violates it, and counts the others. */
struct content_findings {
    struct content_finding {
        enum rule rule;
        struct location location;
        struct finding finding;
        uint64_t last; /* the last element that violates the rule */
    } * items;
    uint32_t count, capacity;
};

/* The data of one geometry while the rules about it are evaluated. */
struct content {
    struct walk *walk;
    const struct range_view *range; /* its build range is known */
    const struct input_memory *memory;
    const struct chained_input *chained; /* NULL: the chain adds nothing */
    struct geometry_input inputs[GEOMETRY_INPUTS];
    uint32_t input_count;
    struct geometry_inputs *retained; /* for later updates, see content_retain_count() */
    struct content_indices {          /* of triangles; zeros: none, or not readable */
        const uint8_t *bytes;
        uint32_t size; /* of an index, in bytes */
        uint32_t max;  /* the largest index */
        uint64_t count;
        struct kept_indices *same; /* those of the update's source, if they are equal */
    } indices;
    /* The packed instances, or the pointers to instances, that the geometry reads; or NULL. */
    struct content_elements {
        const uint8_t *bytes;
        uint64_t size;
    } elements;
    uint64_t hash;   /* of packed instances, if what builds read is to be reported; or 0 */
    bool has_gaps;   /* the data of some instance is unknown */
    bool has_strays; /* some instance refers to what is unknown */
    struct content_findings findings;
    uint64_t violations;
};

/* Keeps the finding, or counts the element if the rule has a finding. `number` is that of the
 * element, which may violate a rule twice; `element` is as in struct finding. */
__attribute__((cold)) void content_found(struct content *content, enum rule rule,
                                         struct location location, const struct finding *finding,
                                         const char *element, uint64_t number);
/* Reports the findings at the end of the geometry. */
void content_report(struct content *content);

/* Returns the bytes of `count` elements of `size` bytes with a stride, beginning at an offset from
 * the address. Returns NULL if any byte is unreadable, or if `count` is 0. */
const uint8_t *content_find(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                            uint64_t offset, uint64_t count, uint64_t stride, uint64_t size);

/* Returns the hash of elements that follow others, whose hash is given; 0: there are none. */
uint64_t content_hash(const struct content_elements *elements, uint64_t hash);

/* Like content_find(), but gets the readable bytes up to the first unreadable one. Returns their
 * number. */
uint64_t content_find_some(const struct content *content, VkDeviceOrHostAddressConstKHR address,
                           uint64_t offset, uint64_t count, uint64_t stride, uint64_t size,
                           const void **bytes);

/* Returns what the geometry reads in a role; NULL: nothing. */
const struct geometry_input *content_input(const struct content *content, enum input_role role);
/* These two do what content_find() and content_find_some() do, for all elements of an input.
 * `input` may be NULL. */
const uint8_t *content_find_input(const struct content *content,
                                  const struct geometry_input *input);
uint64_t content_find_some_input(const struct content *content, const struct geometry_input *input,
                                 const void **bytes);
/* Opens the arrays found, each from its offset on, for the builder's readers. Returns false if that
 * fails. */
struct builder_geometry;
struct source;
bool content_open_source(const struct content *content, const struct builder_geometry *described,
                         struct source *source);
/* Describes the triangles or AABBs of the geometry for it, without transforms. Returns false if the
 * builder does not know their formats, or for other geometries. */
bool content_describe(const struct content *content, struct builder_geometry *described);
/* Reads the index at `position`; indices have `size` bytes each. */
uint32_t content_read_index(const uint8_t *indices, uint32_t size, uint64_t position);

/* Validates the radii of a geometry of spheres or linear swept spheres. */
void content_read_radii(struct content *content);

/* Validate the instances of a geometry, or one instance with motion. */
void content_read_instances(struct content *content);
void content_read_motion_instance(struct content *content, uint32_t index, const void *bytes);
/* Validates one instance with motion of which only the data is in memory, not the type. */
void content_read_motion_data(struct content *content, uint32_t index, uint32_t type,
                              const void *bytes);

struct instance_use;
/* Finds the structure that a reference refers to. If it is not among those that are kept, returns
 * `other`, all unknown if the structure is unknown. Valid until the next reference is found. */
struct instance_use *content_find_use(struct content *content, uint64_t reference,
                                      struct instance_use *other);
/* Counts an instance that refers to the structure. */
void content_count_use(struct instance_use *use, uint32_t index);
/* Evaluate the rules that apply to instances of every kind. An instance without reference is
 * inactive: its other members are ignored. */
void content_check_reference(struct content *content, uint32_t index, uint64_t reference,
                             const struct accel_facts *referenced);
void content_check_transform(struct content *content, uint32_t index, uint64_t reference,
                             const VkTransformMatrixKHR *matrix);
void content_check_instance(struct content *content, uint32_t index, bool has_motion,
                            const VkAccelerationStructureInstanceKHR *instance);

/* What an array looks like one of whose pointers leads nowhere, or one of whose instances refers to
 * nothing. */
struct data_look content_look_of_pointers(const struct content *content);
struct data_look content_look_of_instance(const struct content *content,
                                          const VkAccelerationStructureInstanceKHR *instance);

/* Store the inputs that later updates are compared with: of every geometry, which comes first, of
 * triangles and AABBs, and of one instance. */
void content_retain_count(struct content *content);
void content_retain_inputs(const struct content *content);
void content_retain_instance(const struct content *content, uint32_t index, uint64_t reference);
void content_retain_unknown_instance(struct content *content);
void content_release_inputs(struct walk *walk); /* called after the build is recorded */

/* The structures that instances of the current build refer to, each once. */
struct instance_uses {
    struct instance_use {
        struct accel_facts referenced;
        uint64_t checked;      /* the last instance whose flags were validated, see instances.c */
        uint32_t first, count; /* the first instance that refers to it, and how many do */
    } * items;
    uint32_t count, capacity;
    uint32_t geometry;           /* the number of geometries with instances so far */
    struct handle_table indices; /* reference to index in `items` + 1 */
};
/* Removes all structures. Keeps the memory of `items`. */
void content_forget_instances(struct instance_uses *instances);
/* Accepts NULL. */
void content_free_instances(struct instance_uses *instances);

/* Each evaluates the rules of its subject. */
void content_walk_indices(struct content *content, const struct indices_view *indices);
void content_walk_box(struct content *content, const struct box_view *box);
void content_walk_instance(struct content *content, const struct instance_view *instance);
void content_walk_nv_instance(struct content *content, const struct nv_instance_view *nv_instance);
void content_walk_instance_pointer(struct content *content,
                                   const struct instance_pointer_view *instance_pointer);
void content_walk_reference(struct content *content, const struct reference_view *reference);
void content_walk_motion_instance(struct content *content,
                                  const struct motion_instance_view *motion_instance);
void content_walk_micromap_triangle(struct content *content,
                                    const struct micromap_triangle_view *micromap_triangle);
void content_walk_opacity_index(struct content *content,
                                const struct opacity_index_view *opacity_index);
void content_walk_radius(struct content *content, const struct radius_view *radius);
void content_walk_transform(struct content *content, const struct transform_view *transform);

#endif
