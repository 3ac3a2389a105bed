#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# packages.sh [build|check|validate]: install the Debian packages that are missing. `build` (the default) is what building
# and `make demo` need; `check` and `validate` are that and what the target of this name needs besides. Costs one dpkg-query when nothing is missing.
set -eu

build='
gcc make pkgconf
protobuf-compiler protobuf-c-compiler python3 python3-protobuf
libzmq3-dev libprotobuf-c-dev libhdf5-dev libyaml-dev libjansson-dev
libcairo2-dev libsystemd-dev libxxhash-dev liblua5.4-dev
python3-numpy python3-h5py python3-matplotlib python3-zmq python3-yaml
'
check='
libcmocka-dev
clang clang-format clang-tidy libclang-rt-14-dev libomp-dev
cppcheck shellcheck g++ git procps
systemd util-linux
paraview python3-paraview xvfb xauth
'
validate='
python3-scipy
'

group=${1:-build}
case $group in
build) wanted=$build ;;
check) wanted=$build$check ;;
validate) wanted=$build$validate ;;
*)
    echo "usage: packages.sh [build|check|validate]" >&2
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

echo "packages to install: ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
    root=()
elif sudo -n true 2>/dev/null; then
    root=(sudo -n)
elif [ -t 0 ] && command -v sudo >/dev/null; then
    root=(sudo)
else
    {
        echo "You may not install packages here. Ask somebody who may to run:"
        echo "    apt-get install --no-install-recommends ${missing[*]}"
    } >&2
    exit 1
fi

install=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends)
# A fresh machine has no package index, and an old index names files that are gone: then fetch it and try again.
"${install[@]}" "${missing[@]}" || {
    "${root[@]}" apt-get update -q
    "${install[@]}" "${missing[@]}"
}
