#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# vectorised.sh: every loop that says `omp simd` is one the compiler did vectorise. A store it cannot prove apart, or a call
# in the loop, makes a pass several times slower without any other sign. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
flags=()
# The words are quoted for a shell. For the instruction set that most machines have had for a decade, so that the answer does not depend
# on this one.
for of in flags solver-flags; do
    eval "flags+=($(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" CC=gcc SANITIZE= "$of"))"
done
flags+=(-march=x86-64-v3 -g0) # with -g it names other lines
remarks=$(mktemp) told=$(mktemp -d)
trap 'rm -rf "$remarks" "$told"' EXIT
failed=0

verdict() {
    if [ "$1" = 0 ]; then
        echo "ok - $2 is vectorised"
    else
        echo "not ok - $2 is vectorised"
        failed=1
    fi
}

# A loop whose body begins in its own file: gcc names the pragma, the loop after it, or its body.
named_here() {
    grep -qxE "(\./)?$1:($(seq -s'|' "$2" $(($2 + 4))))" "$remarks"
}

# Loops over a row whose bodies are inlined are named after a line of block_pair(), where they begin: one for each dimension, or more.
rows_of() {
    grep -c 'const Pair pair = block_pair(' "$1" || true
}

# lines FILE FUNCTION: the lines of an inline function, as a pattern.
lines() {
    local first last
    first=$(grep -nE "INLINE [A-Za-z]+ $2\(" "$1" | cut -d: -f1)
    last=$(awk -v first="$first" 'NR > first && /^}/ { print NR; exit }' "$1")
    seq -s'|' "$first" "$last"
}

in_block_pair=$(lines server/sim/row.h block_pair)
# Fused loops begin in one of these, in so many instances that it is easier to see whether one of them was given up.
fused="fused\.h:($(lines server/sim/fused.h with_rest)|$(lines server/sim/fused.h fetched_pair)"
fused="$fused|$(lines server/sim/fused.h approach)|$(lines server/sim/fused.h near_pair))"
fused="($fused|pairs\.h:($(lines server/sim/pairs.h nearest)))"

# given_up REMARKS: how many fused loops were.
given_up() {
    grep -cE "$fused:.*couldn't vectorize loop" "$1" || true
}

mapfile -t files < <(grep -rlE '^[[:space:]]*#pragma omp.*simd' server/sim --include='*.c' | sort)
# What gcc says of each file, as many at a time as there are processors.
# shellcheck disable=SC2016 # the inner shell expands
printf '%s\0' "${files[@]}" | xargs -0 -P "$(nproc)" -I{} bash -c '
    told=$1 file=$2
    shift 2
    gcc "$@" -fopt-info-vec-optimized-missed -c -o /dev/null "$file" 2>&1 |
        grep -E "loop vectorized|couldn.t vectorize loop" >"$told/${file//\//_}" || true' \
    bash "$told" {} "${flags[@]}"
for file in "${files[@]}"; do
    all=$told/${file//\//_}
    grep -E 'loop vectorized' "$all" | sed -E 's|^([^:]*:[0-9]+):.*|\1|' >"$remarks" || true
    while IFS=: read -r line _; do
        body=$(sed -n "$((line + 2))p" "$file")
        [[ $body == *"const Pair pair = "* ]] || verdict "$(named_here "$file" "$line" && echo 0 || echo 1)" "$file:$line"
    done < <(grep -nE '^[[:space:]]*#pragma omp.*simd' "$file")
    rows=$(rows_of "$file")
    if [ "$rows" -gt 0 ]; then
        found=$(grep -cE "row\.h:($in_block_pair)$" "$remarks" || true)
        verdict "$((found < 2 * rows))" "each of $rows loops over rows in $file"
    fi
    if grep -qE '(FUSED|BESIDE)_TABLE' "$file"; then
        found=$(grep -cE "$fused$" "$remarks" || true)
        verdict "$(($(given_up "$all") > 0 || found == 0))" "what is fused in $file"
    fi
done
exit $failed
