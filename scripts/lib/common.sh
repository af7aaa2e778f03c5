# SPDX-License-Identifier: Apache-2.0
# What the scripts share: where the repository is and how they speak.
# shellcheck shell=bash disable=SC2034

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
script=$(basename "$0")

say() {
    printf '%s: %s\n' "$script" "$*"
}

die() {
    printf '%s: %s\n' "$script" "$*" >&2
    exit 1
}

# usage_error MESSAGE: the caller defines usage().
usage_error() {
    printf '%s: %s\n\n' "$script" "$*" >&2
    usage >&2
    exit 2
}

# lavapipe_manifest: the file that names Mesa's Vulkan driver for the CPU to the loader; its name
# has the architecture in some releases.
lavapipe_manifest() {
    local file
    for file in /usr/share/vulkan/icd.d/lvp_icd*.json; do
        if [ -f "$file" ]; then
            printf '%s\n' "$file"
            return 0
        fi
    done
    return 1
}
