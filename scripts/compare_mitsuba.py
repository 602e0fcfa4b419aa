#!/usr/bin/env python3
"""Compares terrane's path tracer with Mitsuba 3 (https://mitsuba-renderer.org), an independent renderer.

    scripts/compare_mitsuba.py WORLD.toml [--set K=V]… [--size 320x180] [--spp 256] [-o FOLDER]

Exports the world with `--layer mitsuba`, renders the folder with Mitsuba and the world with terrane (constant materials, no
aerial perspective), and prints the means of both, channel by channel. It fails (exit 1) if a mean differs by more than
0.2 % and by more than noise explains, or if the difference has a structure: if some block of 8 × 8, 16 × 16 or 32 × 32
pixels differs by more than 0.2 % of the picture's mean, and by so many standard errors as noise would reach in one of
10,000 pictures. Beside the numbers it leaves mitsuba.exr, terrane.exr and difference.png: red is where terrane is
brighter, blue where Mitsuba is, full where they differ by 10 % of the mean.

Mitsuba and NumPy come from PyPI, into a virtual environment that the script makes where it is told by --venv.
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys

TOLERANCE = 0.002
CHANCE = 1e-4
SIDES = [8, 16, 32]
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
    """Several passes."""
    scene = mitsuba.load_file(str(folder / "scene.xml"))
    spp = max(1, spp // PASSES)
    passes = [numpy.array(mitsuba.render(scene, spp=spp, seed=seed), dtype=numpy.float64) for seed in range(PASSES)]
    mean = numpy.mean(passes, axis=0)
    mitsuba.util.write_bitmap(str(folder / "mitsuba.exr"), mitsuba.TensorXf(mean.astype(numpy.float32)))
    return numpy.array(passes)


def channels(mitsuba, numpy, path):
    """R, G and B of one of our files, and their variances."""
    layers = {name: numpy.array(bitmap, dtype=numpy.float64) for name, bitmap in mitsuba.Bitmap(str(path)).split()}
    return layers["<root>"][..., :3], layers["variance"][..., :3]


def variance_of_mean(numpy, passes):
    return numpy.var(passes, axis=0, ddof=1) / len(passes)


def blocks(numpy, values, side):
    """Sums over blocks of pixels, channel by channel."""
    height, width = (length // side * side for length in values.shape[:2])
    cut = values[:height, :width]
    return cut.reshape(height // side, side, width // side, side, -1).sum(axis=(1, 3))


def deviations(numpy, ours, ours_variance, passes, side):
    """What blocks differ by: as a share of the picture's mean, and in standard errors."""
    theirs = passes.mean(axis=0)
    gap = blocks(numpy, ours - theirs, side)
    by_pixels = blocks(numpy, variance_of_mean(numpy, passes), side)
    # Mitsuba spreads a sample over neighbouring pixels, whose noise therefore adds up to more than that of each by itself.
    shared = variance_of_mean(numpy, numpy.array([blocks(numpy, one, side) for one in passes])).sum() / max(by_pixels.sum(), 1e-30)
    noise = numpy.sqrt(blocks(numpy, ours_variance, side) + shared * by_pixels) + 1e-12
    return gap / (side * side * theirs.mean()), gap / noise


def largest_by_chance(count, chance):
    """What the largest of so many standard normal deviations exceeds with this chance."""
    return statistics.NormalDist().inv_cdf(0.5 + 0.5 * (1 - chance) ** (1 / count))


def main():
    options = arguments()
    in_environment(options.venv)
    import mitsuba
    import numpy

    mitsuba.set_variant(options.variant)
    folder = pathlib.Path(options.out)
    ours, ours_variance = channels(mitsuba, numpy, by_terrane(options, folder))
    passes = by_mitsuba(mitsuba, numpy, folder, options.spp)
    theirs = passes.mean(axis=0)
    variance = ours_variance + variance_of_mean(numpy, passes)
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

    print("blocks           largest deviation   by chance   but once in 10,000")
    for side in SIDES:
        if side > min(ours.shape[:2]):
            continue
        share, errors = deviations(numpy, ours, ours_variance, passes, side)
        # What is seen directly has hardly any noise, and the sky that Mitsuba sees is a picture of ours.
        errors = numpy.where(numpy.abs(share) > options.tolerance, numpy.abs(errors), 0)
        worst = numpy.unravel_index(numpy.argmax(errors), errors.shape)
        usual, most = (largest_by_chance(errors.size, chance) for chance in [0.5, CHANCE])
        print(f"{side:2} × {side:2} ({errors.size:5})      {errors[worst]:8.2f}     {usual:8.2f}    {most:8.2f}   "
              f"{100 * share[worst]:+.2f} % of the mean at ({side * worst[1]}, {side * worst[0]}){'   WRONG' if errors[worst] > most else ''}")
        failed |= bool(errors[worst] > most)

    shown = numpy.clip(difference.mean(axis=2) / (0.1 * theirs.mean()), -1, 1)
    picture = numpy.stack([numpy.clip(1 + shown, 0, 1), 1 - numpy.abs(shown), numpy.clip(1 - shown, 0, 1)], axis=2)
    mitsuba.Bitmap((255 * picture).astype(numpy.uint8)).write(str(folder / "difference.png"))
    print(f"wrote {folder / 'difference.png'}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
