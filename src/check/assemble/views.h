/* SPDX-License-Identifier: Apache-2.0 */
/* Makes views of calls, builds and geometries: what is readable of the application's arrays, and
 * the facts about the handles and addresses in them. */
#ifndef ASSAY_CHECK_ASSEMBLE_VIEWS_H
#define ASSAY_CHECK_ASSEMBLE_VIEWS_H

#include "src/check/walk/context.h"
#include "src/view/micromap_view.h"
#include "src/view/view.h"

/* Fills the flags of a call view: which arrays are readable. */
void view_call(struct check_context *context, struct call_view *call);

/* Fills a build view from parameters alone. view_build() has one caller, the loop over the builds
 * of a call: a second one would cost 30 instructions a build, because it is no longer inlined. */
void view_build(struct check_context *context, const struct call_view *call, uint32_t index,
                struct build_view *build);
/* Fills the view of a build whose sizes are queried. The query gives the primitive counts as
 * maximum counts. */
void view_sized_build(struct check_context *context, const struct call_view *call,
                      struct build_view *build);
void view_geometry(struct check_context *context, const struct build_view *build, uint32_t index,
                   struct geometry_view *geometry);

/* Gets the primitive count that the call gives for a geometry. Returns false if it is
 * unreadable. */
bool view_primitive_count(const struct build_view *build, uint32_t geometry, uint32_t *count);

/* Add facts from the state about handles and addresses: in one batch of up to VIEWS_MAX builds and
 * the first geometry of each, or of one geometry. */
enum { VIEWS_MAX = 16 };
void view_builds_found(struct check_context *context, struct build_view *builds,
                       struct geometry_view *first_geometries, unsigned count);
void view_geometry_found(struct check_context *context, struct geometry_view *geometry);

/* Adds the remaining facts, after view_builds_found() or view_geometry_found(). */
void view_build_state(struct check_context *context, struct build_view *build);
void view_geometry_state(struct check_context *context, struct geometry_view *geometry);

/* Queries the sizes of a build if its parameters are well-formed. `holds`: its rules about
 * parameters, and those of its geometries, are known to hold. */
void view_build_sizes(struct check_context *context, struct build_view *build, bool holds);

/* ---- Host memory that a build accesses, and whether it is there */

/* Returns whether `size` bytes are readable or lie in mapped device memory. Tools that trace writes
 * (gfxreconstruct) protect the pages of a mapping, and handle the faults: such pages are valid,
 * though they are not readable now. */
bool host_memory_is_there(struct check_context *context, const void *address, uint64_t size);

/* Returns the bytes of `count` elements of `size` bytes with a stride, beginning at an offset from
 * the address. */
struct host_bytes host_memory_bytes(struct check_context *context, const void *address,
                                    uint64_t offset, uint64_t count, uint64_t stride,
                                    uint64_t size);

/* ---- The pNext chains of geometries: which structures they may contain, and whether these are
 * readable. */

/* Longer chains are cyclic or invalid. */
enum { CHAIN_MAX = 64 };

/* Returns the size of a structure of a known type, or that of VkBaseInStructure. */
size_t chain_size_of(VkStructureType type);

enum chain_owner { CHAIN_OF_GEOMETRY, CHAIN_OF_TRIANGLES };

/* Walks a chain and fills `facts`, which the caller has zeroed. */
void chain_view(struct check_context *context, const struct device_facts *device,
                enum chain_owner owner, const void *chain, struct chain_facts *facts);

/* Returns whether each structure of a chain is readable, up to the size that its type has. */
bool chain_links_are_readable(struct check_context *context, const void *chain);
static inline bool chain_is_readable(struct check_context *context, const void *chain)
{
    return !chain || chain_links_are_readable(context, chain);
}

/* Returns the structure of a type in a chain for which chain_view() filled `facts`. Returns NULL if
 * there is none, or if the chain is unreadable or has duplicates. */
const void *chain_member(const void *chain, const struct chain_facts *facts, VkStructureType type);

/* Fills the usage counts of a micromap, which are an array or an array of pointers. */
void chain_view_usages(struct readable_cache *cache, uint32_t count, const void *array,
                       const void *const *pointers, struct micromap_usages *usages);

/* ---- micromaps: which of their structures a geometry has, and the facts about the objects and
 * addresses in them */

/* Each fills a view from parameters alone. Returns false if the geometry lacks the structure. */
bool view_micromap_data(struct check_context *context, const struct geometry_view *geometry,
                        struct micromap_data_view *view);
bool view_opacity(const struct geometry_view *geometry, struct opacity_view *view);
bool view_opacity_ext(struct check_context *context, const struct geometry_view *geometry,
                      struct opacity_ext_view *view);
bool view_displacement(struct check_context *context, const struct geometry_view *geometry,
                       struct displacement_view *view);

/* Each adds facts from the state and lists the addresses among the geometry's chained inputs. */
void view_micromap_data_state(struct check_context *context, struct geometry_view *geometry,
                              struct micromap_data_view *view);
void view_opacity_state(struct check_context *context, struct geometry_view *geometry,
                        struct opacity_view *view);
void view_opacity_ext_state(struct check_context *context, struct geometry_view *geometry,
                            struct opacity_ext_view *view);
void view_displacement_state(struct check_context *context, struct geometry_view *geometry,
                             struct displacement_view *view);

/* ---- Misaligned parameters of a build call are replaced by aligned copies in the views.
 * Unreadable parameters stay as they are. The copies belong to the context's aligned_copies. */

/* Returns whether the arrays of a call are aligned, as in nearly all calls. */
static inline bool call_is_aligned(const struct call_view *call)
{
    uintptr_t of_pointers = (uintptr_t)call->infos | (uintptr_t)(const void *)call->build_ranges |
                            (uintptr_t)(const void *)call->max_primitive_counts |
                            (uintptr_t)call->indirect_addresses;
    uintptr_t of_words = (uintptr_t)call->indirect_strides;
    return !(of_pointers & (_Alignof(uint64_t) - 1)) && !(of_words & (_Alignof(uint32_t) - 1));
}

/* Aligns the arrays of the call. Returns false if there is no memory. */
__attribute__((cold)) bool align_call(struct check_context *context, struct call_view *call);

/* Returns whether the geometries of a build, their chains, or arrays in the chains are
 * misaligned. */
__attribute__((cold)) bool build_is_misaligned(struct check_context *context,
                                               const struct build_view *build);
/* Aligns all of these. Returns false if there is no memory. */
__attribute__((cold)) bool align_build(struct check_context *context, struct build_view *build);

/* Aligns the parameters of COMMAND_NV. Returns false if there is no memory. */
bool align_nv_call(struct check_context *context, struct nv_call_view *call);

/* Returns `array` if it is aligned, else a copy. Returns NULL if there is no memory. */
static inline const void *align_array(struct check_context *context, const void *array, size_t size,
                                      size_t alignment)
{
    return is_aligned(array, alignment) ? array : aligned_copies_take(context->copies, array, size);
}

#endif
