#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# demo.sh [NAME]: a tour of what was just built. A dam breaks in a daemon while we watch, pause, ask and change it; at the end
# there are pictures to look at. Nothing is left running, and nothing is written outside $BUILD/NAME ($BUILD/demo) but the sockets.
# What was there before is removed.
set -eu
cd "$(dirname "$0")/.."
BUILD=${BUILD:-build}
RESOLUTION=${RESOLUTION:-40} # particles per water depth
WATCH=${WATCH:-6}            # seconds
case ${1:-demo} in
*/* | .*)
    echo "demo.sh: \"$1\" is no name of a directory in $BUILD" >&2
    exit 2
    ;;
esac
demo=${BUILD:?}/${1:-demo}

export XDG_RUNTIME_DIR MENISCUS_DAEMON=demo
XDG_RUNTIME_DIR=$(mktemp -d /tmp/meniscus-demo-XXXXXX)
daemon=
finish() {
    status=$?
    if [ -n "$daemon" ] && kill "$daemon" 2>/dev/null; then wait "$daemon" || true; fi
    rm -rf "$XDG_RUNTIME_DIR"
    if [ $status -ne 0 ]; then
        echo "The demo did not get to its end (exit status $status)." >&2
        if [ -s "$demo/meniscusd.log" ]; then sed 's/^/    /' "$demo/meniscusd.log" | tail -n 20 >&2; fi
    fi
    exit $status
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

say() {
    echo
    printf '%s\n' "$@"
}
# Show a command before it is run, as one would type it.
try() {
    printf '$ meniscus %s\n' "$*"
    "$BUILD/meniscus" "$@"
}

rm -rf "$demo"
mkdir -p "$demo"

say "1. A daemon runs one simulation and listens on a socket in a directory of its own."
echo "\$ meniscusd --name demo --state-dir $demo &"
"$BUILD/meniscusd" --name demo --state-dir "$demo" 2>"$demo/meniscusd.log" &
daemon=$!
for _ in $(seq 100); do
    [ -S "$XDG_RUNTIME_DIR/meniscus/demo/control.ipc" ] && break
    kill -0 "$daemon"
    sleep 0.05
done

say "2. We give it a case: a column of water, 2 H wide and H deep, beside air a thousand times lighter." \
    "   The wall that held it is gone at t = 0. Any entry of the case can be set on the way."
try load dambreak2d --set resolution="$RESOLUTION" --set end_time=3 --start

say "3. We watch for a few seconds: progress, and the probes of the case, as they are computed."
printf '$ meniscus watch\n'
timeout --foreground "$WATCH" "$BUILD/meniscus" watch || [ $? -eq 124 ]

say "4. Pause. The answer comes when the solver stands still, and names the step."
try pause
try query

say "5. A paused simulation can be changed. Snapshots every 0.25 s from here on, please; resume."
try set output.snapshot_interval=0.25
try resume

say "6. While it runs: the fields as a file that ParaView opens, and the whole state to go on from."
try snapshot
try checkpoint
try status

say "7. Now we wait for the end: \`to go\` above says how long that is."
try wait --for state=DONE --timeout 3600

say "8. Pictures, drawn from the last snapshot, and the water front against theory."
try snapshot
snapshots=("$demo"/*/snapshot*.hdf "$demo"/snapshot*.hdf)
last=
for file in "${snapshots[@]}"; do
    if [ -f "$file" ] && { [ -z "$last" ] || [ "$file" -nt "$last" ]; }; then last=$file; fi
done
for field in phase pressure velocity; do
    try render "$last" --field $field --out "$demo/$field.png"
done
series=$(find "$demo" -name probes.hdf | head -n 1)
/usr/bin/python3 tools/plot_front.py "$series" "$demo/front.png" \
    --label "Meniscus, H/Δx = $RESOLUTION"
try shutdown
wait "$daemon" || true
daemon=

say "That was it. Look at:" \
    "    $demo/phase.png      water and air" \
    "    $demo/pressure.png   pressure" \
    "    $demo/velocity.png   speed" \
    "    $demo/front.png      the water front against Ritter's solution and a volume-of-fluid computation" \
    "Everything of the run is in $(dirname "$series"): open snapshots.hdf.series there with ParaView."
