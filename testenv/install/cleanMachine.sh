#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# cleanMachine.sh FOLDER: proves both README commands on a machine with nothing but git, python3 and
# apt. Makes such a machine as a chroot in FOLDER, clones this repository into it, and runs
# scripts/render twice and .ci/run there, with empty caches. What it reads of the environment: cleanSystem.sh.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=testenv/install/cleanSystem.sh
source "$here/cleanSystem.sh"
repository=$(cd "$here/../.." && pwd -P)
MakeSystem "$1" git,python3
rm -rf "$folder/srv/hdStream" "$folder/srv/.cache"
git clone -q "$repository" "$folder/srv/hdStream"
HasNone c++ cmake ninja pip
Timed /srv/hdStream/scripts/render
Timed /srv/hdStream/scripts/render
Timed bash /srv/hdStream/.ci/run
