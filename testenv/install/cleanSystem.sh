# SPDX-License-Identifier: Apache-2.0
# A bare system as a chroot, for cleanMachine.sh and cleanWheel.sh, sourced by both. Needs root and debootstrap.
#
# From the environment:
#   SUITE=bookworm MIRROR=http://deb.debian.org/debian COMPONENTS=main   what is installed
#   CARRY="/etc/..."   further files of this machine to copy, e.g. of its package mirrors
#   KEEP=1             use the system that the folder already holds
# shellcheck shell=bash

# Mounts are those of this script's processes alone and go with the last of them, however it ends. Where the machine saw
# them, one that was killed left its /dev in the folder, and who then removed the folder removed the machine's devices.
if [ -z "${HDSTREAM_OWN_MOUNTS:-}" ]; then
    exec env HDSTREAM_OWN_MOUNTS=1 unshare --mount --propagation private bash "$0" "$@"
fi

# MakeSystem FOLDER PACKAGES: the system, with proc, sys and dev of this machine for this script.
MakeSystem() {
    folder=$1
    local file
    if [ -z "${KEEP:-}" ]; then
        debootstrap --variant=minbase --components="${COMPONENTS:-main}" --include="ca-certificates,$2" \
            "${SUITE:-bookworm}" "$folder" "${MIRROR:-http://deb.debian.org/debian}" >"$folder.debootstrap.log"
    fi
    # How this machine reaches the network, and nothing else of it.
    for file in /etc/hosts /etc/resolv.conf /etc/pip.conf /usr/local/share/ca-certificates ${CARRY:-}; do
        if [ -e "$file" ]; then
            mkdir -p "$folder$(dirname "$file")"
            cp -rL -T "$file" "$folder$file"
        fi
    done
    mount -t proc proc "$folder/proc"
    mount -t sysfs sys "$folder/sys"
    mount --rbind /dev "$folder/dev"
    In update-ca-certificates >/dev/null
    # shellcheck source=/dev/null
    echo "== $(. "$folder/etc/os-release" && echo "$PRETTY_NAME"), $(In dpkg-query -W | wc -l) packages, $(nproc) cores"
}

# In COMMAND...: runs it there, at home in /srv.
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

# HasNone PROGRAM...: ends the script when one of them is there.
HasNone() {
    # shellcheck disable=SC2016
    if In sh -c 'for name; do command -v "$name" && exit 0; done; exit 1' sh "$@"; then
        echo "this machine is not clean" >&2
        exit 1
    fi
}
