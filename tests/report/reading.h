/* SPDX-License-Identifier: Apache-2.0 */
/* What the tests of settings share: reading them, and what is said of those that can't be taken. */
#ifndef REPORT_READING_H
#define REPORT_READING_H

#include "hearing.h"
#include "src/report/settings.h"

/* Since settings were read last. */
extern struct kept_lines warned;

/* Those of an instance that is created with this chain. */
VkResult settings_try(const void *chain, struct settings *settings);
/* The same; they live until the next call, or fail the test. */
struct settings settings_read(const void *chain);

/* Reads them without each allocation in turn: they say so, or warn of `warnings` lines, of which
 * one may be lost. */
void settings_read_scarce(const void *chain, unsigned warnings);

unsigned settings_muted(const struct settings *settings);
/* The settings that differ from the defaults: "level=content limit=3 flags=error+info". Flags, and
 * numbers of enumerators, are as in struct settings; "muted=2 03710 glob=..." are the filters.
 * Until the next call. */
const char *settings_text(const struct settings *settings);

/* One line was said, in which assert_parts() finds these parts. */
void assert_warned(const char *parts);

/* One value of VK_EXT_layer_settings, or a text; and the structure that has several. */
VkLayerSettingEXT setting_given(const char *key, VkLayerSettingTypeEXT type, const void *values);
VkLayerSettingEXT text_given(const char *key, const char *const *text);
VkLayerSettingsCreateInfoEXT settings_given(const VkLayerSettingEXT *settings, uint32_t count);

#endif
