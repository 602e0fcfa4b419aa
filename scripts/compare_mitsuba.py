#!/usr/bin/env python3
"""Compares terrane's path tracer with Mitsuba 3 (https://mitsuba-renderer.org), an independent renderer.

    scripts/compare_mitsuba.py WORLD.toml [--set K=V]… [--size 320x180] [--spp 256] [-o FOLDER]

Exports the world with `--layer mitsuba`, renders the folder with Mitsuba and the world with terrane (constant materials, no
aerial perspective), and prints the means of both, channel by channel. It fails (exit 1) if a mean differs by more than
0.2 % and by more than noise explains, or if the difference has a structure: if some block of pixels differs by more than
its noise and by more than 2 % of the picture's mean. Beside the numbers it leaves mitsuba.exr, terrane.exr and
difference.png: red is where terrane is brighter, blue where Mitsuba is, full where they differ by 10 % of the mean.

Mitsuba and NumPy come from PyPI, into a virtual environment that the script makes where it is told by --venv.
"""

import argparse
import os
import pathlib
import subprocess
import sys

TOLERANCE = 0.002
STRUCTURE = 0.02
PASSES = 16


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("world")
    parser.add_argument("--set", action="append", default=[], metavar="K=V", help="as for terrane")
    parser.add_argument("--size", default="320x180", metavar="WxH")
    parser.add_argument("--spp", type=int, default=256, help="samples a pixel, of each renderer")
    parser.add_argument("-o", "--out", default="mitsuba", metavar="FOLDER")
    parser.add_argument("--traced", metavar="EXR", help="terrane's picture, if there is one already")
    parser.add_argument("--terrane", default="target/release/terrane", help="the program")
    parser.add_argument("--variant", default="scalar_rgb", help="of Mitsuba [default: scalar_rgb, which needs nothing else]")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument("--venv", default=os.path.expanduser("~/.cache/terrane-mitsuba"))
    return parser.parse_args()


def in_environment(venv):
    """Starts again with a Python that has Mitsuba, if this one has not."""
    try:
        import mitsuba  # noqa: F401
        return
    except ImportError:
        pass
    python = pathlib.Path(venv) / "bin" / "python"
    if pathlib.Path(sys.prefix).resolve() == pathlib.Path(venv).resolve():
        sys.exit("error: Mitsuba is installed and can't be imported")
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", venv], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "mitsuba>=3.5", "numpy"], check=True)
    os.execv(python, [str(python), *sys.argv])


def by_terrane(options, folder):
    """Exports the world and traces it; the picture's file."""
    width, height = options.size.split("x")
    # What the user sets comes last.
    settings = ["render.constant_materials=true", "render.aerial=false", f"render.size=[{width}, {height}]", *options.set]
    settings = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([options.terrane, "export", options.world, "--layer", "mitsuba", "-o", f"{folder}/", *settings], check=True)
    if options.traced:
        return options.traced
    picture = folder / "terrane.exr"
    subprocess.run([options.terrane, "render", options.world, "--renderer", "trace", "--spp", str(options.spp), "-o", picture,
                    *settings], check=True)
    return picture


def by_mitsuba(mitsuba, numpy, folder, spp):
    """The mean of several passes, and the variance of that mean."""
    scene = mitsuba.load_file(str(folder / "scene.xml"))
    spp = max(1, spp // PASSES)
    passes = [numpy.array(mitsuba.render(scene, spp=spp, seed=seed), dtype=numpy.float64) for seed in range(PASSES)]
    mean = numpy.mean(passes, axis=0)
    mitsuba.util.write_bitmap(str(folder / "mitsuba.exr"), mitsuba.TensorXf(mean.astype(numpy.float32)))
    return mean, numpy.var(passes, axis=0, ddof=1) / PASSES


def channels(mitsuba, numpy, path):
    """R, G and B of one of our files, and their variances."""
    layers = {name: numpy.array(bitmap, dtype=numpy.float64) for name, bitmap in mitsuba.Bitmap(str(path)).split()}
    return layers["<root>"][..., :3], layers["variance"][..., :3]


def blocks(numpy, values, side):
    """Sums over blocks of pixels."""
    height, width = (length // side * side for length in values.shape[:2])
    cut = values[:height, :width]
    return cut.reshape(height // side, side, width // side, side, -1).sum(axis=(1, 3))


def main():
    options = arguments()
    in_environment(options.venv)
    import mitsuba
    import numpy

    mitsuba.set_variant(options.variant)
    folder = pathlib.Path(options.out)
    ours, ours_variance = channels(mitsuba, numpy, by_terrane(options, folder))
    theirs, theirs_variance = by_mitsuba(mitsuba, numpy, folder, options.spp)
    variance = ours_variance + theirs_variance
    difference = ours - theirs

    failed = False
    print(f"{options.world}: {options.size}, {options.spp} samples a pixel, {mitsuba.variant()}")
    print("channel     terrane     Mitsuba   ratio − 1   standard error")
    for channel, name in enumerate(["red", "green", "blue", "all"]):
        of = slice(None) if name == "all" else slice(channel, channel + 1)
        a, b = ours[..., of].mean(), theirs[..., of].mean()
        error = numpy.sqrt(variance[..., of].sum()) / variance[..., of].size / max(b, 1e-30)
        ratio = a / b - 1 if b > 0 else float(a > 0)
        wrong = abs(ratio) > options.tolerance and abs(ratio) > 3 * error
        failed |= wrong
        print(f"{name:7}  {a:10.6f}  {b:10.6f}   {100 * ratio:+8.4f} %      {100 * error:.4f} %{'   WRONG' if wrong else ''}")
    relative = numpy.sqrt((difference**2).mean()) / theirs.mean()
    expected = numpy.sqrt(variance.mean()) / theirs.mean()
    print(f"RMSE {100 * relative:.2f} % of the mean; noise alone explains {100 * expected:.2f} %")

    side = 16
    gap = blocks(numpy, difference, side).sum(axis=2)
    # Few passes know their own variance badly, so blocks are judged by twice as many errors as a Gaussian would need.
    noise = numpy.sqrt(blocks(numpy, variance, side).sum(axis=2)) + 1e-12
    size = gap / (3 * side * side * theirs.mean())
    # A constant sky has no noise, and differs in the last digit.
    judged = numpy.where(numpy.abs(size) > 1e-4, numpy.abs(gap) / noise, 0)
    worst = numpy.unravel_index(numpy.argmax(judged), gap.shape)
    structured = (numpy.abs(gap) > 8 * noise) & (numpy.abs(size) > STRUCTURE)
    print(f"worst of {gap.size} blocks: {100 * size[worst]:+.2f} % of the mean, {gap[worst] / noise[worst]:+.1f} standard errors, "
          f"at ({side * worst[1]}, {side * worst[0]})")
    if structured.any():
        failed = True
        print(f"{structured.sum()} blocks differ by more than noise explains")

    shown = numpy.clip(difference.mean(axis=2) / (0.1 * theirs.mean()), -1, 1)
    picture = numpy.stack([numpy.clip(1 + shown, 0, 1), 1 - numpy.abs(shown), numpy.clip(1 - shown, 0, 1)], axis=2)
    mitsuba.Bitmap((255 * picture).astype(numpy.uint8)).write(str(folder / "difference.png"))
    print(f"wrote {folder / 'difference.png'}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
