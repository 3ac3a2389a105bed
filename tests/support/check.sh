#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# check.sh [check|ci|nightly]: run the tests, after the build. A test is of `check` unless its file says otherwise: a line "Run by: make check
# CI=1", or "Run by: make nightly", among its first. Each level has what the ones before it have. Prints a line for each group, all output of what
# failed, and at the end one line: N passed, N failed. Single tests are counted where a program tells of them (TAP, unittest). With TIMES=1 it
# prints before that what each file took, for how much of it it waited, and what for (waits.py).
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
level=${1:-check}
case $level in check | ci | nightly) ;; *)
    echo "usage: check.sh [check|ci|nightly]" >&2
    exit 64
    ;;
esac
jobs=$(nproc) passed=0 failed=0 failures=()
scratch=$(mktemp -d)
log=$scratch/log
trap 'rm -rf "$scratch"' EXIT
export BUILD CC CMOCKA_MESSAGE_OUTPUT=TAP PYTHONDONTWRITEBYTECODE=1
# Files that have more of the same for `make nightly` ask for this.
export MENISCUS_TESTS=$level
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

# within SECONDS NAME LOG COMMAND...: run it, with what it says in the log, and note how long it took.
within() {
    local limit=$1 name=$2 said=$3 status=0 watched=() TIMEFORMAT='%R %U %S'
    shift 3
    if [ -n "${TIMES:-}" ]; then watched=(tests/support/waits.py "$scratch/waits.${name//\//-}"); fi
    { time timeout --kill-after=10 "$limit" "${watched[@]}" "$@" >"$said" 2>&1 </dev/null; } 2>"$said.time" || status=$?
    echo "$(tail -n 1 "$said.time") $name" >>"$scratch/times"
    return "$status"
}

# run KIND NAME SECONDS COMMAND...: of KIND tests, which names its tests, or step.
run() {
    local kind=$1 name=$2 limit=$3 status=0
    shift 3
    within "$limit" "$name" "$log" "$@" || status=$?
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

# of_level FILE: whether it is run at this level.
of_level() {
    local by
    by=$(sed -nE '1,12s/.*Run by: make (check CI=1|nightly).*/\1/p' "$1")
    case $by in
    nightly) [ "$level" = nightly ] ;;
    'check CI=1') [ "$level" != check ] ;;
    *) true ;;
    esac
}

one() {
    local file=$1 limit=$2 said=$3 status=0 with=()
    if [[ $file == *.py ]]; then with=(/usr/bin/python3 -W ignore::ResourceWarning); fi
    within "$limit" "$file" "$said" "${with[@]}" "$file" || status=$?
    echo "$status" >"$said.status"
}
export -f one within
export scratch

# at_once SECONDS AT_A_TIME FILE...: told in their order.
at_once() {
    local limit=$1 many=$2 file k=0
    shift 2
    # shellcheck disable=SC2016 # the inner shell expands
    for file; do printf '%s\0%s\0' "$file" "$scratch/$((k++))"; done |
        xargs -0 -P "$many" -n 2 bash -c 'one "$1" '"$limit"' "$2"' bash
    k=0
    for file; do
        mv "$scratch/$k" "$log"
        note "$file" "$(cat "$scratch/$k.status")" "$limit"
        k=$((k + 1))
    done
}

# Those that took longest the last time come first, so that none goes on alone at the end; the others before them.
longest_first() {
    awk -v last="$BUILD/times" '
        BEGIN { while ((getline line < last) > 0) { split(line, word, " "); took[word[4]] = word[1] } }
        { print (($0 in took) ? took[$0] : 1e9), $0 }' | sort -srn -k1,1 | cut -d' ' -f2-
}

# More at a time than there are processors, as most wait for daemons.
programs() {
    local source files=()
    mapfile -t files < <(
        for source in tests/protocol/test_*.c tests/*/test_*.py tests/*/test_*.sh tests/unit/test_*.c; do
            if ! of_level "$source"; then continue; fi
            if [[ $source == *.c ]]; then echo "$BUILD/${source%.c}"; else echo "$source"; fi
        done | longest_first
    )
    if [ ${#files[@]} -le 100 ]; then
        echo "check: only ${#files[@]} test programs found, there are more than 100" >&2
        exit 1
    fi
    at_once "$([ "$level" = nightly ] && echo 2400 || echo 1200)" $((2 * jobs)) "${files[@]}"
    sort -rn "$scratch/times" >"$BUILD/times"
}

house() {
    run tests "layers" 60 tests/support/layers.sh
    run tests "headers" 120 tests/support/headers.sh
    run step "server/cases/REFERENCE.md is what \`make reference\` writes" 10 \
        diff -u server/cases/REFERENCE.md "$BUILD/case-reference.md"
}

style() { run tests "lint" 1500 tests/support/lint.sh; }

vectors() { run tests "vector loops" 1200 tests/support/vectorised.sh; }

portability() {
    run tests "other x86-64" 600 tests/portable/x86_64.sh
    run tests "aarch64" 600 tests/portable/aarch64.sh
}

build_with() { # build_with COMPILER SANITIZERS FOLDER TARGET...
    local compiler=$1 sanitize=$2 folder=$3
    shift 3
    run step "build with $compiler and $sanitize" 1500 make -s -j"$jobs" BUILD="$BUILD/$folder" CC="$compiler" SANITIZE="$sanitize" "$@"
}

addresses() {
    # Not by clang, whose OpenMP runtime loses what it keeps for threads, so that leaks of our own would not be seen.
    build_with "$CC" address,undefined asan all tests
    run tests "address and undefined-behaviour sanitizers" 3000 env BUILD="$BUILD/asan" tests/support/sanitize.sh address
}

threads() {
    build_with clang thread tsan raced # what clang warns of breaks it
    run tests "thread sanitizer" 3000 env BUILD="$BUILD/tsan" tests/support/sanitize.sh thread
}

# A hundredth of the inputs that are promised.
fuzzing() {
    build_with clang address,undefined,fuzzer-no-link fuzz fuzz-programs
    run tests "fuzz targets" 600 env BUILD="$BUILD/fuzz" tests/support/fuzz.sh 240 1000000
}

# What took longest first. Waits are told of those that waited for a tenth of a second or more: a sample is not taken more often.
told_times() {
    sleep 0.3 # who watches has a last look
    echo "seconds  of them waited  file: waited for"
    sort -rn "$scratch/times" | awk -v waits="$scratch/waits." '{
        name = $0
        sub(/^[^ ]+ [^ ]+ [^ ]+ /, "", name)
        file = name
        gsub("/", "-", file)
        waited = $1 - $2 - $3
        what = ""
        if (waited > 0.1 && (getline what < (waits file)) > 0 && what != "") what = ": " what
        close(waits file)
        printf "%7.1f  %14.1f  %s%s\n", $1, (waited > 0 ? waited : 0), name, what
    }'
}

group "unit, protocol and system tests" programs
group "the house: layers, headers, manual" house
if [ "$level" != check ]; then
    group "style" style
fi
if [ "$level" = nightly ]; then
    group "address sanitizer" addresses
    group "fuzzing" fuzzing
    group "thread sanitizer" threads
    group "vector loops" vectors
    group "another processor" portability
fi

[ -z "${TIMES:-}" ] || told_times
[ ${#failures[@]} -eq 0 ] || printf 'failed: %s\n' "${failures[@]}"
printf '%d seconds\n' $SECONDS
printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]
