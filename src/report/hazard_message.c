/* SPDX-License-Identifier: Apache-2.0 */
/* Hazards are templates. A message says what the two accesses are, why they are not ordered, and
 * what orders them: what the barrier between them lacks, or which barrier, semaphore or wait to
 * add. */
#include "src/report/hazard_message.h"

#include <string.h>

#include "src/model/input_names.h"
#include "src/report/message.h"
#include "src/report/words.h"
#include "src/state/commands/object_names.h"

enum { BARRIER_FRAMES_SHOWN = 2 };

enum hazard_id hazard_id_of(const struct hazard *hazard)
{
    switch (hazard->type) {
    case READ_AFTER_WRITE:
        return hazard->is_racing ? HAZARD_ID_READ_RACING_WRITE : HAZARD_ID_READ_AFTER_WRITE;
    case WRITE_AFTER_READ:
        return hazard->is_racing ? HAZARD_ID_WRITE_RACING_READ : HAZARD_ID_WRITE_AFTER_READ;
    case EARLY_TRACE:
        return HAZARD_ID_EARLY_TRACE;
    case READ_AFTER_SHADER:
        return HAZARD_ID_LATE_SHADER;
    case READ_RACING_HOST:
        return HAZARD_ID_HOST_WRITE;
    case TRACE_OF_DESTROYED:
        return HAZARD_ID_TRACE_DESTROYED;
    case READ_OF_OVERWRITTEN:
        return HAZARD_ID_OVERWRITTEN;
    case TRACE_OF_UNBUILT:
        return HAZARD_ID_TRACE_UNBUILT;
    case WRITE_AFTER_WRITE:
        break;
    }
    return hazard->is_racing ? HAZARD_ID_WRITE_RACING_WRITE : HAZARD_ID_WRITE_AFTER_WRITE;
}

struct message_subject hazard_subject(const struct hazard_report *report)
{
    const struct hazard_access_text *later = &report->later;
    if (later->object)
        return (struct message_subject){later->type, later->object};
    return message_subject_of(&later->origin, &(struct finding){.says = ""});
}

/* ---- members */

/* The member of a geometry that has the address. */
static const char *geometry_member(enum hazard_role role)
{
    switch (role) {
    case HAZARD_VERTICES:
        return input_name(INPUT_VERTEX, INPUT_PLAIN);
    case HAZARD_INDICES:
        return input_name(INPUT_INDEX, INPUT_PLAIN);
    case HAZARD_TRANSFORM:
        return input_name(INPUT_MATRIX, INPUT_PLAIN);
    case HAZARD_BOXES:
        return input_name(INPUT_AABBS, INPUT_PLAIN);
    case HAZARD_INSTANCES:
    case HAZARD_INSTANCE_POINTERS:
        return input_name(INPUT_INSTANCES, INPUT_PLAIN);
    default:
        return NULL;
    }
}

static void append_build_member(struct text_buffer *text, const struct hazard_access_text *access)
{
    const char *member = geometry_member(access->role);
    if (access->role == HAZARD_RANGES) {
        text_say(text, "pIndirectDeviceAddresses[{}]", number(access->info));
        return;
    }
    if (access->role == HAZARD_REFERENCE)
        text_append(text, "an instance of ");
    text_say(text, "pInfos[{}]", number(access->info));
    if (access->role == HAZARD_DST || access->role == HAZARD_TOP_DST)
        text_append(text, ".dstAccelerationStructure");
    else if (access->role == HAZARD_SRC)
        text_append(text, ".srcAccelerationStructure");
    else if (access->role == HAZARD_SCRATCH)
        text_append(text, ".scratchData");
    else if (member)
        text_say(text, ".pGeometries[{}].{}", number(access->geometry), phrase(member));
    else if (access->role == HAZARD_OTHER_INPUT || access->role == HAZARD_MICROMAP)
        text_say(text, ".pGeometries[{}]", number(access->geometry));
}

static const char *plain_member(enum hazard_role role)
{
    switch (role) {
    case HAZARD_DST:
    case HAZARD_TOP_DST:
        return "dst";
    case HAZARD_SRC:
        return "src";
    case HAZARD_SCRATCH:
        return "scratchData";
    case HAZARD_DST_ADDRESSES:
        return "dstAddressesArray";
    case HAZARD_DST_SIZES:
        return "dstSizesArray";
    case HAZARD_INFOS:
        return "srcInfosArray";
    case HAZARD_COUNT:
        return "srcInfosCount";
    case HAZARD_REFERENCE:
        return "a structure that it refers to";
    case HAZARD_MEMORY:
        return "deviceAddress";
    case HAZARD_SHADER:
    case HAZARD_TRACED:
    case HAZARD_USED:
        return "a shader";
    default:
        return "an input";
    }
}

static void append_member(struct text_buffer *text, const struct hazard_access_text *access)
{
    if (access->is_build)
        append_build_member(text, access);
    else
        text_append(text, plain_member(access->role));
}

/* ---- gaps */

static void append_object_of(const struct words *words, const struct hazard_access_text *access)
{
    if (!access->object)
        text_append(words->text, "memory");
    else if (access->object_is_destroyed)
        words_say(words, "{}", destroyed_object(access->type, access->object, 0));
    else
        words_say(words, "{}", object(access->type, access->object));
}

/* Appends where the command was recorded, such as: in VkCommandBuffer 0x12, build 3. */
static void append_place(const struct words *words, const struct hazard_access_text *access)
{
    const struct call_origin *origin = &access->origin;
    if (!origin->command_buffer)
        return;
    words_say(words, " in {}",
              object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(origin->command_buffer)));
    message_append_place(words, origin,
                         access->is_build ? (int64_t)origin->build_index + access->info : -1, true);
}

static void append_bytes(const struct words *words, const struct hazard_bytes *bytes)
{
    if (bytes->end - bytes->begin == 1)
        words_say(words, "byte {}", number(bytes->begin));
    else
        words_say(words, "bytes {} to {}", number(bytes->begin), number(bytes->end - 1));
}

/* Appends an object that is destroyed, with the name that it had, or one without memory. */
static void append_destroyed(const struct words *words, const struct hazard_report *report)
{
    if (report->is_freed)
        append_object_of(words, &report->earlier);
    else
        words_append_object(&(const struct words){.text = words->text}, report->earlier.type,
                            report->earlier.object, report->destroyed_name);
}

/* Stages and accesses are named as the device's features allow. */
static void append_stage(const struct words *words, const struct hazard_report *report,
                         enum access_kind kind)
{
    const struct access_names names = access_names(kind, &report->features);
    words_say(words, "{}{}", phrase(names.stage_prefix), phrase(names.stage));
}

static void append_access(const struct words *words, const struct hazard_report *report,
                          enum access_kind kind)
{
    const struct access_names names = access_names(kind, &report->features);
    words_say(words, "{}{}", phrase(names.access_prefix), phrase(names.access));
}

/* Appends which barrier it is that does not suffice. */
static void append_barrier(const struct words *words, const struct hazard_report *report)
{
    const struct hazard_barrier_text *barrier = &report->barrier;
    if (!barrier->follows)
        text_append(words->text, "the first barrier of ");
    else if (barrier->builds)
        words_say(words, "the barrier after {}, build {}, in ", phrase(barrier->follows),
                  number(barrier->first_build + barrier->builds - 1));
    else
        words_say(words, "the barrier after {} in ", phrase(barrier->follows));
    words_say(words, "{}",
              object(VK_OBJECT_TYPE_COMMAND_BUFFER, handle_number(barrier->command_buffer)));
    if (barrier->call_site) {
        text_append(words->text, " (at ");
        message_append_call_frames(words->text, barrier->call_site, BARRIER_FRAMES_SHOWN);
        text_append(words->text, ")");
    }
}

static void fill_dependency(const struct words *words, const struct hazard_report *report,
                            const char *gap)
{
    const enum access_kind src = report->hazard.earlier.kind, dst = report->hazard.later.kind;
    const struct hazard_barrier_text *barrier = &report->barrier;
    if (strcmp(gap, "src.stage") == 0)
        append_stage(words, report, src);
    else if (strcmp(gap, "dst.stage") == 0)
        append_stage(words, report, dst);
    else if (strcmp(gap, "src.access") == 0)
        append_access(words, report, src);
    else if (strcmp(gap, "dst.access") == 0)
        append_access(words, report, dst);
    else if (strcmp(gap, "side") == 0)
        text_append(words->text, barrier->lacks_src ? "src" : "dst");
    else if (strcmp(gap, "stage that lacks") == 0 && barrier->lacks_stage)
        append_stage(words, report, barrier->lacks_src ? src : dst);
    else if (strcmp(gap, "access that lacks") == 0)
        append_access(words, report, barrier->lacks_src ? src : dst);
    else if (strcmp(gap, "write") == 0 && report->write != ACCESS_KINDS)
        append_access(words, report, report->write);
    else if (strcmp(gap, "write that lacks") == 0 && report->write != ACCESS_KINDS &&
             !barrier->lacks_src)
        append_access(words, report, report->write);
    else if (strcmp(gap, "barrier") == 0)
        append_barrier(words, report);
}

static void fill_gap(const struct words *words, const void *about, const char *gap)
{
    const struct hazard_report *report = about;
    const struct hazard_access_text *later = &report->later, *earlier = &report->earlier;
    if (strcmp(gap, "reads") == 0)
        text_append(words->text, access_is_write(later->kind) ? "writes" : "reads");
    else if (strcmp(gap, "wrote") == 0)
        text_append(words->text, access_is_write(earlier->kind) ? "wrote" : "read");
    else if (strcmp(gap, "later.object") == 0)
        append_object_of(words, later);
    else if (strcmp(gap, "earlier.object") == 0)
        append_object_of(words, earlier);
    else if (strcmp(gap, "top-level structure") == 0 && later->object)
        append_object_of(words, later);
    else if (strcmp(gap, "other object") == 0 && earlier->object &&
             earlier->object != later->object)
        append_object_of(words, earlier);
    else if (strcmp(gap, "earlier.member") == 0)
        append_member(words->text, earlier);
    else if (strcmp(gap, "earlier.command") == 0)
        text_append(words->text, earlier->command);
    else if (strcmp(gap, "earlier.place") == 0)
        append_place(words, earlier);
    else if (strcmp(gap, "bytes") == 0)
        append_bytes(words, &report->hazard.bytes);
    else if (strcmp(gap, "destroyed") == 0)
        append_destroyed(words, report);
    else if (strcmp(gap, "That was destroyed") == 0)
        text_append(words->text, report->is_freed ? "Its memory was freed" : "That was destroyed");
    else if (strcmp(gap, "more hazards") == 0 && report->more)
        text_append_count(words->text, report->more, "more hazard");
    else if (strcmp(gap, "seconds") == 0 && report->timeout)
        text_append_real(words->text, (double)report->timeout * 1e-9, 3);
    else if (strcmp(gap, "timeout") == 0)
        text_append_decimal(words->text, report->timeout);
    else
        fill_dependency(words, report, gap);
}

/* ---- templates */

#define READ " reads {later.object} ({bytes} of its memory)."
#define ACCESSES                                                                                   \
    " {reads} {later.object} ({bytes} of its memory). Earlier, {earlier.member} of "               \
    "{earlier.command}[[{earlier.place},]] {wrote} them[[ as part of {other object}]]."

/* What happens, for a hazard that needs no barrier; for the others, what the accesses are. */
static const char *accesses_of(const struct hazard_report *report)
{
    const bool is_racing = report->hazard.is_racing;
    switch (report->hazard.type) {
    case EARLY_TRACE:
        return " traces rays, and no top-level structure that it may trace is visible to it. The "
               "last one of them that was built is {earlier.object}: {earlier.member} of "
               "{earlier.command}[[{earlier.place},]] wrote it.";
    case READ_AFTER_SHADER:
        return READ
            " The data have changed since the last build that read them. No other command "
            "can have written them, so a shader did. The last command with shaders before "
            "this one is {earlier.command}{earlier.place}.";
    case READ_RACING_HOST:
        return READ
            " The host has overwritten them since the build was submitted, and has not "
            "observed that the build is complete. Wait on the host until it is, for "
            "example for a fence, before the write, or give each frame in flight a buffer "
            "of its own.";
    case TRACE_OF_DESTROYED:
        if (report->is_used)
            return " statically uses a descriptor that holds {destroyed}. {That was destroyed} "
                   "before this command executed. Write another structure to the descriptor set, "
                   "or keep this one.";
        if (is_racing)
            return " traces rays in [[{top-level structure}, an instance of which refers to "
                   "]]{destroyed}. {That was destroyed}, and the application had not observed that "
                   "this command is complete. Wait on the host until it is, for example for a "
                   "fence, before that.";
        if (!report->later.object) /* the top-level structure itself is destroyed */
            return " traces rays in {destroyed}. {That was destroyed} before this command "
                   "executed. Update the descriptor set that still refers to it, or keep it.";
        return " traces rays in {later.object}, an instance of which refers to {destroyed}. {That "
               "was destroyed} before this command executed. Build the top-level structure "
               "without it first, or keep it.";
    case TRACE_OF_UNBUILT:
        return " traces rays in {later.object}. No command has built it, or copied to it, before "
               "this command executed. Build the structure first, or bind the one that is built.";
    case READ_OF_OVERWRITTEN:
        if (report->is_own_write)
            return READ
                " The same build writes them as {earlier.member}, which is "
                "{earlier.object}. Give each structure memory of its own.";
        return ACCESSES
            " Nothing has built or copied the structure since. Give each structure "
            "memory of its own, or build it again before its use.";
    case READ_AFTER_WRITE:
    case WRITE_AFTER_READ:
    case WRITE_AFTER_WRITE:
        break;
    }
    return ACCESSES;
}

/* Why the accesses are not ordered. */
static const char *reason_of(const struct hazard *hazard)
{
    if (hazard->is_racing)
        return " Nothing orders the two accesses, so they may happen in either order.";
    if (!hazard->is_ordered)
        return " Nothing between them makes the second command wait for the first.";
    if (!hazard->is_available)
        return " The second command waits for the first, but no srcAccessMask with {src.access} "
               "makes the write available.";
    return " The second command waits for the first, and the write is available, but no "
           "dstAccessMask with {dst.access} makes it visible.";
}

/* What orders them. */
static const char *remedy_of(const struct hazard_report *report)
{
    const struct hazard *hazard = &report->hazard;
    const bool needs_access = hazard->type != WRITE_AFTER_READ;
    if (hazard->earlier.queue == HAZARD_HOST_QUEUE || hazard->later.queue == HAZARD_HOST_QUEUE)
        return " Wait on the host until the first has completed, for example for a fence, before "
               "the second.";
    if (hazard->is_racing)
        return " Signal a semaphore after the first, and let the second wait for it at "
               "{dst.stage}.";
    if (report->barrier.is_there && needs_access)
        return " Add [[{stage that lacks} to the {side}StageMask, and ]]{access that lacks}[[ | "
               "{write that lacks}]] to the {side}AccessMask of {barrier}.";
    if (report->barrier.is_there)
        return " Add {stage that lacks} to the {side}StageMask of {barrier}.";
    if (needs_access)
        return " Record a barrier between them with srcStageMask {src.stage}, dstStageMask "
               "{dst.stage}, srcAccessMask {src.access}, dstAccessMask {dst.access}[[ | {write}]].";
    return " Record a barrier between them with srcStageMask {src.stage}, dstStageMask "
           "{dst.stage}[[ | {write}]].";
}

/* An application may take 4.3 s (UINT32_MAX ns) for no limit. */
static const char timeout_says[] =
    "[[ In between, a wait of the host returned VK_TIMEOUT after {seconds} s (timeout {timeout} "
    "ns), so the host has observed nothing by it.]]";

/* Whether a dependency could order the accesses: then the message says which. */
static bool lacks_dependency(const struct hazard *hazard)
{
    switch (hazard->type) {
    case READ_RACING_HOST:
    case TRACE_OF_UNBUILT:
    case TRACE_OF_DESTROYED:
    case READ_OF_OVERWRITTEN:
        return false;
    case EARLY_TRACE:
    case READ_AFTER_SHADER:
    case READ_AFTER_WRITE:
    case WRITE_AFTER_READ:
    case WRITE_AFTER_WRITE:
        break;
    }
    return true;
}

void message_of_hazard(struct message *message, const struct hazard_report *report,
                       const struct message_style *style)
{
    const struct hazard_access_text *later = &report->later;
    const struct message_subject subject = hazard_subject(report);
    const struct location at = {.subject = later->is_build ? SUBJECT_BUILD : SUBJECT_CALL,
                                .build = later->info};
    struct text_buffer text;
    const struct words words = {&text, &message->named, later->origin.names, COMMAND_COUNT, false};
    const unsigned id = other_id_of_hazard(hazard_id_of(&report->hazard));
    message_begin(message, &text, other_id_is_error(id) ? REPORT_ERROR : REPORT_WARNING,
                  other_id_name(id));
    message_set_origin(message, &later->origin, later->command, LEVEL_EXECUTION, &at);
    words_say(&words, "{}(): ", phrase(later->command));
    size_t before = text.length;
    message->main = text.text + before;
    append_member(&text, later);
    message->path_length = text.length - before;
    words_fill(&words, accesses_of(report), fill_gap, report);
    if (lacks_dependency(&report->hazard))
        words_fill(&words, reason_of(&report->hazard), fill_gap, report);
    if (lacks_dependency(&report->hazard) || report->hazard.type == READ_RACING_HOST)
        words_fill(&words, timeout_says, fill_gap, report);
    if (lacks_dependency(&report->hazard))
        words_fill(&words, remedy_of(report), fill_gap, report);
    words_fill(&words, "[[ The same command has {more hazards} of this kind.]]", fill_gap, report);
    message->main_length = text.length - before;
    message_append_origin(&text, message);
    message_append_last_notice(&text, "hazard", &subject, style);
}
