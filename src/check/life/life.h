/* SPDX-License-Identifier: Apache-2.0 */
/* Validates calls of the commands of commands.def: all about acceleration structures and micromaps
 * but the builds of structures. */
#ifndef ASSAY_CHECK_LIFE_LIFE_H
#define ASSAY_CHECK_LIFE_LIFE_H

#include "src/check/walk/walk.h"
#include "src/snapshots/recorded_build.h"
#include "src/view/life_view.h"

/* Validates a call by the active rules of the context. `call->arguments` is the command's struct
 * arguments_of_NAME. */
void check_life(struct check_context *context, const struct call_view *call);

/* Returns the micromaps that serialized data on the host refer to, for a structure which is
 * deserialized from them. Returns NULL if none is known, or without memory. */
struct geometry_shapes *check_referenced_micromaps(struct check_context *context,
                                                   const void *bytes);

/* Validates the data that a deserialization of a command buffer has read. `bytes`: the first `size`
 * bytes of the data, or all. */
void check_read_serialized(struct walk *walk, const struct call_view *call,
                           const struct deserialization *deserialization, const void *bytes,
                           uint64_t size);

/* Validates a structure that the device has read, by the tables of implicit.h. `bytes` may be
 * misaligned. `addresses_are_known`: no buffer was destroyed since. */
void check_implicit_read(struct walk *walk, const struct call_view *call,
                         const struct location *location, const char *name, const void *bytes,
                         bool addresses_are_known);

/* ---- for the files of this folder: each validates the commands of one subject */

/* Validates the arguments of a call by the tables of implicit.h. Returns false if enumerants,
 * flags, counts or pointers are invalid, so that nothing else about the call can be decided. */
bool check_implicit(struct walk *walk, const struct call_view *call);

/* Validates the structures with ids that a VkWriteDescriptorSet chains. */
void check_implicit_descriptor(struct walk *walk, const struct call_view *call,
                               const struct location *location, const void *chain);

void check_copy(struct walk *walk, const struct call_view *call);
/* Sets copy->data from the memory that a copy on the host reads. */
void check_view_serialized(struct check_context *context, struct copy_view *copy);
void check_descriptors(struct walk *walk, const struct call_view *call);
void check_templated(struct walk *walk, const struct call_view *call);
void check_bindings(struct walk *walk, const struct call_view *call);
void check_capture(struct walk *walk, const struct call_view *call);
void check_micromap_builds(struct walk *walk, const struct call_view *call);
void check_micromap_size_query(struct walk *walk, const struct call_view *call);
/* Builds at addresses, and queries of their sizes; ignores all other commands. */
void check_addressed(struct walk *walk, const struct call_view *call);
/* Validates a write of descriptors of partitioned structures, at a location that has its index. */
void check_partition_descriptors(struct walk *walk, const struct call_view *call,
                                 struct location location, const VkWriteDescriptorSet *write);
void check_lookup(struct walk *walk, const struct call_view *call);
void check_create(struct walk *walk, const struct call_view *call);
void check_query(struct walk *walk, const struct call_view *call);
void check_read_queries(struct walk *walk, const struct call_view *call);
void check_size_query(struct walk *walk, const struct call_view *call);
void check_destroyed(struct walk *walk, const struct call_view *call);

/* Returns what a pointer of the application leads to, aligned as any structure. Returns NULL if it
 * is not readable. */
const void *check_read(struct check_context *context, const void *pointer, size_t size);
/* The same for the parameter pInfo, which is the last one of its commands. */
const void *check_info_argument(struct check_context *context, const struct call_view *call,
                                size_t size);

/* Finds a structure or micromap; only its handle below level STATE. */
struct life_object check_find_object(struct check_context *context, VkObjectType type,
                                     uint64_t handle);

/* The location of what a parameter points to (NULL: of the parameters themselves), and of an
 * element of an array. */
struct location check_argument(const struct call_view *call, const char *parameter);
struct location check_element(const struct call_view *call, const char *parameter, uint32_t index);

/* Each evaluates the rows of its subject at all levels. */
void walk_copy(struct walk *walk, const struct copy_view *copy, const struct location *location);
void walk_create(struct walk *walk, const struct create_view *create,
                 const struct location *location);
void walk_query(struct walk *walk, const struct query_view *query, const struct location *location);
void walk_size_query(struct walk *walk, const struct size_query_view *size_query,
                     const struct location *location);
void walk_binding(struct walk *walk, const struct binding_view *binding,
                  const struct location *location);
void walk_capture(struct walk *walk, const struct capture_view *capture,
                  const struct location *location);
void walk_micromap_info(struct walk *walk, const struct micromap_info_view *micromap_info,
                        const struct location *location);
void walk_built_micromap(struct walk *walk, const struct built_micromap_view *built_micromap,
                         const struct location *location);
void walk_micromap_triangles(struct walk *walk,
                             const struct micromap_triangles_view *micromap_triangles,
                             const struct location *location);
void walk_descriptor(struct walk *walk, const struct descriptor_view *descriptor,
                     const struct location *location);
void walk_templated(struct walk *walk, const struct templated_view *templated,
                    const struct location *location);
void walk_lookup(struct walk *walk, const struct lookup_view *lookup,
                 const struct location *location);
void walk_destroyed(struct walk *walk, const struct destroyed_view *destroyed,
                    const struct location *location);
void walk_read_queries(struct walk *walk, const struct read_queries_view *read_queries,
                       const struct location *location);
void walk_queried(struct walk *walk, const struct queried_view *queried,
                  const struct location *location);

#endif
