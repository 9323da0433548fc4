# SPDX-License-Identifier: Apache-2.0
# The set-up that scripts/render and scripts/test share, sourced by both: system packages, a private
# Python in .venv, the configured and built tree in build/release.
# Steps run once: .setup/stamp holds a hash of all that decides them. Each keeps its log in .setup/.
# Explained in docs/building.md.
# shellcheck shell=bash

root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd -P)
state=$root/.setup
build=$root/build/release
# Debian's python3-dev belongs to this interpreter, whatever else PATH holds.
systemPython=/usr/bin/python3
[ -x "$systemPython" ] || systemPython=$(command -v python3 || true)

packages=(
    g++ cmake ninja-build python3-dev python3-venv
    pocl-opencl-icd ocl-icd-opencl-dev
    libopenimageio-dev openimageio-tools # the tools only because OpenImageIO's CMake file insists on them
    libopencolorio-dev libopenvdb-dev libboost-dev libosd-dev libtbb-dev libglm-dev nlohmann-json3-dev libgtest-dev
)

Say() { echo "hdStream: $*" >&2; }
Fail() { Say "$*"; exit 1; }

# Step LOG COMMAND...: runs a command quietly; on failure shows the end of its log and stops.
Step() {
    local log=$state/$1.log
    shift
    if ! "$@" >"$log" 2>&1 </dev/null; then
        tail -n 15 "$log" >&2
        Fail "set-up failed; the full log is $log"
    fi
}

CheckSystem() {
    [ -n "$systemPython" ] || Fail "python3 is missing"
    if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
        local tool missing=()
        for tool in c++ cmake ninja; do
            command -v "$tool" >/dev/null || missing+=("$tool")
        done
        [ ${#missing[@]} = 0 ] ||
            Fail "no apt-get here, and missing: ${missing[*]}; docs/building.md lists all requirements"
    fi
}

MissingPackages() {
    command -v dpkg-query >/dev/null || return 0
    local installed package
    # dpkg-query exits with 1 when it does not know one of them.
    installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null || true)
    for package in "${packages[@]}"; do
        grep -qxF "installed $package" <<<"$installed" || echo "$package"
    done
}

InstallPackages() {
    local missing asRoot=()
    mapfile -t missing < <(MissingPackages)
    [ ${#missing[@]} = 0 ] && return
    if [ "$(id -u)" != 0 ]; then
        asRoot=(sudo -n)
        sudo -n true 2>/dev/null ||
            Fail "missing packages and no root; run: sudo apt-get install --no-install-recommends ${missing[*]}"
    fi
    missing+=(ccache) # not needed: a machine that has all the others is asked for nothing
    Say "installing ${#missing[@]} system packages with apt-get (about 3 minutes, up to 300 MB)"
    local apt=("${asRoot[@]}" env DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a
               apt-get -y -q -o DPkg::Lock::Timeout=600 -o Acquire::Retries=3)
    # A broken source of somebody else is no reason to stop: the installation tells.
    "${apt[@]}" update >"$state/aptUpdate.log" 2>&1 </dev/null || true
    # --no-remove: another OpenCL loader or driver of the user's must not be replaced.
    Step apt "${apt[@]}" install --no-install-recommends --no-remove "${missing[@]}"
}

InstallPython() {
    local version='import sys; print(sys.version_info[:2])'
    if [ "$("$root/.venv/bin/python" -c "$version" 2>/dev/null)" != "$("$systemPython" -c "$version")" ]; then
        Step venv "$systemPython" -m venv --clear "$root/.venv"
    fi
    Say "installing the Python packages of scripts/requirements.txt into .venv (about 1 minute)"
    Step pip "$root/.venv/bin/python" -m pip install --disable-pip-version-check -r "$root/scripts/requirements.txt"
    # `.venv/bin/python -m hdstream` finds the build from any folder.
    "$root/.venv/bin/python" -c 'import pathlib, sys, sysconfig
pathlib.Path(sysconfig.get_path("purelib"), "hdstream.pth").write_text(sys.argv[1] + "\n")' "$build/python"
}

# What any tree of this machine has compiled is not compiled again, where ccache is installed: neither by another checkout
# nor by the wheel that testenv/install builds.
UseCompilerCache() {
    if command -v ccache >/dev/null; then
        export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
        export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$root} CCACHE_NOHASHDIR=1
    fi
}

Configure() {
    # A tree that was moved or copied: its build folder names the old place.
    if [ -f "$build/CMakeCache.txt" ] &&
       ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$build/CMakeCache.txt"; then
        rm -rf "$build"
    fi
    Step configure cmake -S "$root" --preset release "-DPython_EXECUTABLE=$root/.venv/bin/python" \
        "-DPython3_EXECUTABLE=$root/.venv/bin/python"
}

# What decides the set-up: these files, the system's release and the place of the tree.
StampValue() {
    { cat "$root/scripts/setup.sh" "$root/scripts/requirements.txt" "$root/CMakePresets.json" /etc/os-release
      echo "$root"; } | sha256sum
}

# Copies ninja's output to the log and announces a build that has something to do.
Announce() {
    local line steps announced=
    while IFS= read -r line; do
        printf '%s\n' "$line"
        if [ -z "$announced" ] && [[ $line =~ ^\[[0-9]+/([0-9]+)\] ]] && [ "${BASH_REMATCH[1]}" -gt 2 ]; then
            announced=yes steps=${BASH_REMATCH[1]}
            Say "building, $steps steps (about $((steps * 2 / $(nproc) / 60 + 1)) minutes)"
        fi
    done
}

# Build TARGET: brings a target up to date; about 0.1 s when it is.
Build() {
    if ! ninja -C "$build" "$1" </dev/null 2>&1 | Announce >"$state/build.log"; then
        grep -E -A 12 'FAILED|CMake Error|error:' "$state/build.log" | cut -c1-300 | head -n 40 >&2 || true
        Fail "the build failed; the full log is $state/build.log"
    fi
}

# Compiles the kernels that most scenes need into the user's cache, so that no first render waits for them (docs/device.md).
# Where there is no device this fails, and renders say why.
PrepareKernels() {
    local value
    value=$({ find "$root/kernels" "$root/hdStream/integrator" -type f -print0 | sort -z | xargs -0 sha256sum; } | sha256sum)
    [ "$(cat "$state/kernels" 2>/dev/null)" = "$value" ] && return
    Say "compiling kernels for this machine (about half a minute)"
    if "$root/.venv/bin/python" -m hdstream cache --kernels >"$state/kernels.log" 2>&1 </dev/null; then
        echo "$value" >"$state/kernels"
    fi
}

# SetUp TARGET: all of the above, as far as it is needed. Runs of several processes take turns.
SetUp() {
    mkdir -p "$state" || Fail "cannot write to $root"
    exec 9>"$state/lock"
    flock 9
    local stamp
    stamp=$(StampValue)
    if [ "$(cat "$state/stamp" 2>/dev/null)" != "$stamp" ] || [ ! -x "$root/.venv/bin/python" ] ||
       [ ! -f "$build/build.ninja" ]; then
        CheckSystem
        InstallPackages
        InstallPython
        UseCompilerCache
        Configure
        echo "$stamp" >"$state/stamp"
    fi
    UseCompilerCache
    Build "$1"
    PrepareKernels
    exec 9>&-
}
