#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Where the Makefile builds, and what `make clean` would remove: never the sources, and nothing above them. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
unset MAKEFLAGS MFLAGS MAKELEVEL BUILD
. tests/support/expect.sh

refused() { # refused BUILD: nothing would be done, and the sentence says what to do
    ! make -n BUILD="$1" clean >"$stage/said" 2>"$stage/told" && [ ! -s "$stage/said" ] && grep -q "BUILD is .*name a folder" "$stage/told"
}
removes() { # removes BUILD: that alone
    [ "$(make -n BUILD="$1" clean)" = "rm -rf $1" ]
}

for where in "" "   " . ./ / // .. ../.. "$PWD" "a b" "build "; do
    expect "BUILD='$where' is refused" refused "$where"
done
for where in build ../elsewhere "$stage/b" tests/../build; do
    expect "BUILD=$where is a folder of its own" removes "$where"
done
exit "$failed"
