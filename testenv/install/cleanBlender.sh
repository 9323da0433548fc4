#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# cleanBlender.sh FOLDER PREFIX BPY: proves Blender's extension from nothing. Makes two bare machines as chroots in FOLDER. In
# the first one, which has git, python3 and apt, scripts/blenderExtension makes the zip from a clone of this repository; PREFIX
# is an OpenUSD as docs/blender.md asks for, which is copied to the same place there, with the libraries of Blender that its
# pxrConfig.cmake names. In the second one, which has no compiler and no OpenCL, BPY (a requirement of PyPI's Blender, such as
# bpy==4.5.15) is installed, takes the zip as *Install from Disk* does, and renders FOLDER/first.png. Prints the wall time of each
# step. What it reads of the environment: cleanSystem.sh, and
#   CCACHE=FOLDER      a compiler cache of this machine for the first one (default: none), and CCACHE_BASEDIR
#   PLACE=/srv/hdStream   of the clone: where it is that of this tree, the cache knows the same names
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=testenv/install/cleanSystem.sh
source "$here/cleanSystem.sh"
repository=$(cd "$here/../.." && pwd -P)
all=$(realpath -m "$1") prefix=$(realpath "$2") bpy=$3
# What Blender itself asks of a system: a window's libraries, which the module is linked with too.
blenders=libx11-6,libxrender1,libxfixes3,libxi6,libxkbcommon0,libsm6,libice6,libxext6,libgl1,libegl1
place=${PLACE:-/srv/hdStream}
mkdir -p "$all"

MakeSystem "$all/build" git,python3
HasNone c++ cmake ninja pip
rm -rf "${folder:?}$place" "$folder/srv/.cache" "${folder:?}$prefix"
mkdir -p "$(dirname "$folder$place")"
git clone -q "$repository" "$folder$place"
mkdir -p "$folder$prefix"
cp -r -T "$prefix" "$folder$prefix"
library=$(grep -ohE '/[^" ;)]*/libusd_ms\.so' "$prefix/pxrConfig.cmake" | head -n 1)
version=$(basename "$(dirname "$(ls -d "$(dirname "$library")"/../[0-9]*/scripts | head -n 1)")")
mkdir -p "$folder$(dirname "$library")/../$version/scripts"
cp "$(dirname "$library")"/*.so* "$folder$(dirname "$library")/"
if [ -n "${CCACHE:-}" ]; then
    mkdir -p "$folder/srv/.cache/ccache" "$CCACHE"
    mount --bind "$CCACHE" "$folder/srv/.cache/ccache"
fi
Timed "$place/scripts/blenderExtension" "$prefix" /srv/zip
cp "$folder"/srv/zip/*.zip "$all/"

MakeSystem "$all/use" "python3-venv,$blenders"
HasNone cc c++ ld
if [ -e "$folder/etc/OpenCL" ]; then
    echo "this machine has OpenCL" >&2
    exit 1
fi
rm -rf "$folder/srv/use" "$folder/srv/.cache"
mkdir -p "$folder/srv/use"
cp "$all/build"/srv/zip/*.zip "$here/firstBlender.py" "$folder/srv/use/"
In python3 -m venv /srv/use/venv
Timed /srv/use/venv/bin/pip --disable-pip-version-check --no-cache-dir install -q "$bpy"
Timed sh -c '/srv/use/venv/bin/python /srv/use/firstBlender.py /srv/use/*.zip /srv/use/first.png'
cp "$folder/srv/use/first.png" "$all/"
