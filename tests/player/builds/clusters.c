/* SPDX-License-Identifier: Apache-2.0 */
/* Builds of clusters and of partitioned structures:
 *
 *     clusters OPERATION [explicit | sizes] [all] [of COUNT] [count COUNT] [room BYTES]
 *         [flags FLAGS] [format FORMAT] [dst ADDRESS]... [indirect FLAGS] [into PLACE]
 *         [scratch PLACE] [infos PLACE] [counted PLACE] [addresses PLACE] [sized PLACE]
 *         [FIELD VALUE]... [and [FIELD VALUE]...]
 *     partitions [src PLACE] [into PLACE] [scratch PLACE] [translates] [count COUNT]
 *         OPERATION [arguments PLACE] [FIELD VALUE]... [again [FIELD VALUE]...]
 *         [then OPERATION [FIELD VALUE]...]
 *
 * The operations are move, bottom, build, template, instantiate and indices; and write, update and
 * translate. What the device reads is in buffer C0, which the host writes when the command is
 * recorded: a count; the structures, from byte 256 on, whose members FIELD names; the destinations;
 * references from byte 8192 on (`reference PLACE`); geometries of triangles from byte 12288 on
 * (`triangle INDEX`, with `unique COUNT`); and the arrays of operations, from byte 16384
 * on. `and` begins the next structure, which is like the first one; `again` the next element of an
 * operation's array; `then` the next operation. Structures are built in C1, with scratch in C2. */
#include "tests/player/play.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    INFOS_AT = 256,
    INFO_STRIDE = 80,
    DSTS_AT = 4096,
    REFERENCES_AT = 8192,
    GEOMETRIES_AT = 12288,
    ARGUMENTS_AT = 16384,
    ARGUMENTS_STRIDE = 1024,
    ARGUMENTS_MAX = 9,
    LIST_MAX = 40,
};

static unsigned char *input_bytes(struct play *play)
{
    const struct play_object *input = play_object(play, "C0");
    PLAY_REQUIRE(play, input->buffer.bytes && !input->is_freed);
    return input->buffer.bytes;
}

/* A member of a structure that the device reads, by the letters of the operations that have it:
 * move, bottom, cluster, template, instantiate, get indices; Write, Update, tRanslate. */
static const struct field {
    const char *of, *name;
    uint32_t at, bits;
} fields[] = {{"ct", "clusterID", 0, 32},
              {"ct", "clusterFlags", 32, 32},
              {"ct", "triangleCount", 64, 9},
              {"ct", "vertexCount", 73, 9},
              {"ct", "positionTruncateBitCount", 82, 6},
              {"ct", "indexType", 88, 4},
              {"ct", "opacityMicromapIndexType", 92, 4},
              {"ct", "geometryIndex", 96, 24},
              {"ct", "geometryReserved", 120, 5},
              {"ct", "indexBufferStride", 128, 16},
              {"ct", "vertexBufferStride", 144, 16},
              {"ct", "geometryStride", 160, 16},
              {"ct", "indexBuffer", 192, 64},
              {"ct", "vertexBuffer", 256, 64},
              {"ct", "geometryIndexAndFlagsBuffer", 320, 64},
              {"ct", "opacityMicromapArray", 384, 64},
              {"ct", "opacityMicromapIndexBuffer", 448, 64},
              {"t", "instantiationBoundingBoxLimit", 512, 64},
              {"b", "clusterReferencesCount", 0, 32},
              {"b", "clusterReferencesStride", 32, 32},
              {"b", "clusterReferences", 64, 64},
              {"i", "geometryIndexOffset", 32, 24},
              {"i", "reserved", 56, 8},
              {"i", "clusterTemplateAddress", 64, 64},
              {"i", "vertexBuffer", 128, 64},
              {"m", "srcAccelerationStructure", 0, 64},
              {"g", "clusterTemplateAddress", 0, 64},
              {"W", "minX", 384, 32},
              {"W", "instanceMask", 608, 32},
              {"W", "instanceContribution", 640, 32},
              {"W", "instanceFlags", 672, 32},
              {"W", "instanceIndex", 704, 32},
              {"W", "partitionIndex", 736, 32},
              {"W", "accelerationStructure", 768, 64},
              {"U", "instanceIndex", 0, 32},
              {"U", "instanceContribution", 32, 32},
              {"U", "accelerationStructure", 64, 64},
              {"R", "partitionIndex", 0, 32}};

static uint64_t value_of(struct play *play, const char *word)
{
    const bool is_place = word[0] >= 'A' && word[0] <= 'Z';
    return is_place || word[0] == '@' ? play_address(play, word) : play_number(play, word);
}

/* Sets a member. Returns false if the operation has none of that name. */
static bool set_field(struct play *play, unsigned char *element, char operation, char **words)
{
    for (size_t i = 0; i < ARRAY_COUNT(fields); i++) {
        const struct field *field = &fields[i];
        if (!strchr(field->of, operation) || !play_is(words[0], field->name))
            continue;
        PLAY_REQUIRE(play, words[1] != NULL);
        const uint64_t value = value_of(play, words[1]);
        uint64_t word;
        memcpy(&word, element + field->at / 64 * 8, sizeof(word));
        const uint64_t mask = (field->bits == 64 ? UINT64_MAX : (UINT64_C(1) << field->bits) - 1)
                              << field->at % 64;
        word = (word & ~mask) | (value << field->at % 64 & mask);
        memcpy(element + field->at / 64 * 8, &word, sizeof(word));
        return true;
    }
    return false;
}

static void set_number(struct play *play, unsigned char *element, char operation, const char *name,
                       uint64_t value)
{
    char text[32];
    snprintf(text, sizeof(text), "%llu", (unsigned long long)value);
    set_field(play, element, operation, (char *[]){(char *)name, text, NULL});
}

/* ---- clusters */

static const struct operation {
    const char *name;
    char letter;
    int type;
} operations[] = {
    {"move", 'm', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV},
    {"bottom", 'b', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV},
    {"build", 'c', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_NV},
    {"template", 't', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_TRIANGLE_CLUSTER_TEMPLATE_NV},
    {"instantiate", 'i', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_INSTANTIATE_TRIANGLE_CLUSTER_NV},
    {"indices", 'g', VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_GET_CLUSTER_TEMPLATE_INDICES_NV},
    {"write", 'W', VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_INSTANCE_NV},
    {"update", 'U', VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_UPDATE_INSTANCE_NV},
    {"translate", 'R',
     VK_PARTITIONED_ACCELERATION_STRUCTURE_OP_TYPE_WRITE_PARTITION_TRANSLATION_NV},
    {"unknown", '-', 77}};

static const struct operation *find_operation(struct play *play, const char *word)
{
    for (size_t i = 0; i < ARRAY_COUNT(operations); i++)
        if (play_is(word, operations[i].name))
            return &operations[i];
    play_fail(play, word);
}

/* A valid element. */
static void fill(struct play *play, unsigned char *element, char operation)
{
    const VkDeviceAddress input = play_address(play, "C0"), built = play_address(play, "C1");
    memset(element, 0, INFO_STRIDE);
    set_number(play, element, operation, "triangleCount", 2);
    set_number(play, element, operation, "vertexCount", 4);
    set_number(play, element, operation, "indexType", 4);
    set_number(play, element, operation, "indexBuffer", input);
    if (operation != 'i') /* an instance has the vertices of its template */
        set_number(play, element, operation, "vertexBuffer", input);
    set_number(play, element, operation, "clusterReferencesStride", 8);
    set_number(play, element, operation, "clusterReferences", input + REFERENCES_AT);
    set_number(play, element, operation, "clusterTemplateAddress", built);
    set_number(play, element, operation, "srcAccelerationStructure", built);
}

struct cluster_line {
    VkClusterAccelerationStructureCommandsInfoNV info;
    VkClusterAccelerationStructureTriangleClusterInputNV triangles;
    VkClusterAccelerationStructureClustersBottomLevelInputNV bottom_level;
    VkClusterAccelerationStructureMoveObjectsInputNV moves;
    uint32_t infos, dsts, references, geometries;
};

static void begin_line(struct play *play, struct cluster_line *line, const struct operation *op)
{
    const VkDeviceAddress input = play_address(play, "C0");
    VkClusterAccelerationStructureInputInfoNV *in = &line->info.input;
    line->triangles = MAKE(VkClusterAccelerationStructureTriangleClusterInputNV,
                           .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                           .maxClusterTriangleCount = 64, .maxClusterVertexCount = 64);
    line->bottom_level =
        MAKE(VkClusterAccelerationStructureClustersBottomLevelInputNV, .maxTotalClusterCount = 5,
             .maxClusterCountPerAccelerationStructure = 4);
    line->moves = MAKE(VkClusterAccelerationStructureMoveObjectsInputNV,
                       .type = VK_CLUSTER_ACCELERATION_STRUCTURE_TYPE_TRIANGLE_CLUSTER_NV,
                       .maxMovedBytes = 4096);
    line->info = MAKE(
        VkClusterAccelerationStructureCommandsInfoNV,
        .input = MAKE(VkClusterAccelerationStructureInputInfoNV, .maxAccelerationStructureCount = 4,
                      .opType = (VkClusterAccelerationStructureOpTypeNV)op->type),
        .dstImplicitData = play_address(play, "C1"), .scratchData = play_address(play, "C2"),
        .srcInfosArray = {input + INFOS_AT, INFO_STRIDE, 4 * INFO_STRIDE}, .srcInfosCount = input);
    if (op->letter == 'm')
        in->opInput.pMoveObjects = &line->moves;
    else if (op->letter == 'b')
        in->opInput.pClustersBottomLevel = &line->bottom_level;
    else
        in->opInput.pTriangleClusters = &line->triangles;
}

#define OPTION(word, member) PLAY_MEMBER(word, struct cluster_line, member)
static const struct play_member options[] = {
    OPTION("of", info.input.maxAccelerationStructureCount),
    OPTION("room", info.srcInfosArray.size),
    OPTION("flags", info.input.flags),
    OPTION("format", triangles.vertexFormat),
    OPTION("unique", triangles.maxClusterUniqueGeometryCount),
    OPTION("bits", triangles.minPositionTruncateBitCount),
    OPTION("indirect", info.addressResolutionFlags),
    OPTION("into", info.dstImplicitData),
    OPTION("scratch", info.scratchData),
    OPTION("infos", info.srcInfosArray.deviceAddress),
    OPTION("counted", info.srcInfosCount),
    OPTION("addresses", info.dstAddressesArray.deviceAddress),
    OPTION("sized", info.dstSizesArray.deviceAddress),
};

/* Reads an option of two words, or returns false. */
static bool read_option(struct play *play, struct cluster_line *line, unsigned char *bytes,
                        char **words)
{
    const uint64_t value = words[1] ? value_of(play, words[1]) : 0;
    uint64_t *dsts = (void *)(bytes + DSTS_AT), *references = (void *)(bytes + REFERENCES_AT);
    uint32_t *geometries = (void *)(bytes + GEOMETRIES_AT);
    if (play_is(words[0], "count"))
        memcpy(bytes, &value, sizeof(uint32_t));
    else if (play_is(words[0], "triangle"))
        geometries[line->geometries++ % LIST_MAX] = (uint32_t)value;
    else if (play_is(words[0], "dst"))
        dsts[line->dsts++ % LIST_MAX] = value;
    else if (play_is(words[0], "reference"))
        references[line->references++ % LIST_MAX] = value;
    else
        return play_set_member(line, options, ARRAY_COUNT(options), words[0], value);
    return true;
}

static void build_clusters(struct play *play, char **words)
{
    const struct operation *op = find_operation(play, words[0]);
    unsigned char *bytes = input_bytes(play);
    struct cluster_line line = {.infos = 1};
    PLAY_REQUIRE(play, play->vk.CmdBuildClusterAccelerationStructureIndirectNV != NULL);
    unsigned char *info = bytes + INFOS_AT;
    begin_line(play, &line, op);
    for (uint32_t i = 0; i < 4; i++)
        fill(play, info + i * INFO_STRIDE, op->letter);
    memcpy(bytes, &(uint32_t){1}, sizeof(uint32_t));
    for (words++; *words;) {
        if (play_is(*words, "explicit") || play_is(*words, "sizes")) {
            const VkStridedDeviceAddressRegionKHR array = {play_address(play, "C0") + DSTS_AT,
                                                           sizeof(uint64_t), 4 * sizeof(uint64_t)};
            const bool computes = play_is(*words++, "sizes");
            line.info.input.opMode =
                computes ? VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_COMPUTE_SIZES_NV
                         : VK_CLUSTER_ACCELERATION_STRUCTURE_OP_MODE_EXPLICIT_DESTINATIONS_NV;
            *(computes ? &line.info.dstSizesArray : &line.info.dstAddressesArray) = array;
        } else if (play_is(*words, "all")) { /* without a count in device memory */
            line.info.srcInfosCount = 0;
            words++;
        } else if (play_is(*words, "and")) {
            PLAY_REQUIRE(play, line.infos < LIST_MAX);
            memcpy(bytes, &(uint32_t){++line.infos}, sizeof(uint32_t));
            info += INFO_STRIDE;
            words++;
        } else {
            if (!set_field(play, info, op->letter, words) &&
                !read_option(play, &line, bytes, words))
                play_fail(play, *words);
            words += 2;
        }
    }
    play->vk.CmdBuildClusterAccelerationStructureIndirectNV(play_commands(play), &line.info);
}

/* ---- partitioned structures */

/* The operation that is written. */
struct operation_line {
    const struct operation *op;
    VkBuildPartitionedAccelerationStructureIndirectCommandNV *command;
    unsigned char *element;
    uint32_t index;
};

static void begin_operation(struct play *play, struct operation_line *line, const char *word)
{
    PLAY_REQUIRE(play, line->index < LIST_MAX);
    const struct play_object *input = play_object(play, "C0");
    const uint32_t at = ARGUMENTS_AT + line->index * ARGUMENTS_STRIDE;
    line->op = find_operation(play, word);
    line->command = (void *)(input->buffer.bytes + INFOS_AT);
    line->command += line->index++;
    *line->command = (VkBuildPartitionedAccelerationStructureIndirectCommandNV){
        .opType = (VkPartitionedAccelerationStructureOpTypeNV)line->op->type,
        .argCount = 1,
        .argData = {input->buffer.address + at,
                    line->op->letter == 'W'
                        ? sizeof(VkPartitionedAccelerationStructureWriteInstanceDataNV)
                        : sizeof(VkPartitionedAccelerationStructureUpdateInstanceDataNV)}};
    line->element = input->buffer.bytes + at;
    memset(line->element, 0, ARGUMENTS_STRIDE);
    memcpy(input->buffer.bytes, &line->index, sizeof(line->index));
}

#define PARTITION_OPTION(word, member)                                                             \
    PLAY_MEMBER(word, VkBuildPartitionedAccelerationStructureInfoNV, member)
static const struct play_member partition_options[] = {
    PARTITION_OPTION("src", srcAccelerationStructureData),
    PARTITION_OPTION("into", dstAccelerationStructureData),
    PARTITION_OPTION("scratch", scratchData),
    PARTITION_OPTION("infos", srcInfos),
};

static void build_partitions(struct play *play, char **words)
{
    VkPartitionedAccelerationStructureFlagsNV flags =
        MAKE(VkPartitionedAccelerationStructureFlagsNV, .enablePartitionTranslation = VK_TRUE);
    const struct play_object *input = play_object(play, "C0");
    unsigned char *bytes = input_bytes(play);
    VkBuildPartitionedAccelerationStructureInfoNV info =
        MAKE(VkBuildPartitionedAccelerationStructureInfoNV,
             .input = MAKE(VkPartitionedAccelerationStructureInstancesInputNV, .instanceCount = 4,
                           .maxInstancePerPartitionCount = 4, .partitionCount = 2,
                           .maxInstanceInGlobalPartitionCount = 4),
             .dstAccelerationStructureData = play_address(play, "C1"),
             .scratchData = play_address(play, "C2"), .srcInfos = input->buffer.address + INFOS_AT,
             .srcInfosCount = input->buffer.address);
    struct operation_line line = {0};
    uint32_t count = UINT32_MAX;
    PLAY_REQUIRE(play, play->vk.CmdBuildPartitionedAccelerationStructuresNV != NULL);
    while (*words) {
        if (play_is(*words, "translates")) {
            info.input.pNext = &flags;
            words++;
        } else if (line.op && play_is(*words, "again")) {
            PLAY_REQUIRE(play, line.command->argCount < ARGUMENTS_MAX);
            line.command->argCount++;
            line.element += line.command->argData.strideInBytes;
            words++;
        } else if (play_set_member(&info, partition_options, ARRAY_COUNT(partition_options), *words,
                                   words[1] ? value_of(play, words[1]) : 0)) {
            words += 2;
        } else if (line.op && play_is(*words, "arguments")) { /* behind all others */
            line.command->argData.startAddress = value_of(play, words[1]);
            words += 2;
        } else if (play_is(*words, "count")) {
            count = (uint32_t)play_number(play, words[1]);
            words += 2;
        } else if (line.op && set_field(play, line.element, line.op->letter, words)) {
            words += 2;
        } else {
            words += play_is(*words, "then");
            begin_operation(play, &line, *words++);
        }
    }
    if (count != UINT32_MAX)
        memcpy(bytes, &count, sizeof(count));
    play->vk.CmdBuildPartitionedAccelerationStructuresNV(play_commands(play), &info);
}

bool play_build_addressed(struct play *play, char **words)
{
    if (play_is(words[0], "clusters"))
        build_clusters(play, words + 1);
    else if (play_is(words[0], "partitions"))
        build_partitions(play, words + 1);
    else
        return false;
    return true;
}
