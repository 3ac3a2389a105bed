#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check.sh: run everything there is to check, after the build. Prints a line for each group, all output of what failed, and
# at the end one line: N passed, N failed. Single tests are counted where a program tells of them (TAP, unittest).
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
PYTHON=/usr/bin/python3
jobs=$(nproc) passed=0 failed=0 failures=()
log=$(mktemp)
trap 'rm -f "$log"' EXIT
export BUILD CC CMOCKA_MESSAGE_OUTPUT=TAP PYTHONDONTWRITEBYTECODE=1
# Tests run a daemon and its clients at once: threads that spin while they wait would take the processors from each other.
export OMP_WAIT_POLICY=passive
unset MAKEFLAGS MFLAGS MAKELEVEL

# Lines of TAP, or the summary of Python's unittest: "passed failed". What was skipped has shown nothing: it has failed.
count() {
    awk '
    /^ok[ \t]/   { if (/# *SKIP/) f++; else p++ }
    /^not ok[ \t]/ { f++ }
    /^Ran [0-9]+ tests? in / { n = $2; python = 1 }
    python && /^(OK|FAILED)/ {
        bad = 0
        line = $0
        gsub(/[(),]/, " ", line)
        k = split(line, words, " ")
        for (i = 2; i <= k; i++) {
            split(words[i], pair, "=")
            if (pair[1] == "failures" || pair[1] == "errors" || pair[1] == "successes" ||
                pair[1] == "skipped") bad += pair[2]
        }
        p += n - bad; f += bad
    }
    END { print p + 0, f + 0 }' "$log"
}

# note NAME STATUS SECONDS: count what a command left in the log. A program that hangs has failed; so has one that ends badly without
# naming a test.
note() {
    local name=$1 status=$2 p f
    read -r p f < <(count)
    if [ "$status" -ne 0 ] && [ "$f" -eq 0 ]; then f=1; fi
    if [ "$status" -eq 0 ] && [ $((p + f)) -eq 0 ]; then p=1; fi
    passed=$((passed + p)) failed=$((failed + f))
    [ "$f" -eq 0 ] && return
    echo "---- $name: $f failed, exit status $status$([ "$status" -ne 124 ] || echo ": still running after $3 s")"
    cat "$log"
    echo "----"
    failures+=("$name")
}

# run NAME SECONDS COMMAND...
run() {
    local name=$1 limit=$2 status=0
    shift 2
    timeout --kill-after=10 "$limit" "$@" >"$log" 2>&1 </dev/null || status=$?
    note "$name" "$status" "$limit"
}

group() {
    local title=$1 started=$SECONDS before="$passed $failed"
    shift
    printf '== %s\n' "$title"
    "$@"
    read -r p f <<<"$before"
    printf '   %d passed, %d failed, %d s\n' $((passed - p)) $((failed - f)) $((SECONDS - started))
}

# As many at a time as there are processors, as they wait for nothing but processors; told in their order.
programs() {
    local limit=120 file k=0 files=() logs
    for file in "$BUILD"/tests/unit/* "$BUILD"/tests/protocol/*; do
        if [ -f "$file" ] && [ -x "$file" ]; then files+=("$file"); fi
    done
    logs=$(mktemp -d)
    # shellcheck disable=SC2016 # the inner shell expands
    for file in "${files[@]}"; do printf '%s\0%s\0' "$file" "$logs/$((k++))"; done |
        xargs -0 -P "$jobs" -n 2 sh -c \
            'timeout --kill-after=10 '$limit' "$1" >"$2" 2>&1 </dev/null; echo $? >"$2.status"' sh
    for k in "${!files[@]}"; do
        mv "$logs/$k" "$log"
        note "${files[k]}" "$(cat "$logs/$k.status")" "$limit"
    done
    rm -rf "$logs"
}

scripts() {
    local file
    for file in tests/*/test_*.py client/python/tests/test_*.py; do
        if [ -f "$file" ]; then run "$file" 240 $PYTHON -W ignore::ResourceWarning "$file"; fi
    done
    for file in tests/*/test_*.sh; do
        if [ -f "$file" ]; then run "$file" 240 "$file"; fi
    done
}

house() {
    run "layers" 60 tests/support/layers.sh
    run "headers" 120 tests/support/headers.sh
    run "vector loops" 150 tests/support/vectorised.sh
    run "lint" 400 tests/support/lint.sh
    run "server/cases/REFERENCE.md is what \`make reference\` writes" 10 \
        diff -u server/cases/REFERENCE.md "$BUILD/case-reference.md"
}

other_compiler() {
    run "build with clang" 300 make -s -j"$jobs" BUILD="$BUILD/clang" CC=clang all tests
}

sanitizers() {
    run "build with address sanitizer" 300 make -s -j"$jobs" BUILD="$BUILD/asan" SANITIZE=address,undefined all tests
    run "address and undefined-behaviour sanitizers" 300 env BUILD="$BUILD/asan" tests/support/sanitize.sh address
    run "build with thread sanitizer" 300 make -s -j"$jobs" BUILD="$BUILD/tsan" CC=clang SANITIZE=thread raced
    run "thread sanitizer" 300 env BUILD="$BUILD/tsan" tests/support/sanitize.sh thread
}

fuzzing() {
    run "build with libFuzzer" 300 make -s -j"$jobs" BUILD="$BUILD/fuzz" CC=clang SANITIZE=address,undefined,fuzzer-no-link fuzz-programs
    run "fuzz targets" 60 env BUILD="$BUILD/fuzz" tests/support/fuzz.sh 8
}

group "unit and protocol tests" programs
group "system tests" scripts
group "the house: layers, headers, style, manual" house
group "clang" other_compiler
group "sanitizers" sanitizers
group "fuzzing" fuzzing

[ ${#failures[@]} -eq 0 ] || printf 'failed: %s\n' "${failures[@]}"
printf '%d seconds\n' $SECONDS
printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]
