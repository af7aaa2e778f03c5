/* SPDX-License-Identifier: Apache-2.0 */
/* Words why two accesses are not ordered, and what orders them: what the barrier between them
 * lacks, or which barrier, semaphore or wait to add. */
#include "src/report/hazard_message.h"

#include <inttypes.h>

enum { BARRIER_FRAMES_SHOWN = 2 };

/* An application may take 4.3 s (UINT32_MAX ns) for no limit. */
void hazard_append_timeout(struct text_buffer *text, uint64_t timeout)
{
    if (timeout)
        text_append(text,
                    " In between, a wait of the host returned VK_TIMEOUT after %.3g s (timeout "
                    "%" PRIu64 " ns), so the host has observed nothing by it.",
                    (double)timeout * 1e-9, timeout);
}

static void append_reason(struct text_buffer *text, const struct hazard_report *report)
{
    const struct hazard *hazard = &report->hazard;
    const struct access_names src = access_names(hazard->earlier.kind, &report->features);
    const struct access_names dst = access_names(hazard->later.kind, &report->features);
    if (hazard->is_racing)
        text_append(text, " Nothing orders the two accesses, so they may happen in either order.");
    else if (!hazard->is_ordered)
        text_append(text, " Nothing between them makes the second command wait for the first.");
    else if (!hazard->is_available)
        text_append(text,
                    " The second command waits for the first, but no srcAccessMask with %s%s makes "
                    "the write available.",
                    src.access_prefix, src.access);
    else
        text_append(text,
                    " The second command waits for the first, and the write is available, but no "
                    "dstAccessMask with %s%s makes it visible.",
                    dst.access_prefix, dst.access);
}

/* Appends which barrier it is. */
static void append_barrier_place(struct text_buffer *text, struct message *message,
                                 const struct hazard_report *report)
{
    const struct hazard_barrier_text *barrier = &report->barrier;
    text_append(text, barrier->follows ? "the barrier behind " : "the first barrier of ");
    if (barrier->follows)
        text_append(text, "%s", barrier->follows);
    if (barrier->follows && barrier->builds)
        text_append(text, ", build %" PRIu32 ",", barrier->first_build + barrier->builds - 1);
    text_append(text, barrier->follows ? " in " : "");
    message_append_object(text, message, VK_OBJECT_TYPE_COMMAND_BUFFER,
                          handle_number(barrier->command_buffer), report->later.origin.names);
}

/* Appends the access of the later command that needs the same barrier. */
static void append_write(struct text_buffer *text, const struct hazard_report *report)
{
    if (report->write != ACCESS_KINDS) {
        const struct access_names write = access_names(report->write, &report->features);
        text_append(text, " | %s%s", write.access_prefix, write.access);
    }
}

/* Names what the barrier between the two commands lacks. */
static void append_barrier(struct text_buffer *text, struct message *message,
                           const struct hazard_report *report)
{
    const struct hazard_barrier_text *barrier = &report->barrier;
    const struct hazard *hazard = &report->hazard;
    const bool needs_access = hazard->type != WRITE_AFTER_READ;
    const char *side = barrier->lacks_src ? "src" : "dst";
    const struct access_names names = access_names(
        barrier->lacks_src ? hazard->earlier.kind : hazard->later.kind, &report->features);
    text_append(text, " Add ");
    if (barrier->lacks_stage)
        text_append(text, "%s%s to the %sStageMask%s", names.stage_prefix, names.stage, side,
                    needs_access ? ", and " : "");
    if (needs_access)
        text_append(text, "%s%s", names.access_prefix, names.access);
    if (needs_access && !barrier->lacks_src)
        append_write(text, report);
    if (needs_access)
        text_append(text, " to the %sAccessMask", side);
    text_append(text, " of ");
    append_barrier_place(text, message, report);
    if (barrier->call_site)
        text_append(text, " (at ");
    if (barrier->call_site)
        message_append_call_frames(text, barrier->call_site, BARRIER_FRAMES_SHOWN);
    text_append(text, barrier->call_site ? ")." : ".");
}

/* Names only what the device has enabled. */
static void append_hint(struct text_buffer *text, struct message *message,
                        const struct hazard_report *report)
{
    const struct hazard *hazard = &report->hazard;
    const struct access_names src = access_names(hazard->earlier.kind, &report->features);
    const struct access_names dst = access_names(hazard->later.kind, &report->features);
    if (hazard->earlier.queue == HAZARD_HOST_QUEUE || hazard->later.queue == HAZARD_HOST_QUEUE) {
        text_append(text,
                    " Wait on the host until the first has completed, for example for a "
                    "fence, before the second.");
        return;
    }
    if (hazard->is_racing) {
        text_append(text,
                    " Signal a semaphore after the first, and let the second wait for it at %s%s.",
                    dst.stage_prefix, dst.stage);
        return;
    }
    if (report->barrier.is_there) {
        append_barrier(text, message, report);
        return;
    }
    text_append(text, " Record a barrier between them with srcStageMask %s%s, dstStageMask %s%s",
                src.stage_prefix, src.stage, dst.stage_prefix, dst.stage);
    if (hazard->type != WRITE_AFTER_READ)
        text_append(text, ", srcAccessMask %s%s, dstAccessMask %s%s", src.access_prefix, src.access,
                    dst.access_prefix, dst.access);
    append_write(text, report);
    text_append(text, ".");
}

void hazard_append_remedy(struct text_buffer *text, struct message *message,
                          const struct hazard_report *report)
{
    append_reason(text, report);
    hazard_append_timeout(text, report->timeout);
    append_hint(text, message, report);
}
