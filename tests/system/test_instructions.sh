#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# test_instructions.sh: how many instructions a pair of particles costs in a time step, counted by valgrind, which gives the same
# number on every machine. Times on a shared machine would say nothing. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
bench=$BUILD/tests/bench/bench_step
export MENISCUS_LEVEL=x86-64-v3 OMP_WAIT_POLICY=passive # the best that valgrind knows
failed=0

# counted NAME RESOLUTION STEPS: all instructions of a run.
counted() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$bench" "$1" 1 "$2" "$3" 2>&1 >"$log" |
        sed -n 's/.*Collected *: *\([0-9]*\).*/\1/p'
}

# within NAME RESOLUTION BOUND: what four more steps cost for each pair that is in reach. New bounds are set by hand, with a
# reason; the last: sums are cleared by more instructions that take less time than the string instructions before.
within() {
    local name=$1 resolution=$2 bound=$3 few many per_pair
    few=$(counted "$name" "$resolution" 4)
    many=$(counted "$name" "$resolution" 8)
    per_pair=$(awk -v few="$few" -v many="$many" -F'[:,]' '{
        for (k = 1; k < NF; k++) {
            if ($k ~ /"fluid_particles"/) n = $(k + 1)
            if ($k ~ /"neighbours"/) m = $(k + 1)
        }
        printf "%.1f", (many - few) / (4 * n * m)
    }' "$log")
    if awk -v a="$per_pair" -v b="$bound" 'BEGIN { exit !(a > 0 && a <= b) }'; then
        echo "ok - $name: $per_pair instructions for each pair and step, allowed: $bound"
    else
        echo "not ok - $name: $per_pair instructions for each pair and step, allowed: $bound"
        failed=1
    fi
}

log=$(mktemp)
trap 'rm -f "$log"' EXIT
if [ "$(uname -m)" != x86_64 ]; then
    echo "ok - instructions are counted on x86-64 only"
    exit 0
fi
within dambreak2d-p3 20 143
within dambreak3d-p3 8 146
within droplet2d-p3 40 149
within droplet3d-p3 12 104
within drop3d-p2 10 247
exit $failed
