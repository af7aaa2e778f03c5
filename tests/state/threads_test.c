/* SPDX-License-Identifier: Apache-2.0 */
/* The state modules and the reporter on many threads, as the layer uses them: some record builds of
 * objects that stay, while others make, bind, name and destroy objects around them. What stays must
 * be found as it is at all times. Worth most under the thread sanitizer. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "random.h"
#include "src/report/reporter.h"
#include "src/state/builds/size_cache.h"
#include "src/state/commands/object_names.h"
#include "tests/fixture/make.h"
#include "tests/fixture/messenger.h"
#include "tests/state/command_fixture.h"
#include "tests/state/fixture.h"

enum {
    RECORDERS = 5,
    MAKERS = 3,
    MILLISECONDS = 700, /* that it goes on for */
    BUILDS = 6,         /* of each recording */
    OBJECTS = 8,        /* that a maker has at a time, each of its own handles */
    SIZE = 0x1000,
};

#define BASE 0x100000000u

static struct device {
    struct resources *resources;
    struct command_buffers *command_buffers;
    struct object_names *names;
    struct size_cache *sizes;
    struct reporter *reporter;
    atomic_bool running;
    atomic_uint sent, heard;
    atomic_uint wrong; /* line of the first thing that was not as it should be */
} device;

/* cmocka's assertions are for the main thread. */
#define EXPECT(condition)                                                                          \
    do {                                                                                           \
        unsigned none = 0;                                                                         \
        if (!(condition))                                                                          \
            atomic_compare_exchange_strong(&device.wrong, &none, (unsigned)__LINE__);              \
    } while (0)

/* ---- recorders: recorder n has memory, buffer and structure n, and pool and command buffer n */

static void make_stable_objects(unsigned n)
{
    const VkCommandBuffer added = handle(n);
    have_memory(device.resources, n);
    have_bound_buffer(device.resources, n, SIZE, 0, n, n * SIZE);
    resources_set_address(device.resources, buffer(n), BASE + n * SIZE);
    have_accel(device.resources, n, n, 0x100, 0x200);
    command_buffers_add_pool(device.command_buffers, pool(n), 0, VK_QUEUE_COMPUTE_BIT, false);
    command_buffers_add(device.command_buffers, pool(n), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1,
                        &added);
}

static void look_up(unsigned n, unsigned others)
{
    struct accel_facts own, other;
    struct address_facts scratch, input;
    unsigned token = resources_begin_reading(device.resources);
    resources_find_accel(device.resources, accel(n), &own);
    resources_find_accel(device.resources, accel(others), &other);
    resources_find_address(device.resources, BASE + n * SIZE + 0x10, &scratch);
    resources_find_address(device.resources, BASE + others * SIZE, &input);
    resources_end_reading(device.resources, token);
    EXPECT(own.alive == YES && own.backed == YES && own.memory == memory(n) &&
           own.begin == n * SIZE + 0x100 && own.size == 0x200);
    EXPECT(other.alive != YES || other.size == 0x80);
    EXPECT(scratch.status == ADDRESS_IN_BUFFER && scratch.buffer == buffer(n) &&
           scratch.bytes_left == SIZE - 0x10);
    EXPECT(input.status != ADDRESS_IN_BUFFER || input.bytes_left <= SIZE);
    resources_find_id(device.resources, RESOURCE_ACCEL, (uint64_t)(uintptr_t)accel(others));
}

/* Shapes that have the same last bits replace each other in the cache. */
static void query_sizes(struct random *random)
{
    const struct build_shape shape = {
        .low = random_below(random, 4) << 16 | random_below(random, 4), .high = 1};
    const struct size_facts sizes = {.known = true,
                                     .acceleration_structure = shape.low + 1,
                                     .build_scratch = shape.low + 2,
                                     .update_scratch = shape.low + 3};
    struct size_facts found;
    if (size_cache_find(device.sizes, &shape, &found))
        EXPECT(found.known && found.acceleration_structure == sizes.acceleration_structure &&
               found.build_scratch == sizes.build_scratch &&
               found.update_scratch == sizes.update_scratch);
    else
        size_cache_add(device.sizes, &shape, &sizes);
}

static void send(unsigned n, const struct label_stack *labels)
{
    struct finding finding;
    finding_says(&finding, "dstAccelerationStructure", "{} lies in {}, {}",
                 object(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)(uintptr_t)accel(n)),
                 object(VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)buffer(n)), number(n));
    const struct location location = {.command = COMMAND_DEVICE, .subject = SUBJECT_BUILD};
    const struct call_origin origin = {
        .command_buffer = handle(n), .names = device.names, .labels = labels};
    atomic_fetch_add(&device.sent, 1);
    reporter_send(device.reporter, RULE_dst_is_backed_by_memory, &location, &origin, &finding);
}

static void record_once(struct random *random, unsigned n)
{
    const STRUCT(VkCommandBufferBeginInfo, info);
    const VkDebugUtilsLabelEXT label = {.pLabelName = "frame"};
    struct command_buffer *own = command_buffers_find(device.command_buffers, handle(n));
    EXPECT(own && own->handle == handle(n));
    command_buffer_begin(own, &info, resources_destroy_count(device.resources), VK_SUCCESS);
    label_stack_push(command_buffers_labels(device.command_buffers, handle(n)), &label);
    for (unsigned build = 0; build < BUILDS; build++) {
        look_up(n, 1 + RECORDERS + random_below(random, MAKERS * OBJECTS));
        query_sizes(random);
        struct command_buffer_facts facts;
        command_buffers_facts(device.command_buffers, own, handle(n), &facts);
        EXPECT(facts.alive == YES && facts.state == COMMAND_BUFFER_RECORDING);
        EXPECT(facts.build_index == build);
        own->facts.build_index++;
    }
    if (random_one_in(random, 4))
        send(n, &own->labels);
    command_buffer_end(own, VK_SUCCESS);
}

static void *record(void *context)
{
    struct random *random = context;
    unsigned n = (unsigned)(random->state & 0xff);
    const VkCommandBuffer own = handle(n);
    while (atomic_load(&device.running)) {
        record_once(random, n);
        if (random_one_in(random, 5))
            command_buffers_reset_pool(device.command_buffers, pool(n), random_one_in(random, 2));
        if (random_one_in(random, 5)) {
            command_buffers_remove(device.command_buffers, 1, &own);
            command_buffers_add(device.command_buffers, pool(n), VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1,
                                &own);
        }
    }
    return NULL;
}

/* ---- makers: each has the objects from its first number on */

static void name(VkObjectType type, uint64_t handle, const char *format, unsigned n)
{
    char text[64];
    snprintf(text, sizeof(text), format, n);
    object_names_set(device.names, type, handle, format[0] ? text : NULL);
}

static void make_object(struct random *random, unsigned n)
{
    have_memory(device.resources, n);
    if (random_one_in(random, 3)) {
        have_sparse_buffer(device.resources, n, SIZE);
        for (unsigned i = 0; i < 4; i++)
            bind_sparse(device.resources, n, i * 0x400, 0x400, n, (3 - i) * 0x400);
    } else {
        have_bound_buffer(device.resources, n, SIZE, 0, n, 0);
    }
    resources_set_address(device.resources, buffer(n), BASE + n * SIZE);
    have_accel(device.resources, n, n, 0, 0x80);
    name(VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)buffer(n), "buffer %u", n);
    name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)(uintptr_t)accel(n), "tree %u", n);
}

static void destroy_object(struct random *random, unsigned n)
{
    name(VK_OBJECT_TYPE_BUFFER, (uint64_t)(uintptr_t)buffer(n), "", n);
    if (random_one_in(random, 2))
        resources_remove_memory(device.resources, memory(n));
    if (random_one_in(random, 2))
        resources_remove_accel(device.resources, accel(n));
    resources_remove_buffer(device.resources, buffer(n));
    resources_remove_accel(device.resources, accel(n));
    resources_remove_memory(device.resources, memory(n));
}

static void note_gone(void *user, VkCommandBuffer gone)
{
    object_names_set(device.names, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)gone, NULL);
}

/* Names of the recorders' objects change all the while. */
static void rename_and_repool(struct random *random, unsigned n)
{
    unsigned recorder = 1 + random_below(random, RECORDERS);
    const VkCommandBuffer added = handle(n);
    name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, (uint64_t)(uintptr_t)accel(recorder),
         random_one_in(random, 2) ? "tree %u" : "oak tree number %u", n);
    command_buffers_add_pool(device.command_buffers, pool(n), 0, VK_QUEUE_TRANSFER_BIT, false);
    command_buffers_add(device.command_buffers, pool(n), VK_COMMAND_BUFFER_LEVEL_SECONDARY, 1,
                        &added);
    command_buffers_remove_pool(device.command_buffers, pool(n), note_gone, NULL);
}

MESSENGER_CALLBACK(hear_nothing)
{
    return VK_FALSE;
}

static VkDebugUtilsMessengerCreateInfoEXT messenger(PFN_vkDebugUtilsMessengerCallbackEXT call)
{
    return MAKE(VkDebugUtilsMessengerCreateInfoEXT,
                .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                .pfnUserCallback = call);
}

static void *make(void *context)
{
    struct random *random = context;
    unsigned first = (unsigned)(random->state & 0xff);
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(hear_nothing);
    while (atomic_load(&device.running)) {
        VkDebugUtilsMessengerEXT ear = (VkDebugUtilsMessengerEXT)(uintptr_t)(100 + first);
        for (unsigned i = 0; i < OBJECTS; i++)
            make_object(random, first + i);
        reporter_add_messenger(device.reporter, ear, &info);
        rename_and_repool(random, first);
        reporter_remove_messenger(device.reporter, ear);
        for (unsigned i = 0; i < OBJECTS; i++)
            destroy_object(random, first + i);
    }
    return NULL;
}

static bool is_a_name(const char *text)
{
    return !text || strncmp(text, "tree ", 5) == 0 || strncmp(text, "oak tree number ", 16) == 0;
}

MESSENGER_CALLBACK(hear)
{
    atomic_fetch_add(&device.heard, 1);
    EXPECT(data->cmdBufLabelCount == 1 && strcmp(data->pCmdBufLabels[0].pLabelName, "frame") == 0);
    for (uint32_t i = 0; i < data->objectCount; i++)
        EXPECT(is_a_name(data->pObjects[i].pObjectName));
    return VK_FALSE;
}

static void make_device(void)
{
    const STRUCT(VkInstanceCreateInfo, create_info);
    const VkDebugUtilsMessengerCreateInfoEXT info = messenger(hear);
    setenv("VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT", "0", 1);
    device.resources = no_resources();
    assert_int_equal(command_buffers_create(&device.command_buffers), VK_SUCCESS);
    assert_int_equal(object_names_create(&device.names), VK_SUCCESS);
    assert_int_equal(size_cache_create(&device.sizes), VK_SUCCESS);
    assert_int_equal(reporter_create(&create_info, &device.reporter), VK_SUCCESS);
    reporter_set_instance_alive(device.reporter, true);
    assert_int_equal(
        reporter_add_messenger(device.reporter, (VkDebugUtilsMessengerEXT)(uintptr_t)1, &info),
        VK_SUCCESS);
    for (unsigned n = 1; n <= RECORDERS; n++)
        make_stable_objects(n);
    atomic_store(&device.running, true);
}

static void destroy_device(void)
{
    reporter_destroy(device.reporter);
    size_cache_destroy(device.sizes);
    object_names_destroy(device.names);
    command_buffers_destroy(device.command_buffers);
    resources_destroy(device.resources);
}

/* A random sequence that carries, in its first state, the number of its thread. */
static struct random random_for(struct random *random, unsigned number)
{
    return (struct random){(random_next(random) & ~(uint64_t)0xff) | number};
}

TEST(test_recorders_and_makers)
{
    struct random random = random_of("threads"), randoms[RECORDERS + MAKERS];
    pthread_t threads[RECORDERS + MAKERS];
    make_device();
    for (unsigned i = 0; i < RECORDERS + MAKERS; i++) {
        unsigned maker = i - RECORDERS;
        randoms[i] = random_for(&random, i < RECORDERS ? 1 + i : 1 + RECORDERS + maker * OBJECTS);
        assert_int_equal(
            pthread_create(&threads[i], NULL, i < RECORDERS ? record : make, &randoms[i]), 0);
    }
    const struct timespec time = {.tv_nsec = MILLISECONDS * 1000000L};
    nanosleep(&time, NULL);
    atomic_store(&device.running, false);
    for (unsigned i = 0; i < RECORDERS + MAKERS; i++)
        pthread_join(threads[i], NULL);
    destroy_device();
    if (atomic_load(&device.wrong))
        fail_msg("line %u", atomic_load(&device.wrong));
    assert_int_equal(atomic_load(&device.heard), atomic_load(&device.sent));
    assert_true(atomic_load(&device.sent) > 0);
}
