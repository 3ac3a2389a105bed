#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# packages.sh installs what is missing as root and with sudo, fetches the index of packages where there is none, and says
# what to do where it may do nothing. The machine is made of scripts. Prints TAP.
# shellcheck disable=SC2016,SC2317 # the scripts expand, not we; functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
. tests/support/expect.sh

fake() { # fake NAME: a program from standard input
    { echo "#!/bin/bash"; cat; } >"$stage/bin/$1"
    chmod +x "$stage/bin/$1"
}

# machine UID SUDO INDEX: who we are, whether sudo lets us in, whether there is an index of packages
machine() {
    rm -rf "${stage:?}/bin"
    mkdir -p "$stage/bin"
    : >"$stage/calls"
    rm -f "$stage/index"
    if [ "$3" = yes ]; then : >"$stage/index"; fi
    fake id <<<"echo $1"
    if [ "$2" = yes ]; then
        fake sudo <<<"echo sudo \"\$@\" >>$stage/calls; shift; \"\$@\""
    else
        fake sudo <<<"exit 1"
    fi
    fake dpkg-query <<<'for p in "$@"; do case $p in make | gcc) ;; *) echo "installed $p" ;; esac done'
    fake apt-get <<<"case \"\$*\" in
        update*) echo update >>$stage/calls; : >$stage/index ;;
        *--simulate*) [ -f $stage/index ] ;;
        *) [ -f $stage/index ] && echo \"\$@\" >>$stage/calls ;;
    esac"
    for tool in bash env sed tr cat; do ln -s "$(command -v "$tool")" "$stage/bin/$tool"; done
}
packages() {
    PATH=$stage/bin tools/packages.sh </dev/null
}
calls() {
    packages && diff - "$stage/calls"
}
install="install -y -q --no-install-recommends gcc make"
sudo="sudo -n env DEBIAN_FRONTEND=noninteractive apt-get $install"

machine 0 no yes
expect "root installs what is missing and no more" calls <<<"$install"
machine 0 no no
expect "where there is no index it is fetched first" calls <<<"update"$'\n'"$install"
machine 1000 yes yes
expect "whoever may use sudo does" calls <<<"sudo -n true"$'\n'"$sudo"$'\n'"$install"
machine 1000 yes no
expect "and fetches the index with it" calls <<<"sudo -n true"$'\n'"sudo -n apt-get update -q"$'\n'update$'\n'"$sudo"$'\n'"$install"

refused() {
    local status=0
    packages >"$stage/out" 2>&1 || status=$?
    cat "$stage/out"
    [ "$status" -eq 1 ] && grep -qx '    apt-get install --no-install-recommends gcc make' "$stage/out" && [ ! -s "$stage/calls" ]
}
machine 1000 no yes
expect "whoever may do nothing is told what to ask for" refused
machine 1000 no yes
rm "$stage/bin/apt-get"
expect "so is whoever has no apt-get" refused

complete() {
    fake dpkg-query <<<'for p in "$@"; do echo "installed $p"; done'
    [ -z "$(packages 2>&1)" ] && [ ! -s "$stage/calls" ]
}
machine 1000 no no
expect "where nothing is missing nothing is said or done" complete
exit "$failed"
