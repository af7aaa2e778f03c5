/* SPDX-License-Identifier: Apache-2.0 */
#include "vuid-tables/advice.h"

const struct advice_info advice_infos[ADVICE_COUNT] = {
#define CERTAIN_mesh true
#define CERTAIN_placing true
#define CERTAIN_traced true
#define CERTAIN_tree false
#define CERTAIN_use false
#define CERTAIN_crowd false
#define ADVICE(subject, name, kind, id, hint)                                                      \
    [ADVICE_##name] = {id, hint, ADVICE_IS_##kind, CERTAIN_##subject},
#include "vuid-tables/advice.def"
};

const struct advice_limit_info advice_limit_infos[ADVICE_LIMITS] = {
#define ADVICE_LIMIT(name, by_default) [ADVICE_LIMIT_##name] = {#name, by_default},
#include "vuid-tables/advice.def"
};
