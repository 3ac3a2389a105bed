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
# For the instruction set that most machines have had for a decade, so that the answer does not depend on this one.
flags+=(-std=c17 -O3 -march=x86-64-v3 -fno-math-errno -fno-trapping-math -ffp-contract=off -fopenmp)
remarks=$(mktemp) object=$(mktemp)
trap 'rm -f "$remarks" "$object"' EXIT
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

# Fused loops, whose bodies are inlined too, are all that take roots: so none may take a single one.
fused_roots() {
    objdump -d --no-show-raw-insn "$object" | awk -v root="$1" '
        /^[0-9a-f]+ <.*>:$/ { inside = $2 ~ /_(fused|beside)_/ }
        inside && $2 == root { n++ }
        END { print n + 0 }'
}

# The lines of block_pair().
first=$(grep -n 'INLINE Pair block_pair' server/sim/row.h | cut -d: -f1)
last=$(awk -v first="$first" 'NR > first && /^}/ { print NR; exit }' server/sim/row.h)
in_block_pair=$(seq -s'|' "$first" "$last")

while read -r file; do
    gcc "${flags[@]}" -fopt-info-vec-optimized -c -o "$object" "$file" 2>&1 |
        grep -E 'loop vectorized' | sed -E 's|^([^:]*:[0-9]+):.*|\1|' >"$remarks" || true
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
        verdict "$(($(fused_roots vsqrtsd) > 0 || $(fused_roots vsqrtpd) == 0))" "what is fused in $file"
    fi
done < <(grep -rlE '^[[:space:]]*#pragma omp.*simd' server/sim --include='*.c' | sort)
exit $failed
