#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make check CI=1
# systemd accepts what we install for it: the unit without a word of complaint and well closed in, the user, the
# directories. Nothing is started. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
unset MAKEFLAGS MFLAGS MAKELEVEL
. tests/support/expect.sh

make -s BUILD="$BUILD" DESTDIR= PREFIX="$stage/usr" install
unit=$stage/usr/lib/systemd/system/meniscusd@dam.service
dashboard=$stage/usr/lib/systemd/system/meniscus-dashboard@dam.service
mv "$stage/usr/lib/systemd/system/meniscusd@.service" "$unit"
mv "$stage/usr/lib/systemd/system/meniscus-dashboard@.service" "$dashboard"

clean() { # unknown keys are only warnings there
    "$@" 2>&1 | tee "$stage/words"
    [ "${PIPESTATUS[0]}" -eq 0 ] && [ ! -s "$stage/words" ]
}
expect "systemd-analyze verify has nothing to say" clean systemd-analyze verify --man=no "$unit"
expect "the exposure level is at most 2.5" systemd-analyze security --offline=yes --threshold=25 --no-pager "$unit"
expect "nor of the dashboard's" clean systemd-analyze verify --man=no "$dashboard"
expect "nor is that more exposed" systemd-analyze security --offline=yes --threshold=25 --no-pager "$dashboard"
expect "the user can be made" systemd-sysusers --dry-run "$stage/usr/lib/sysusers.d/meniscus.conf"
sweep=$stage/usr/share/meniscus/workflows/meniscus-sweep
expect "nor of the sweep's and its timer" clean systemd-analyze verify --man=no "$sweep.service" "$sweep.timer"
expect "a sweep tells make alone, with time for checkpoints" grep -qx "KillMode=mixed" "$sweep.service"
for word in "Type=notify" "NotifyAccess=main" "TimeoutStopSec=300" "StateDirectory=meniscus/%i" "RuntimeDirectory=meniscus/%i" \
    "MemoryMax=80%" "Restart=on-failure"; do
    expect "the unit says $word" grep -qx "$word" "$unit"
done
uncommented_at_once() { # of two lines for a variable only the last counts
    [ -z "$(grep -o '^#[A-Z_]*=' systemd/meniscus.conf | sort | uniq -d)" ]
}
expect "all that the example has can be uncommented" uncommented_at_once
directories() {
    # In a directory that plays the root of a machine, with the user just made.
    mkdir -p "$stage/root/etc"
    systemd-sysusers --root="$stage/root" "$stage/usr/lib/sysusers.d/meniscus.conf"
    systemd-tmpfiles --create --root="$stage/root" "$stage/usr/lib/tmpfiles.d/meniscus.conf"
    [ "$(stat -c %a "$stage/root/var/lib/meniscus")" = 750 ]
}
# Only root may give files away; for others there is nothing to test.
if [ "$(id -u)" -eq 0 ]; then expect "the directories can be made" directories; fi
exit "$failed"
