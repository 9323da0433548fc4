#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# cleanMachine.sh FOLDER: proves both README commands on a machine with nothing but git, python3 and
# apt. Makes such a machine as a chroot in FOLDER, clones this repository into it, and runs
# scripts/render twice and .ci/run there, with empty caches. Needs root and debootstrap.
#
# From the environment:
#   SUITE=bookworm MIRROR=http://deb.debian.org/debian COMPONENTS=main   what is installed
#   CARRY="/etc/..."   further files of this machine to copy, e.g. of its package mirrors
#   KEEP=1             use the system that FOLDER already holds
set -euo pipefail
repository=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.." && pwd -P)
folder=$1
suite=${SUITE:-bookworm} mirror=${MIRROR:-http://deb.debian.org/debian} components=${COMPONENTS:-main}

if [ -z "${KEEP:-}" ]; then
    debootstrap --variant=minbase --components="$components" --include=ca-certificates,git,python3 \
        "$suite" "$folder" "$mirror" >"$folder.debootstrap.log"
fi
# How this machine reaches the network, and nothing else of it.
for file in /etc/hosts /etc/resolv.conf /etc/pip.conf /usr/local/share/ca-certificates ${CARRY:-}; do
    if [ -e "$file" ]; then
        mkdir -p "$folder$(dirname "$file")"
        cp -rL -T "$file" "$folder$file"
    fi
done
trap 'umount -l "$folder/proc" "$folder/sys" "$folder/dev"' EXIT
mount -t proc proc "$folder/proc"
mount -t sysfs sys "$folder/sys"
mount --rbind /dev "$folder/dev"
mount --make-rslave "$folder/dev"

rm -rf "$folder/srv/hdStream" "$folder/srv/.cache"
git clone -q "$repository" "$folder/srv/hdStream"
In() {
    env -i HOME=/srv LANG=C.UTF-8 PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin CI=true \
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
if In sh -c 'command -v c++ cmake ninja pip'; then
    echo "this machine is not clean" >&2
    exit 1
fi
Timed /srv/hdStream/scripts/render
Timed /srv/hdStream/scripts/render
Timed bash /srv/hdStream/.ci/run
