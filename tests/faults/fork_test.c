/* SPDX-License-Identifier: Apache-2.0 */
/* fork_test PLATFORM LEVEL: forks of a process whose threads use the layer. The child has one
 * thread, and any lock may be held for ever. Whatever the child does, it ends. */
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/loader/loader_test.h"

enum {
    THREADS = 4,
    FORKS = 15,      /* of each kind */
    CHILD_ENDS = 60, /* seconds */
    IS_MISSING = 2,  /* exit codes of children */
    IS_FOUND = 3,
};

static const char *level;
static struct fixture fixture;
static atomic_bool are_busy;
static atomic_uint rounds;

/* Looks up handles that do not exist, which takes the locks of the registry and of all devices; and
 * makes mistakes. No object is created: the driver has locks, too, and the loader. */
static void *use_layer(void *context)
{
    struct scene *scene = context;
    const uint32_t count = scene->info_count;
    VkAccelerationStructureBuildGeometryInfoKHR *info = &scene->infos[0];
    const VkAccelerationStructureKHR dst = info->dstAccelerationStructure;
    /* It leads to the device, and is none of its command buffers. */
    const void *key = *(const void *const *)scene->command_buffer;
    const VkCommandBuffer commands = scene->command_buffer,
                          freed = (VkCommandBuffer)(uintptr_t)&key;
    for (uint64_t i = 0; atomic_load(&are_busy); i++) {
        scene->command_buffer = freed;
        for (int j = 0; j < 50; j++)
            scene_call(scene);
        scene->command_buffer = commands;
        info->dstAccelerationStructure = i % 3 ? dst : (VkAccelerationStructureKHR)(uintptr_t)i;
        scene->info_count = i % 5 ? count : 0;
        scene_call(scene);
        scene->vk->EndCommandBuffer(scene->command_buffer);
        scene_begin(scene, scene->command_buffer, 0);
        atomic_fetch_add(&rounds, 1);
    }
    return NULL;
}

/* ---- what children do */

static void leave(struct scene *scene) {}

static void execute_program(struct scene *scene)
{
    execlp("true", "true", (char *)NULL);
    _exit(IS_MISSING);
}

/* As an application does that destroys its objects in functions of atexit(). */
static void destroy(struct scene *scene)
{
    const VkuDeviceDispatchTable *vk = scene->vk;
    vk->DestroyFence(fixture.device, VK_NULL_HANDLE, NULL);
    vk->DestroyDevice(fixture.device, NULL);
    fixture.instance.vk.DestroyDebugUtilsMessengerEXT(fixture.instance.instance,
                                                      fixture.instance.messenger, NULL);
}

static void record(struct scene *scene)
{
    const uint32_t count = scene->info_count;
    for (uint32_t i = 0; i < 10; i++) {
        scene->info_count = i % 2 ? count : 0;
        scene_buffer(scene, 256, INPUT_USAGE);
        scene_call(scene);
    }
    scene->vk->EndCommandBuffer(scene->command_buffer);
    const STRUCT(VkSubmitInfo, info, .commandBufferCount = 1,
                 .pCommandBuffers = &scene->command_buffer);
    VkQueue queue;
    scene->vk->GetDeviceQueue(fixture.device, 0, 0, &queue);
    scene->vk->QueueSubmit(queue, 1, &info, VK_NULL_HANDLE);
    scene->vk->DeviceWaitIdle(fixture.device);
}

/* In it a mistake is found, and nothing else. */
static void create(struct scene *scene)
{
    const struct setup setup = {.level = level};
    if (count_findings(&setup) != 1)
        _exit(IS_MISSING);
    exit(IS_FOUND);
}

static int wait_for(pid_t child);

static void use_all(struct scene *scene)
{
    record(scene);
    const pid_t grandchild = fork();
    if (grandchild == 0) {
        record(scene);
        exit(IS_FOUND);
    }
    if (wait_for(grandchild) != IS_FOUND)
        exit(IS_MISSING);
    const struct setup setup = {.level = level};
    const uint32_t count = count_findings(&setup);
    destroy(scene);
    exit(count == 1 ? IS_FOUND : IS_MISSING);
}

/* ---- forks */

/* Returns the child's exit code. */
static int wait_for(pid_t child)
{
    int status = 0;
    for (int i = 0; i < CHILD_ENDS * 1000; i++) {
        if (waitpid(child, &status, WNOHANG) == child) {
            if (!WIFEXITED(status))
                fail_msg("the child ended with signal %d", WTERMSIG(status));
            return WEXITSTATUS(status);
        }
        usleep(1000);
    }
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    fail_msg("the child hangs");
    return -1;
}

static const struct row {
    const char *test;
    void (*deed)(struct scene *scene);
    int code; /* the child's exit code */
} rows[] = {{"test_child_exits", leave, 0},
            {"test_child_executes_another_program", execute_program, 0},
            {"test_child_creates_an_instance", create, IS_FOUND},
            {"test_child_records_for_the_parent", record, 0},
            {"test_child_destroys_objects_of_the_parent", destroy, 0},
            {"test_child_does_everything", use_all, IS_FOUND}};

TEST_OF_ROWS(test_fork, rows, const struct row *row, unit_test_nothing)
{
    const struct setup setup = {.level = level};
    struct scene *scenes[THREADS + 1];
    pthread_t threads[THREADS];
    assert_null(fixture_open(&fixture, &platform, &setup));
    for (int i = 0; i <= THREADS; i++)
        scenes[i] = scene_open(&fixture, COMMAND_DEVICE);
    atomic_store(&are_busy, true);
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, use_layer, scenes[i]), 0);
    for (int i = 0; i < FORKS; i++) {
        const unsigned before = atomic_load(&rounds);
        while (atomic_load(&rounds) - before < 20)
            usleep(100);
        fflush(NULL);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            messages_after_fork();
            row->deed(scenes[THREADS]);
            exit(0);
        }
        assert_int_equal(wait_for(child), row->code);
    }
    atomic_store(&are_busy, false);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    for (int i = 0; i <= THREADS; i++)
        scene_close(scenes[i]);
    fixture_close(&fixture);
}

const char *loader_test_open(void)
{
    level = unit_test_arguments[1];
    return NULL;
}
