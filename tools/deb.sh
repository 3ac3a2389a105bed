#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# deb.sh: a Debian package of what was built, in $BUILD. What is in it is what install.sh puts there; debhelper strips,
# compresses, finds out on which packages it depends, and writes the scripts that make the user and the directories. Who maintains it is in
# DEBFULLNAME and DEBEMAIL, as Debian's own tools have it; else who made the last commit, so that it is the same on any machine.
set -eu
cd "$(dirname "$0")/.."
BUILD=${BUILD:-build} VERSION=${VERSION:?}
author() { git log -1 --format="$1" 2>/dev/null | grep . || echo "$2"; }
who=${DEBFULLNAME:-$(author %an "The Meniscus authors")}
mail=${DEBEMAIL:-$(author %ae authors@meniscus.invalid)}
# The same sources make the same bytes.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH DH_QUIET=1 LC_ALL=C.UTF-8

top=$PWD out=$(cd "$BUILD" && pwd)
modules=$out/web/node_modules
rm -rf "$out/deb"
mkdir -p "$out/deb/debian"
LIBDIR=/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)
export LIBDIR
DESTDIR=$out/deb/debian/meniscus PREFIX=/usr tools/install.sh install
cd "$out/deb"
# paragraph FILES LICENCES FILE...: of debian/copyright. The files have a line of copyright and then the licence, of which the last one's is shown.
paragraph() {
    local files=$1 licences=$2
    shift 2
    printf '\nFiles: %s\nCopyright: %s\nLicense: %s\n' "$files" "$(sed -nE 's/^Copyright (\(c\)|©) //p' "$@" | sed '2,$s/^/ /')" "$licences"
    sed -e '1,/^Copyright/d' -e 's/^$/./' -e 's/^/ /' "${@: -1}" | sed '1{/^ \.$/d}'
}
# Debian has a place of its own for licences.
rm debian/meniscus/usr/share/doc/meniscus/LICENSE
{
    echo 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/'
    paragraph '*' BSD-3-Clause "$top/LICENSE"
    # The dashboard's page has both inside.
    [ ! -f "$out/meniscus-dashboard" ] || paragraph usr/bin/meniscus-dashboard 'BSD-3-Clause and Expat' "$top/LICENSE" "$modules/uplot/LICENSE" "$modules/three/LICENSE"
} >debian/copyright
sed "s|@maintainer@|$who <$mail>|" "$top/systemd/debian/control" >debian/control
cat >debian/changelog <<CHANGELOG
meniscus ($VERSION-1) unstable; urgency=medium

  * As CHANGELOG.md has it.

 -- $who <$mail>  $(date -R -u -d "@$SOURCE_DATE_EPOCH")
CHANGELOG
cp "$top/systemd/meniscus.sysusers" debian/meniscus.sysusers
dh_installdocs
dh_installchangelogs
dh_installsysusers
dh_installtmpfiles
# Instances are started by name, by whoever wants one.
dh_installsystemd --no-enable --no-start --no-restart-on-upgrade
dh_compress -X.md -X.conf
dh_fixperms
dh_strip --no-automatic-dbgsym
dh_makeshlibs -V
dh_shlibdeps
dh_installdeb
dh_gencontrol
dh_md5sums
dh_builddeb --destdir="$out"
ls -1 "$out"/meniscus_"$VERSION"-1_*.deb
