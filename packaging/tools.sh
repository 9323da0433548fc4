# SPDX-License-Identifier: Apache-2.0
# What scripts/wheel and scripts/blenderExtension share, sourced by both after scripts/setup.sh: their tools in
# build/wheelTools/venv, and the image library of PyPI, as it came in build/wheelTools/download and for CMake in
# build/wheelTools/openimageio.
# shellcheck shell=bash

tools=$root/build/wheelTools
python=$tools/venv/bin/python
imageLibrary=3.2.2.0 # of PyPI: its libraries carry this version in their names

MakeTools() {
    Say "preparing the tools and the image library in build/wheelTools"
    rm -rf "$tools"
    mkdir -p "$tools"
    Step wheelVenv "$systemPython" -m venv "$tools/venv"
    Step wheelPip "$python" -m pip install --disable-pip-version-check -r "$root/packaging/requirements.txt"
    local download=("$python" -m pip download --disable-pip-version-check --no-deps --dest "$tools/download")
    Step wheelLibrary "${download[@]}" --only-binary :all: "openimageio==$imageLibrary"
    # --no-build-isolation: pip asks a source archive for its name, and what that needs is in our environment.
    Step wheelHeaders "${download[@]}" --no-binary :all: --no-build-isolation "openimageio==$imageLibrary"
    Step wheelStage "$python" "$root/packaging/stageImageLibrary.py" "$tools/download/"openimageio-*.whl \
        "$tools/download/"openimageio-*.tar.gz "$tools/openimageio"
    echo "$1" >"$tools/stamp"
}

# PrepareTools: system packages and tools, as far as they are missing. Runs of several processes take turns until the end.
PrepareTools() {
    mkdir -p "$state"
    exec 9>"$state/lock"
    flock 9
    CheckSystem
    InstallPackages
    local stamp
    stamp=$(cat "$root/packaging/"{tools.sh,requirements.txt,stageImageLibrary.py} | sha256sum)
    [ "$(cat "$tools/stamp" 2>/dev/null)" = "$stamp" ] || MakeTools "$stamp"
}
