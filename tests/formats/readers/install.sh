#!/bin/sh
# Puts readers of other makes into a folder: OpenImageIO, rasterio (GDAL) and trimesh (which wants Pillow for materials)
# from PyPI, the Khronos glTF validator from npm.
# usage: install.sh FOLDER
set -eu

here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
cd "$1"
[ -d python ] || python3 -m venv python
python/bin/pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"
cp "$here/package.json" .
npm install --silent --no-audit --no-fund --no-package-lock --prefer-offline
