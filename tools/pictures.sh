#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# pictures.sh: draw the pictures of README.md again, into client/pictures, from runs of the cases that come with Meniscus.
set -eu
cd "$(dirname "$0")/.."
BUILD=${BUILD:-build}
runs=$BUILD/pictures
mkdir -p client/pictures

# draw PICTURE CASE TIME OPTION... [-- RENDER OPTION...]: the last snapshot of a run to that time.
draw() {
    local picture=$1 case=$2 time=$3 options=()
    shift 3
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        options+=(--set "$1")
        shift
    done
    [ $# -eq 0 ] || shift
    rm -rf "${runs:?}/$picture"
    "$BUILD/meniscus" run "$case" --out "$runs/$picture" --set end_time="$time" --set output.snapshot_interval="$time" "${options[@]}" -o json >/dev/null
    local snapshots=("$runs/$picture"/snapshot-*.hdf)
    "$BUILD/meniscus" render "${snapshots[-1]}" --out "client/pictures/$picture.png" "$@"
}

draw dam-break dambreak2d 5.4 resolution=40 -- --size 1000 --field velocity --fluid water \
    --title 'A dam has broken: speed of the water, under air a thousand times lighter'
draw instability rayleigh-taylor2d 3 resolution=80 -- --size 660 --title 'A heavy fluid sinks through a light one'
draw bubble bubble2d-hysing1 3 resolution=50 -- --size 660 --field pressure --title 'A bubble has risen'

# The dashboard as its test sees it.
PICTURES=$runs /usr/bin/python3 tests/system/test_dashboard.py Page.test_a_person_can_do_everything_in_a_browser
cp "$runs/running.png" client/pictures/dashboard.png
