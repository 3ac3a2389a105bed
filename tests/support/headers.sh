#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# headers.sh: every header compiles by itself, and the public ones in C++ too, so that nobody must know an order of
# includes. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
# The words are quoted for a shell.
flags=$(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" flags)
export CC flags

compiles() {
    local what=$1 header=$2 words=() output
    shift 2
    eval "words=($flags)"
    # Included rather than compiled, as some warnings are meant for main files only.
    if output=$(echo "#include \"$PWD/$header\"" | "$@" "${words[@]}" -Wall -Wextra -Werror -fsyntax-only - 2>&1); then
        echo "ok - $header compiles alone in $what"
    else
        echo "not ok - $header compiles alone in $what"$'\n'"# ${output//$'\n'/$'\n'# }"
        return 1
    fi
}

one() {
    local status=0
    compiles C17 "$1" "$CC" -std=c17 -fopenmp -x c || status=1
    case $1 in include/*) compiles C++17 "$1" g++ -std=c++17 -x c++ || status=1 ;; esac
    return "$status"
}
export -f compiles one

# shellcheck disable=SC2016 # the inner shell expands
find include server common client tests -name '*.h' | sort | xargs -P "$(nproc)" -n 1 bash -c 'one "$1"' bash
