/* SPDX-License-Identifier: Apache-2.0 */
/* What became of a structure since it was created, and what its builds have read: noted in its
 * record (struct structures). */
#ifndef ASSAY_ADVICE_USES_H
#define ASSAY_ADVICE_USES_H

#include "src/advice/figures/boxes.h"
#include "src/state/builds/structures.h"

enum structure_use {
    USE_BUILT,         /* it was built, and not by an update */
    USE_UPDATED,       /* it was the dst of an update */
    USE_UPDATE_SOURCE, /* it was the src of an update, also of one in place */
    USE_FILLED,    /* it was written by a copy or a deserialization, or its contents are unknown */
    USE_COPIED,    /* it was cloned or serialized */
    USE_COMPACTED, /* it was the src of a compacting copy */
    USE_SIZE_QUERIED, /* its compacted size was queried */
    USE_REFERRED_TO,  /* instances of a build that was read refer to it */
    STRUCTURE_USES,
};

/* What a build was made of, at level content. */
struct structure_contents {
    uint64_t primitives;
    uint64_t inactive;
    uint64_t
        invisible; /* others that no ray can hit: degenerate triangles, instances with mask 0 */
    bool is_top;
    bool has_box;          /* of a bottom level */
    struct figure_box box; /* around all that a ray can hit */
};

static inline bool structure_is_hollow(const struct structure_contents *contents)
{
    return contents->inactive + contents->invisible == contents->primitives;
}

/* What a build has read: a hash of its parameters and of the bytes. */
struct input_digest {
    uint64_t words[2];
    /* If is_top: what structures_find_serial() returned when the build executed. */
    uint64_t serial;
    bool is_top;
};

/* Which builds and updates of a structure have read the same input, as far as the layer compared
 * it. Numbers are those of read_builds. */
struct input_repeats {
    struct input_digest last;
    bool is_known;       /* `last` is */
    bool is_shared;      /* its memory may be */
    uint32_t number;     /* of the build that `last` is of */
    uint32_t since;      /* the first build with this input */
    uint32_t equal_ones; /* how many had, since then, the input of the build just before */
};

struct structure_uses {
    uint32_t counts[STRUCTURE_USES]; /* by enum structure_use */
    uint32_t first_build; /* number of executed submissions up to its first build, if it has one;
                           * or up to its copy, if is_hasty_copy */
    bool is_hasty_copy;   /* its first write was a copy of a structure that was built once, with
                           * PREFER_FAST_BUILD */
    VkBuildAccelerationStructureFlagsKHR flags; /* that all its builds had */
    VkDeviceSize compacted_size;                /* the last one that the host read; 0: none */
    /* Counts of builds and updates: the layer has read the input data of read_builds, and no ray
     * can hit anything in hollow_builds of these. */
    uint32_t read_builds, hollow_builds;
    struct structure_contents contents; /* of the last hollow one */
    bool has_box;                       /* of one build or copy */
    struct figure_box box;
    struct input_repeats repeats;
    uint64_t advised;         /* bits 1 << enum advice: given about the input data */
    bool is_tiny;             /* its last build has few primitives */
    VkDeviceSize needed_size; /* of its last build, in bytes; 0: unknown, or it has none */
};

/* ---- the writer of the structures */

/* Counts a build of a structure that has a record: written structures have one. The build has flags
 * and needs so many bytes (0: unknown), and is of the submission with this number. Returns false if
 * there is no memory. */
bool uses_note_build(struct structures *structures, uint64_t id, uint32_t submission,
                     VkBuildAccelerationStructureFlagsKHR flags, VkDeviceSize needed);
/* A copy to a structure that has a record takes the box of its source, if that is known. */
void uses_copy_box(const struct structures *structures, uint64_t dst_id, uint64_t src_id);
/* The copy takes is_hasty_copy of its source, too. Call this once the copy is counted. */
void uses_copy_haste(const struct structures *structures, uint64_t dst_id, uint64_t src_id,
                     uint32_t submission);
/* The host has read the compacted size of a structure that has a record. */
bool uses_note_compacted_size(struct structures *structures, uint64_t id, VkDeviceSize size);

/* ---- any thread */

/* Counts a use of a structure that has a record. Returns false if there is no memory. */
bool uses_note(struct structures *structures, uint64_t id, enum structure_use use);
/* Notes whether a structure is tiny, and returns whether it was; with false, when it is destroyed.
 */
bool uses_note_tiny(const struct structures *structures, uint64_t id, bool is_tiny);
/* Finds what became of a structure that is alive, all zero if nothing. Returns false if that is
 * unknown. */
bool uses_find(const struct structures *structures, uint64_t id, struct structure_uses *uses);

/* Counts a build whose input data is read. Data that is built again and again costs little: it is
 * judged if all builds before it were hollow, or if its number is a power of eight. Its input is
 * compared with that of the next one if its number is a power of two or a multiple of 127. */
struct reading_wanted {
    bool is_judged, is_compared;
    uint32_t number; /* from 1 on; 0: unknown */
};
struct reading_wanted uses_begin_read(const struct structures *structures, uint64_t id);
/* What a build that is to be compared has read. NULL: that is not known. Returns true for some that
 * repeat the input before: then the caller calls uses_note_shared() if the structure may
 * share its memory. */
bool uses_note_input(const struct structures *structures, uint64_t id,
                     const struct input_digest *digest);
void uses_note_shared(const struct structures *structures, uint64_t id);
/* That build has these contents. */
void uses_note_contents(const struct structures *structures, uint64_t id,
                        const struct structure_contents *contents);
/* Finds the box of a bottom-level structure that one build has written, or one copy of such a
 * structure, and nothing else. Returns false if it is unknown. */
bool uses_find_box(const struct structures *structures, uint64_t id, struct figure_box *box);
/* Returns whether an advice about input data (enum advice) is the first one of a structure. */
bool uses_note_advised(const struct structures *structures, uint64_t id, unsigned advice);

#endif
