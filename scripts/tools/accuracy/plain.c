/* SPDX-License-Identifier: Apache-2.0 */
/* accuracy_plain ACCURACY: for callgrind, which collects in counted_build() or in counted_rays().
 * The reference builder builds a mesh that uses nothing of any extension, and RAYS rays are traced
 * at accuracy 0 (fast), 1 (robust) or 2 (exact). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "tests/builder/fixture.h"

enum { SIDE = 20, RAYS = 2000 };

__attribute__((noipa)) void counted_build(const struct builder_input *input,
                                          const struct builder_sizes *sizes, void *structure,
                                          void *scratch);
void counted_build(const struct builder_input *input, const struct builder_sizes *sizes,
                   void *structure, void *scratch)
{
    builder_build(input, structure, sizes->structure, scratch, sizes->build_scratch, NULL);
}

__attribute__((noipa)) uint32_t counted_rays(const void *structure, const struct trace_ray *rays,
                                             enum trace_accuracy accuracy);
uint32_t counted_rays(const void *structure, const struct trace_ray *rays,
                      enum trace_accuracy accuracy)
{
    struct trace_hit hit;
    uint32_t hits = 0;
    for (uint32_t i = 0; i < RAYS; i++)
        hits += fixture_trace(structure, accuracy, &rays[i], &hit);
    return hits;
}

static void make_rays(struct trace_ray rays[RAYS])
{
    uint64_t random = 88172645463325252u;
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (struct trace_ray){.t_max = INFINITY, .cull_mask = 0xff};
        for (int axis = 0; axis < 3; axis++) {
            rays[i].origin[axis] = fixture_uniform(&random, -2, 2);
            rays[i].direction[axis] = fixture_uniform(&random, -1, 1) - rays[i].origin[axis];
        }
    }
}

int main(int count, char **arguments)
{
    static const float center[3] = {0, 0, 0};
    static struct trace_ray rays[RAYS];
    struct fixture_mesh mesh = fixture_sphere(SIDE, 1, center);
    struct fixture_input input;
    struct builder_sizes sizes;
    if (count != 2)
        return 2;
    fixture_input_mesh(&input, &mesh);
    input.input.threads = 1;
    input.input.quality = BUILDER_BALANCED;
    builder_get_sizes(&input.input, &mesh.triangle_count, &sizes);
    void *structure = fixture_allocate(sizes.structure),
         *scratch = fixture_allocate(sizes.build_scratch);
    make_rays(rays);
    counted_build(&input.input, &sizes, structure, scratch);
    printf("%u hits\n",
           counted_rays(structure, rays, (enum trace_accuracy)strtoul(arguments[1], NULL, 10)));
    free(structure);
    free(scratch);
    fixture_mesh_free(&mesh);
    return EXIT_SUCCESS;
}
