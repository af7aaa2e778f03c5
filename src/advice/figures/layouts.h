/* SPDX-License-Identifier: Apache-2.0 */
/* Whether geometries of one build read the same bytes as vertices in two ways, of which one must be
 * wrong. Several positions in one vertex are legal, and every second vertex of a finer mesh. */
#ifndef ASSAY_ADVICE_FIGURES_LAYOUTS_H
#define ASSAY_ADVICE_FIGURES_LAYOUTS_H

#include <stdbool.h>
#include <stdint.h>

/* The vertices that one geometry reads, nearly all of them: from the first one that it uses to the
 * last one. */
struct vertex_layout {
    uint64_t begin, count, stride; /* an address; of vertices; in bytes */
    uint32_t geometry;
    uint32_t format;    /* VkFormat */
    uint32_t component; /* its size in bytes; 0: not whole bytes */
    bool is_float;
};

/* The first geometries of a build. */
struct vertex_layouts {
    struct vertex_layout items[16];
    uint32_t count;
};

/* Returns an earlier geometry that reads the same bytes in another way, or NULL. */
const struct vertex_layout *vertex_layouts_find_other(const struct vertex_layouts *layouts,
                                                      const struct vertex_layout *layout);
/* Ignores a layout for which there is no room. */
void vertex_layouts_add(struct vertex_layouts *layouts, const struct vertex_layout *layout);

#endif
