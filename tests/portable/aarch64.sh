#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# aarch64.sh: the solver compiles for aarch64 without a warning, and each scheme computes there what it does here, to the last bit. A cross
# compiler builds it and an emulator runs it, without the libraries of that machine: for formulas there is numbers.c. Prints TAP.
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

# Headers of libraries are the same on both machines; those of C are the cross compiler's.
status=0
make_quietly states-objects BUILD="$there" CC=$cross HYPRE= SANITIZE= \
    CPPFLAGS="-idirafter /usr/include -idirafter /usr/include/$(gcc -print-multiarch)" || status=$?
verdict "$status" "the solver compiles for aarch64"
[ "$status" = 0 ] || exit 1
mapfile -t objects < <(find "$there/obj/server" "$there/obj/tests" -name '*.o')
# MPFR is called only where a function cannot be rounded without it.
$cross -static -fopenmp -Wl,--unresolved-symbols=ignore-all -o "$there/states" "${objects[@]}" -lm 2>"$there/linker"

make_quietly states BUILD="$BUILD"
"$BUILD/tests/portable/states" 1 >"$there/here"
qemu-aarch64-static "$there/states" 2 >"$there/there" || verdict $? "the solver runs on aarch64"
while read -r scheme dim hash; do
    grep -qx "$scheme $dim $hash" "$there/there" && status=0 || status=$?
    verdict "$status" "$scheme in $dim ends in $hash on aarch64 too"
done <"$there/here"
exit $failed
