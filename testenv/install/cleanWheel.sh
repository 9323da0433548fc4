#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# cleanWheel.sh FOLDER WHEEL: proves a wheel of scripts/wheel on a machine with nothing but python3. Makes such a
# machine as a chroot in FOLDER, installs the wheel there with pip and renders a first picture, with empty caches.
# Prints the wall time of both steps. Needs root and debootstrap. From the environment: as cleanMachine.sh.
set -euo pipefail
folder=$1 wheel=$2
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
suite=${SUITE:-bookworm} mirror=${MIRROR:-http://deb.debian.org/debian} components=${COMPONENTS:-main}

if [ -z "${KEEP:-}" ]; then
    debootstrap --variant=minbase --components="$components" --include=ca-certificates,python3-venv \
        "$suite" "$folder" "$mirror" >"$folder.debootstrap.log"
fi
for file in /etc/hosts /etc/resolv.conf /etc/pip.conf /usr/local/share/ca-certificates ${CARRY:-}; do
    if [ -e "$file" ]; then
        mkdir -p "$folder$(dirname "$file")"
        cp -rL -T "$file" "$folder$file"
    fi
done
trap 'umount -l "$folder/proc" "$folder/dev"' EXIT
mount -t proc proc "$folder/proc"
mount --rbind /dev "$folder/dev"
mount --make-rslave "$folder/dev"

rm -rf "$folder/srv/wheel"
mkdir -p "$folder/srv/wheel"
cp "$wheel" "$here/first.usda" "$folder/srv/wheel/"
In() {
    env -i HOME=/srv/wheel LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
        ${PIP_DEFAULT_TIMEOUT:+PIP_DEFAULT_TIMEOUT=$PIP_DEFAULT_TIMEOUT} chroot "$folder" "$@"
}
Timed() {
    local start=$SECONDS code=0
    echo "== $*"
    In "$@" </dev/null || code=$?
    echo "== exit code $code after $((SECONDS - start)) s"
    return $code
}
In update-ca-certificates >/dev/null
# shellcheck source=/dev/null
echo "== $(. "$folder/etc/os-release" && echo "$PRETTY_NAME"), $(In dpkg-query -W | wc -l) packages, $(nproc) cores"
if In sh -c 'command -v cc c++ ld pip; ls /etc/OpenCL 2>/dev/null'; then
    echo "this machine is not clean" >&2
    exit 1
fi
bin=/srv/wheel/venv/bin
In python3 -m venv /srv/wheel/venv
Timed $bin/pip --disable-pip-version-check --no-cache-dir download -q --dest /srv/wheel/download \
    "/srv/wheel/$(basename "$wheel")"
Timed $bin/pip --disable-pip-version-check install -q --no-index --find-links /srv/wheel/download hdstream
Timed $bin/hdstream devices
Timed $bin/hdstream record /srv/wheel/first.usda /srv/wheel/first.exr --camera /Camera --imageWidth 480 --samples 16 --quiet
Timed $bin/hdstream record /srv/wheel/first.usda /srv/wheel/first.png --camera /Camera --imageWidth 480 --samples 16 --quiet
