#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# layers.sh: prove that each folder uses only what lies below it. First by reading its includes, by the
# table of ARCHITECTURE.md; then by asking the linker: the solver library must be complete without the libraries of messages,
# files and sockets. Prints TAP.
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
failed=0

# The rows of ARCHITECTURE.md: folder, and what it may use: folders of ours, `messages` (generated from proto/), libraries.
# shellcheck disable=SC2016 # the backticks are those of the table
table=$(sed -n 's/^| `\([a-z/.]*\)` |[^|]*| \([a-z][a-z0-9, ]*\) |$/\1 \2/p' ARCHITECTURE.md | tr -d ,)

# What an include names, in the words of the table. Angle brackets that are none of these are the C library's.
kind_of() {
    case $1 in
    '<meniscus/'*) echo meniscus ;;
    *.pb-c.h? | '<protobuf-c/'*) echo messages ;;
    '<zmq'*) echo zmq ;;
    '<hdf5'* | '<H5'*) echo hdf5 ;;
    '<yaml.h>') echo yaml ;;
    '<jansson.h>') echo jansson ;;
    '<cairo'*) echo cairo ;;
    '<systemd/'*) echo systemd ;;
    '<lua'* | '<lauxlib.h>') echo lua ;;
    '<xxh'*) echo xxhash ;;
    '<omp.h>') echo openmp ;;
    '<'*) echo system ;;
    '"'*/*)
        local path=${1#\"}
        echo "${path%%/*}"
        ;;
    *) echo "$1, which does not begin with its folder" ;;
    esac
}

while read -r folder allowed; do
    [ -n "$folder" ] || continue
    bad=$(find "$folder" -name '*.[ch]' -exec grep -HnE '^[[:space:]]*#[[:space:]]*include' {} + |
        sed 's|^\([^:]*:[0-9]*\):[^<"]*\([<"][^>"]*[>"]\).*|\1 \2|' |
        while read -r where include; do
            kind=$(kind_of "$include")
            case " $allowed system " in
            *" $kind "*) ;;
            *) echo "# $where includes $include: $kind" ;;
            esac
        done)
    if [ -z "$bad" ]; then
        echo "ok - $folder includes only: $allowed"
    else
        echo "not ok - $folder includes only: $allowed"
        echo "$bad"
        failed=1
    fi
done <<<"$table"

forgotten=$(comm -23 <(find include server proto client -name '*.[ch]' | sort) \
    <(cut -d' ' -f1 <<<"$table" | xargs -I{} find {} -name '*.[ch]' | sort))
if [ -z "$forgotten" ]; then
    echo "ok - every source is in a folder of the table"
else
    echo "not ok - every source is in a folder of the table"
    echo "# ${forgotten//$'\n'/$'\n'# }"
    failed=1
fi

# What a folder may not include it may still declare and call by hand, so the linker has the last word. Of the C library the
# solver has no business with files and sockets either.
system='fopen(64)?|fdopen|open(64)?|openat(64)?|creat(64)?|fread|fwrite|socket|bind|connect|listen|accept4?|send(to|msg)?|recv(from|msg)?'
undefined=$(nm -u "$BUILD/libmeniscus.a")
if undefined=$(grep -E " U ((zmq_|H5|protobuf_c_|meniscus__|yaml_|json_|cairo_|sd_)|($system)\$)" <<<"$undefined"); then
    echo "not ok - the solver library calls no library of messages, files or sockets"
    echo "# ${undefined//$'\n'/$'\n'# }"
    failed=1
else
    echo "ok - the solver library calls no library of messages, files or sockets"
fi
if output=$("$CC" -shared -fopenmp -o "$BUILD/libmeniscus-alone.so" -Wl,--no-undefined -Wl,--whole-archive \
    "$BUILD/libmeniscus.a" -Wl,--no-whole-archive -llua5.4 -lxxhash -lm 2>&1); then
    echo "ok - the solver library is complete by itself"
else
    echo "not ok - the solver library is complete by itself"
    echo "# ${output//$'\n'/$'\n'# }"
    failed=1
fi
exit $failed
