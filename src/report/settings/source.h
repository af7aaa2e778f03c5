/* SPDX-License-Identifier: Apache-2.0 */
/* The sources of settings: the environment, vk_layer_settings.txt and VK_EXT_layer_settings, in
 * this order of precedence. They are read as the Vulkan utility library reads them for other
 * layers. In a process with elevated privileges only VK_EXT_layer_settings counts. */
#ifndef ASSAY_REPORT_SETTINGS_SOURCE_H
#define ASSAY_REPORT_SETTINGS_SOURCE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <vulkan/vulkan_core.h>

#include "src/base/text_buffer.h"
#include "src/report/settings/reported_lines.h"

#define SETTINGS_LAYER "VK_LAYER_ASSAY_validation"

struct settings_source {
    /* The application's VkLayerSettingEXT of this layer, except unreadable ones; owned. */
    VkLayerSettingEXT *given;
    uint32_t given_count;
};

VkResult settings_source_open(struct settings_source *source,
                              const VkInstanceCreateInfo *create_info);
void settings_source_close(struct settings_source *source);

/* Sets `list` to the comma-separated values of a key; NULL if the key is not set. The caller frees
 * it. */
VkResult settings_source_list(const struct settings_source *source, const char *key, char **list);

/* Sets `text` to the value of a key whose value is one text, with its commas and colons. */
VkResult settings_source_text(const struct settings_source *source, const char *key, char **text);

/* Appends where the value of a key came from, such as: environment variable
 * VK_ASSAY_VALIDATION_LEVEL. The key must be set. */
void settings_append_origin(struct text_buffer *text, const char *key);

/* Adds one line to `warnings` for each thing that the user has written without effect: settings
 * that are not among `keys`, lines without an equals sign, a settings file that is not read. `keys`
 * ends with NULL. */
void settings_source_ignored(const struct settings_source *source, const char *const *keys,
                             struct kept_lines *warnings);

/* ---- the settings file, vk_layer_settings.txt, which all layers share */

enum { SETTINGS_PATH_SIZE = 4096 };

/* What became of the environment variable VK_LAYER_SETTINGS_PATH. */
enum settings_path {
    SETTINGS_PATH_USED, /* or not set */
    SETTINGS_PATH_MISSING,
    SETTINGS_PATH_WITHOUT_FILE, /* a folder without the file */
    SETTINGS_PATH_SECOND,       /* the user's file in XDG_DATA_HOME or HOME comes first */
};

/* Writes the path of the file that is read, whether or not it exists. */
enum settings_path settings_file_find(char path[SETTINGS_PATH_SIZE]);

/* One line, which is cut off at a comment, and trimmed. */
struct settings_line {
    char *name;  /* the trimmed text before the equals sign; the whole line if it has none */
    char *value; /* the trimmed text after it; NULL if the line has none */
};

/* Reads the next line that is not empty. The text is in `*buffer`, which begins as NULL and which
 * the caller frees. Returns false at the end. */
bool settings_file_next(FILE *file, char **buffer, size_t *size, struct settings_line *line);

/* ---- values of settings, as text: comma-separated lists with blanks around the entries */

/* Cuts the next entry off a list, and trims it. Returns NULL at the end. */
char *value_next_entry(char **list);

/* Reads exactly one number. If the list is something else, returns false and does not change
 * `value`. Changes the text of the list. */
bool value_read_number(char *list, uint32_t *value);

#endif
