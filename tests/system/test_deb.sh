#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
# The Debian package has everything, Debian's own judge finds no error in it, and on a machine that is this one without what is built here it
# can be installed, used as its user, and removed. That machine is a file system laid over this one's, which only this test sees. Prints TAP.
# shellcheck disable=SC2317 # functions are called by expect()
set -eu
cd "$(dirname "$0")/../.."
BUILD=${BUILD:-build}
unset MAKEFLAGS MFLAGS MAKELEVEL
if [ "${1:-}" != inside ]; then
    # All that is mounted goes away with the namespace, and nothing is ever removed from below it.
    machine=$(mktemp -d)
    status=77
    for how in "-m --pid --fork --mount-proc" "-rm --pid --fork --mount-proc"; do
        # shellcheck disable=SC2086 # words
        unshare $how mount -t tmpfs none "$machine" 2>/dev/null || continue
        status=0
        # shellcheck disable=SC2086
        unshare $how tests/system/test_deb.sh inside "$machine" || status=$?
        break
    done
    rmdir "$machine"
    [ "$status" -ne 77 ] || echo "not ok - a package can be installed # SKIP this user may not mount a file system of its own"
    exit "$status"
fi
machine=$2
. tests/support/expect.sh

expect "make deb works" env -u DEBFULLNAME -u DEBEMAIL make -s BUILD="$BUILD" deb
deb=$(echo "$BUILD"/meniscus_*.deb)
maintainer() { dpkg-deb -f "$deb" Maintainer; }
expect "nobody of this machine is its maintainer" eval "! maintainer | grep -qi -e '^root' -e '@$(hostname)>'"
dpkg-deb -c "$deb" >"$stage/list"
for file in usr/bin/meniscusd usr/bin/meniscus usr/bin/meniscus-dashboard lib/systemd/system/meniscusd@.service usr/lib/sysusers.d/meniscus.conf \
    usr/lib/tmpfiles.d/meniscus.conf usr/share/bash-completion/completions/meniscus usr/share/zsh/site-functions/_meniscus \
    usr/share/man/man1/meniscus.1.gz usr/share/man/man8/meniscusd.8.gz usr/share/man/man8/meniscus-dashboard.8.gz \
    usr/share/meniscus/cases/dambreak2d.yaml usr/share/meniscus/workflows/Snakefile usr/share/doc/meniscus/copyright \
    usr/include/meniscus/client.h usr/lib/python3/dist-packages/meniscus/__init__.py; do
    expect "it has $file" grep -q " \./$file\$" "$stage/list"
done
notices() { dpkg-deb --fsys-tarfile "$deb" | tar -xO ./usr/share/doc/meniscus/copyright | grep -c -e '2010-.* three.js authors$' -e 'Leon Sorokin$'; }
expect "it names who wrote what the dashboard's page has inside" test "$(notices)" = 2
# Whoever installs nothing by hand can import the package; what it uses here and there is at least named.
cat >"$stage/uses.py" <<'PY'
import ast, importlib.util, pathlib, subprocess, sys

deb, package = sys.argv[1], pathlib.Path(sys.argv[2])
field = lambda name: subprocess.run(["dpkg-deb", "-f", deb, name], capture_output=True, text=True, check=True).stdout
pulled, named = field("Depends") + field("Recommends"), field("Suggests")
failed = False
for page in package.glob("*.py"):
    tree = ast.parse(page.read_text())
    hints = [n for at in tree.body if isinstance(at, ast.If) and "TYPE_CHECKING" in ast.unparse(at.test) for n in ast.walk(at)]
    for node in ast.walk(tree):
        if node in hints:
            continue
        names = [n.name for n in node.names] if isinstance(node, ast.Import) else [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
        for name in {n.split(".")[0] for n in names} - set(sys.stdlib_module_names) - {"meniscus"}:
            found = importlib.util.find_spec("google.protobuf" if name == "google" else name)
            if not found:
                continue  # one of several that would do
            owner = subprocess.run(["dpkg", "-S", found.origin], capture_output=True, text=True, check=True).stdout.split(":")[0].removesuffix("-serial")
            if owner not in pulled + ("" if node in tree.body else named):
                print(f"{page.name} imports {name} of {owner}")
                failed = True
sys.exit(failed)
PY
expect "what its Python package imports comes with it" /usr/bin/python3 "$stage/uses.py" "$deb" "$BUILD/python/meniscus"
expect "lintian finds no error in it" lintian --allow-root --fail-on error "$deb"

mount -t tmpfs none "$machine"
root=$machine/root
mkdir "$machine/changed" "$machine/work" "$root"
mount -t overlay overlay -o "lowerdir=/,upperdir=$machine/changed,workdir=$machine/work" "$root"
mount -t proc proc "$root/proc"
mount -t tmpfs none "$root/dev"
mknod -m 666 "$root/dev/null" c 1 3
mknod -m 666 "$root/dev/urandom" c 1 9
mkdir -m 1777 "$root/dev/shm"
ln -s /proc/self/fd "$root/dev/fd"
cp "$deb" "$root/meniscus.deb"
there() { chroot "$root" "$@"; }
expect "it can be installed" there dpkg -i /meniscus.deb
expect "its user was made" there id meniscus
expect "that user's directory too" there test "$(there stat -c %U:%a /var/lib/meniscus)" = meniscus:750
expect "man finds its pages" there man -w meniscus-dashboard

# As the unit does.
cat >"$root/use.sh" <<'SH'
set -eu
export XDG_RUNTIME_DIR=/run
meniscusd --state-dir /var/lib/meniscus/default &
until meniscus status >/dev/null 2>&1; do sleep 0.1; done
meniscus load hydrostatic --set resolution=8 --set end_time=0.02
meniscus start
meniscus wait --for state=DONE --timeout 60
python3 -c 'import meniscus; print(meniscus.Client().status().state)'
meniscus shutdown
wait
ls /var/lib/meniscus/default/*/snapshot-*.hdf
SH
expect "its user starts a daemon and runs a case that comes with it" there timeout 120 runuser -u meniscus -- bash /use.sh
expect "it can be removed" there dpkg -r meniscus
gone() {
    local left
    left=$(find "$machine/changed" -name '*meniscus*' -not -type c -not -path '*/changed/var/*' -not -path '*/changed/run/*' -not -name meniscus.deb \
        -not -path '*/changed/etc/meniscus')
    echo "$left"
    [ -z "$left" ]
}
expect "then nothing of it is left but what runs wrote and the directory of settings" gone
exit "$failed"
