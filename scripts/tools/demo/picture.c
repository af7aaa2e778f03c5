/* SPDX-License-Identifier: Apache-2.0 */
/* Writes, reads and compares pictures. */
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "scene.h"

#define PATH_SIZE 4096

/* As mkdir -p. What is there already may be anything: opening the file will tell. */
static void picture_make_folder(const char *folder)
{
    char part[PATH_SIZE];
    snprintf(part, sizeof(part), "%s", folder);
    for (char *slash = strchr(part + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(part, 0777);
        *slash = '/';
    }
    mkdir(part, 0777);
}

static void picture_path(const char *folder, const char *name, char path[PATH_SIZE])
{
    if (snprintf(path, PATH_SIZE, "%s/%s", folder, name) >= PATH_SIZE)
        tool_fail("the path of the folder for the picture is too long");
}

void picture_write(const char *folder, const char *name, uint32_t width, uint32_t height,
                   const uint32_t *pixels)
{
    char path[PATH_SIZE];
    picture_path(folder, name, path);
    picture_make_folder(folder);
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = width, .height = height, .format = PNG_FORMAT_RGBA};
    if (!png_image_write_to_file(&image, path, 0, pixels, 0, NULL))
        tool_fail("picture %s: %s", path, image.message);
}

bool picture_read(const char *folder, const char *name, uint32_t width, uint32_t height,
                  uint32_t *pixels)
{
    char path[PATH_SIZE];
    picture_path(folder, name, path);
    png_image image = {.version = PNG_IMAGE_VERSION};
    if (!png_image_begin_read_from_file(&image, path))
        return false;
    image.format = PNG_FORMAT_RGBA;
    const bool is_read = image.width == width && image.height == height &&
                         png_image_finish_read(&image, NULL, pixels, 0, NULL);
    png_image_free(&image);
    return is_read;
}

/* ---- comparison */

#define GAIN 8

static uint32_t channel(uint32_t pixel, int i)
{
    return pixel >> 8 * i & 0xff;
}

struct comparison compare_pictures(const uint32_t *a, const uint32_t *b, uint32_t *difference,
                                   uint32_t pixel_count)
{
    struct comparison comparison = {0};
    for (uint32_t i = 0; i < pixel_count; ++i) {
        uint32_t largest = 0;
        for (int c = 0; c < 3; ++c) {
            uint32_t apart = (uint32_t)abs((int)channel(a[i], c) - (int)channel(b[i], c));
            largest = apart > largest ? apart : largest;
        }
        comparison.differing += largest > 0;
        comparison.visible += largest > COMPARE_VISIBLE;
        comparison.largest = largest > comparison.largest ? largest : comparison.largest;
        uint32_t grey = largest * GAIN < 255 ? largest * GAIN : 255;
        difference[i] = 0xff000000u | grey << 16 | grey << 8 | grey;
    }
    return comparison;
}
