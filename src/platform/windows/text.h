/* SPDX-License-Identifier: Apache-2.0 */
/* Text of Windows, which is UTF-16, and of the layer. */
#ifndef ASSAY_PLATFORM_WINDOWS_TEXT_H
#define ASSAY_PLATFORM_WINDOWS_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <windows.h>

enum { WIDE_PATH_SIZE = 4096 };

/* Converts UTF-8 or, if it is not UTF-8, text of the system's code page. Returns false if it does
 * not fit. */
static inline bool text_to_wide(const char *text, wchar_t *wide, size_t size)
{
    return MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, -1, wide, (int)size) > 0 ||
           (GetLastError() == ERROR_NO_UNICODE_TRANSLATION &&
            MultiByteToWideChar(CP_ACP, 0, text, -1, wide, (int)size) > 0);
}

/* Converts to UTF-8; to "" if it does not fit. */
static inline void text_from_wide(const wchar_t *wide, char *text, size_t size)
{
    if (WideCharToMultiByte(CP_UTF8, 0, wide, -1, text, (int)size, NULL, NULL) <= 0)
        text[0] = '\0';
}

#endif
