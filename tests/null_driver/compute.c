/* SPDX-License-Identifier: Apache-2.0 */
/* Compute shaders: those of the layer, and one of the tests, are known by their words and carried
 * out here. All others do nothing. */
#include "copy_comp.h"
#include "gather_comp.h"
#include "guard_comp.h"
#include "internal.h"
#include "shade_comp.h"

/* ---- recording */

/* What a command buffer has bound and pushed. NULL of a freed one. */
static struct dispatch *compute_of(VkCommandBuffer commands)
{
    struct object *object = OBJECT(commands);
    return object->type == VK_OBJECT_TYPE_COMMAND_BUFFER ? &object->command_buffer.compute : NULL;
}

COMMAND(CmdBindPipeline)
{
    struct dispatch *compute = compute_of(commandBuffer);
    const struct object *object = FIND(PIPELINE, pipeline);
    if (pipelineBindPoint == VK_PIPELINE_BIND_POINT_COMPUTE && compute != NULL)
        compute->shader = object != NULL ? object->shader : NULL;
}

COMMAND(CmdPushConstants)
{
    struct dispatch *compute = compute_of(commandBuffer);
    if ((stageFlags & VK_SHADER_STAGE_COMPUTE_BIT) && compute != NULL &&
        offset <= sizeof(compute->constants) && size <= sizeof(compute->constants) - offset)
        memcpy(compute->constants + offset, pValues, size);
}

COMMAND(CmdBeginConditionalRenderingEXT)
{
    struct dispatch *compute = compute_of(commandBuffer);
    if (compute == NULL)
        return;
    compute->condition.buffer = pConditionalRenderingBegin->buffer;
    compute->condition.offset = pConditionalRenderingBegin->offset;
    compute->condition.is_inverted =
        pConditionalRenderingBegin->flags & VK_CONDITIONAL_RENDERING_INVERTED_BIT_EXT;
}

COMMAND(CmdEndConditionalRenderingEXT)
{
    struct dispatch *compute = compute_of(commandBuffer);
    if (compute != NULL)
        compute->condition.buffer = VK_NULL_HANDLE;
}

COMMAND(CmdDispatch)
{
    struct dispatch *compute = compute_of(commandBuffer);
    if (compute == NULL || compute->shader == NULL)
        return;
    compute->groups = groupCountX;
    transfers_add_dispatch(commandBuffer, compute);
}

/* ---- memory by its addresses */

bool address_read(VkDeviceAddress address, void *bytes, VkDeviceSize size)
{
    VkDeviceSize part;
    for (VkDeviceSize done = 0; done < size; done += part) {
        part = size - done;
        const unsigned char *from = address_bytes(address + done, &part);
        if (from == NULL)
            return false;
        memcpy((unsigned char *)bytes + done, from, part);
    }
    return true;
}

void address_write(VkDeviceAddress address, const void *bytes, VkDeviceSize size)
{
    VkDeviceSize part;
    for (VkDeviceSize done = 0; done < size; done += part) {
        part = size - done;
        unsigned char *to = address_bytes(address + done, &part);
        if (to == NULL)
            return;
        memcpy(to, (const unsigned char *)bytes + done, part);
    }
}

static void copy_bytes(VkDeviceAddress source, VkDeviceAddress target, VkDeviceSize size)
{
    VkDeviceSize part;
    for (VkDeviceSize done = 0; done < size; done += part) {
        part = size - done;
        const unsigned char *from = address_bytes(source + done, &part);
        if (from == NULL)
            return;
        address_write(target + done, from, part);
    }
}

/* ---- layer/snapshots/copies/copy.comp */

struct copy_order {
    uint64_t source, target, left;
    uint32_t size, is_done;
};

struct copy_constants {
    uint64_t gate, orders;
};

static bool is_open(VkDeviceAddress gate)
{
    uint32_t value;
    return address_read(gate, &value, sizeof(value)) && value != 0;
}

static void copy(const struct dispatch *dispatch)
{
    struct copy_constants constants;
    memcpy(&constants, dispatch->constants, sizeof(constants));
    if (!is_open(constants.gate))
        return;
    for (uint32_t i = 0; i < dispatch->groups; i++) {
        const VkDeviceAddress at = constants.orders + i * sizeof(struct copy_order);
        struct copy_order order;
        if (!address_read(at, &order, sizeof(order)))
            return;
        copy_bytes(order.source, order.target, order.left < order.size ? order.left : order.size);
        order.is_done = 1;
        address_write(at, &order, sizeof(order));
    }
}

/* ---- layer/snapshots/copies/gather.comp */

struct gathering {
    uint64_t gate, addresses, ranges, target;
    uint32_t count, range_count, words, typed, first, stride, parts, reserved;
};

enum { WORDS_MAX = 36 }; /* of an instance */

static void gather(const struct dispatch *dispatch)
{
    struct gathering gathering;
    memcpy(&gathering, dispatch->constants, sizeof(gathering));
    const VkDeviceSize size = gathering.words * sizeof(uint32_t);
    if (!is_open(gathering.gate))
        return;
    for (uint32_t i = 0; i < gathering.count && gathering.words <= WORDS_MAX; i++) {
        uint32_t element[WORDS_MAX] = {0}, words = gathering.words;
        VkDeviceAddress address;
        const uint64_t at = gathering.first + (uint64_t)(i / gathering.parts) * gathering.stride;
        if (!address_read(gathering.addresses + at * sizeof(address), &address, sizeof(address)))
            return;
        if (gathering.typed != 0) {
            words = instance_words((uint32_t)address & 15);
            address &= ~(VkDeviceAddress)15;
        }
        address += i % gathering.parts * size;
        if (address % sizeof(uint32_t) == 0 &&
            ranges_contain(gathering.ranges, gathering.range_count, address,
                           words * sizeof(uint32_t)))
            address_read(address, element, words * sizeof(uint32_t));
        address_write(gathering.target + i * size, element, size);
    }
}

/* ---- tests/fixture/shaders/shade.comp */

struct shade_constants {
    uint64_t address;
    uint32_t count;
    float number;
};

static void shade(const struct dispatch *dispatch)
{
    struct shade_constants constants;
    memcpy(&constants, dispatch->constants, sizeof(constants));
    for (uint32_t i = 0; i < constants.count; i++)
        address_write(constants.address + i * sizeof(float), &constants.number, sizeof(float));
}

static bool condition_is_met(const struct dispatch *dispatch)
{
    uint32_t word = 1;
    VkDeviceSize size = sizeof(word);
    if (!dispatch->condition.buffer)
        return true;
    const unsigned char *bytes =
        buffer_bytes(dispatch->condition.buffer, dispatch->condition.offset, &size);
    if (bytes != NULL && size == sizeof(word))
        memcpy(&word, bytes, sizeof(word));
    return (word != 0) != dispatch->condition.is_inverted;
}

void dispatch_execute(const struct dispatch *dispatch)
{
    if (condition_is_met(dispatch))
        dispatch->shader(dispatch);
}

/* ---- shaders and pipelines */

static const struct {
    const uint32_t *words;
    size_t size;
    shader_function *execute;
} shaders[] = {{copy_comp, sizeof(copy_comp), copy},
               {gather_comp, sizeof(gather_comp), gather},
               {guard_comp, sizeof(guard_comp), guard_execute},
               {shade_comp, sizeof(shade_comp), shade}};

ON_CREATION(CreateShaderModule)
{
    for (size_t i = 0; i < COUNT_OF(shaders); i++)
        if (pCreateInfo->codeSize == shaders[i].size &&
            memcmp(pCreateInfo->pCode, shaders[i].words, shaders[i].size) == 0)
            object->shader = shaders[i].execute;
}

COMMAND(CreateComputePipelines)
{
    const VkResult result =
        objects_create(OBJECT(device), VK_OBJECT_TYPE_PIPELINE, createInfoCount, pPipelines);
    for (uint32_t i = 0; i < createInfoCount; i++) {
        const struct object *module = FIND(SHADER_MODULE, pCreateInfos[i].stage.module);
        struct object *pipeline = FIND(PIPELINE, pPipelines[i]);
        if (module != NULL && pipeline != NULL)
            pipeline->shader = module->shader;
    }
    return result;
}
