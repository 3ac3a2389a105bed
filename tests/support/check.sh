#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check.sh [everything]: run every test, after the build; with `everything` also the linters, another compiler, another processor, the sanitizers
# and the fuzz targets, which take longer than the tests. Prints a line for each group, all output of what failed, and at the end one line: N
# passed, N failed. Single tests are counted where a program tells of them (TAP, unittest).
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

# note NAME STATUS SECONDS [step]: count what a command left in the log. A program that hangs has failed; so has one that ends badly without
# naming a test, or well without having tested anything, unless it is a step, which is one test by itself.
note() {
    local name=$1 status=$2 p f
    read -r p f < <(count)
    if [ $((p + f)) -eq 0 ] && [ "$status" -eq 0 ] && [ "${4:-}" = step ]; then p=1; fi
    if [ "$f" -eq 0 ] && { [ "$status" -ne 0 ] || [ "$p" -eq 0 ]; }; then f=1; fi
    passed=$((passed + p)) failed=$((failed + f))
    [ "$f" -eq 0 ] && return
    echo "---- $name: $f failed, exit status $status$(
        [ "$status" -ne 124 ] || echo ": still running after $3 s"
        [ $((p + status)) -ne 0 ] || echo ", and no test named"
    )"
    cat "$log"
    echo "----"
    failures+=("$name")
}

# run KIND NAME SECONDS COMMAND...: of KIND tests, which names its tests, or step.
run() {
    local kind=$1 name=$2 limit=$3 status=0
    shift 3
    timeout --kill-after=10 "$limit" "$@" >"$log" 2>&1 </dev/null || status=$?
    note "$name" "$status" "$limit" "$kind"
}

group() {
    local title=$1 started=$SECONDS before="$passed $failed"
    shift
    printf '== %s\n' "$title"
    "$@"
    read -r p f <<<"$before"
    printf '   %d passed, %d failed, %d s\n' $((passed - p)) $((failed - f)) $((SECONDS - started))
}

# at_once SECONDS FILE...: as many at a time as there are processors; told in their order.
at_once() {
    local limit=$1 file k=0 logs
    shift
    logs=$(mktemp -d)
    # shellcheck disable=SC2016 # the inner shell expands
    for file; do printf '%s\0%s\0' "$file" "$logs/$((k++))"; done |
        xargs -0 -P "$jobs" -n 2 sh -c '
            case $1 in *.py) with="'"$PYTHON"' -W ignore::ResourceWarning" ;; *) with= ;; esac
            timeout --kill-after=10 '"$limit"' $with "$1" >"$2" 2>&1 </dev/null; echo $? >"$2.status"' sh
    k=0
    for file; do
        mv "$logs/$k" "$log"
        note "$file" "$(cat "$logs/$k.status")" "$limit"
        k=$((k + 1))
    done
    rm -rf "$logs"
}

programs() {
    local file files=()
    for file in "$BUILD"/tests/unit/* "$BUILD"/tests/protocol/*; do
        if [ -f "$file" ] && [ -x "$file" ]; then files+=("$file"); fi
    done
    at_once 120 "${files[@]}"
}

# They wait for daemons more than for processors.
scripts() { at_once 300 tests/*/test_*.py tests/*/test_*.sh; }

house() {
    run tests "layers" 60 tests/support/layers.sh
    run tests "headers" 120 tests/support/headers.sh
    run step "server/cases/REFERENCE.md is what \`make reference\` writes" 10 \
        diff -u server/cases/REFERENCE.md "$BUILD/case-reference.md"
}

style() {
    run tests "vector loops" 400 tests/support/vectorised.sh
    run tests "lint" 800 tests/support/lint.sh
}

portability() {
    run tests "other x86-64" 300 tests/portable/x86_64.sh
    run tests "aarch64" 300 tests/portable/aarch64.sh
}

# The thread sanitizer's build is clang's too: what clang warns of breaks it.
sanitizers() {
    run step "build with address sanitizer" 600 make -s -j"$jobs" BUILD="$BUILD/asan" SANITIZE=address,undefined all tests
    run tests "address and undefined-behaviour sanitizers" 1500 env BUILD="$BUILD/asan" tests/support/sanitize.sh address
    run step "build with clang and thread sanitizer" 600 make -s -j"$jobs" BUILD="$BUILD/tsan" CC=clang SANITIZE=thread raced
    run tests "thread sanitizer" 1500 env BUILD="$BUILD/tsan" tests/support/sanitize.sh thread
}

fuzzing() {
    run step "build with libFuzzer" 600 make -s -j"$jobs" BUILD="$BUILD/fuzz" CC=clang SANITIZE=address,undefined,fuzzer-no-link fuzz-programs
    run tests "fuzz targets" 300 env BUILD="$BUILD/fuzz" tests/support/fuzz.sh 120 1000000 # a hundredth of the promise
}

group "unit and protocol tests" programs
group "system tests" scripts
group "the house: layers, headers, manual" house
if [ "${1:-}" = everything ]; then
    group "style" style
    group "another processor" portability
    group "sanitizers" sanitizers
    group "fuzzing" fuzzing
fi

[ ${#failures[@]} -eq 0 ] || printf 'failed: %s\n' "${failures[@]}"
printf '%d seconds\n' $SECONDS
printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]
