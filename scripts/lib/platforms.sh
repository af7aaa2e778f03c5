# SPDX-License-Identifier: Apache-2.0
# The platforms of scripts/platforms: each function platform_NAME builds and tests Assay for one. It
# writes what ran into $folder.result and the output into $log. Needs common.sh, apt.sh and debian.sh.
# shellcheck shell=bash disable=SC2154

headers_suite=forky # as in scripts/setup

# result TEXT...: adds to the summary.
result() {
    printf '%s\n' "$*" >>"$folder.result"
}

# version COMMAND: prints the name and version of a compiler.
version() {
    "$1" --version | head -n 1
}

# tools_ensure PACKAGE...: installs what is missing.
tools_ensure() {
    local package missing=()
    for package in "$@"; do
        package_installed "$package" >/dev/null || missing+=("$package")
    done
    [ ${#missing[@]} != 0 ] || return 0
    require_root "${missing[@]}"
    lists_update
    say "  installing ${missing[*]}"
    packages_install "${missing[@]}"
}

# unpack ARCHITECTURE [PACKAGE]...: unpacks PACKAGEs, and the libraries that the build takes from outside,
# into $folder-root.
unpack() {
    local package packages suite
    [ ! -e "$folder-root/done" ] || return 0
    rm -rf "$folder-root"
    mkdir -p "$folder-root"
    for suite in "$VERSION_CODENAME" "$headers_suite"; do
        packages=(libvulkan-dev vulkan-utility-libraries-dev)
        [ "$suite" = "$headers_suite" ] || packages=(libvulkan1 libcmocka0 libcmocka-dev libxxhash-dev
            libjansson4 libjansson-dev libgmp10 libgmp-dev "${@:2}")
        suite_open "$suite" "$1"
        suite_download "${packages[@]/%//$suite}" # the machine may have a newer version
        for package in "$suite_folder"/debs/*.deb; do
            dpkg-deb -x "$package" "$folder-root"
        done
        suite_close
    done
    touch "$folder-root/done"
}

# toolchain_write PROCESSOR C-COMPILER [LINE]...: describes a cross compiler that takes
# libraries from $folder-root.
toolchain_write() {
    printf '%s\n' "set(CMAKE_SYSTEM_NAME Linux)" "set(CMAKE_SYSTEM_PROCESSOR $1)" \
        "set(CMAKE_C_COMPILER $2)" "${@:3}" \
        "set(CMAKE_FIND_ROOT_PATH \"$folder-root\")" \
        "set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)" "set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)" \
        "set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)" "set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)" \
        >"$folder.cmake"
}

# configure CMAKE-ARGUMENT...: pkg-config reads the folder $pkgconfig, if it is set.
configure() {
    logged ${pkgconfig:+env "PKG_CONFIG_LIBDIR=$pkgconfig"} cmake -S "$root" -B "$folder" -G Ninja \
        -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "$@"
}

# tests_run COMPILER CTEST-ARGUMENT...
tests_run() {
    local compiler=$1 bad=0 tests failures others
    shift
    logged ctest --test-dir "$folder" --parallel "$(nproc)" --timeout 3600 --output-on-failure \
        --no-tests=error --output-junit "$folder/ctest.xml" "$@" || bad=1
    read -r tests failures others <<<"$(report_counts "$folder/ctest.xml")"
    result "$(version "$compiler"): $((tests - failures - others)) tests passed, $failures failed," \
        "$others skipped"
    return $bad
}

platform_clang() {
    tools_ensure clang
    # Debian 12's Valgrind cannot read clang's DWARF 5.
    configure -DCMAKE_C_COMPILER=clang -DCMAKE_C_FLAGS=-gdwarf-4
    logged cmake --build "$folder" --target quick_tests
    tests_run clang -L '^quick$'
}

platform_i686() {
    tools_ensure gcc-i686-linux-gnu libc6-dev-i386-cross
    toolchain_write i686 i686-linux-gnu-gcc
    ! configure -DCMAKE_TOOLCHAIN_FILE="$folder.cmake" 2>/dev/null || {
        result "CMake accepts 32 bits"
        return 1
    }
    grep -q 'Assay needs a processor with 64-bit pointers' "$log"
    result "$(version i686-linux-gnu-gcc): CMake refuses 32 bits"
}

# Debian has no cmocka for musl, so the tests are those of the reference builder, which needs libc alone.
platform_musl() {
    local library=/usr/lib/x86_64-linux-gnu headers=$folder-root/usr/include
    tools_ensure musl-tools
    unpack amd64 linux-libc-dev
    # Its folder has headers of glibc, too, which must not come before those of musl.
    install -D -m 644 "$headers/x86_64-linux-gnu/gmp.h" "$folder-root/gmp/gmp.h"
    toolchain_write x86_64 musl-gcc "set(CMAKE_LIBRARY_PATH $library)" \
        "set(CMAKE_C_FLAGS_INIT \"-idirafter $headers -idirafter $headers/x86_64-linux-gnu\")" \
        "set(CMAKE_EXE_LINKER_FLAGS_INIT -Wl,--defsym=__fprintf_chk=0) # GMP calls it only to end a program" \
        "set(CMAKE_MODULE_LINKER_FLAGS_INIT -Wl,--defsym=_dl_find_object=0) # gcc's unwinder is for glibc" \
        "set(ASSAY_GMP $folder-root$library/libgmp.a CACHE FILEPATH \"\")" \
        "set(ASSAY_gmp_h_DIR $folder-root/gmp CACHE PATH \"\")" \
        "set(VulkanUtilityLibraries_DIR $folder-root$library/cmake/VulkanUtilityLibraries)"
    pkgconfig=$folder-root$library/pkgconfig
    configure -DCMAKE_TOOLCHAIN_FILE="$folder.cmake"
    logged cmake --build "$folder" --target VkLayer_assay numeric_test fuzz_builder_replay
    result "the layer linked"
    tests_run musl-gcc -R '^(numeric_|fuzz_builder_)'
}

platform_aarch64() {
    local triple=aarch64-linux-gnu test bad=0
    local library=$folder-root/usr/lib/$triple
    local emulator=(qemu-aarch64 -L "/usr/$triple" -E "LD_LIBRARY_PATH=$library")
    tools_ensure gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user
    unpack arm64
    toolchain_write aarch64 $triple-gcc \
        "set(CMAKE_CROSSCOMPILING_EMULATOR $(printf '"%s" ' "${emulator[@]}"))"
    pkgconfig=$library/pkgconfig
    PKG_CONFIG_SYSROOT_DIR=$folder-root \
        configure -DCMAKE_TOOLCHAIN_FILE="$folder.cmake"
    logged cmake --build "$folder" --target quick_tests
    # Each random program reserves much address space, and the emulator keeps tables of what was reserved: they
    # would take 20 GB.
    tests_run $triple-gcc -L '^quick$' -E '^fuzz_programs_random$' || bad=1
    for test in base/base_readable_test cpu_backend/cpu_host_objects_test "programs/programs_test cpu_null backend/mistakes" \
        "programs/programs_test null snapshots/pointers"; do # kernels for ARM may have such pages
        # shellcheck disable=SC2086 # the words of a program and its arguments
        logged "${emulator[@]}" -p 65536 "$folder/tests/"$test || bad=1
    done
    [ $bad != 0 ] || result "4 programs passed with pages of 64 KiB"
    return $bad
}

# ---- releases of Debian

# debian_run RELEASE: the commands of the README, for the last commit, in a bare installation.
debian_run() {
    local bad=0 picture=build/demo/scene-cpu.png
    [ "$(id -u)" = 0 ] || die "$1 needs root, for debootstrap and chroot."
    tools_ensure debootstrap
    [ -d "$folder" ] || debian_fresh "$1" "$1" >>"$log"
    rm -rf "$folder/root/assay"
    git clone --quiet "file://$root" "$folder/root/assay"
    debian_inside "$folder" TESTS="$tests" >>"$log" 2>&1 <<'END' || bad=1
cd /root/assay
apt-get update
apt-get install -y --no-install-recommends git ca-certificates
scripts/setup
scripts/demo
$TESTS
printf 'versions: %s, loader %s, Mesa %s\n' "$(gcc --version | head -n 1)" \
    $(dpkg-query -W -f '${Version} ' libvulkan1 mesa-vulkan-drivers)
END
    result "$(sed -n 's/^versions: //p' "$log")"
    result "demo: $(grep '^clean scene' "$log" | sort | uniq -c | sed 's/^ *\([0-9]*\) /\1 times /')"
    if [ -f "$picture" ]; then # the reference builder gives the same hits everywhere
        cmp "$picture" "$folder/root/assay/$picture" && result "picture of backend cpu as here" || bad=1
    fi
    result "$(grep -E '^[0-9]+ passed' "$log" | tail -n 1)"
    return $bad
}

platform_trixie() {
    debian_run trixie
}

platform_forky() {
    debian_run forky
}
