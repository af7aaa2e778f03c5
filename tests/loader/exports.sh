#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# exports.sh LIBRARY: the layer exports one function and depends on the C library alone.
set -eu
library=$1
failed=0

exported=$(nm -D --defined-only "$library" | awk '$2 != "A" { print $3 }' | sed 's/@.*//')
if [ "$exported" != vkNegotiateLoaderLayerInterfaceVersion ]; then
    echo "exported: $exported"
    failed=1
fi
for name in $(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p'); do
    case $name in
    libc.so.* | libm.so.* | ld-linux*.so.*) ;;
    *)
        echo "needed: $name"
        failed=1
        ;;
    esac
done
# A library with these could not be unloaded, or would run code when it is.
if nm -D "$library" | grep -E ' (__cxa_thread_atexit_impl|atexit)(@|$)'; then
    failed=1
fi
exit $failed
