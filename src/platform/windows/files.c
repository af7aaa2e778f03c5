/* SPDX-License-Identifier: Apache-2.0 */
/* Files. */
#include "src/platform/files.h"

#include <direct.h>
#include <errno.h>
#include <io.h>
#include <stdlib.h>

#include "src/platform/windows/text.h"

enum { LINE_START = 128 };

enum file_kind file_find_kind(const char *path)
{
    wchar_t wide[WIDE_PATH_SIZE];
    DWORD attributes = text_to_wide(path, wide, WIDE_PATH_SIZE) ? GetFileAttributesW(wide)
                                                                : INVALID_FILE_ATTRIBUTES;
    if (attributes == INVALID_FILE_ATTRIBUTES)
        return FILE_NONE;
    return attributes & FILE_ATTRIBUTE_DIRECTORY ? FILE_FOLDER
           : attributes & FILE_ATTRIBUTE_DEVICE  ? FILE_OTHER
                                                 : FILE_REGULAR;
}

static DWORD integrity_of(HANDLE token)
{
    union {
        TOKEN_MANDATORY_LABEL label;
        char size[sizeof(TOKEN_MANDATORY_LABEL) + SECURITY_MAX_SID_SIZE];
    } found;
    DWORD size;
    if (!GetTokenInformation(token, TokenIntegrityLevel, &found, sizeof(found), &size))
        return 0;
    PSID sid = found.label.Label.Sid;
    return *GetSidSubAuthority(sid, (DWORD)*GetSidSubAuthorityCount(sid) - 1);
}

static bool has_high_integrity(void)
{
    HANDLE token;
    if (!OpenProcessToken(GetCurrentProcess(), TOKEN_QUERY, &token))
        return false;
    bool is_high = integrity_of(token) >= SECURITY_MANDATORY_HIGH_RID;
    CloseHandle(token);
    return is_high;
}

/* A value's name is a path. In a process of high integrity only the machine's key counts, as for
 * the Vulkan loader. */
static bool find_in_key(HKEY parent, char *path, size_t size)
{
    HKEY key;
    wchar_t name[WIDE_PATH_SIZE];
    bool found = false;
    if (RegOpenKeyExW(parent, L"Software\\Khronos\\Vulkan\\Settings", 0, KEY_READ, &key) != 0)
        return false;
    for (DWORD i = 0; !found; i++) {
        DWORD length = WIDE_PATH_SIZE;
        if (RegEnumValueW(key, i, name, &length, NULL, NULL, NULL, NULL) != 0)
            break;
        text_from_wide(name, path, size);
        found = file_find_kind(path) == FILE_REGULAR;
    }
    RegCloseKey(key);
    return found;
}

bool file_find_users_settings(char *path, size_t size)
{
    return find_in_key(HKEY_LOCAL_MACHINE, path, size) ||
           (!has_high_integrity() && find_in_key(HKEY_CURRENT_USER, path, size));
}

static FILE *open_file(const char *path, const wchar_t *mode)
{
    wchar_t wide[WIDE_PATH_SIZE];
    if (text_to_wide(path, wide, WIDE_PATH_SIZE))
        return _wfopen(wide, mode);
    errno = ENAMETOOLONG;
    return NULL;
}

/* N: not inherited. */
FILE *file_open_to_read(const char *path)
{
    return open_file(path, L"rbN");
}

FILE *file_open_to_append(const char *path)
{
    return open_file(path, L"abN");
}

/* "x" fails if the file exists. */
FILE *file_open_new(const char *path)
{
    return open_file(path, L"wxbN");
}

int file_make_folder(const char *path)
{
    wchar_t wide[WIDE_PATH_SIZE];
    if (!text_to_wide(path, wide, WIDE_PATH_SIZE))
        return ENAMETOOLONG;
    if (_wmkdir(wide) == 0 || (errno == EEXIST && file_find_kind(path) == FILE_FOLDER))
        return 0;
    return errno;
}

int file_rename(const char *path, const char *name)
{
    wchar_t from[WIDE_PATH_SIZE], to[WIDE_PATH_SIZE];
    if (!text_to_wide(path, from, WIDE_PATH_SIZE) || !text_to_wide(name, to, WIDE_PATH_SIZE))
        return ENAMETOOLONG;
    return _wrename(from, to) == 0 ? 0 : errno;
}

void file_remove(const char *path)
{
    wchar_t wide[WIDE_PATH_SIZE];
    if (text_to_wide(path, wide, WIDE_PATH_SIZE))
        _wunlink(wide);
}

bool file_read_line(FILE *file, char **buffer, size_t *size)
{
    size_t length = 0;
    int byte = 0;
    while (byte != '\n' && (byte = fgetc(file)) != EOF) {
        if (length + 1 >= *size) {
            size_t more = *size ? 2 * *size : LINE_START;
            char *grown = realloc(*buffer, more);
            if (!grown)
                return false;
            *buffer = grown;
            *size = more;
        }
        (*buffer)[length++] = (char)byte;
        (*buffer)[length] = '\0';
    }
    return length > 0;
}

int file_descriptor(FILE *file)
{
    return _fileno(file);
}

void file_lock(FILE *file)
{
    _lock_file(file);
}

void file_unlock(FILE *file)
{
    _unlock_file(file);
}

static int error_number(DWORD error)
{
    switch (error) {
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
        return ENOSPC;
    case ERROR_BROKEN_PIPE:
    case ERROR_NO_DATA:
        return EPIPE;
    case ERROR_INVALID_HANDLE:
        return EBADF;
    default:
        return EIO;
    }
}

/* Writes the first text alone if there is one: the caller then calls again. */
int file_write(int descriptor, const char *first, size_t first_size, const char *second,
               size_t second_size, size_t *done)
{
    const HANDLE handle = (HANDLE)_get_osfhandle(descriptor);
    OVERLAPPED at_end = {.Offset = 0xffffffff, .OffsetHigh = 0xffffffff};
    DWORD written = 0;
    BOOL has_written = WriteFile(handle, first_size ? first : second,
                                 (DWORD)(first_size ? first_size : second_size), &written,
                                 GetFileType(handle) == FILE_TYPE_DISK ? &at_end : NULL);
    *done = written;
    return has_written && written ? 0 : has_written ? EIO : error_number(GetLastError());
}

void file_block_signals(struct write_signals *blocked)
{
    blocked->unused = 0;
}

void file_unblock_signals(const struct write_signals *blocked, int error)
{
    (void)blocked;
    (void)error;
}
