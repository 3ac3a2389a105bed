#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# vectorised.sh: every loop that says `omp simd` is one the compiler did vectorise, for AVX2 and for AVX-512 as for each alone, and in
# the objects that are shipped, which have functions for each, as much. A store it cannot prove apart, or a call in the loop, makes a pass several
# times slower without any other sign. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
flags=()
# The words are quoted for a shell.
for of in flags solver-flags; do
    eval "flags+=($(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" CC=gcc SANITIZE= "$of"))"
done
flags+=(-g0) # with -g it names other lines
remarks=$(mktemp) told=$(mktemp -d)
trap 'rm -rf "$remarks" "$told"' EXIT
failed=0

verdict() { # verdict STATUS WHAT
    if [ "$1" = 0 ]; then
        echo "ok - $2 is vectorised${set:+ ($set)}"
    else
        echo "not ok - $2 is vectorised${set:+ ($set)}"
        failed=1
    fi
}

# A loop whose body begins in its own file: gcc names the pragma, the loop after it, or its body.
named_here() {
    grep -qxE "(\./)?$1:($(seq -s'|' "$2" $(($2 + 4))))" "$remarks"
}

# Loops over a row whose bodies are inlined are named after a line of block_pair(), where they begin: one for each dimension, or more.
rows_of() {
    grep -c 'Pair pair = block_pair(' "$1" || true
}

# lines FILE FUNCTION: the lines of an inline function, as a pattern.
lines() {
    local first last
    first=$(grep -nE "INLINE [A-Za-z]+ $2\(" "$1" | cut -d: -f1)
    last=$(awk -v first="$first" 'NR > first && /^}/ { print NR; exit }' "$1")
    seq -s'|' "$first" "$last"
}

# Their own lines, as a pattern: gcc names those whose bodies are inlined otherwise by them.
rows_at() {
    grep -n 'Pair pair = block_pair(' "$1" | awk -F: '{ printf "%s%d|%d", bar, $1 - 1, $1; bar = "|" }'
}

in_block_pair=$(lines server/sim/row.h block_pair)
# Fused loops begin in one of these, in so many instances that it is easier to see whether one of them was given up.
fused="fused\.h:($(lines server/sim/fused.h with_rest)|$(lines server/sim/fused.h fetched_pair)"
fused="$fused|$(lines server/sim/fused.h approach)|$(lines server/sim/fused.h near_pair))"
fused="($fused|pairs\.h:($(lines server/sim/pairs.h nearest)))"

# given_up REMARKS: how many fused loops were, and loops over rows.
given_up() {
    grep -cE "($fused|row\.h:($in_block_pair)):.*couldn't vectorize loop" "$1" || true
}

# wide REMARKS...: the loops that are done for AVX2 or AVX-512, with the size of the vectors.
wide() {
    sed -nE 's#^([^:]*:[0-9]+):[0-9]+: optimized: .*using (32|64) byte.*#\1 \2#p' "$@" | sort
}

# levelled REMARKS...: of these, those in headers, whose bodies are inlined into functions for each instruction set; and once each, as functions that
# there is one of are inlined more often, those at the places that are named in $told/places. What else is in a source has no functions for each.
levelled() {
    wide "$@" | awk -v places="$told/places" '
        BEGIN { while ((getline place <places) > 0) { split(place, word, " "); is[word[1]] = 1 } }
        $1 ~ /\.h:/ || ($1 in is && !seen[$0]++)'
}

mapfile -t files < <(grep -rlE '^[[:space:]]*#pragma omp.*simd' server/sim --include='*.c' | sort)
# What gcc says of each file: for one instruction set, whatever this machine has, and as it is shipped. As many at a time as there are processors.
# shellcheck disable=SC2016 # the inner shell expands
for file in "${files[@]}"; do printf '%s\0' "$file" v3 "$file" v4 "$file" shipped; done | xargs -0 -P "$(nproc)" -n 2 bash -c '
    told=$1 n=$2
    flags=("${@:3:n}") file=${*: -2:1} set=${*: -1}
    [ "$set" = shipped ] || flags+=("-march=x86-64-$set")
    all=$told/$set.${file//\//_}
    gcc "${flags[@]}" -fopt-info-vec-optimized-missed="$all.all" -c -o /dev/null "$file" 2>"$all.errors" || exit 1
    grep -E "loop vectorized|couldn.t vectorize loop" "$all.all" >"$all"' \
    bash "$told" "${#flags[@]}" "${flags[@]}" || true # what is missing is told below

# judge FILE SET: the loops of one file, for one instruction set.
judge() {
    local file=$1 set=$2 all=$told/$2.${1//\//_} line body rows found
    sed -nE 's|^([^:]*:[0-9]+):.*loop vectorized.*|\1|p' "$all" >"$remarks"
    while IFS=: read -r line _; do
        body=$(sed -n "$((line + 2))p" "$file")
        [[ $body == *"Pair pair = "* ]] || verdict "$(named_here "$file" "$line" && echo 0 || echo 1)" "$file:$line"
    done < <(grep -nE '^[[:space:]]*#pragma omp.*simd' "$file")
    if [ "$file" = server/sim/row.c ]; then # which uses all that rows are filled by
        while IFS=: read -r line _; do
            verdict "$(named_here server/sim/pairs.h "$line" && echo 0 || echo 1)" "server/sim/pairs.h:$line in $file"
        done < <(grep -nE '^[[:space:]]*#pragma omp.*simd' server/sim/pairs.h)
    fi
    rows=$(rows_of "$file")
    if [ "$rows" -gt 0 ]; then
        found=$(grep -cE "(row\.h:($in_block_pair)|(\./)?$file:($(rows_at "$file")))$" "$remarks" || true)
        verdict "$(($(given_up "$all") > 0 || found < 2 * rows))" "each of $rows loops over rows in $file"
    fi
    if grep -qE '(FUSED|BESIDE)_TABLE' "$file"; then
        found=$(grep -cE "$fused$" "$remarks" || true)
        verdict "$(($(given_up "$all") > 0 || found == 0))" "what is fused in $file"
    fi
}

# judge_shipped FILE: as many loops in its functions for AVX2 and AVX-512 as where it is compiled for one of them.
judge_shipped() {
    local file=$1 name=${1//\//_} difference='' bad=0
    wide "$told/shipped.$name" >"$told/places"
    difference=$(diff <(levelled "$told/shipped.$name") <(levelled "$told/v3.$name" "$told/v4.$name")) || bad=1
    [ -z "$difference" ] || echo "# ${difference//$'\n'/$'\n'# }"
    if [ "$(rows_of "$file")" -gt 0 ] || grep -qE '(FUSED|BESIDE)_TABLE' "$file"; then
        [ -s "$told/places" ] || bad=1
    fi
    verdict "$bad" "what is shipped of $file"
}

for file in "${files[@]}"; do
    for set in v3 v4 shipped; do
        all=$told/$set.${file//\//_}
        [ -s "$all" ] && continue
        echo "not ok - $file compiles for $set, and something in it is vectorised"
        cat "$all.errors"
        exit 1
    done
    for set in v3 v4; do judge "$file" "$set"; done
    set=
    judge_shipped "$file"
done
exit $failed
