# SPDX-License-Identifier: Apache-2.0
# Bare installations of Debian, by debootstrap, to try something in. Needs common.sh, $work (a folder)
# and root.
# shellcheck shell=bash disable=SC2154

# debian_fresh RELEASE NAME: prints a folder with a bare installation.
debian_fresh() {
    local base=$work/base-$1 tree=$work/$2 rules=/usr/share/debootstrap/scripts/$1
    [ -e "$rules" ] || rules=${rules%/*}/sid # a release that is newer than this debootstrap
    if [ ! -e "$base.done" ]; then
        rm -rf "$base"
        debootstrap --variant=minbase "$1" "$base" http://deb.debian.org/debian "$rules" >"$base.log" 2>&1 ||
            die "debootstrap failed: $base.log"
        cp /etc/resolv.conf "$base/etc/resolv.conf"
        # A mirror may be weeks behind; testing's lists last one.
        echo 'Acquire::Check-Valid-Until "false";' >"$base/etc/apt/apt.conf.d/90mirror"
        touch "$base.done"
    fi
    rm -rf "$tree"
    cp -a "$base" "$tree"
    printf '%s\n' "$tree"
}

# debian_inside TREE [NAME=VALUE]...: runs a script, standard input, in the installation; what it starts
# ends with it.
debian_inside() {
    local tree=$1
    shift
    unshare --mount --pid --fork --root="$tree" --wd=/ --mount-proc \
        env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive "$@" bash -eu
}
