/* SPDX-License-Identifier: Apache-2.0 */
/* Records builds and their inputs in a journal. Entries are filled in place, because each recorded
 * build has one. */
#include "layer/intercepts/intercepts.h"

#include "src/base/recording_path.h"
#include "src/model/geometry.h"
#include "src/state/builds/structures.h"

static uint32_t position_of(const struct build_call *call, const struct build_view *build)
{
    return call->view.command_buffer.build_index + build->index;
}

/* ---- inputs */

/* Inputs of a build that are being recorded: the position of the next one. */
struct noting {
    struct journal *journal;
    struct journal_input *next;
    uint32_t position, info, geometry;
    unsigned char command;
    bool geometry_by_pointer;
};

static inline struct noting begin_noting(const struct build_call *call,
                                         const struct build_view *build, uint32_t geometry)
{
    return (struct noting){.journal = call->journal,
                           .next = journal_begin_inputs(call->journal),
                           .position = position_of(call, build),
                           .info = build->index,
                           .geometry = geometry,
                           .command = (unsigned char)call->view.command,
                           .geometry_by_pointer = build->geometry_pointers != NULL};
}

static inline void note_input(struct noting *noting, enum input_role role,
                              const struct address_facts *facts)
{
    if (facts->status != ADDRESS_IN_BUFFER ||
        !journal_notes_buffer(noting->journal, facts->buffer_id))
        return;
    struct journal_input input =
        journal_input_of(role, noting->command, noting->position, facts->buffer_id);
    input.geometry_by_pointer = noting->geometry_by_pointer;
    input.info = noting->info;
    input.geometry = noting->geometry;
    input.address = facts->address;
    *noting->next++ = input;
}

static inline void note_geometry(struct noting *noting, const struct geometry_view *geometry)
{
    if (!type_is_triangles(geometry->geometry->geometryType)) {
        note_input(noting, data_role(geometry), &geometry->data);
        return;
    }
    note_input(noting, INPUT_VERTEX, &geometry->vertex);
    note_input(noting, INPUT_INDEX, &geometry->index_data);
    note_input(noting, INPUT_MATRIX, &geometry->transform);
}

/* Records an address of a build or of one of its geometries. */
static void note_address(const struct build_call *call, const struct build_view *build,
                         uint32_t geometry, enum input_role role, const struct address_facts *facts)
{
    struct noting noting = begin_noting(call, build, geometry);
    if (!noting.next)
        return;
    note_input(&noting, role, facts);
    journal_end_inputs(call->journal, noting.next);
}

static void record_geometry(void *user, const struct geometry_view *geometry)
{
    const struct build_call *call = user;
    const struct chained_inputs *chained = geometry->chained;
    if (!call->command_buffer)
        return;
    struct noting noting = begin_noting(call, geometry->build, geometry->index);
    if (noting.next) {
        note_geometry(&noting, geometry);
        journal_end_inputs(call->journal, noting.next);
    }
    for (uint32_t i = 0; chained && i < chained->count; i++)
        note_address(call, geometry->build, geometry->index, chained->items[i].role,
                     &chained->items[i].facts);
}

static void record_indirect(void *user, const struct indirect_view *indirect)
{
    note_address(user, indirect->build, 0, INPUT_INDIRECT, &indirect->facts);
}

/* ---- builds */

/* Records the micromaps that a build reads. */
__attribute__((cold)) static void note_micromaps(const struct build_call *call,
                                                 const struct build_view *build)
{
    const struct micromap_uses *uses = build->micromaps;
    bool may_change =
        build->info->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_OPACITY_MICROMAP_UPDATE_BIT_KHR;
    bool updates = build_is_update(build->info);
    for (uint32_t i = 0; i < uses->count; i++) {
        const struct micromap_use *use = &uses->items[i];
        const struct journal_entry entry = {
            .command = (unsigned char)call->view.command,
            .info = build->index,
            .geometry_by_pointer = build->geometry_pointers != NULL,
            .src = use->handle,
            .src_id = use->id,
            .micromap = {.updated = updates ? handle_number(build->src.handle) : 0,
                         .updated_id = updates ? build->src.id : 0,
                         .position = position_of(call, build),
                         .geometry = use->geometry,
                         .first = use->first,
                         .triangle_count = use->triangle_count,
                         .is_ext = use->is_ext,
                         .is_unindexed = use->is_unindexed,
                         .must_stay = updates && !may_change},
        };
        if (use->id)
            journal_add_use_micromap(call->journal, entry);
    }
}

static inline unsigned char backing_of(const struct accel_facts *accel)
{
    return (unsigned char)((accel->backed == YES ? BACKED_BY_MEMORY : 0) |
                           (accel->is_sparse ? BACKED_BY_SPARSE : 0));
}

/* Records src, which only updates read. */
static inline void note_src(struct journal_entry *entry, const struct build_view *build)
{
    if (!build_is_update(build->info)) {
        entry->src = entry->src_id = 0;
        entry->src_backing = 0;
        return;
    }
    entry->src = handle_number(build->src.handle);
    entry->src_id = build->src.id;
    entry->src_backing = backing_of(&build->src);
}

static bool has_all_geometries(const struct build_view *build)
{
    return build->geometry_count == build->info->geometryCount;
}

/* Adds the shapes of the geometries, or marks them as unknown if the geometries could not be read.
 * Ends the entry. */
__attribute__((noinline)) static void
add_shapes(struct journal *journal, const struct build_view *build, struct journal_entry *entry)
{
    const struct build_description description = {
        .info = build->info,
        .ranges = build->ranges,
        .dst_size = build->dst.size,
        .needed_size = build->sizes.known ? build->sizes.acceleration_structure : 0,
        .dense_readable = build->dense_readable,
        .micromaps = build->micromaps,
        .inputs = build->inputs,
    };
    if (has_all_geometries(build))
        built_add_shapes(&entry->built, &description);
    else
        built_forget(&entry->built);
    journal_end_entry(journal, entry);
}

/* Whether the inputs of the call's builds may be copied. */
static inline bool is_copied(const struct build_call *call)
{
    return call->device->snapshots && call->command_buffer;
}

static inline void note_build(const struct build_call *call, const struct build_view *build)
{
    struct journal_entry *entry =
        journal_begin_build(call->journal, build_is_update(build->info), is_copied(call));
    if (!entry)
        return;
    entry->command = (unsigned char)call->view.command;
    entry->judged = false;
    entry->info = build->index;
    entry->origin = build_call_origin(call);
    entry->dst = handle_number(build->dst.handle);
    entry->dst_id = build->dst.id;
    entry->dst_backing = backing_of(&build->dst);
    entry->geometry_by_pointer = build->geometry_pointers != NULL;
    note_src(entry, build);
    built_describe(&entry->built, build->info, &call->view.command_buffer,
                   position_of(call, build));
    if (build->sizes.known)
        entry->built.plain_size = build->sizes.acceleration_structure;
    if (built_has_shapes(build->info) || !has_all_geometries(build))
        add_shapes(call->journal, build, entry);
}

static const VkAccelerationStructureGeometryKHR *geometry_of(const struct build_view *build,
                                                             uint32_t i)
{
    return build->geometries ? &build->geometries[i] : build->geometry_pointers[i];
}

/* Returns false if the number is unknown: the counts are in device memory, or in the data of dense
 * geometries, or they are unreadable. */
static bool count_primitives(const struct build_view *build, VkDeviceSize *count)
{
    *count = 0;
    if (!has_all_geometries(build) || (build->geometry_count && !build->ranges))
        return false;
    for (uint32_t i = 0; i < build->geometry_count; i++) {
        if (type_is_dense(geometry_of(build, i)->geometryType))
            return false;
        *count += build->ranges[i].primitiveCount;
    }
    return true;
}

/* For setting record_builds, and consumers. */
__attribute__((cold)) static void note_figures(const struct build_call *call,
                                               const struct build_view *build)
{
    struct journal_entry entry = {0};
    entry.info = count_primitives(build, &entry.number);
    if (build->sizes.known && build_is_update(build->info))
        entry.dst = build->sizes.update_scratch;
    else if (build->sizes.known)
        entry.dst = build->sizes.build_scratch;
    if (entry.info || entry.dst)
        journal_add_primitives(call->journal, entry);
}

/* Records the place of copies of a build that writes no known structure. */
__attribute__((cold)) static void note_unknown_build(const struct build_call *call,
                                                     const struct build_view *build)
{
    struct journal_entry *entry = is_copied(call)
                                      ? journal_add_inputs(call->journal, call->view.command,
                                                           build->index, position_of(call, build))
                                      : NULL;
    if (entry)
        entry->origin = build_call_origin(call);
}

/* Records all inputs of a typical build at once. */
static inline void note_inputs(const struct build_call *call, const struct build_view *build,
                               const struct geometry_view *geometry)
{
    struct noting noting = begin_noting(call, build, 0);
    if (!noting.next)
        return;
    if (geometry)
        note_geometry(&noting, geometry);
    if (build->dst.id && build->sizes.known)
        note_input(&noting, build_is_update(build->info) ? INPUT_UPDATE_SCRATCH : INPUT_SCRATCH,
                   &build->scratch);
    journal_end_inputs(call->journal, noting.next);
}

ON_RECORDING_PATH static void record_build(void *user, const struct build_view *build,
                                           const struct geometry_view *geometry)
{
    const struct build_call *call = user;
    const struct command_buffer *command_buffer = call->command_buffer;
    if (command_buffer)
        note_inputs(call, build, geometry);
    if (!build->dst.id) {
        note_unknown_build(call, build);
        return;
    }
    if (build->micromaps && command_buffer)
        note_micromaps(call, build);
    if (call->device->notes_figures)
        note_figures(call, build);
    note_build(call, build);
}

/* If the ranges cannot be kept, rules about them stay silent. */
void build_notes_record_ranges(void *user, struct noted_ranges *ranges)
{
    const struct build_call *call = user;
    if (!ranges)
        return;
    ranges->position = call->view.command_buffer.build_index;
    journal_add_ranges(
        call->journal,
        (struct journal_entry){.command = (unsigned char)call->view.command, .ranges = ranges});
}

const struct build_recorder *build_notes_recorder(void)
{
    static const struct build_recorder recorder = {
        .record_build = record_build,
        .record_geometry = record_geometry,
        .record_indirect = record_indirect,
        .record_ranges = build_notes_record_ranges,
        .record_nv_build = nv_record_build,
        .record_nv_input = nv_record_input,
    };
    return &recorder;
}
