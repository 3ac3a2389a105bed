# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash disable=SC2034 # $failed is for whoever sources this
# expect.sh: for tests that are shell scripts, to be sourced. Gives $stage, a directory that goes away at the end, and
# `expect WHAT COMMAND...`: the test WHAT passes if the command does; if not, its output is shown. The script ends with
# `exit "$failed"`. Prints TAP.
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
failed=0

expect() {
    local what=$1
    shift
    if "$@" >"$stage/log" 2>&1; then
        echo "ok - $what"
    else
        echo "not ok - $what"
        sed 's/^/# /' "$stage/log"
        failed=1
    fi
}
