#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# install.sh install|uninstall: put what was built below $DESTDIR$PREFIX, or take the same files away again. One list serves
# both, so uninstall leaves nothing behind; it needs no build for that. $LIBDIR is for distributions that keep libraries elsewhere than in
# $PREFIX/lib.
set -eu
cd "$(dirname "$0")/.."
BUILD=${BUILD:-build} PREFIX=${PREFIX:-/usr/local} DESTDIR=${DESTDIR:-} VERSION=${VERSION:?}
case ${1:-} in
install | uninstall) action=$1 ;;
*)
    echo "usage: install.sh install|uninstall" >&2
    exit 64
    ;;
esac

bin=$PREFIX/bin lib=${LIBDIR:-$PREFIX/lib} share=$PREFIX/share/meniscus doc=$PREFIX/share/doc/meniscus
# Where python3 looks, which is called otherwise in /usr/local than in /usr; below any other prefix it has to be told.
places=$(/usr/bin/python3 -I -c 'import site; print(*site.getsitepackages(), sep="\n")' 2>/dev/null || true)
python=$(grep -m 1 "^$PREFIX/lib/" <<<"$places" || echo "$PREFIX/lib/python3/dist-packages")/meniscus
units=$PREFIX/lib/systemd/system sysusers=$PREFIX/lib/sysusers.d tmpfiles=$PREFIX/lib/tmpfiles.d
if [ "$PREFIX" = /usr ]; then
    # The distribution says where its own packages put these.
    units=$(pkg-config --variable=systemdsystemunitdir systemd 2>/dev/null || echo "$units")
    sysusers=$(pkg-config --variable=sysusersdir systemd 2>/dev/null || echo "$sysusers")
    tmpfiles=$(pkg-config --variable=tmpfilesdir systemd 2>/dev/null || echo "$tmpfiles")
fi

# put MODE FILE TARGET
put() {
    if [ "$action" = install ]; then
        install -D -m "$1" "$2" "$DESTDIR$3"
    else
        rm -f "$DESTDIR$3"
    fi
}

# fill FILE TARGET: put a template, its @words@ replaced.
fill() {
    local filled
    filled=$(mktemp)
    sed -e "s|@bindir@|$bin|g" -e "s|@docdir@|$doc|g" -e "s|@share@|$share|g" -e "s|@prefix@|$PREFIX|g" -e "s|@libdir@|${lib/#$PREFIX/\$\{prefix\}}|g" -e "s|@version@|$VERSION|g" \
        -e "s|@hypre@|$hypre|g" "$1" >"$filled"
    put 644 "$filled" "$2"
    rm -f "$filled"
}

# document FILE NAME: a page, whose links lead to other pages that are installed; those to what is not are only words then.
document() {
    local page
    if [ "$action" = uninstall ]; then
        put 644 "$1" "$doc/$2"
        return
    fi
    page=$(mktemp)
    sed -E -e "s#(\]\()[./]*(client/)?(dashboard|python|workflows)/README\.md#\1\3.md#g" -e "s#(\]\()(\.\./)*server/http/README\.md#\1http.md#g" \
        -e "s#(\]\()(client/|\.\./)README\.md#\1client.md#g" -e "s#(\]\()proto/README\.md#\1protocol.md#g" \
        -e "s#(\]\()server/cases/REFERENCE\.md#\1case-reference.md#g" -e "s#(\]\()(\.\./(sim/)?|server/sim/)schemes/README\.md#\1schemes.md#g" \
        -e "s#(\]\(|src=\")client/pictures/#\1pictures/#g" -e "s#\]\((workflows/)?([A-Za-z_.-]+\.(py|sh|json|service|timer)|Makefile|Snakefile)\)#](../../meniscus/workflows/\2)#g" \
        -e "s#\[([^]]*)\]\((\.\./)*(tests/[A-Za-z/_.]*|CONTRIBUTING\.md|DECISIONS\.md)\)#\1#g" "$1" >"$page"
    put 644 "$page" "$doc/$2"
    rm -f "$page"
}

# link TARGET NAME
link() {
    if [ "$action" = install ]; then ln -sf "$1" "$DESTDIR$2"; else rm -f "$DESTDIR$2"; fi
}

hypre=$(MAKEFLAGS='' make -s --no-print-directory BUILD="$BUILD" solver-libs)
put 755 "$BUILD/meniscusd" "$bin/meniscusd"
put 755 "$BUILD/meniscus" "$bin/meniscus"
# Where it was built; what is not there is not missed when it is taken away.
if [ -f "$BUILD/meniscus-dashboard" ] || [ "$action" = uninstall ]; then
    put 755 "$BUILD/meniscus-dashboard" "$bin/meniscus-dashboard"
    put 644 "$BUILD/man/meniscus-dashboard.8" "$PREFIX/share/man/man8/meniscus-dashboard.8"
    fill systemd/meniscus-dashboard@.service "$units/meniscus-dashboard@.service"
fi
# Shells look for these by the name of the program.
completion() {
    local text
    text=$(mktemp)
    if [ "$action" = install ]; then "$BUILD/meniscus" completion "$1" >"$text"; fi
    put 644 "$text" "$2"
    rm -f "$text"
}
completion bash "$PREFIX/share/bash-completion/completions/meniscus"
for program in meniscusd meniscus-dashboard; do link meniscus "$PREFIX/share/bash-completion/completions/$program"; done
completion zsh "$PREFIX/share/zsh/site-functions/_meniscus"
for page in meniscus.1 meniscusd.8 meniscus-case.5; do put 644 "$BUILD/man/$page" "$PREFIX/share/man/man${page##*.}/$page"; done
put 644 "$BUILD/shipped/libmeniscus.a" "$lib/libmeniscus.a"
put 644 "$BUILD/shipped/libmeniscus-client.a" "$lib/libmeniscus-client.a"
put 755 "$BUILD/libmeniscus-client.so" "$lib/libmeniscus-client.so.$VERSION"
link "libmeniscus-client.so.$VERSION" "$lib/libmeniscus-client.so.${VERSION%%.*}"
link "libmeniscus-client.so.${VERSION%%.*}" "$lib/libmeniscus-client.so"
fill tools/meniscus.pc.in "$lib/pkgconfig/meniscus.pc"
fill tools/meniscus-client.pc.in "$lib/pkgconfig/meniscus-client.pc"
for file in include/meniscus/*.h; do put 644 "$file" "$PREFIX/$file"; done
for file in server/cases/*.yaml; do put 644 "$file" "$share/cases/${file##*/}"; done
for file in server/monitoring/*; do put 644 "$file" "$share/monitoring/${file##*/}"; done
for file in proto/*.proto; do put 644 "$file" "$share/${file}"; done
for file in CHANGELOG.md LICENSE systemd/meniscus.conf; do put 644 "$file" "$doc/${file##*/}"; done
for file in client/workflows/*.py client/workflows/*.sh; do put 755 "$file" "$share/workflows/${file##*/}"; done
for file in client/workflows/Makefile client/workflows/Snakefile client/workflows/*.json; do put 644 "$file" "$share/workflows/${file##*/}"; done
for file in client/workflows/*.service client/workflows/*.timer; do fill "$file" "$share/workflows/${file##*/}"; done
for file in README.md ARCHITECTURE.md; do document "$file" "$file"; done
for page in dashboard python workflows; do document "client/$page/README.md" "$page.md"; done
document client/README.md client.md
document proto/README.md protocol.md
document server/http/README.md http.md
document server/sim/schemes/README.md schemes.md
for file in server/sim/schemes/*.c; do document "${file%.c}.md" "$(basename "$file" .c).md"; done # each scheme has a page beside it
document "$BUILD/case-reference.md" case-reference.md
for file in client/pictures/*.png; do put 644 "$file" "$doc/pictures/${file##*/}"; done
for file in client/python/examples/*.ipynb; do put 644 "$file" "$share/notebooks/${file##*/}"; done
if [ "$action" = install ]; then
    for file in "$BUILD"/python/meniscus/*.py* "$BUILD/python/meniscus/py.typed"; do put 644 "$file" "$python/${file##*/}"; done
else
    rm -rf "$DESTDIR${python:?}" # what modules there are only a build knows
fi
fill systemd/meniscusd@.service "$units/meniscusd@.service"
put 644 systemd/meniscus.sysusers "$sysusers/meniscus.conf"
put 644 systemd/meniscus.tmpfiles "$tmpfiles/meniscus.conf"

if [ "$action" = uninstall ]; then
    # Directories of our own go too, once they are empty; those that others share stay.
    for directory in "$PREFIX/include/meniscus" "$share/cases" "$share/monitoring" "$share/proto" "$share/workflows/__pycache__" "$share/workflows" "$share/notebooks" "$share" "$doc/pictures" "$doc"; do
        case $directory in */__pycache__) rm -rf "$DESTDIR${directory:?}" ;; esac
        if [ -d "$DESTDIR$directory" ]; then rmdir --ignore-fail-on-non-empty "$DESTDIR$directory"; fi
    done
fi

# What a package's scripts do otherwise: the user, the directories, and that libraries and units are found. Of other prefixes systemd knows nothing.
if [ "$action$DESTDIR" = install ] && { [ "$PREFIX" = /usr ] || [ "$PREFIX" = /usr/local ]; }; then
    after=("systemd-sysusers $sysusers/meniscus.conf" "systemd-tmpfiles --create $tmpfiles/meniscus.conf" ldconfig)
    if [ -d /run/systemd/system ]; then after+=("systemctl daemon-reload"); fi
    for command in "${after[@]}"; do
        # shellcheck disable=SC2086 # words
        if [ "$(id -u)" != 0 ] || ! $command; then echo "still to be done by root: $command" >&2; fi
    done
fi
