#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
# test_hdf5.sh: nothing is read that has been freed, by HDF5 neither, which sanitizers do not look into. Needs the unit tests. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
export MENISCUS_LEVEL=x86-64-v3 OMP_WAIT_POLICY=passive OMP_NUM_THREADS=1 # the best that valgrind knows
log=$(mktemp)
trap 'rm -f "$log"' EXIT

if valgrind -q --error-exitcode=9 --log-file="$log" "$BUILD/tests/unit/test_series" >/dev/null 2>&1; then
    echo "ok - files are written and read under valgrind"
else
    echo "not ok - files are written and read under valgrind"
    sed 's/^/# /' "$log"
    exit 1
fi
