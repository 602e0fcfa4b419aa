#!/bin/sh
# Installs what building and running terrane needs and this machine lacks; with nothing missing it does nothing.
# usage: install.sh [validation] [readers]
#   validation  the Vulkan validation layers too, which the tests run under, and a desktop that nobody sees, for those of the viewer
#   readers     what the long tests fetch programs of other makes with, too
set -eu

wanted=" $* "
wants() { case $wanted in *" $1 "*) true ;; *) false ;; esac; }

tools='cmake ninja c++ python3 pkg-config'
! wants readers || tools="$tools node npm"

say() { printf '%s\n' "$*" >&2; }

if ! command -v cargo >/dev/null; then
    say 'terrane needs Rust 1.95 or newer, and cargo is not in the PATH. Install it from https://rustup.rs, then open a new shell.'
    exit 1
fi

# On systems other than Debian's family: says what to install, if anything seems to be missing.
advise() {
    if [ "$(uname)" = Darwin ]; then
        say 'macOS is not supported yet; use Linux with a Vulkan 1.3 driver, in a virtual machine for example.'
        exit 1
    fi
    missing=
    for tool in $tools; do
        command -v "$tool" >/dev/null || missing="$missing $tool"
    done
    if command -v ldconfig >/dev/null && ! ldconfig -p | grep -q 'libvulkan\.so\.1'; then
        missing="$missing the-Vulkan-loader"
    fi
    [ -n "$missing" ] || return 0
    say "terrane needs these, and they are not here:$missing. Install them, with a Vulkan 1.3 driver, by one of"
    say "  Fedora  sudo dnf install cmake ninja-build gcc-c++ python3 pkgconf-pkg-config vulkan-loader mesa-vulkan-drivers${1:+ vulkan-validation-layers}"
    say "  Arch    sudo pacman -S cmake ninja gcc python pkgconf vulkan-icd-loader vulkan-swrast${1:+ vulkan-validation-layers}"
    say 'or by the like of it on your system, and run this again.'
    exit 1
}

if ! command -v apt-get >/dev/null; then
    advise "$@"
    exit 0
fi

installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

missing=
need_tool() { command -v "$1" >/dev/null || missing="$missing $2"; }
need_package() { installed "$1" || missing="$missing $1"; }

need_tool cmake cmake
need_tool ninja ninja-build
need_tool c++ g++
need_tool python3 python3
need_tool pkg-config pkg-config
need_package libvulkan1
# Brings lavapipe, the driver that needs no graphics card.
need_package mesa-vulkan-drivers
if wants validation; then
    need_package vulkan-validationlayers
    need_tool Xvfb xvfb
    need_tool openbox openbox
    need_tool xdotool xdotool
fi
# What windows are made with, where there is a display.
need_package libxkbcommon-x11-0
need_package libxcursor1
need_package libxi6
need_package libx11-xcb1
if wants readers; then
    need_tool node nodejs
    need_tool npm npm
    python3 -c 'import ensurepip' 2>/dev/null || missing="$missing python3-venv"
fi
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root() { env DEBIAN_FRONTEND=noninteractive "$@"; }
# Without a terminal nobody can type a password.
elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
    as_root() { sudo env DEBIAN_FRONTEND=noninteractive "$@"; }
else
    say 'Some packages are missing, and only root may install them. Let someone who may run'
    say "  apt-get update && apt-get install$missing"
    say 'then run this again.'
    exit 1
fi

has_candidates() {
    for package in $missing; do
        apt-cache policy "$package" 2>/dev/null | grep -q 'Candidate: [^(]' || return 1
    done
}

# shellcheck disable=SC2086  # a list of names
install() { as_root apt-get install -y -q --no-install-recommends $missing; }

say "Installing$missing"
has_candidates || as_root apt-get update -q
# Lists that are there may be too old to be served.
install || { as_root apt-get update -q && install; }
