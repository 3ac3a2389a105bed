#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# sanitize.sh address|thread: run the unit and protocol tests of a sanitizer's build, $BUILD, as many at a time as there are
# processors. Each program is one test, as a sanitizer ends a program at its first find. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
export BUILD=${BUILD:-build}
export LIMIT=${LIMIT:-1200} # seconds for a program
case ${1:-} in
address)
    export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=1:strict_string_checks=1
    cat tests/support/leaks.supp tests/support/leaks_garbage.supp >"$BUILD/leaks_garbage.supp"
    export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
    ;;
thread)
    # The OpenMP runtime is not instrumented: Archer tells the sanitizer about its barriers.
    export OMP_TOOL_LIBRARIES=/usr/lib/llvm-14/lib/libarcher.so
    export TSAN_OPTIONS=ignore_noninstrumented_modules=1:halt_on_error=1:die_after_fork=0
    ;;
*)
    echo "usage: sanitize.sh address|thread" >&2
    exit 64
    ;;
esac
export OMP_WAIT_POLICY=passive OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} MENISCUS_SANITIZED=$1 CMOCKA_MESSAGE_OUTPUT=STDOUT

# Those of the protocol wait for daemons, and come first.
programs() {
    local program name
    for program in "$BUILD"/tests/protocol/* "$BUILD"/tests/unit/*; do
        if [ ! -f "$program" ] || [ ! -x "$program" ]; then continue; fi
        name=${program#"$BUILD"/tests/}
        # Flows that run long, of what the others run shortly.
        if [[ $name =~ ^unit/test_(flow|wall_seam|probe_surface)$ ]]; then continue; fi
        echo "$name"
    done
}

# What one program says is printed at once, so that programs side by side do not mix.
run_one() {
    local name=$1 status=0 output run=() suppressions=tests/support/leaks.supp
    # Addresses are not randomised, as the thread sanitizer of this version does not find its shadow memory on kernels that use many
    # random bits.
    [ "$MENISCUS_SANITIZED" != thread ] || run=(setarch "$(uname -m)" -R)
    [[ ! $name =~ ^protocol/test_(daemon_(garbage|fuzz)|stream_(client|trouble))$ ]] || suppressions=$BUILD/leaks_garbage.supp
    output=$(LSAN_OPTIONS=suppressions=$suppressions:print_suppressions=0 \
        timeout --kill-after=10 "$LIMIT" "${run[@]}" "$BUILD/tests/$name" 2>&1) || status=$?
    if [ $status -eq 0 ]; then
        echo "ok - $name under the $MENISCUS_SANITIZED sanitizer"
        return
    fi
    [ $status -ne 124 ] || output="still running after $LIMIT seconds"$'\n'$output
    echo "not ok - $name under the $MENISCUS_SANITIZED sanitizer"$'\n'"# ${output//$'\n'/$'\n'# }"
    return 1
}
export -f run_one

# shellcheck disable=SC2016 # the inner shell expands
programs | xargs -P "$(nproc)" -n 1 bash -c 'run_one "$1"' run_one
