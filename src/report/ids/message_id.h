/* SPDX-License-Identifier: Apache-2.0 */
/* The numbers of messages (VkDebugUtilsMessengerCallbackDataEXT::messageIdNumber). */
#ifndef ASSAY_REPORT_IDS_MESSAGE_ID_H
#define ASSAY_REPORT_IDS_MESSAGE_ID_H

#include <stdint.h>

/* Returns XXH32 of the id with seed 8: the same number as the Khronos layer. */
int32_t message_id_number(const char *id);

#endif
