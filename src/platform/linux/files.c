/* SPDX-License-Identifier: Apache-2.0 */
/* Files. */
#include "src/platform/files.h"

#include <errno.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum file_kind file_find_kind(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return FILE_NONE;
    return S_ISREG(status.st_mode)   ? FILE_REGULAR
           : S_ISDIR(status.st_mode) ? FILE_FOLDER
                                     : FILE_OTHER;
}

bool file_find_users_settings(char *path, size_t size)
{
    const char *data = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
    bool has_data = data && data[0];
    if (!has_data && !(home && home[0]))
        return false;
    int length = snprintf(path, size, "%s%s/vulkan/settings.d/vk_layer_settings.txt",
                          has_data ? data : home, has_data ? "" : "/.local/share");
    return length > 0 && (size_t)length < size && file_find_kind(path) == FILE_REGULAR;
}

FILE *file_open_to_read(const char *path)
{
    return fopen(path, "re");
}

FILE *file_open_to_append(const char *path)
{
    return fopen(path, "ae");
}

FILE *file_open_new(const char *path)
{
    return fopen(path, "axe");
}

int file_make_folder(const char *path)
{
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && file_find_kind(path) == FILE_FOLDER))
        return 0;
    return errno;
}

int file_rename(const char *path, const char *name)
{
    return rename(path, name) == 0 ? 0 : errno;
}

void file_remove(const char *path)
{
    unlink(path);
}

bool file_read_line(FILE *file, char **buffer, size_t *size)
{
    return getline(buffer, size, file) >= 0;
}

int file_descriptor(FILE *file)
{
    return fileno(file);
}

void file_lock(FILE *file)
{
    flockfile(file);
}

void file_unlock(FILE *file)
{
    funlockfile(file);
}

int file_write(int descriptor, const char *first, size_t first_size, const char *second,
               size_t second_size, size_t *done)
{
    const struct iovec parts[] = {{(char *)(uintptr_t)first, first_size},
                                  {(char *)(uintptr_t)second, second_size}};
    ssize_t written;
    do
        written = writev(descriptor, parts, 2);
    while (written < 0 && errno == EINTR);
    *done = written > 0 ? (size_t)written : 0;
    return written > 0 ? 0 : written < 0 ? errno : EIO;
}

void file_block_signals(struct write_signals *blocked)
{
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGXFSZ);
    sigaddset(&signals, SIGPIPE);
    sigpending(&blocked->pending);
    pthread_sigmask(SIG_BLOCK, &signals, &blocked->before);
}

void file_unblock_signals(const struct write_signals *blocked, int error)
{
    int raised = error == EFBIG ? SIGXFSZ : error == EPIPE ? SIGPIPE : 0;
    if (raised && !sigismember(&blocked->pending, raised)) {
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, raised);
        sigtimedwait(&signals, NULL, &(struct timespec){0});
    }
    pthread_sigmask(SIG_SETMASK, &blocked->before, NULL);
}
