#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# headers.sh: every header compiles by itself, and the public ones in C++ too, so that nobody must know an order of
# includes. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
failed=0
# The words are quoted for a shell.
flags=()
eval "flags=($(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" flags))"

compiles() {
    local what=$1 header=$2
    shift 2
    # Included rather than compiled, as some warnings are meant for main files only.
    if output=$(echo "#include \"$PWD/$header\"" | "$@" "${flags[@]}" -Wall -Wextra -Werror -fsyntax-only - 2>&1); then
        echo "ok - $header compiles alone in $what"
    else
        echo "not ok - $header compiles alone in $what"
        echo "# ${output//$'\n'/$'\n'# }"
        failed=1
    fi
}

while read -r header; do
    compiles C17 "$header" "$CC" -std=c17 -fopenmp -x c
    case $header in include/*) compiles C++17 "$header" g++ -std=c++17 -x c++ ;; esac
done < <(find include server proto client tests -name '*.h' | sort)
exit $failed
