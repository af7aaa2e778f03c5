/* SPDX-License-Identifier: Apache-2.0 */
/* Records what builds access: a struct build_recorder that records builds in journals, too. Its
 * `user` is the struct build_call. */
#ifndef ASSAY_LAYER_HAZARDS_BUILDS_H
#define ASSAY_LAYER_HAZARDS_BUILDS_H

#include "layer/hazards/recording.h"
#include "layer/intercepts/intercepts.h"

/* Returns the recorder of builds with setting `hazards`. */
const struct build_recorder *hazards_build_recorder(void);

/* The role of an input of a geometry; `has_pointers`: its instances are behind pointers (inputs.c).
 */
enum hazard_role hazards_role_of(enum input_role role, bool has_pointers);

/* Adds what a vkCmdBuildAccelerationStructureNV accesses. */
void hazards_add_nv_build(struct hazard_recording *recording, const struct nv_call_view *view);

/* Adds reads of `count` elements; `facts` and `host` are those of the input's address, and `host`
 * is NULL in device builds. Bytes between elements may belong to something else. */
struct hazard_elements {
    const struct address_facts *facts;
    const void *host;
    uint64_t memory_id; /* 0: to be looked up from `facts` */
    uint64_t offset, count, stride, size;
};
void hazards_add_elements(struct hazard_recording *recording, const struct hazard_use *use,
                          const struct hazard_elements *elements);

/* Adds the vertices of a geometry with indices, which say which ones are read: `elements` begin at
 * the vertex of index 0. */
void hazards_add_indexed(struct hazard_recording *recording, const struct hazard_use *use,
                         const struct hazard_elements *elements);

/* Adds what a geometry certainly reads; of what a host build reads, mapped memory (inputs.c). */
void hazards_add_inputs(struct hazard_recording *recording, const struct geometry_view *geometry);

#endif
