/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of cases that are no builds:
 *
 *     clone | compact | serialize | deserialize SRC > DST     of structures and micromaps
 *     query NAME [NAME...] > POOL                             the compacted size, from query 0 on
 *     copy | copy1 SRC > DST [SIZE]
 *     fill PLACE [SIZE | whole]  update PLACE [SIZE]
 *     marker PLACE STAGE         marker2 PLACE STAGE          VK_AMD_buffer_marker
 *     host clone | compact | serialize | deserialize SRC > DST
 *     host query NAME [size | serialized | references] [gives NUMBER]      the compacted size; or
 *                                that of the structure or its data, or the number of references
 *     host compatible | incompatible PLACE [micromap]         what the device says of such data
 *     host reset POOL [from QUERY] [queries COUNT]              reset POOL [from ...] [queries ...]
 *     host read POOL [from QUERY] [queries COUNT] [64] [wait] [availability] [partial]
 *         [gives NUMBER...]      NUMBER: `size`: what the host got last; `kept`: the call has
 *                                not written it
 *     host ... deferred NAME     host join NAME             host result NAME
 *
 * SIZE is 64 unless said otherwise; QUERY is 0, and COUNT 1. */
#include "tests/fixture/copies.h"
#include "tests/player/play.h"

#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SIZE = 64, UPDATE_MAX_SIZE = 4096 };

static VkDeviceSize size_of(const char *word)
{
    return play_is(word, "whole") ? VK_WHOLE_SIZE : word ? strtoull(word, NULL, 0) : DEFAULT_SIZE;
}

/* ---- structures */

/* SRC > DST deferred NAME */
static VkDeferredOperationKHR operation_of(struct play *play, char **words)
{
    if (!play_is(words[4], "deferred"))
        return VK_NULL_HANDLE;
    play->keeps_blocks = true;
    return play_object(play, words[5])->operation;
}

/* Records a copy, or calls the host's form. What is deferred reads its parameters until it is
 * complete. */
#define COPY(command, info)                                                                        \
    (is_host ? play_note(play, play->vk.command(play->device, operation_of(play, words),           \
                                                play_copy_for_call(play, &(info), sizeof(info))))  \
             : play->vk.Cmd##command(play_commands(play), &(info)))

static void copy_structure(struct play *play, char **words, bool is_host)
{
    const VkCopyAccelerationStructureInfoKHR info =
        copy_info(play_object(play, words[1])->structure, play_object(play, words[3])->structure,
                  play_is(words[0], "compact") ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                                               : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    if (play_object(play, words[1])->is_nv)
        play_copy_nv(play, words);
    else
        COPY(CopyAccelerationStructureKHR, info);
}

static void serialize(struct play *play, char **words, bool is_host)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info =
        serialize_info(play_object(play, words[1])->structure,
                       play_address_for(play, words[3], is_host).deviceAddress);
    COPY(CopyAccelerationStructureToMemoryKHR, info);
}

static void deserialize(struct play *play, char **words, bool is_host)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info =
        deserialize_info(play_address_for(play, words[1], is_host).deviceAddress,
                         play_object(play, words[3])->structure);
    COPY(CopyMemoryToAccelerationStructureKHR, info);
}

static bool play_structures(struct play *play, char **words, bool is_host)
{
    static const char *const names[] = {"clone", "compact", "serialize", "deserialize"};
    bool is_known = false;
    for (size_t i = 0; i < ARRAY_COUNT(names); i++)
        is_known |= play_is(words[0], names[i]);
    if (!is_known)
        return false;
    PLAY_REQUIRE(play, words[1] && play_is(words[2], ">") && words[3]);
    if (words[1][0] == 'M' || words[3][0] == 'M')
        play_copy_micromap(play, words, is_host);
    else if (play_is(words[0], "serialize"))
        serialize(play, words, is_host);
    else if (play_is(words[0], "deserialize"))
        deserialize(play, words, is_host);
    else
        copy_structure(play, words, is_host);
    return true;
}

/* ---- queries */

static void query(struct play *play, char **words)
{
    VkAccelerationStructureKHR structures[PLAY_ITEMS];
    uint32_t count = 0;
    if (words[1] && words[1][0] == 'M') {
        PLAY_REQUIRE(play, play_is(words[2], ">") && words[3]);
        play->vk.CmdWriteMicromapsPropertiesEXT(
            play_commands(play), 1, &play_object(play, words[1])->micromap,
            words[3][1] == 'C' ? VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT
                               : VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT,
            play_object(play, words[3])->queries, 0);
        return;
    }
    if (words[1] && play_object(play, words[1])->is_nv) {
        play_query_nv(play, words);
        return;
    }
    for (words++; *words && !play_is(*words, ">"); words++) {
        PLAY_REQUIRE(play, count < PLAY_ITEMS);
        structures[count++] = play_object(play, *words)->structure;
    }
    PLAY_REQUIRE(play, *words != NULL);
    play->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        play_commands(play), count, structures,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        play_object(play, words[1])->queries, 0);
}

static VkResult query_micromap(const struct play *play, VkMicromapEXT micromap, bool is_compacted,
                               uint64_t *found)
{
    return play->vk.WriteMicromapsPropertiesEXT(play->device, 1, &micromap,
                                                is_compacted
                                                    ? VK_QUERY_TYPE_MICROMAP_COMPACTED_SIZE_EXT
                                                    : VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT,
                                                sizeof(*found), found, sizeof(*found));
}

static void query_on_host(struct play *play, char **words)
{
    uint64_t found = 0;
    const struct play_object *object = play_object(play, words[1]);
    const VkQueryType type =
        play_is(words[2], "size") ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SIZE_KHR
        : play_is(words[2], "serialized")
            ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_SIZE_KHR
        : play_is(words[2], "references")
            ? VK_QUERY_TYPE_ACCELERATION_STRUCTURE_SERIALIZATION_BOTTOM_LEVEL_POINTERS_KHR
            : VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    if (object->is_nv && play_is(words[2], "size"))
        found = object->buffer.size;
    else if (object->name[0] == 'M')
        play_note(play,
                  query_micromap(play, object->micromap, !play_is(words[2], "serialized"), &found));
    else
        play_note(play, play->vk.WriteAccelerationStructuresPropertiesKHR(
                            play->device, 1, &object->structure, type, sizeof(found), &found,
                            sizeof(found)));
    while (*words && !play_is(*words, "gives"))
        words++;
    if (*words)
        play_expect_number(play, "the answer", found, play_number(play, words[1]));
    play->last_size = found;
}

static void expect_compatibility(struct play *play, char **words)
{
    const STRUCT(VkAccelerationStructureVersionInfoKHR, info,
                 .pVersionData = play_bytes(play, words[1]));
    const STRUCT(VkMicromapVersionInfoEXT, of_micromap, .pVersionData = info.pVersionData);
    VkAccelerationStructureCompatibilityKHR found;
    if (play_is(words[2], "micromap"))
        play->vk.GetDeviceMicromapCompatibilityEXT(play->device, &of_micromap, &found);
    else
        play->vk.GetDeviceAccelerationStructureCompatibilityKHR(play->device, &info, &found);
    if (play->is_scarce || (found == VK_ACCELERATION_STRUCTURE_COMPATIBILITY_COMPATIBLE_KHR) ==
                               play_is(words[0], "compatible"))
        return;
    report_say(&play->report, "the device says otherwise\n");
    play->report.outcome = OUTCOME_FAILED;
}

/* Which queries of a pool a command is about. */
struct queries {
    VkQueryPool pool;
    uint32_t first, count;
};

/* Reads POOL [from QUERY] [queries COUNT]. Returns the words behind it. */
static char **read_range(struct play *play, char **words, struct queries *queries)
{
    *queries = (struct queries){play_object(play, *words++)->queries, 0, 1};
    for (; play_is(words[0], "from") || play_is(words[0], "queries"); words += 2) {
        PLAY_REQUIRE(play, words[1] != NULL);
        *(play_is(words[0], "from") ? &queries->first : &queries->count) =
            (uint32_t)strtoul(words[1], NULL, 0);
    }
    return words;
}

static void reset(struct play *play, char **words, bool is_host)
{
    struct queries queries;
    read_range(play, words, &queries);
    if (is_host)
        play->vk.ResetQueryPool(play->device, queries.pool, queries.first, queries.count);
    else
        play->vk.CmdResetQueryPool(play_commands(play), queries.pool, queries.first, queries.count);
}

/* The stride leaves room for two results: a query's availability comes behind its value. */
enum { READ_QUERIES = 4, READ_STRIDE = 2 * sizeof(uint64_t), READ_FILLER = 0xee };

static uint64_t result_at(const unsigned char *results, uint32_t query, unsigned index,
                          VkQueryResultFlags flags)
{
    const size_t size = flags & VK_QUERY_RESULT_64_BIT ? sizeof(uint64_t) : sizeof(uint32_t);
    uint64_t result = 0;
    memcpy(&result, results + (size_t)query * READ_STRIDE + index * size, size);
    return result;
}

static void expect_results(struct play *play, char **words, const unsigned char *results,
                           VkQueryResultFlags flags)
{
    const unsigned each = flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT ? 2 : 1;
    const uint64_t kept = ~UINT64_C(0) / 0xff * READ_FILLER;
    for (unsigned i = 0; words[i]; i++) {
        const uint64_t wanted = play_is(words[i], "kept") ? kept : play_number(play, words[i]);
        play_expect_number(play, "a result", result_at(results, i / each, i % each, flags),
                           flags & VK_QUERY_RESULT_64_BIT ? wanted : (uint32_t)wanted);
    }
}

static void read_queries(struct play *play, char **words)
{
    unsigned char results[READ_QUERIES * READ_STRIDE];
    struct queries queries;
    VkQueryResultFlags flags = 0;
    for (words = read_range(play, words, &queries); *words && !play_is(*words, "gives"); words++)
        flags |= play_is(*words, "64")             ? VK_QUERY_RESULT_64_BIT
                 : play_is(*words, "wait")         ? VK_QUERY_RESULT_WAIT_BIT
                 : play_is(*words, "availability") ? VK_QUERY_RESULT_WITH_AVAILABILITY_BIT
                                                   : VK_QUERY_RESULT_PARTIAL_BIT;
    PLAY_REQUIRE(play, queries.count <= READ_QUERIES);
    memset(results, *words ? READ_FILLER : 0, sizeof(results));
    const VkResult result = play_call(
        play, play->vk.GetQueryPoolResults(play->device, queries.pool, queries.first, queries.count,
                                           sizeof(results), results, READ_STRIDE, flags));
    play_note_result(play, result);
    if (*words)
        expect_results(play, words + 1, results, flags);
    else if (result == VK_SUCCESS)
        play->last_size = result_at(results, 0, 0, flags);
}

static void join_operation(struct play *play, VkDeferredOperationKHR operation)
{
    while (play->vk.DeferredOperationJoinKHR(play->device, operation) ==
           VK_ERROR_OUT_OF_HOST_MEMORY)
        ;
    if (play->repeats)
        play_give_up_if_scarce(play,
                               play->vk.GetDeferredOperationResultKHR(play->device, operation));
}

static bool play_operation(struct play *play, char **words)
{
    if (play_is(words[0], "join"))
        join_operation(play, play_object(play, words[1])->operation);
    else if (play_is(words[0], "result"))
        play->vk.GetDeferredOperationResultKHR(play->device,
                                               play_object(play, words[1])->operation);
    else if (play_is(words[0], "query"))
        query_on_host(play, words);
    else if (play_is(words[0], "compatible") || play_is(words[0], "incompatible"))
        expect_compatibility(play, words);
    else if (play_is(words[0], "read"))
        read_queries(play, words + 1);
    else if (play_is(words[0], "reset") && words[1] && words[1][0] == 'P')
        reset(play, words + 1, true);
    else
        return false;
    return true;
}

/* ---- transfers */

static void copy_buffer(struct play *play, char **words)
{
    VkDeviceSize from, to;
    PLAY_REQUIRE(play, play_is(words[2], ">"));
    const struct play_object *src = play_place(play, words[1], &from);
    const struct play_object *dst = play_place(play, words[3], &to);
    const VkDeviceSize size = size_of(words[4]);
    if (play_is(words[0], "copy1")) {
        play->vk.CmdCopyBuffer(play_commands(play), src->buffer.handle, dst->buffer.handle, 1,
                               &(VkBufferCopy){from, to, size});
        return;
    }
    const STRUCT(VkBufferCopy2, region, .srcOffset = from, .dstOffset = to, .size = size);
    const STRUCT(VkCopyBufferInfo2, info, .srcBuffer = src->buffer.handle,
                 .dstBuffer = dst->buffer.handle, .regionCount = 1, .pRegions = &region);
    play->vk.CmdCopyBuffer2(play_commands(play), &info);
}

static void write_buffer(struct play *play, char **words)
{
    static const unsigned char zeros[UPDATE_MAX_SIZE];
    VkDeviceSize offset;
    const struct play_object *to = play_place(play, words[1], &offset);
    const VkDeviceSize size = size_of(words[2]);
    PLAY_REQUIRE(play, play_is(words[0], "fill") || size <= UPDATE_MAX_SIZE);
    if (play_is(words[0], "fill"))
        play->vk.CmdFillBuffer(play_commands(play), to->buffer.handle, offset, size, 0);
    else
        play->vk.CmdUpdateBuffer(play_commands(play), to->buffer.handle, offset, size, zeros);
}

static void write_marker(struct play *play, char **words)
{
    VkDeviceSize offset;
    const struct play_object *to = play_place(play, words[1], &offset);
    const VkPipelineStageFlags2 stages = play_stages(play, words[2]);
    if (play_is(words[0], "marker2"))
        play->vk.CmdWriteBufferMarker2AMD(play_commands(play), stages, to->buffer.handle, offset,
                                          1);
    else
        play->vk.CmdWriteBufferMarkerAMD(play_commands(play), (VkPipelineStageFlagBits)stages,
                                         to->buffer.handle, offset, 1);
}

bool play_copy(struct play *play, char **words)
{
    if (play_is(words[0], "host"))
        return play_operation(play, words + 1) || play_structures(play, words + 1, true);
    if (play_structures(play, words, false))
        return true;
    if (play_is(words[0], "query"))
        query(play, words);
    else if (play_is(words[0], "reset") && words[1] && words[1][0] == 'P')
        reset(play, words + 1, false);
    else if (play_is(words[0], "copy") || play_is(words[0], "copy1"))
        copy_buffer(play, words);
    else if (play_is(words[0], "fill") || play_is(words[0], "update"))
        write_buffer(play, words);
    else if (play_is(words[0], "marker") || play_is(words[0], "marker2"))
        write_marker(play, words);
    else
        return play_transfer(play, words);
    return true;
}
