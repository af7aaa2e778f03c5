# SPDX-License-Identifier: Apache-2.0
# Shared by the scripts: the root of the repository, functions for output, and ctest's counts.
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

# lavapipe_manifest: prints the path of the manifest of Mesa's CPU driver, whose name includes the
# architecture in some releases.
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

# report_counts FILE: how many tests of ctest's report ran or not, have failed, and were left out.
report_counts() {
    python3 -B - "$1" <<'END'
import sys
import xml.etree.ElementTree

suite = xml.etree.ElementTree.parse(sys.argv[1]).getroot()
tests, failures, skipped, disabled = (
    int(suite.get(name, 0)) for name in ("tests", "failures", "skipped", "disabled"))
print(tests, failures, skipped + disabled)
END
}
