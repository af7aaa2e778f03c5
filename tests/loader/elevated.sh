#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# elevated.sh PROBE LIBRARY: in a process with elevated privileges the layer takes no setting from
# the environment or from a file, and writes no file. A copy of the probe that belongs to root and
# has the set-user-ID bit runs as another user; a copy without the bit takes all settings.
set -eu
probe=$1 library=$2 user=65534
passed=0 failed=0

skip() { # REASON
    echo "skipped: $1"
    exit 77
}

tell() { # WHAT RESULT
    if [ "$2" = 0 ]; then
        passed=$((passed + 1))
        echo "[       OK ] $1"
    else
        failed=$((failed + 1))
        echo "[  FAILED  ] $1"
        cat "$folder/output"
    fi
}

[ "$(id -u)" = 0 ] || skip "only root can make a program that runs with elevated privileges"
command -v setpriv >/dev/null || skip "setpriv is not installed"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
chmod 755 "$folder"
cp "$library" "$folder/layer.so"
for kind in plain elevated; do
    cp "$probe" "$folder/$kind"
    chmod 755 "$folder/$kind"
done
chmod 4755 "$folder/elevated"

# run KIND [VARIABLE=VALUE...]: the probe, in folder/work, which the user may write to.
run() {
    kind=$1
    shift
    result=0
    (cd "$folder/work" &&
        exec setpriv --reuid=$user --regid=$user --clear-groups \
            env -i "$@" "$folder/$kind" "$folder/layer.so") >"$folder/output" 2>&1 || result=$?
    [ "$result" = 0 ] || cat "$folder/output"
    return "$result"
}

clear() {
    rm -rf "$folder/work"
    mkdir -m 777 "$folder/work"
}

has() { # WORD
    grep -q "$1" "$folder/output"
}

clear
run plain || skip "user $user cannot run a program in $folder"
run elevated || skip "user $user cannot run a program in $folder"
has elevated || skip "the file system of $folder ignores the set-user-ID bit"

# check NAME FOLDER [VARIABLE=VALUE...]: a settings file in FOLDER below folder/work, which the
# variable names.
check() {
    name=$1 place=$2
    shift 2
    for kind in plain elevated; do
        clear
        mkdir -p "$folder/work/$place"
        echo 'assay_validation.backend = bogus-file' >"$folder/work/$place/vk_layer_settings.txt"
        result=0
        run $kind VK_ASSAY_VALIDATION_LEVEL=bogus-variable VK_ASSAY_VALIDATION_LEVLE=state "$@" ||
            result=1
        for word in bogus-file bogus-variable LEVLE; do
            if [ "$kind" = plain ]; then has $word || result=1; else ! has $word || result=1; fi
        done
        has bogus-given || result=1
        tell "${kind}_$name" $result
    done
}
check current_folder .
check settings_path path VK_LAYER_SETTINGS_PATH=path
check home .local/share/vulkan/settings.d "HOME=$folder/work"
check data_home data/vulkan/settings.d "XDG_DATA_HOME=$folder/work/data"

for kind in plain elevated; do
    clear
    result=0
    run $kind VK_ASSAY_VALIDATION_LOG_FILENAME=assay.log || result=1
    if [ "$kind" = plain ]; then
        grep -q bogus-given "$folder/work/assay.log" || result=1
    else
        has bogus-given || result=1
        [ -z "$(ls -A "$folder/work")" ] || result=1
    fi
    tell "${kind}_log_file" $result
done

echo "$passed passed, $failed failed"
[ $failed = 0 ]
