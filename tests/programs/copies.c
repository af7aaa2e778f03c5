/* SPDX-License-Identifier: Apache-2.0 */
/* Commands of cases that are no builds:
 *
 *     clone | compact | serialize | deserialize SRC > DST     of structures and micromaps
 *     query NAME > POOL                                       the compacted size
 *     copy | copy1 SRC > DST [SIZE]
 *     fill PLACE [SIZE | whole]  update PLACE [SIZE]
 *     marker PLACE STAGE         marker2 PLACE STAGE          VK_AMD_buffer_marker
 *     host clone | compact | serialize | deserialize SRC > DST
 *     host query NAME            host reset POOL            reset POOL
 *     host read POOL [64] [wait] [availability] [partial]
 *     host ... deferred NAME     host join NAME             host result NAME
 *
 * SIZE is 64 unless said otherwise. */
#include "tests/fixture/copies.h"
#include "play.h"

#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SIZE = 64, UPDATE_MAX_SIZE = 4096 };

static VkDeviceSize size_of(const char *word)
{
    return play_is(word, "whole") ? VK_WHOLE_SIZE : word ? strtoull(word, NULL, 0) : DEFAULT_SIZE;
}

/* ---- structures */

/* What is deferred reads its parameters until it is complete. */
#define FOR_CALL(play, info) play_copy_for_call(play, &(info), sizeof(info))

/* SRC > DST deferred NAME */
static VkDeferredOperationKHR operation_of(struct play *play, char **words)
{
    if (!play_is(words[4], "deferred"))
        return VK_NULL_HANDLE;
    play->keeps_blocks = true;
    return play_object(play, words[5])->operation;
}

static void copy_structure(struct play *play, char **words, bool is_host)
{
    const VkCopyAccelerationStructureInfoKHR info =
        copy_info(play_object(play, words[1])->structure, play_object(play, words[3])->structure,
                  play_is(words[0], "compact") ? VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR
                                               : VK_COPY_ACCELERATION_STRUCTURE_MODE_CLONE_KHR);
    if (play->is_nv)
        play_copy_nv(play, words);
    else if (is_host)
        play_note(play, play->vk.CopyAccelerationStructureKHR(
                            play->device, operation_of(play, words), FOR_CALL(play, info)));
    else
        play->vk.CmdCopyAccelerationStructureKHR(play_commands(play), &info);
}

static void serialize(struct play *play, char **words, bool is_host)
{
    const VkCopyAccelerationStructureToMemoryInfoKHR info =
        serialize_info(play_object(play, words[1])->structure,
                       play_address_for(play, words[3], is_host).deviceAddress);
    if (is_host)
        play_note(play, play->vk.CopyAccelerationStructureToMemoryKHR(
                            play->device, operation_of(play, words), FOR_CALL(play, info)));
    else
        play->vk.CmdCopyAccelerationStructureToMemoryKHR(play_commands(play), &info);
}

static void deserialize(struct play *play, char **words, bool is_host)
{
    const VkCopyMemoryToAccelerationStructureInfoKHR info =
        deserialize_info(play_address_for(play, words[1], is_host).deviceAddress,
                         play_object(play, words[3])->structure);
    if (is_host)
        play_note(play, play->vk.CopyMemoryToAccelerationStructureKHR(
                            play->device, operation_of(play, words), FOR_CALL(play, info)));
    else
        play->vk.CmdCopyMemoryToAccelerationStructureKHR(play_commands(play), &info);
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
    PLAY_REQUIRE(play, play_is(words[2], ">"));
    if (words[1][0] == 'M') {
        play->vk.CmdWriteMicromapsPropertiesEXT(
            play_commands(play), 1, &play_object(play, words[1])->micromap,
            VK_QUERY_TYPE_MICROMAP_SERIALIZATION_SIZE_EXT, play_object(play, words[3])->queries, 0);
        return;
    }
    play->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        play_commands(play), 1, &play_object(play, words[1])->structure,
        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        play_object(play, words[3])->queries, 0);
}

static void query_on_host(struct play *play, char **words)
{
    play_note(play, play->vk.WriteAccelerationStructuresPropertiesKHR(
                        play->device, 1, &play_object(play, words[1])->structure,
                        VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                        sizeof(play->compacted), &play->compacted, sizeof(play->compacted)));
}

/* Reads query 0 with a stride that leaves room for two results; its availability may come second.
 */
static void read_queries(struct play *play, char **words)
{
    uint64_t results[4] = {0};
    uint32_t first_half;
    VkQueryResultFlags flags = 0;
    for (char **word = words + 2; *word; word++)
        flags |= play_is(*word, "64")             ? VK_QUERY_RESULT_64_BIT
                 : play_is(*word, "wait")         ? VK_QUERY_RESULT_WAIT_BIT
                 : play_is(*word, "availability") ? VK_QUERY_RESULT_WITH_AVAILABILITY_BIT
                                                  : VK_QUERY_RESULT_PARTIAL_BIT;
    const VkResult result =
        play->vk.GetQueryPoolResults(play->device, play_object(play, words[1])->queries, 0, 1,
                                     sizeof(results), results, sizeof(results), flags);
    play_note(play, result);
    memcpy(&first_half, results, sizeof(first_half));
    if (result == VK_SUCCESS)
        play->compacted = flags & VK_QUERY_RESULT_64_BIT ? results[0] : first_half;
}

static bool play_operation(struct play *play, char **words)
{
    if (play_is(words[0], "join"))
        play->vk.DeferredOperationJoinKHR(play->device, play_object(play, words[1])->operation);
    else if (play_is(words[0], "result"))
        play->vk.GetDeferredOperationResultKHR(play->device,
                                               play_object(play, words[1])->operation);
    else if (play_is(words[0], "query"))
        query_on_host(play, words);
    else if (play_is(words[0], "read"))
        read_queries(play, words);
    else if (play_is(words[0], "reset") && words[1] && words[1][0] == 'P')
        play->vk.ResetQueryPool(play->device, play_object(play, words[1])->queries, 0, 1);
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
        play->vk.CmdResetQueryPool(play_commands(play), play_object(play, words[1])->queries, 0, 1);
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
