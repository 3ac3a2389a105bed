#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# packages.sh [build|dashboard|deb|bench|check|ci|pictures|nightly|validate]: install the Debian packages that are missing. `build` (the default) is what building
# and `make demo` need; the others are that and what the target of this name needs besides. Costs one dpkg-query when nothing is missing.
set -eu

build='
gcc make pkgconf ccache
protobuf-compiler protobuf-c-compiler python3 python3-protobuf
libzmq3-dev libprotobuf-c-dev libhdf5-dev libyaml-dev libjansson-dev
libcairo2-dev libsystemd-dev libxxhash-dev liblz4-dev libzstd-dev liblua5.4-dev libmpfr-dev libhypre-dev libmicrohttpd-dev
python3-numpy python3-h5py python3-cairo python3-zmq python3-yaml python3-xxhash python3-lz4 python3-zstandard
'
dashboard='
libwebsockets-dev
'
# Not those of Debian where there are others.
command -v node >/dev/null || dashboard+=' nodejs'
command -v npm >/dev/null || dashboard+=' npm'
deb='
debhelper dpkg-dev
'
bench='
libcmocka-dev
'
check='
g++ git procps man-db
python3-scipy python3-prometheus-client
'
ci='
clang clang-format clang-tidy libclang-rt-14-dev libomp-dev
cppcheck shellcheck mypy
systemd
'
nightly='
chromium valgrind prometheus lintian zsh util-linux
paraview python3-paraview xvfb xauth
python3-matplotlib python3-pandas python3-xarray python3-nbclient python3-ipykernel python3-jsonschema snakemake
munge slurm-client slurmctld slurmd
'
# For a processor that is not here (tests/portable).
[ "$(dpkg --print-architecture 2>/dev/null)" != amd64 ] || nightly+='gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static'
validate='
python3-scipy
'

group=${1:-build}
case $group in
build) wanted=$build ;;
dashboard) wanted=$build$dashboard ;;
deb) wanted=$build$deb ;;
bench) wanted=$build$bench ;;
check) wanted=$build$bench$check ;;
ci) wanted=$build$bench$check$dashboard$ci ;;
pictures) wanted=$build$bench$check$dashboard$ci" chromium" ;;
nightly) wanted=$build$bench$check$dashboard$ci$deb$nightly ;;
validate) wanted=$build$validate ;;
*)
    echo "usage: packages.sh [build|dashboard|deb|bench|check|ci|pictures|nightly|validate]" >&2
    exit 64
    ;;
esac
read -ra wanted <<<"$(tr '\n' ' ' <<<"$wanted")"

# dpkg-query complains about packages it has never heard of; those are missing too.
installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null | sed -n 's/^installed //p') || true
missing=()
for package in "${wanted[@]}"; do
    case $'\n'$installed$'\n' in
    *$'\n'"$package"$'\n'*) ;;
    *) missing+=("$package") ;;
    esac
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "Packages to install: ${missing[*]}"
refuse() {
    {
        echo "$1 Ask somebody who may install packages to run:"
        echo "    apt-get update"
        echo "    apt-get install --no-install-recommends ${missing[*]}"
        echo "Elsewhere than on Debian 12 these packages have other names; the list is in tools/packages.sh."
    } >&2
    exit 1
}
command -v apt-get >/dev/null || refuse "There is no apt-get here."
if [ "$(id -u)" -eq 0 ]; then
    root=()
elif sudo -n true 2>/dev/null; then
    root=(sudo -n)
elif [ -t 0 ] && command -v sudo >/dev/null; then
    root=(sudo)
else
    refuse "You are not root, and sudo does not let you in without a password."
fi

install=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends)
update=("${root[@]}" apt-get update -q)
# A fresh machine has no index of packages. An old one names files that are gone: then it is fetched, and we try again.
apt-get install --simulate -qq --no-install-recommends "${missing[@]}" >/dev/null 2>&1 || "${update[@]}"
"${install[@]}" "${missing[@]}" || {
    "${update[@]}"
    "${install[@]}" "${missing[@]}"
} || refuse "apt-get could not install them; what it said is above."
