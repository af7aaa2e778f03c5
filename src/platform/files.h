/* SPDX-License-Identifier: Apache-2.0 */
/* Files. Paths are UTF-8; on Windows, a path that is not UTF-8 is one of the system's code page.
 * Children of the process do not inherit what is opened here. */
#ifndef ASSAY_PLATFORM_FILES_H
#define ASSAY_PLATFORM_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#ifndef _WIN32
#include <signal.h>
#endif

enum { FILES_STDERR = 2 }; /* descriptor */

enum file_kind { FILE_NONE, FILE_REGULAR, FILE_FOLDER, FILE_OTHER };
enum file_kind file_find_kind(const char *path);

/* Writes the path of the user's settings file for Vulkan's layers, which comes before all others:
 * on Linux vk_layer_settings.txt under XDG_DATA_HOME or HOME; on Windows what the registry names
 * under Software\\Khronos\\Vulkan\\Settings. Returns false if there is none. */
bool file_find_users_settings(char *path, size_t size);

/* Separates the entries of a list of paths. */
#ifdef _WIN32
enum { FILES_LIST_SEPARATOR = ';' };
#else
enum { FILES_LIST_SEPARATOR = ':' };
#endif

/* Return NULL, and set errno, if the file cannot be opened. */
FILE *file_open_to_read(const char *path);
FILE *file_open_to_append(const char *path);
/* Makes a new file; fails with EEXIST if there is one. */
FILE *file_open_new(const char *path);

/* Makes a folder, in one that exists. Returns 0, also if there is that folder, or an error number.
 */
int file_make_folder(const char *path);
/* Renames a file, to a name that no file has. Returns 0 or an error number. */
int file_rename(const char *path, const char *name);
void file_remove(const char *path);

/* Reads a line with its newline into `*buffer`, which begins as NULL and which the caller frees.
 * `*size` is its size. Returns false at the end. */
bool file_read_line(FILE *file, char **buffer, size_t *size);

int file_descriptor(FILE *file);
/* Keeps other threads from writing to the file in between. */
void file_lock(FILE *file);
void file_unlock(FILE *file);

/* Writes two texts by one call, past the buffer of FILE, and sets `done` to the bytes that were
 * written. Returns an error number or 0. A signal handler may call it. */
int file_write(int descriptor, const char *first, size_t first_size, const char *second,
               size_t second_size, size_t *done);

/* A limit of file sizes, or a closed pipe, must not end the application: while the layer writes,
 * the signals of these errors are blocked. Windows has no such signals. */
struct write_signals {
#ifdef _WIN32
    int unused;
#else
    sigset_t before, pending;
#endif
};
void file_block_signals(struct write_signals *blocked);
/* Takes back the signal of the error, if there is one, unless the application has had it before. */
void file_unblock_signals(const struct write_signals *blocked, int error);

#endif
