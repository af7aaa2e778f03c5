/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of advice.def as data. */
#ifndef ASSAY_VUID_TABLES_ADVICE_H
#define ASSAY_VUID_TABLES_ADVICE_H

#include <stdbool.h>
#include <stdint.h>

enum advice {
#define ADVICE(subject, name, kind, id, hint) ADVICE_##name,
#include "vuid-tables/advice.def"
    ADVICE_COUNT,
};

enum advice_limit {
#define ADVICE_LIMIT(name, by_default) ADVICE_LIMIT_##name,
#include "vuid-tables/advice.def"
    ADVICE_LIMITS,
};

/* Setting advice_limits. */
struct advice_limits {
    uint32_t of[ADVICE_LIMITS]; /* by enum advice_limit */
};

enum advice_kind {
    ADVICE_IS_WASTE,    /* costs time or memory: a performance warning */
    ADVICE_IS_NONSENSE, /* hardly meant: a warning */
};

struct advice_info {
    const char *id;
    const char *hint; /* what to do: the last sentence of the message */
    enum advice_kind kind;
    bool is_certain; /* as soon as the input of one build was read */
};

extern const struct advice_info advice_infos[ADVICE_COUNT];

extern const struct advice_limit_info {
    const char *name;
    uint32_t by_default;
} advice_limit_infos[ADVICE_LIMITS];

#endif
