#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# aarch64.sh: the solver compiles for aarch64 without a warning, and each scheme computes there what it does here, to the last bit. A cross
# compiler builds it and an emulator runs it, without the libraries of that machine: for Lua and MPFR there is numbers.c. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
cross=aarch64-linux-gnu-gcc
there=$BUILD/aarch64
failed=0

verdict() { # verdict STATUS FACT
    if [ "$1" = 0 ]; then
        echo "ok - $2"
    else
        echo "not ok - $2"
        failed=1
    fi
}

if [ "$(uname -m)" = aarch64 ]; then
    echo "ok - this is an aarch64"
    exit 0
fi

export MAKEFLAGS=''
# make_quietly TARGET VARIABLE=...
make_quietly() { make -s --no-print-directory -j"$(nproc)" "$@"; }

# Headers of libraries are the same on both machines; those of C are the cross compiler's. A kept build may have objects whose sources are gone.
rm -rf "$there"
status=0
make_quietly states-objects BUILD="$there" CC=$cross HYPRE= SANITIZE= \
    CPPFLAGS="-idirafter /usr/include -idirafter /usr/include/$(gcc -print-multiarch)" || status=$?
verdict "$status" "the solver compiles for aarch64"
[ "$status" = 0 ] || exit 1
mapfile -t objects < <(find "$there/obj" -name '*.o')
$cross -static -fopenmp -o "$there/states" "${objects[@]}" -lm 2>"$there/linker" || status=$?
verdict "$status" "and links, without libraries but C's and OpenMP's"
if [ "$status" != 0 ]; then
    sed 's/^/# /' "$there/linker"
    exit 1
fi

make_quietly states BUILD="$BUILD" || status=$?
"$BUILD/tests/portable/states" 1 >"$there/here" || status=$?
verdict "$status" "it runs here"
qemu-aarch64-static "$there/states" 2 >"$there/there" || status=$?
verdict "$status" "and on aarch64"
while read -r scheme dim hash; do
    grep -qx "$scheme $dim $hash" "$there/there" && status=0 || status=$?
    verdict "$status" "$scheme in $dim ends in $hash on both"
done <"$there/here"
exit $failed
