"""Reads what `terrane export` wrote with OpenImageIO, GDAL and trimesh, and compares it with what was simulated.

usage: layers.py FOLDER     (as tests/formats/readers.rs fills it)
"""

import json
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import rasterio
import trimesh

FOLDER = Path(sys.argv[1])
CHANNELS = {"normal": 3, "splat": 4}


def sidecar(path):
    return json.loads(Path(f"{path}.json").read_text())


def read(path, kind):
    """Samples as (row, column, channel), and the names of the channels."""
    # Weights are in all four channels: none of them is to be multiplied by the last.
    plain = oiio.ImageSpec()
    plain.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(str(path), plain)
    assert file, oiio.geterror()
    assert str(file.spec().format) == kind, (path, file.spec().format)
    pixels = file.read_image(kind)
    names = list(file.spec().channelnames)
    file.close()
    return np.asarray(pixels).reshape(pixels.shape[0], pixels.shape[1], -1), names


def check(condition, *what):
    if not np.all(condition):
        sys.exit(f"readers disagree: {' '.join(map(str, what))}")


def check_integers(integers, floats, least, most, greatest, *what):
    """Integers are the floats to half a step, and a rounding or two."""
    step = (most - least) / greatest
    error = np.abs(least + integers.astype(np.float64) * step - floats).max()
    check(error <= 0.5 * step + 1e-6 * max(abs(least), abs(most)), *what, error, "for a step of", step)


def layers():
    """EXR against the simulation to the bit; every other format against EXR to its precision."""
    names = sorted(path.stem for path in (FOLDER / "exr").glob("*.exr"))
    check(len(names) == 11, names)
    for name in names:
        exact, channels = read(FOLDER / f"exr/{name}.exr", "float")
        check(channels == ([name] if name not in CHANNELS else list("RGBA")[: CHANNELS[name]]) or channels == ["Y"],
              name, channels)
        size = exact.shape[:2]
        simulated = FOLDER / f"simulated/{name}.f32"
        if simulated.exists():
            check(np.fromfile(simulated, "<f4").reshape(exact.shape) == exact, name, "is not what was simulated")

        with rasterio.open(FOLDER / f"tif/{name}.tif") as tif:
            check(np.moveaxis(tif.read(), 0, -1) == exact, name, "in TIFF")
            extent = sidecar(FOLDER / f"tif/{name}.tif")["extent"]
            cell = extent / (size[0] - 1)
            # GDAL places the corner of a pixel, half of one north-west of the sample.
            check(tif.transform * (0.5, 0.5) == (-extent / 2, extent / 2), name, tif.transform)
            check((tif.transform.a, tif.transform.e) == (cell, -cell), name, tif.transform)
            check(np.isnan(tif.nodata), name, tif.nodata)
            check('UNIT["metre",1' in tif.crs.to_wkt(), name, tif.crs)
        check(read(FOLDER / f"tif/{name}.tif", "float")[0] == exact, name, "in TIFF")

        integers, _ = read(FOLDER / f"png16/{name}.png", "uint16")
        notes = sidecar(FOLDER / f"png16/{name}.png")
        least, most = (notes["min"], notes["max"]) if name not in CHANNELS else (0.0, 1.0)
        check_integers(integers, exact, least, most, 65535, name, "in PNG")
        if name not in CHANNELS:
            check((least, most) == (exact.min(), exact.max()), name, "has another range")
            raw = np.fromfile(FOLDER / f"r16/{name}.r16", "<u2").reshape(size)
            check(raw == integers[..., 0], name, "in R16")
            turned = np.fromfile(FOLDER / f"big/{name}.r16", ">u2").reshape(size)
            check(turned[::-1] == raw, name, "big-endian and turned over")

    several, channels = read(FOLDER / "all.exr", "float")
    for name in names:
        exact, _ = read(FOLDER / f"exr/{name}.exr", "float")
        of = [name] if name not in CHANNELS else [f"{name}.{letter}" for letter in "RGBA"[: CHANNELS[name]]]
        check(several[..., [channels.index(channel) for channel in of]] == exact, name, "in one EXR")
    print(f"{len(names)} layers agree in EXR, TIFF, PNG and R16")


def tiles():
    whole, _ = read(FOLDER / "exr/height.exr", "float")
    side = (whole.shape[0] + 1) // 2
    for row in range(2):
        for column in range(2):
            part = whole[row * (side - 1) :][:side, column * (side - 1) :][:, :side]
            check(read(FOLDER / f"tiles/height_x{column}_y{row}.exr", "float")[0] == part, "tile", column, row)
    print("tiles agree")


def engines():
    """Heights as Unreal and Unity compute them from the integers and what the sidecar tells to type in."""
    exact = read(FOLDER / "unreal/exact/height.exr", "float")[0][..., 0]
    integers = read(FOLDER / "unreal/height.png", "uint16")[0][..., 0]
    engine = sidecar(FOLDER / "unreal/height.png")["unreal"]
    check(integers.shape == (127, 127), integers.shape)
    metres = ((integers - 32768.0) / 128 * engine["scale"][2] + engine["location"][2]) / 100
    step = (exact.max() - exact.min()) / 65535
    # The scale spreads 65536 steps over the range and there are 65535: up to one more at the top.
    check(np.abs(metres - exact).max() <= 1.51 * step + 1e-4, "Unreal", np.abs(metres - exact).max())
    weights = [read(FOLDER / f"unreal/splat_{name}.png", "uint8")[0] for name in ("grass", "rock", "sand", "sea_floor")]
    check(np.abs(sum(weight.astype(int) for weight in weights) - 255) <= 2, "weights don't sum to 1")

    exact = read(FOLDER / "exr/height.exr", "float")[0][..., 0]
    integers = np.fromfile(FOLDER / "unity/height.raw", "<u2").reshape(65, 65)
    engine = sidecar(FOLDER / "unity/height.raw")["unity"]
    metres = integers[::-1] / 65535 * engine["terrain_size"][1] + engine["position"][1]
    check(np.abs(metres - exact).max() <= 0.51 * step + 1e-4, "Unity", np.abs(metres - exact).max())
    print("Unreal and Unity get the heights that were simulated")


def meshes():
    """Every vertex on its sample, every sample within the largest error, no gaps."""
    exact = read(FOLDER / "exr/height.exr", "float")[0][..., 0].astype(np.float64)
    for error in (0, 2):
        for suffix in ("glb", "ply", "obj"):
            path = FOLDER / f"mesh{error}.{suffix}"
            notes = sidecar(path)
            mesh = trimesh.load(path, process=False, force="mesh")
            check(len(mesh.faces) == notes["triangles"], path, len(mesh.faces))
            place = mesh.vertices[:, [2, 0]] / notes["extent"] + 0.5
            samples = np.rint(place * (len(exact) - 1)).astype(int)
            check(np.abs(samples / (len(exact) - 1) - place) < 1e-6, path, "has vertices beside the samples")
            heights = mesh.vertices[:, 1].astype(np.float32)
            check(exact[tuple(samples.T)] == heights, path, "has other heights")
            check(len(np.unique(samples, axis=0)) == notes["vertices"], path, "has other vertices")
            check(mesh.face_normals[:, 1] > 0, path, "has triangles that look down")
            found, area = 0.0, 0
            for corners in samples[mesh.faces]:
                found = max(found, distance(exact, corners))
                area += abs(np.linalg.det((corners[1:] - corners[0]).astype(float))) / 2
            check(found <= error + 1e-9, path, "strays by", found)
            check(round(area) == (len(exact) - 1) ** 2, path, "covers", area)
            print(f"{path.name}: {notes['vertices']} vertices, {len(mesh.faces)} triangles, within {found:.4f} m")


def distance(heights, corners):
    """The farthest that a sample within a triangle lies above or below it."""
    (top, left), (bottom, right) = corners.min(axis=0), corners.max(axis=0)
    at = np.stack(np.meshgrid(np.arange(top, bottom + 1), np.arange(left, right + 1), indexing="ij"), -1)
    edges = (corners[1:] - corners[0]).T.astype(float)
    weights = (at - corners[0]) @ np.linalg.inv(edges).T
    inside = (weights >= -1e-12).all(axis=-1) & (weights.sum(axis=-1) <= 1 + 1e-12)
    rises = heights[tuple(corners.T)]
    plane = rises[0] + weights @ (rises[1:] - rises[0])
    return np.abs(plane - heights[top : bottom + 1, left : right + 1])[inside].max(initial=0.0)


layers()
tiles()
engines()
meshes()
