#!/bin/sh
# Puts a newer Mesa beside the system's: lavapipe of Debian's backports, which traces rays by itself (VK_KHR_ray_query), where the
# Mesa of Debian 12 does not. Nothing is installed: packages are unpacked into a folder.
# usage: mesa_newer.sh FOLDER; then run what you like with VK_DRIVER_FILES=FOLDER/lavapipe.json before it
set -eu

if [ $# -ne 1 ]; then
    echo 'usage: mesa_newer.sh FOLDER' >&2
    exit 2
fi
for tool in curl xz dpkg-deb; do
    if ! command -v "$tool" >/dev/null; then
        echo "mesa_newer.sh needs $tool (Debian and Ubuntu: apt install curl xz-utils dpkg)" >&2
        exit 1
    fi
done
mkdir -p "$1"
folder=$(cd "$1" && pwd)
mirror=${DEBIAN_MIRROR:-https://deb.debian.org/debian}
index=$mirror/dists/bookworm-backports/main/binary-amd64/Packages.xz

# Path and checksum of a package, as the index has them.
curl -fsSL "$index" | xz -d | awk '
    $1 == "Package:" { here = $2 == "mesa-vulkan-drivers" }
    here && ($1 == "Filename:" || $1 == "SHA256:") { print $2 }' > "$folder/package"
{ read -r path; read -r sum; } < "$folder/package"
curl -fsSL "$mirror/$path" -o "$folder/package.deb"
echo "$sum  $folder/package.deb" | sha256sum --check --quiet
dpkg-deb -x "$folder/package.deb" "$folder/root"
library=$folder/root/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so
if ldd "$library" | grep 'not found' >&2; then
    echo 'these libraries are missing (Debian 12: apt install libllvm15 libdrm-amdgpu1 libxcb-dri3-0 libxcb-present0)' >&2
    exit 1
fi
printf '{"file_format_version": "1.0.0", "ICD": {"library_path": "%s", "api_version": "1.3.0"}}\n' "$library" \
    > "$folder/lavapipe.json"
rm "$folder/package" "$folder/package.deb"
echo "VK_DRIVER_FILES=$folder/lavapipe.json"
