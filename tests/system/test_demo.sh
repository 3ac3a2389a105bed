#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make check CI=1
# The tour of `make demo` gets to its end, in small, and leaves the pictures it promises and nothing running. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
scratch=$(mktemp -d)
BUILD=${BUILD:-build}
export BUILD
demo=$BUILD/demo-in-small
trap 'rm -rf "$scratch" "$demo"' EXIT
status=0
mkdir "$scratch/mine"
DEMO=$scratch/mine RESOLUTION=20 WATCH=1 tools/demo.sh demo-in-small >"$scratch/log" 2>&1 || status=$?
if [ $status -eq 0 ]; then
    echo "ok - the demo gets to its end"
else
    echo "not ok - the demo gets to its end"
    sed 's/^/# /' "$scratch/log"
fi
for picture in phase pressure velocity front; do
    if [ "$(head -c 4 "$demo/$picture.png" 2>/dev/null | tail -c 3)" = PNG ]; then
        echo "ok - there is a picture $picture.png"
    else
        echo "not ok - there is a picture $picture.png"
        status=1
    fi
done
if pgrep -f -- "--state-dir $demo" >/dev/null; then
    echo "not ok - no daemon is left"
    status=1
else
    echo "ok - no daemon is left"
fi
if [ -d "$scratch/mine" ] && ! tools/demo.sh ../mine 2>/dev/null; then
    echo "ok - it removes nothing but a directory of the build"
else
    echo "not ok - it removes nothing but a directory of the build"
    status=1
fi
exit $status
