/* SPDX-License-Identifier: Apache-2.0 */
/* The observers of commands whatever the settings, and the build commands: what the generated
 * entries call, and what the files of this folder share. */
#ifndef ASSAY_LAYER_INTERCEPTS_INTERCEPTS_H
#define ASSAY_LAYER_INTERCEPTS_INTERCEPTS_H

#include "layer/layer.h"
#include "layer/physical_device.h"
#include "src/check/call/check.h"
#include "src/state/commands/journal.h"

/* ---- Commands that build no structures are validated before anything observes them. */

/* Whether a rule about the command is active on the device. */
bool checks_are_active(const struct layer_device *device, enum build_command command);

/* Validates a call. `arguments`: struct arguments_of_NAME. Returns true if the call is to be
 * skipped. */
bool check_command(struct layer_device *device, enum build_command command, const void *arguments);
/* Whether that has found something about the last call of this thread that was validated. */
bool check_has_found(void);

/* As check_referenced_micromaps(), at level CONTENT; below, returns NULL. */
struct geometry_shapes *find_referenced_micromaps(struct layer_device *device, const void *bytes);

/* Gets the sizes of a build of clusters or of a partitioned structure from the next layer: of a
 * structure whose sType says which. */
struct size_facts find_addressed_sizes(const struct layer_device *device, const void *input);

/* Reports that the first argument is no command buffer, or no device. */
void check_invalid_handle(enum build_command command, const void *handle);

/* ---- Call sites of commands that are validated, for setting call_sites. With the setting, entries
 * find the caller before they call the plain ones; without it, call sites cost nothing. */

/* Creates device->call_sites as the settings say. Without memory there are no call sites. */
void call_sites_enable(struct layer_device *device);

/* For an entry: its frame and its return address, see call_stack_walk_frames(). `device` may be
 * NULL for an invalid handle. If `is_quick`, unwinding tables are not used: the return address
 * alone is the site. Returns the site of the call in whose message callback this one is made, which
 * call_site_leave() gets. */
const struct call_site *call_site_enter(const struct layer_device *device, const void *dispatchable,
                                        const void *frame, const void *first, bool is_quick);
void call_site_leave(const struct call_site *outer);

/* The call site of the command that this thread is in; NULL: unknown, or there is none. */
const struct call_site *call_site_of_thread(void);
/* The call site for entries of a journal; NULL if the setting is off. */
static inline const struct call_site *call_site_of_call(const struct layer_device *device)
{
    return device->call_sites ? call_site_of_thread() : NULL;
}

/* ---- one call of a build command */

struct build_call {
    struct layer_device *device;
    struct command_buffer *command_buffer; /* NULL for host builds and if no record exists */
    struct call_view view;
    struct journal *journal;             /* in which the builds are recorded; or NULL */
    const struct execution_point *point; /* of a host build, see struct check_context */
    struct hazard_entry *hazards; /* the call's HAZARD_COMMAND, with setting hazards; or NULL */
    bool has_found;               /* a rule of the call's own was violated */
    bool skip;                    /* a callback asked to skip the call */
};

void build_call_start(struct build_call *call, struct layer_device *device,
                      enum build_command command);
/* Starts a call that is recorded in a command buffer; the handle may be invalid. */
void build_call_start_recorded(struct build_call *call, struct layer_device *device,
                               enum build_command command, VkCommandBuffer handle);

/* Reports that a build command was given a handle which is no command buffer. The report goes to
 * the device that the handle leads to, or else to any device. */
void build_call_report_command_buffer(enum build_command command, VkCommandBuffer handle);

/* Reports that a host command was given a handle which is no device. The report goes to any device.
 */
void build_call_report_device(enum build_command command, VkDevice handle);

/* For struct check_hooks; `user` is the call. */
bool build_call_found(void *user, enum rule rule, const struct location *location,
                      const struct finding *finding);
bool build_call_of_another_device(void *user, enum resource_kind kind, uint64_t handle);
static inline enum tristate build_call_vertex_format_supported(void *user, VkFormat format)
{
    return layer_vertex_format_supported(((struct build_call *)user)->device, format);
}
static inline enum tristate build_call_radius_format_supported(void *user, VkFormat format)
{
    return layer_radius_format_supported(((struct build_call *)user)->device, format);
}

/* For recorded calls: judges updates whose sources the command buffer has built itself. Then keeps
 * the call's journal entries, or removes them if the call will be skipped. Most journals have no
 * updates to judge. */
void build_call_settle_entries(struct build_call *call);
static inline void build_call_settle_journal(struct build_call *call)
{
    const struct command_buffer *command_buffer = call->command_buffer;
    if (command_buffer && call->journal &&
        (call->journal->has_sources_to_check || call->skip || command_buffer->has_known_states))
        build_call_settle_entries(call);
}

/* Returns the value of journal_entry.origin for the builds of the call. */
static inline uint32_t build_call_origin(const struct build_call *call)
{
    const struct command_buffer *command_buffer = call->command_buffer;
    return journal_note_origin(call->journal, command_buffer ? &command_buffer->labels : NULL,
                               call_site_of_call(call->device));
}

void build_call_count_builds(struct build_call *call, uint32_t count);

/* ---- the recorder: a struct build_recorder whose `user` is the struct build_call */

const struct build_recorder *build_notes_recorder(void);

/* Functions of the recorder. Those for COMMAND_NV are in nv.c. */
void build_notes_record_ranges(void *user, struct noted_ranges *ranges);
void nv_record_build(void *user, const struct nv_call_view *view);
void nv_record_input(void *user, uint32_t geometry, enum input_role role,
                     const struct buffer_facts *facts);

/* ---- what commands record in journals */

/* The id of a structure in journals; 0 if it is unknown. */
uint64_t layer_accel_id(const struct layer_device *device, VkAccelerationStructureKHR handle);

/* The bytes from an address to the end of its VkBuffer; 0: unknown. */
VkDeviceSize layer_bytes_at(const struct layer_device *device, VkDeviceAddress address);

/* The command buffer, if its commands are recorded in a journal. Returns NULL otherwise. */
struct command_buffer *layer_find_recording(const struct layer_device *device,
                                            VkCommandBuffer handle);

/* Records what a command that builds no structures does, and validates it as far as the command
 * buffer knows its sources. Returns whether to skip the call. */
bool layer_record(struct layer_device *device, VkCommandBuffer handle,
                  struct journal_entry *entries, uint32_t count);

/* Places a host command in execution order among the batches. Takes ownership of the journal. If
 * that is NULL, because memory ran out, the order becomes unknown. Returns false if memory runs out
 * for the command: then nothing is known of it. */
bool layer_run_host_command(struct layer_device *device, struct journal *journal);

/* ---- A host command that builds or copies acceleration structures, from begin to end. Its effects
 * are a journal of its own. The journal is judged before the call. It is applied when the work has
 * ended: after the call, or when the deferred operation completes. */

struct host_work {
    struct layer_device *device;
    struct journal *journal; /* NULL below level EXECUTION, and without memory; valid until
                                host_work_prepare() */
    struct submission *submission;
};

/* With setting hazards: the journal of the next host command of this thread, which has what the
 * command accesses. Takes over a reference, which host_work_begin() takes on; accepts NULL. */
void host_work_set_journal(struct journal *journal);

/* The caller then adds entries to the journal, if there is one. */
struct host_work host_work_begin(struct layer_device *device);

/* Adds an entry of this call, if there is a journal. */
void host_work_add(struct host_work *work, struct journal_entry *entry);

/* Called before the call goes down: judges updates. Returns true if the call is to be skipped,
 * because `skip` is set or a callback returned VK_TRUE; the work is then over. */
bool host_work_prepare(struct host_work *work, bool skip);

/* Called after the call with its result. Returns that result. */
VkResult host_work_finish(struct host_work *work, VkDeferredOperationKHR operation,
                          VkResult result);

/* What rules may read about the operation to which a command is deferred. */
struct deferred_operation_facts host_work_operation_facts(const struct layer_device *device,
                                                          VkDeferredOperationKHR operation);

/* Ends the submission of work that was deferred; a parameter of deferred_operations_create(). */
void host_work_end(void *submission, VkResult result);

#endif
