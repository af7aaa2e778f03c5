# SPDX-License-Identifier: Apache-2.0
# How slow the machine is now. Needs common.sh.
# shellcheck shell=bash

# machine_tenths: prints the time of a fixed loop, run on every core at once, in tenths of the time
# that the idle reference machine takes. At least 10; at most 80, so that a test that hangs ends. The
# reference machine: two cores of a Xeon server of 2023 with bash 5.2.
machine_tenths() {
    local reference=1000000 begin end core tenths # microseconds
    begin=${EPOCHREALTIME//[!0-9]/}
    for ((core = 0; core < $(nproc); core++)); do
        (for ((i = 0; i < 800000; i++)); do :; done) &
    done
    wait
    end=${EPOCHREALTIME//[!0-9]/}
    tenths=$(((end - begin) * 10 / reference))
    printf '%d\n' $((tenths < 10 ? 10 : tenths > 80 ? 80 : tenths))
}
