#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# pictures.sh: draw the pictures of README.md again, into client/pictures, from runs of the cases that come with Meniscus.
set -eu
cd "$(dirname "$0")/../.."
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
    "$BUILD/meniscus" render "${snapshots[-1]}" --out "client/pictures/$picture.png" --size 1000 "$@"
}

draw dam-break dambreak2d 5.4 resolution=40 -- --field velocity --title 'A dam has broken: water under air a thousand times lighter'
draw instability rayleigh-taylor2d 3 resolution=80 -- --title 'A heavy fluid sinks through a light one'
draw bubble bubble2d-hysing1 3 resolution=50 -- --field pressure --title 'A bubble has risen'
