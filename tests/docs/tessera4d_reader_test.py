#!/usr/bin/env python3
"""The reader of docs/reference/tessera4d.py against the program: what it slices is drawn alike.

Usage: tessera4d_reader_test.py TESSERA FIXTURE_FOLDER SCRATCH. Exit code 77 without numpy.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True
try:
    import numpy as np
except ImportError:
    print("skipped: numpy is not installed (python3-numpy)")
    sys.exit(77)

REFERENCE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "reference"
sys.path.insert(0, str(REFERENCE))
import make_vectors  # noqa: E402  beside this file
import tessera4d  # noqa: E402

PROGRAM, FIXTURE, SCRATCH = None, None, None


def run(*words):
    subprocess.run([PROGRAM, *map(str, words)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)


def image(path):
    """Values of a .pfm."""
    with path.open("rb") as file:
        file.readline()
        file.readline()
        order = "<f4" if float(file.readline()) < 0 else ">f4"
        return np.frombuffer(file.read(), order)


def export(model, *options):
    folder = SCRATCH / "-".join([model, *(o.strip("-") for o in options)])
    run("export", FIXTURE / f"{model}.ply", "--format", "tessera", *options, "-o", folder)
    return folder / ("scene.t4d" if "--single" in options else "manifest.json")


def least_psnr(file, model, t):
    """Of the sliced scene against the model at t, over the fixture's cameras, dB."""
    sliced, ours, theirs = SCRATCH / "sliced.ply", SCRATCH / "ours", SCRATCH / "theirs"
    subprocess.run([sys.executable, REFERENCE / "tessera4d.py", file, str(t), sliced], check=True)
    cameras = ["--cameras", FIXTURE / "transforms.json", "--float", "--overwrite"]
    run("render", sliced, *cameras, "--time", 0, "-o", ours)
    run("render", FIXTURE / f"{model}.ply", *cameras, "--time", t, "-o", theirs)
    files = sorted(ours.glob("*.pfm"))
    assert len(files) == 3
    return min(-10 * np.log10(np.mean((image(f) - image(theirs / f.name)) ** 2)) for f in files)


def read_at(scene, t):
    """As make_vectors.gaussians."""
    g = scene.at(t)
    order = np.argsort(g["mean"][:, 0].astype(np.float32))
    return {"mean": g["mean"][order],
            "covariance": make_vectors.covariance(g["rotation"][order], g["scale"][order]), "opacity": g["opacity"][order], "colour": g["sh"][order, 0],
            "sh_sum": np.abs(g["sh"][order, 1:]).sum((1, 2))}


class Reader(unittest.TestCase):
    # Bugs put back: the sign of smaller quaternions, the anchor left unclamped, the order of SH;
    # each seen to fail.
    def test_rounded_files_are_drawn_alike(self):
        for model in ("model", "carried"):
            file = export(model, "--single")
            for t in (0, 0.37, 1):
                self.assertGreater(least_psnr(file, model, t), 45, (model, t))

    def test_lossless_files_are_drawn_as_the_model_is(self):
        for model in ("model", "carried"):
            self.assertGreater(least_psnr(export(model, "--lossless"), model, 0.37), 100, model)

    # Bugs put back: no CRC, no check of the version; each seen to fail.
    def test_damaged_and_later_files_are_refused(self):
        file = export("model", "--single")
        data = bytearray(file.read_bytes())
        data[-10] ^= 1
        file.write_bytes(data)
        with self.assertRaisesRegex(ValueError, "damaged"):
            tessera4d.Scene(file)
        manifest = export("model")
        later = json.loads(manifest.read_text())
        later["version"] = tessera4d.VERSION + 1
        manifest.write_text(json.dumps(later))
        with self.assertRaisesRegex(ValueError, "version"):
            tessera4d.Scene(manifest)

    # Bugs put back: the marginal without its square, nodes' turns not blended, the earlier window
    # drawn at a border, t in place of tau; each seen to fail.
    def test_the_vectors_are_read_as_they_say(self):
        for expected in sorted((REFERENCE / "vectors").glob("*.json")):
            scene = tessera4d.Scene(expected.with_suffix(".t4d"))
            for row in json.loads(expected.read_text()):
                self.check_vector(expected.stem, row, read_at(scene, row["t"]))
                if expected.stem != "windows":  # the program exports one window of such a file
                    self.check_vector(expected.stem, row, make_vectors.gaussians(
                        PROGRAM, expected.with_suffix(".t4d"), row["t"]))

    def check_vector(self, name, row, found):
        for key in ("mean", "covariance", "opacity", "colour", "sh_sum"):
            wanted = np.array(row[key])
            self.assertEqual(found[key].shape, wanted.shape, (name, row["t"], key))
            worst = np.abs(found[key] - wanted).max(initial=0)
            self.assertLess(worst, 1e-6 if key == "covariance" else 2e-5, (name, row["t"], key))

    def test_it_stays_short(self):
        self.assertLess(len((REFERENCE / "tessera4d.py").read_text().splitlines()), 170)


if __name__ == "__main__":
    PROGRAM, FIXTURE, SCRATCH = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(SCRATCH, ignore_errors=True)
    SCRATCH.mkdir(parents=True)
    unittest.main(argv=sys.argv[:1])
