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

# What an include names, in the words of the table. What C itself has, everybody may use; all else in angle brackets is the
# operating system's.
standard=' assert complex ctype errno fenv float inttypes limits locale math setjmp signal stdalign stdarg stdatomic stdbool
 stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype '
# kind_of INCLUDE: sets $kind, as a process for each would take most of the time.
kind_of() {
    local name=${1#<}
    name=${name%.h>}
    case $1 in
    '<meniscus/'*) kind=meniscus ;;
    *.pb-c.h? | '<protobuf-c/'*) kind=messages ;;
    '<zmq'*) kind=zmq ;;
    '<microhttpd.h>') kind=microhttpd ;;
    '<libwebsockets.h>') kind=websockets ;;
    '<hdf5'* | '<H5'*) kind=hdf5 ;;
    '<yaml.h>') kind=yaml ;;
    '<jansson.h>') kind=jansson ;;
    '<cairo'*) kind=cairo ;;
    '<systemd/'*) kind=systemd ;;
    '<lua'* | '<lauxlib.h>') kind=lua ;;
    '<xxh'*) kind=xxhash ;;
    '<lz4'* | '<zstd'*) kind=codecs ;;
    '<mpfr.h>') kind=mpfr ;;
    '<omp.h>') kind=openmp ;;
    '<immintrin.h>') kind=instructions ;;
    '<HYPRE'* | '<mpi.h>') kind=hypre ;;
    '<'*)
        case ${standard//$'\n'/} in
        *" $name "*) kind=standard ;;
        *) kind=posix ;;
        esac
        ;;
    '"'*/*)
        local path=${1#\"}
        path=${path#client/}
        path=${path#common/}
        kind=${path%%/*}
        ;;
    *) kind="$1, which does not begin with its folder" ;;
    esac
}

while read -r folder allowed; do
    [ -n "$folder" ] || continue
    bad=$(find "$folder" -name '*.[ch]' -exec grep -HnE '^[[:space:]]*#[[:space:]]*include' {} + |
        sed 's|^\([^:]*:[0-9]*\):[^<"]*\([<"][^>"]*[>"]\).*|\1 \2|' |
        while read -r where include; do
            kind_of "$include"
            case " $allowed standard " in
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

forgotten=$(comm -23 <(find include server common client -name '*.[ch]' | sort) \
    <(cut -d' ' -f1 <<<"$table" | xargs -I{} find {} -name '*.[ch]' | sort))
if [ -z "$forgotten" ]; then
    echo "ok - every source is in a folder of the table"
else
    echo "not ok - every source is in a folder of the table"
    echo "# ${forgotten//$'\n'/$'\n'# }"
    failed=1
fi

# What a folder may not include it may still declare and call by hand, so the linker has the last word: on the library, of
# which server/base waits for signals, and on the solver proper, which needs nothing but memory, text and mathematics.
named() { sed "s/^[0-9a-f ]*[A-Za-z] //; s/@.*//; /^\$/d; /:\$/d" | sort -u; }
report() { # report FACT BAD
    if [ -z "$2" ]; then
        echo "ok - $1"
    else
        echo "not ok - $1"
        echo "# ${2//$'\n'/$'\n'# }"
        failed=1
    fi
}

libraries='zmq_|H5|protobuf_c_|meniscus__|yaml_|json_|cairo_|sd_'
system='f(re|d)?open(64)?|popen|open(64)?|openat(64)?|creat(64)?|fread|fwrite|p?writev?(64)?|rename(at2?)?|unlink(at)?|mmap(64)?'
system+='|dlopen|socket(pair)?|bind|connect|listen|accept4?|send(to|m?msg|file)?|recv(from|m?msg)?|fork|exec.*|posix_spawnp?'
report "the solver library calls no library of messages, files or sockets" \
    "$(nm -u "$BUILD/libmeniscus.a" | named | grep -E "^(($libraries).*|$system)\$" || true)"

# With the names that compilers give to the same: of checked and sanitized code, of either OpenMP.
solver='setenv|(HYPRE_|MPI_|ompi_|lua|GOMP_|omp_|__kmpc_|XXH|__([atl]|ub)san_).*|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail|__assert_fail|(__)?(mem|str)[a-z]*(_chk)?'
solver+='|__cpu_model|bcmp|malloc|calloc|realloc|free|aligned_alloc|qsort|bsearch|(__)?(snprintf|vsnprintf)(_chk)?|(__isoc[0-9]+_)?(sscanf|strto[a-z]+)'
mapfile -t objects < <(find server/sim -name '*.c' | sed "s|^\(.*\)c\$|$BUILD/obj/\1o|")
report "the solver itself calls nothing of the system but memory, text and mathematics" \
    "$(comm -23 <(nm -u "${objects[@]}" | named | grep -vxE "$solver") \
        <({ nm -g --defined-only "$BUILD/libmeniscus.a" && nm -D --defined-only "$("$CC" -print-file-name=libm.so.6)"; } | named))"

read -ra hypre <<<"$(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" CC="$CC" solver-libs)"
if output=$("$CC" -shared -fopenmp -o "$BUILD/libmeniscus-alone.so" -Wl,--no-undefined -Wl,--whole-archive \
    "$BUILD/libmeniscus.a" -Wl,--no-whole-archive -llua5.4 -lxxhash -lmpfr "${hypre[@]}" -lm 2>&1); then
    echo "ok - the solver library is complete by itself"
else
    echo "not ok - the solver library is complete by itself"
    echo "# ${output//$'\n'/$'\n'# }"
    failed=1
fi
exit $failed
