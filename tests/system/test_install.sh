#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
# What is installed can be used by a stranger, through pkg-config alone, and goes away again without a trace. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
CC=${CC:-gcc}
unset MAKEFLAGS MFLAGS MAKELEVEL
. tests/support/expect.sh

root=$stage/root
export PKG_CONFIG_SYSROOT_DIR='' PKG_CONFIG_PATH=$root/opt/lib/pkgconfig
expect "make install works below DESTDIR" make -s BUILD="$BUILD" DESTDIR="$root" PREFIX=/opt install

cat >"$stage/solver.c" <<'C'
#include <meniscus/sim.h>
#include <stdio.h>
int main(void)
{
    MnsError error;
    MnsCase nothing = {0};
    printf("%s, %s\n", mns_fields()[0].name, mns_status_name(mns_case_check(&nothing, &error)));
    return mns_field_find("position") < 0;
}
C
cat >"$stage/client.c" <<'C'
#include <meniscus/client.h>
#include <stdio.h>
int main(void)
{
    MnsError error;
    char endpoint[MNS_ENDPOINT_SIZE];
    const MnsStatus status = mns_daemon_endpoint("nobody", endpoint, &error);
    printf("%s\n", status == MNS_OK ? endpoint : error.text);
    return 0;
}
C
build() {
    local flags
    # The prefix in the files is the final one; below a DESTDIR it must be said.
    flags=$(pkg-config --define-variable=prefix="$root/opt" --cflags --libs "$2")
    # shellcheck disable=SC2086 # words
    "$CC" -std=c17 -o "$stage/$1" "$stage/$1.c" $flags
}
expect "a program builds with the solver library" build solver meniscus
# Beside C's mathematics, which formulas are to have too, and OpenMP's locks, which nobody can call.
foreign() {
    local names
    names=$(nm -g --defined-only "$root"/opt/lib/libmeniscus*.a | sed -n 's/.* [A-Z] //p' |
        grep -vxE 'mns_.*|[.]gomp_critical_user_.*|a?(sin|cos|tan)|atan2|cbrt|exp|log(2|10)?|pow|sincos')
    [ -z "$names" ] || { echo "$names" && return 1; }
}
expect "its libraries keep their own names to themselves" foreign
expect "it runs" "$stage/solver"
expect "a program builds with the client library" build client meniscus-client
expect "it runs" env LD_LIBRARY_PATH="$root/opt/lib" "$stage/client"
expect "the installed command line runs" "$root/opt/bin/meniscus" --help
expect "the installed daemon runs" "$root/opt/bin/meniscusd" --help
expect "the installed dashboard runs" "$root/opt/bin/meniscus-dashboard" --help
expect "the Python client can be imported where python3 is told of it" env PYTHONPATH="$root/opt/lib/python3/dist-packages" \
    /usr/bin/python3 -c "import meniscus"
expect "bash finds the completion of the daemon" bash -n "$root/opt/share/bash-completion/completions/meniscusd"
expect "bash finds its completion" bash -n "$root/opt/share/bash-completion/completions/meniscus"
expect "zsh finds its completion" grep -q '^#compdef meniscus meniscusd' "$root/opt/share/zsh/site-functions/_meniscus"
# shellcheck disable=SC2016 # the inner shell expands
expect "man finds the manual pages" sh -c 'for page in meniscus meniscusd meniscus-case; do man -M "$1" -w "$page" || exit 1; done' \
    sh "$root/opt/share/man"
cat >"$stage/links.py" <<'PY'
import pathlib, re, sys

pages = sorted(pathlib.Path(sys.argv[1]).glob("*.md"))
links = [(page, link) for page in pages for link in re.findall(r"(?:\]\(|src=\")([^)\"#:]+\.[a-z]+|Makefile|Snakefile)[)\"]", page.read_text())]
dead = [f"{page.name}: {link}" for page, link in links if not (page.parent / link).exists()]
print(*dead, sep="\n")
sys.exit(bool(dead) or len(links) < 20)
PY
expect "the pages about it lead to each other and to the examples" /usr/bin/python3 "$stage/links.py" "$root/opt/share/doc/meniscus"
expect "the notebooks are there" test -f "$root/opt/share/meniscus/notebooks/steer.ipynb"
expect "the cases are there" test -f "$root/opt/share/meniscus/cases/dambreak2d.yaml"
expect "the installed example of a sweep runs" env MENISCUS="$root/opt/bin/meniscus" make -f "$root/opt/share/meniscus/workflows/Makefile" \
    OUT="$stage/sweep" CASE="$root/opt/share/meniscus/cases/hydrostatic.yaml" RESOLUTIONS=8 SCHEMES=riemann SETTINGS=end_time=0.01
expect "its unit names it" grep -q ' -f /opt/share/meniscus/workflows/Makefile ' "$root/opt/share/meniscus/workflows/meniscus-sweep.service"
expect "the unit names the installed daemon" grep -q '^ExecStart=/opt/bin/meniscusd ' "$root/opt/lib/systemd/system/meniscusd@.service"

# As after `make clean`, and by whoever has the sources anew.
expect "make uninstall works without a build" make -s BUILD="$stage/none" DESTDIR="$root" PREFIX=/opt uninstall
nothing_left() {
    local left
    left=$(find "${1:-$root}" \( -type f -o -type l -o -name '*meniscus*' \))
    echo "$left"
    [ -z "$left" ]
}
expect "uninstall leaves nothing" nothing_left

built_too() { make -s -p BUILD="$1" help 2>/dev/null | grep "^INSTALLED :\?= .*meniscus-dashboard"; }
mkdir "$stage/with"
touch "$stage/with/meniscus-dashboard"
expect "a dashboard that was built once is brought up to date before it is installed" built_too "$stage/with"
left_alone() { ! built_too "$1"; }
expect "none is made where there was none" left_alone "$stage/none"

# In /usr/local itself, or rather in an empty one that nobody else sees, by who is root there; what systemd does then is only noted down.
mkdir "$stage/noted"
for command in systemd-sysusers systemd-tmpfiles ldconfig; do
    # shellcheck disable=SC2016 # the command expands
    printf '#!/bin/sh\necho "${0##*/} $*" >>"%s/noted/commands"\n' "$stage" >"$stage/noted/$command"
    chmod +x "$stage/noted/$command"
done
cat >"$stage/local.sh" <<'SH'
set -eu
mount -t tmpfs none /usr/local
PATH=$stage/noted:$PATH make -s BUILD="$BUILD" install
cd /
env -u PYTHONPATH /usr/bin/python3 -c 'import meniscus; print(meniscus.__file__)'
env -u PYTHONPATH -u MENISCUS_CASES /usr/bin/python3 -c 'from meniscus import case; print(case.find("dambreak2d"))' | grep '^/usr/local/share/meniscus/cases/'
cd - >/dev/null
grep -x 'systemd-sysusers /usr/local/lib/sysusers.d/meniscus.conf' "$stage/noted/commands"
grep -x 'systemd-tmpfiles --create /usr/local/lib/tmpfiles.d/meniscus.conf' "$stage/noted/commands"
grep -x 'ldconfig ' "$stage/noted/commands"
make -s BUILD="$stage/none" uninstall
left=$(find /usr/local \( -type f -o -type l -o -name '*meniscus*' \))
echo "$left"
[ -z "$left" ]
SH
export stage BUILD
for how in "-m" "-rm"; do
    # shellcheck disable=SC2086 # words
    if unshare $how mount -t tmpfs none /usr/local 2>/dev/null; then break; fi
    how=
done
if [ -n "$how" ]; then
    # shellcheck disable=SC2086
    expect "by default Python finds it, services have their user and directories, and it goes away again" unshare $how bash "$stage/local.sh"
else
    echo "ok - by default Python finds it # SKIP this user may not mount a file system of its own"
fi
exit "$failed"
