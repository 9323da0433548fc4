#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# cleanWheel.sh FOLDER WHEEL: proves a wheel of scripts/wheel on a machine with nothing but python3. Makes such a
# machine as a chroot in FOLDER, installs the wheel there with pip and renders a first picture, with empty caches.
# Prints the wall time of each step. What it reads of the environment: cleanSystem.sh.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=testenv/install/cleanSystem.sh
source "$here/cleanSystem.sh"
wheel=$2
MakeSystem "$1" python3-venv
rm -rf "$folder/srv/wheel" "$folder/srv/.cache"
mkdir -p "$folder/srv/wheel"
cp "$wheel" "$here/first.usda" "$here/samePicture.py" "$folder/srv/wheel/"
HasNone cc c++ ld pip
if [ -e "$folder/etc/OpenCL" ]; then
    echo "this machine has OpenCL" >&2
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
Timed $bin/python /srv/wheel/samePicture.py /srv/wheel/first.exr /srv/wheel/first.png
