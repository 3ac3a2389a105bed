#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# fuzz.sh SECONDS [INPUTS]: let libFuzzer look for inputs that break a promise, crash, leak or hang, so long for each target of $BUILD/tests/fuzz,
# or until it has had its share of so many inputs, which have to be done by then; as many targets at a time as there are processors. Inputs to begin
# with are in tests/fuzz/corpus and, for cases, those that are shipped; what is found on the way is kept in $BUILD/corpus, and what breaks something
# in $BUILD/finds. Prints TAP. A target that has looked at next to nothing has failed.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build/fuzz}
seconds=${1:?how many seconds for each target}
inputs=${2:-}
# What was freed is kept from use for 16 MiB and not for 256, which is a fifth of the time of some.
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1:quarantine_size_mb=16 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
export LSAN_OPTIONS=print_suppressions=0:suppressions=$PWD/tests/support/leaks.supp OMP_WAIT_POLICY=passive BUILD seconds inputs

# Of a thousand inputs: the quick ones take most, so that all take a time of the same order. The slowest take milliseconds for each.
share_of() {
    case $1 in
    packing) echo 599 ;;
    request) echo 280 ;;
    stream) echo 50 ;;
    case) echo 45 ;;
    journal) echo 20 ;;
    checkpoint) echo 5 ;;
    replay) echo 1 ;;
    *) echo 1 ;;
    esac
}

# By rarity of what inputs do (entropic), libFuzzer chooses a little better and takes up to four times as long for each.
fuzz_one() {
    local program=$1 name log ran least=100 runs=-1
    name=${program##*/fuzz_}
    log=$BUILD/fuzz_$name.log
    local corpus=(tests/fuzz/corpus/"$name")
    if [ "$name" = case ]; then corpus=(server/cases); fi
    mkdir -p "$BUILD/corpus/$name" "$BUILD/finds"
    if [ "$inputs" ]; then runs=$((inputs * $(share_of "$name") / 1000)) least=$runs; fi
    if "$program" -entropic=0 -runs="$runs" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=32768 -print_final_stats=1 \
        -artifact_prefix="$BUILD/finds/$name-" "$BUILD/corpus/$name" "${corpus[@]}" >"$log" 2>&1; then
        ran=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
        if [ "${ran:-0}" -ge "$least" ]; then
            echo "ok - $name: $ran inputs break nothing"
        else
            echo "not ok - $name: no more than ${ran:-0} inputs in $seconds s"
            return 1
        fi
    else
        echo "not ok - $name: an input in $BUILD/finds breaks something"
        grep -aE '^(==|SUMMARY|.*(broken|runtime error):)|#[0-9] .* in ' "$log" | head -n 30 | sed 's/^/# /'
        return 1
    fi
}
export -f fuzz_one share_of

# shellcheck disable=SC2016 # the inner shell expands
printf '%s\0' "$BUILD"/tests/fuzz/fuzz_* | xargs -0 -P "$(nproc)" -n 1 bash -c 'fuzz_one "$1"' bash
