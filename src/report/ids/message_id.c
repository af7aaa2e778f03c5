/* SPDX-License-Identifier: Apache-2.0 */
/* Hashes ids. */
#include "src/report/ids/message_id.h"

#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

int32_t message_id_number(const char *id)
{
    return (int32_t)XXH32(id, strlen(id), 8);
}
