/* SPDX-License-Identifier: Apache-2.0 */
/* Threads: none but the caller's where one was asked for, and the same bytes however many there are
 * and whenever they come. */
#include <dirent.h>
#include <math.h>
#include <pthread.h>
#include <string.h>

#include "tests/builder/fixture.h"
#include "tests/unit/unit_test.h"

#define INSTANCES 9000u /* more than one thread's portion */

static uint32_t count_threads(void)
{
    DIR *tasks = opendir("/proc/self/task");
    uint32_t count = 0;
    assert_non_null(tasks);
    while (readdir(tasks))
        count++;
    closedir(tasks);
    return count - 2; /* . and .. */
}

/* Called in the midst of a build. */
static uint32_t most_threads;

static const void *count_and_find(void *context, uint64_t reference)
{
    if (reference % 1024 == 1 && __atomic_load_n(&most_threads, __ATOMIC_RELAXED) < 100) {
        uint32_t count = count_threads();
        if (count > __atomic_load_n(&most_threads, __ATOMIC_RELAXED))
            __atomic_store_n(&most_threads, count, __ATOMIC_RELAXED);
    }
    return context;
}

static uint32_t threads_in_build(const void *blas, uint32_t threads)
{
    VkAccelerationStructureInstanceKHR *instances =
        fixture_allocate(INSTANCES * sizeof(*instances));
    for (uint32_t i = 0; i < INSTANCES; i++) {
        instances[i] = fixture_instance(NULL);
        instances[i].accelerationStructureReference = i + 1;
    }
    INPUT(instances, input, instances, INSTANCES);
    input.input.threads = threads;
    input.input.resolver = (struct builder_resolver){count_and_find, (void *)blas};
    most_threads = 0;
    void *tlas = fixture_build(&input.input, NULL);
    assert_non_null(tlas);
    return most_threads;
}

SCOPE_TEST(test_threads)
{
    INPUT(triangles, input, fixture_triangle, 1);
    void *blas = fixture_build(&input.input, NULL);
    uint32_t before = count_threads();
    assert_int_equal(threads_in_build(blas, 0), before);
    assert_int_equal(threads_in_build(blas, 1), before);
    assert_true(threads_in_build(blas, 2) > before);
}

/* Enough for all threads at once, some of them at one place, some inactive, and nine far off: one
 * child of the root has more nodes than a thread's portion. */
static struct fixture_mesh make_mesh(void)
{
    struct fixture_mesh mesh = fixture_soup(75000, 5);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        if (i / 3 % 97 == 0)
            memcpy(&mesh.positions[3 * i], &mesh.positions[3 * (i % 3)], 12);
        else if (i % 1009 == 0)
            mesh.positions[3 * i] = NAN;
        else if (i / 3 % 8333 == 1)
            mesh.positions[3 * i] += ldexpf(1, 3 * (int)(i / 25000));
    return mesh;
}

/* What one thread builds, at each quality, and what that becomes when the mesh has moved. */
struct expected {
    struct fixture_mesh mesh, moved;
    void *built[3], *refitted[3];
};

static void *refit(const struct builder_input *input, const void *source)
{
    struct builder_report report;
    void *structure = fixture_allocate(builder_size(source));
    assert_int_equal(fixture_refit(input, source, structure, &report), BUILDER_OK);
    return structure;
}

static void make_expected(struct expected *expected)
{
    expected->mesh = make_mesh();
    expected->moved = make_mesh();
    for (uint32_t i = 0; i < 3 * expected->moved.vertex_count; i++)
        expected->moved.positions[i] *= 1 + (float)(i % 7) * 0.01f;
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++) {
        INPUT(mesh, input, &expected->mesh);
        input.input.quality = (enum builder_quality)quality;
        expected->built[quality] = fixture_build(&input.input, NULL);
        fixture_input_mesh(&input, &expected->moved);
        expected->refitted[quality] = refit(&input.input, expected->built[quality]);
    }
}

static void check_same(const struct expected *expected, int quality, uint32_t threads,
                       struct builder_team *team)
{
    const void *one = expected->built[quality];
    INPUT(mesh, input, &expected->mesh);
    input.input.quality = (enum builder_quality)quality;
    input.input.threads = threads;
    input.input.team = team;
    void *structure = fixture_build(&input.input, NULL);
    assert_int_equal(memcmp(structure, one, builder_size(one)), 0);
    input.geometry.triangles.vertices = expected->moved.positions;
    void *refitted = refit(&input.input, structure);
    assert_int_equal(memcmp(refitted, expected->refitted[quality], builder_size(one)), 0);
}

/* For the thread sanitizer, which takes long, the most threads are enough. */
static void check_threads(const struct expected *expected)
{
    for (uint32_t threads = HAS_THREAD_SANITIZER ? 5 : 2; threads <= 5; threads += 3)
        for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++)
            check_same(expected, quality, threads, NULL);
}

static void *help(void *team)
{
    builder_team_help(team);
    return NULL;
}

static void *help_for_now(void *team)
{
    builder_team_help_for_now(team);
    return NULL;
}

struct leader {
    const struct expected *expected;
    struct builder_team *team;
};

static void *lead(void *argument)
{
    const struct leader *leader = argument;
    check_same(leader->expected, BUILDER_FAST, 0, leader->team);
    check_same(leader->expected, BUILDER_BALANCED, 0, leader->team);
    return NULL;
}

/* One helper before the first build, one that comes in its midst, one after the last; and two
 * threads that lead builds at once. */
static void check_team(const struct expected *expected)
{
    struct builder_team team;
    pthread_t early, late, other;
    builder_team_open(&team);
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH && !HAS_THREAD_SANITIZER; quality++)
        check_same(expected, quality, 0, &team); /* no thread helps */
    struct leader leader = {expected, &team};
    assert_int_equal(pthread_create(&early, NULL, help, &team), 0);
    assert_int_equal(pthread_create(&other, NULL, lead, &leader), 0);
    assert_int_equal(pthread_create(&late, NULL, help_for_now, &team), 0);
    for (int quality = BUILDER_FAST; quality <= BUILDER_HIGH; quality++)
        check_same(expected, quality, 0, &team);
    pthread_join(other, NULL);
    builder_team_close(&team);
    pthread_join(early, NULL);
    pthread_join(late, NULL);
    builder_team_help(&team);
    builder_team_destroy(&team);
    builder_team_open(&team);
    builder_team_help_for_now(&team); /* there is nothing to do */
    builder_team_close(&team);
    builder_team_help_for_now(&team);
    builder_team_destroy(&team);
}

/* One test, because the thread sanitizer takes long for what one thread builds. */
SCOPE_TEST(test_same_bytes)
{
    struct expected expected;
    make_expected(&expected);
    check_threads(&expected);
    check_team(&expected);
}
