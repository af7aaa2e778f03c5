/* SPDX-License-Identifier: Apache-2.0 */
/* Messages about what builds have read, whole: they name the command buffer, its labels, the build,
 * the geometry, the primitive and the value. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/rules/submitted/variant.h"

/* ---- what is found */

static void turn_a_box(struct scene *scene)
{
    float *box = (float *)(void *)(scene->boxes.host + 24);
    box[0] = 2.5f;
}

static void put_a_triangle_to_sleep(struct scene *scene)
{
    float *vertex = (float *)(void *)(scene->vertices.host + 60);
    scene->infos[UNINDEXED].flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    const uint32_t build = scene_add_build(scene, UNINDEXED);
    scene_build_before(scene, build, 1);
    scene->infos[build].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
    scene->infos[build].srcAccelerationStructure = scene->infos[build].dstAccelerationStructure;
    vertex[0] = NAN;
}

static void use_a_far_vertex(struct scene *scene)
{
    uint16_t *indices = (uint16_t *)(void *)(scene->indices.host + SCENE_BUFFER_SIZE / 2);
    indices[5] = 6;
}

struct text {
    const char *name;
    void (*mutate)(struct scene *scene);
    const char *text; /* up to the specification's sentence; every handle is 0x# */
};

#define FOUND "vkCmdBuildAccelerationStructuresKHR(): "
#define IN_FRAME(build)                                                                            \
    " Command buffer VkCommandBuffer 0x#[\"frame\"], build " #build                                \
    ", labels \"scene\" > \"builds\", as submitted to VkQueue 0x#, submission #."

static const struct text texts[] = {
    {"texts.box", turn_a_box,
     FOUND "pInfos[2].pGeometries[0].geometry.aabbs.data.deviceAddress leads to primitive 1, whose "
           "minX 2.5 is not less than or equal to maxX (1). Write the lower bound to minX; to make "
           "an AABB inactive, write NaN to minX." IN_FRAME(2)},
    {"texts.activity", put_a_triangle_to_sleep,
     FOUND "pInfos[6].pGeometries[0] makes primitive 1 inactive, but the primitive was active when "
           "VkAccelerationStructureKHR 0x# was last built (in VkCommandBuffer 0x#, build 0). Build "
           "the structure anew if a primitive becomes inactive." IN_FRAME(6)},
    {"texts.index", use_a_far_vertex,
     FOUND
     "ppBuildRangeInfos[1][1].firstVertex 0 plus index 6 of primitive 1 is vertex 6, which "
     "exceeds maxVertex (5). Raise maxVertex if the vertex data has that vertex; else correct "
     "the index or firstVertex." IN_FRAME(1)},
};

/* ---- the program */

static void begin_label(struct scene *scene, const char *name)
{
    const STRUCT(VkDebugUtilsLabelEXT, label, .pLabelName = name);
    scene->vk->CmdBeginDebugUtilsLabelEXT(scene->command_buffer, &label);
}

static void name_command_buffer(struct scene *scene)
{
    const STRUCT(VkDebugUtilsObjectNameInfoEXT, name, .objectType = VK_OBJECT_TYPE_COMMAND_BUFFER,
                 .objectHandle = (uint64_t)(uintptr_t)scene->command_buffer,
                 .pObjectName = "frame");
    expect_success(scene->vk->SetDebugUtilsObjectNameEXT(scene->fixture->device, &name),
                   "vkSetDebugUtilsObjectNameEXT");
}

static void run(struct fixture *fixture, const struct text *text)
{
    messages_clear(&fixture->messages);
    struct scene *scene = scene_open(fixture, COMMAND_DEVICE);
    text->mutate(scene);
    name_command_buffer(scene);
    begin_label(scene, "scene");
    begin_label(scene, "builds");
    scene_call(scene);
    scene->vk->CmdEndDebugUtilsLabelEXT(scene->command_buffer);
    scene->vk->CmdEndDebugUtilsLabelEXT(scene->command_buffer);
    submission_prepare(scene);
    submission_begin(scene);
    submission_wait(scene, WAIT_FENCE);
    scene_close(scene);
}

/* ---- the comparison */

/* Up to the end of its first line, with # for the digits of handles and for the number of the
 * submission. */
static void simplify(const char *from, char *to, size_t size)
{
    size_t length = 0;
    while (*from != '\0' && *from != '\n' && length + 4 < size) {
        static const char submission[] = "submission ";
        if (strncmp(from, submission, strlen(submission)) == 0 && length + 16 < size) {
            length += (size_t)sprintf(to + length, "%s#", submission);
            from += strlen(submission);
            from += strspn(from, "0123456789");
        }
        const bool is_hex = strncmp(from, "0x", 2) == 0;
        to[length++] = *from++;
        if (!is_hex)
            continue;
        to[length++] = *from++;
        to[length++] = '#';
        while (isxdigit((unsigned char)*from))
            from++;
    }
    to[length] = '\0';
}

static void play(struct fixture *fixture, const struct text *text, struct tally *tally)
{
    char line[MESSAGE_TEXT_MAX], report[2 * MESSAGE_TEXT_MAX];

    run(fixture, text);
    simplify(fixture->messages.count > 0 ? fixture->messages.items[0].text : "", line,
             sizeof(line));
    const bool good = fixture->messages.count == 1 && strcmp(line, text->text) == 0;
    snprintf(report, sizeof(report), "%u messages: %s\n", fixture->messages.count, line);
    tally_count(tally, good ? OUTCOME_PASSED : OUTCOME_FAILED, text->name, report);
}

void texts_play(const struct platform *platform, struct fixture *fixture, struct tally *tally)
{
    static const struct setup with_content = {.level = "content"};

    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) {
        if (!tally_starts(tally, texts[i].name))
            continue;
        fixture_close(fixture);
        const char *missing = fixture_open(fixture, platform, &with_content);
        fixture->inputs = INPUTS_VISIBLE;
        fixture->uses_two_queues = fixture->records_secondary = false;
        if (missing == NULL)
            play(fixture, &texts[i], tally);
        else
            tally_count(tally, OUTCOME_SKIPPED, texts[i].name, missing);
    }
}
