/* SPDX-License-Identifier: Apache-2.0 */
/* The settings file, vk_layer_settings.txt, which all layers share. The Vulkan utility library
 * reads its values but tells neither the file's path nor its lines. */
#ifndef ASSAY_REPORT_SETTINGS_FILE_H
#define ASSAY_REPORT_SETTINGS_FILE_H

#include <stdbool.h>
#include <stdio.h>

enum { SETTINGS_PATH_SIZE = 4096 };

/* What became of the environment variable VK_LAYER_SETTINGS_PATH. */
enum settings_path {
    SETTINGS_PATH_USED, /* or not set */
    SETTINGS_PATH_MISSING,
    SETTINGS_PATH_WITHOUT_FILE, /* a folder without the file */
    SETTINGS_PATH_SECOND,       /* the user's file in XDG_DATA_HOME or HOME comes first */
};

/* Writes the path of the file that the library reads, whether or not it exists. */
enum settings_path settings_file_find(char path[SETTINGS_PATH_SIZE]);

/* One line, which is cut off at a comment, and trimmed. */
struct settings_line {
    char *name;  /* the trimmed text before the equals sign; the whole line if it has none */
    char *value; /* the trimmed text after it; NULL if the line has none */
};

/* Reads the next line that is not empty. The text is in `*buffer`, which begins as NULL and which
 * the caller frees. Returns false at the end. */
bool settings_file_next(FILE *file, char **buffer, size_t *size, struct settings_line *line);

#endif
