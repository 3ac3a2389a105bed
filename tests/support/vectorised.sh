#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# vectorised.sh: every loop that says `omp simd` is one the compiler did vectorise. A store it cannot prove apart, or a call
# in the loop, makes a pass several times slower without any other sign. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
flags=()
# The words are quoted for a shell.
eval "flags=($(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" CC=gcc flags))"
remarks=$(mktemp)
trap 'rm -f "$remarks"' EXIT

# For the instruction set that most machines have had for a decade, so that the answer does not depend on this one.
find server/sim -name '*.c' | sort | while read -r file; do
    gcc "${flags[@]}" -std=c17 -O3 -march=x86-64-v3 -fno-math-errno -fno-trapping-math -ffp-contract=off \
        -fopenmp -fopt-info-vec-optimized -c -o /dev/null "$file" 2>&1
done | grep -E 'loop vectorized' | sed -E 's|^([^:]*:[0-9]+):.*|\1|' | sort -u >"$remarks"

failed=0
while IFS=: read -r file line _; do
    # gcc names the pragma, the loop after it, or its body.
    if grep -qxE "(\./)?$file:($(seq -s'|' "$line" $((line + 4))))" "$remarks"; then
        echo "ok - $file:$line is vectorised"
    else
        echo "not ok - $file:$line is vectorised"
        failed=1
    fi
done < <(grep -rnE '^[[:space:]]*#pragma omp.*simd' server/sim --include='*.[ch]')
exit $failed
