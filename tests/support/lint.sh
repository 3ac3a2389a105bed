#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# lint.sh: layout, static analysis, scripts, licence lines. Needs a finished build in $BUILD for the generated headers.
# Prints TAP.
# shellcheck disable=SC2317 # functions are called by check()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
failed=0
flags=$(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" flags)
mapfile -t sources < <(find server common client tests -name '*.c' | sort)
mapfile -t programs < <(printf '%s\n' "${sources[@]}" | grep -v '^tests/')
mapfile -t headers < <(find include server common proto client tests -name '*.h' | sort)
mapfile -t scripts < <({
    find tests tools client systemd -name '*.sh'
    echo .ci/run
} | sort)

# check WHAT COMMAND...: the command's output is shown if it fails.
check() {
    local what=$1 started=$SECONDS
    shift
    if output=$("$@" 2>&1); then
        echo "ok - $what ($((SECONDS - started)) s)"
    else
        echo "not ok - $what ($((SECONDS - started)) s)"
        echo "# ${output//$'\n'/$'\n'# }"
        failed=1
    fi
}

licensed() {
    find include server common proto client tests tools systemd Makefile .ci/run -type f \( -name '*.[ch]' -o -name '*.proto' -o -name '*.py' \
        -o -name '*.js' -o -name '*.mjs' -o -name '*.css' -o -name '*.sh' -o -name '*.yaml' -o -name Makefile -o -name run \) \
        -not -path '*/__pycache__/*' -print0 | xargs -0 awk '
        FNR <= 3 && /SPDX-License-Identifier: BSD-3-Clause/ { licensed[FILENAME] = 1 }
        END { for (k = 1; k < ARGC; k++) if (!(ARGV[k] in licensed)) { print ARGV[k] " has no SPDX line at its top"; bad = 1 } exit bad }'
}

# Many files for each process of clang's tools, as to load one takes longer than to look at a file.
layout() {
    printf '%s\n' "${sources[@]}" "${headers[@]}" | xargs -P "$(nproc)" -n 100 clang-format --dry-run -Werror
}

# What was found clean once is not looked at again: a file as clang sees it, with the comments of its headers (NOLINT), by this program and this
# script, with the checks of all folders. A file that cannot be read so is looked at each time.
clang_warns='-Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wpointer-arith'
known() {
    local words=() file seen stamp
    eval "words=($FLAGS)"
    for file; do
        stamp=none
        if seen=$(set -o pipefail; clang -E -CC -std=c17 -fopenmp "${words[@]}" "$file" 2>/dev/null | sha256sum); then
            stamp=$({ echo "$seen $file $checks" && cat "$file"; } | sha256sum | cut -c1-64)
        fi
        echo "$stamp $file"
    done
}

look_at() {
    local files=() stamps=() words=() file stamp
    while read -r stamp file; do
        if [ "$stamp" = none ]; then
            files+=("$file")
        elif [ ! -e "$cache/$stamp" ]; then
            files+=("$file") stamps+=("$cache/$stamp")
        fi
    done < <(known "$@")
    if [ ${#files[@]} -eq 0 ]; then return; fi
    eval "words=($FLAGS)"
    # On standard error it only counts what it does not show.
    # shellcheck disable=SC2086 # several words
    clang-tidy --quiet "${files[@]}" -- -std=c17 -fopenmp $clang_warns "${words[@]}" 2>/dev/null &&
        { [ ${#stamps[@]} -eq 0 ] || touch "${stamps[@]}"; }
}

tidy() {
    export clang_warns FLAGS=$flags cache=${XDG_CACHE_HOME:-$HOME/.cache}/meniscus/tidy
    export -f known look_at
    mkdir -p "$cache" && find "$cache" -type f -mtime +30 -delete
    checks=$({ find . -name .clang-tidy -not -path './build*' | sort | xargs cat && clang-tidy --version && echo "$flags" && cat tests/support/lint.sh; } | sha256sum)
    export checks
    # In a second file of one process clang takes each va_list for one that was not begun.
    mapfile -t alone < <(grep -l va_list "${sources[@]}")
    mapfile -t together < <(grep -L va_list "${sources[@]}")
    # shellcheck disable=SC2016 # the inner shell expands
    { printf '%s\n' "${together[@]}" | xargs -P "$(nproc)" -n 25 bash -c 'look_at "$@"' bash; } &&
        printf '%s\n' "${alone[@]}" | xargs -P "$(nproc)" -n 1 bash -c 'look_at "$@"' bash
}

# A name that a module or a class defines twice is one whose first meaning is lost, as a test that is never run.
python_compiles() {
    find tests tools client proto -name '*.py' -print0 | xargs -0 -r /usr/bin/python3 -c '
import ast, sys
bad = 0
for name in sys.argv[1:]:
    tree = ast.parse(open(name, encoding="utf-8").read(), name)
    for scope in (n for n in ast.walk(tree) if isinstance(n, (ast.Module, ast.ClassDef))):
        seen = {}
        for one in scope.body:
            if not isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                continue
            if one.name in seen and not one.decorator_list and not seen[one.name].decorator_list:
                print(f"{name}:{one.lineno}: {one.name} is defined in line {seen[one.name].lineno} already")
                bad = 1
            seen[one.name] = one
sys.exit(bad)'
}

# With what is generated, which is in the build.
types() {
    (cd "$BUILD/python" && mypy --config-file "$OLDPWD/client/python/pyproject.toml" --cache-dir .mypy_cache -p meniscus)
}

# Of those who use it, too.
mistakes() {
    (cd "$BUILD/python" && mypy --config-file "$OLDPWD/client/python/pyproject.toml" --cache-dir .mypy_cache "$OLDPWD/tests/support/mistakes.py")
}

# What the manual shows is checked as its readers would.
manual_types() {
    rm -rf "$BUILD/python/shown" && mkdir -p "$BUILD/python/shown"
    awk -v to="$BUILD/python/shown/block" \
        '/^```python$/ { file = to (++n) ".py"; next } /^```$/ { file = "" } file { print > file }' client/python/README.md
    (cd "$BUILD/python" && mypy --config-file "$OLDPWD/client/python/pyproject.toml" --allow-untyped-defs --allow-untyped-calls \
        --check-untyped-defs --cache-dir .mypy_cache shown/*.py)
}

# By the comments of its JavaScript, beside the modules it takes.
page_types() {
    local folder=$BUILD/web-check
    rm -rf "$folder/src" && cp -r client/dashboard/web/src client/dashboard/web/tsconfig.json "$folder" && (cd "$folder" && node_modules/.bin/tsc -p .)
}

check "every source names its licence" licensed
check "layout of C (clang-format)" layout
check "shell scripts (shellcheck)" shellcheck "${scripts[@]}"
check "Python parses, and defines nothing twice" python_compiles
check "types of the Python client (mypy)" types
check "types that refuse mistakes of its users (mypy)" mistakes
check "types of what its manual shows (mypy)" manual_types
check "types of the dashboard's page (tsc)" page_types
# readdir is safe on a stream of its own, and readdir_r is deprecated. Uninitialised values are the compilers' to find:
# cppcheck takes `c ? a : &b` for a use of b. That a condition reads an element before its limit is style, not an error.
# It is kept from the tests, as it does not know that cmocka's skip() and fail() do not return.
check "cppcheck" cppcheck --quiet -j 2 --std=c11 --enable=warning,performance,portability --error-exitcode=1 \
    --inline-suppr --suppress=missingIncludeSystem --suppress=readdirCalled --suppress=uninitvar --suppress=arrayIndexThenCheck \
    --library=posix -Iinclude -Iserver -I. "${programs[@]}"
check "clang-tidy" tidy
exit $failed
