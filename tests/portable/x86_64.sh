#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# x86_64.sh: the one build runs on processors without AVX, and on those that have AVX2 at most: each scheme computes there what it does here with
# the instructions of that level, to the last bit. An emulator stands for them. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
if [ "$(uname -m)" != x86_64 ]; then
    echo "ok - this is no x86-64"
    exit 0
fi
. tests/support/expect.sh
export MAKEFLAGS=''
states=$BUILD/tests/portable/states

build() { make -s --no-print-directory -j"$(nproc)" states all BUILD="$BUILD"; }

# On a processor, and here with the instructions that it has. What it says of features that it does not emulate is no error.
same() {
    qemu-x86_64-static -cpu "$1" "$states" 2 >"$stage/$1" 2>"$stage/said" || {
        cat "$stage/said"
        return 1
    }
    diff "$stage/here" "$stage/$1"
}
names() { OMP_WAIT_POLICY=passive qemu-x86_64-static -cpu "$1" "$BUILD/meniscusd" --machine 2>/dev/null | grep -w "instructions $2"; }

expect "the schemes are built" build
[ "$failed" = 0 ] || exit 1
while read -r processor level year; do
    if ! "$states" 1 "$level" >"$stage/here"; then
        echo "ok - a processor of $year, $processor # SKIP this machine has not its instructions"
        continue
    fi
    expect "a processor of $year, $processor, computes what $level does here" same "$processor"
    expect "and the daemon says that it would" names "$processor" "$level,"
done <<'END'
core2duo x86-64 2006
Nehalem x86-64 2008
Haswell x86-64-v3 2013
END
exit "$failed"
