#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Where the Makefile builds, and what `make clean` would remove: never the sources, and nothing above them; and levels of tests that it does not have.
# Prints TAP.
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

old_level() { # as the short check would pass for the long one
    ! make -n check "$@" >"$stage/said" 2>"$stage/told" && [ ! -s "$stage/said" ] && grep -q "make check CI=1.*make nightly" "$stage/told"
}
expect "ALL=1 is refused" old_level ALL=1
# shellcheck disable=SC2016 # the inner shell expands
expect "check.sh refuses a level that there is not" bash -c 'tests/support/check.sh all 2>"$1/told"; [ $? -eq 64 ] && grep -q usage "$1/told"' sh "$stage"
expect "ALL in the environment is someone else's" env ALL=1 make -n BUILD="$stage/b" clean
exit "$failed"
