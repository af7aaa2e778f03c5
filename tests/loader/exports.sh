#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# exports.sh LIBRARY: the layer exports one function and depends on the C library alone.
set -eu
library=$1

exported=$(nm -D --defined-only "$library" | awk '$2 != "A" { print $3 }' | sed 's/@.*//' | sort)
wanted=vkNegotiateLoaderLayerInterfaceVersion
needed=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort)
passed=0 failed=0

tell() { # WHAT RESULT
    if [ "$2" = 0 ]; then
        passed=$((passed + 1))
        echo "[       OK ] $1"
    else
        failed=$((failed + 1))
        echo "[  FAILED  ] $1"
    fi
}

if [ "$exported" = "$wanted" ]; then result=0; else result=1; echo "exported: $exported"; fi
tell exports_one_function $result

result=0
for name in $needed; do
    case $name in
    libc.so.* | libm.so.* | ld-linux*.so.*) ;;
    *)
        echo "needed: $name"
        result=1
        ;;
    esac
done
tell needs_only_the_c_library $result

# A library with these could not be unloaded, or would run code when it is.
if nm -D "$library" | grep -E ' (__cxa_thread_atexit_impl|atexit)(@|$)'; then result=1; else result=0; fi
tell leaves_nothing_behind $result

echo "$passed passed, $failed failed"
[ $failed = 0 ]
