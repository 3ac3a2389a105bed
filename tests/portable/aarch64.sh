#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# aarch64.sh: the solver compiles for aarch64 without a warning, and each scheme computes there what it does here, to the last bit. A cross
# compiler builds it and an emulator runs it, without the libraries of that machine: for Lua and MPFR there is numbers.c. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
if [ "$(uname -m)" = aarch64 ]; then
    echo "ok - this is an aarch64"
    exit 0
fi
. tests/support/expect.sh
export MAKEFLAGS=''
cross=aarch64-linux-gnu-gcc
there=$BUILD/aarch64

# Headers of libraries are the same on both machines; those of C are the cross compiler's.
compile() {
    make -s --no-print-directory -j"$(nproc)" states-objects BUILD="$there" CC="$cross" HYPRE= SANITIZE= \
        CPPFLAGS="-idirafter /usr/include -idirafter /usr/include/$(gcc -print-multiarch)"
}
link() {
    mapfile -t objects < <(find "$there/obj" -name '*.o')
    "$cross" -static -fopenmp -o "$there/states" "${objects[@]}" -lm
}
run_here() {
    make -s --no-print-directory -j"$(nproc)" states BUILD="$BUILD" && "$BUILD/tests/portable/states" 1 >"$stage/here"
}
run_there() { qemu-aarch64-static "$there/states" 2 >"$stage/there"; }

rm -rf "$there" # a kept build may have objects whose sources are gone
expect "the solver compiles for aarch64" compile
expect "it links, without libraries but C's and OpenMP's" link
expect "the schemes run here" run_here
expect "and on aarch64" run_there
[ "$failed" = 0 ] || exit 1
while read -r scheme dim hash; do
    expect "$scheme in $dim ends in $hash on both" grep -qx "$scheme $dim $hash" "$stage/there"
done <"$stage/here"
exit "$failed"
