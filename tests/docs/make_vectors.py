#!/usr/bin/env python3
"""Writes the test vectors of the Tessera 4D file, docs/reference/vectors: small files, and for
each a .json of the Gaussians that the program finds in it at some times.

Usage: make_vectors.py TESSERA FIXTURE_FOLDER     (of tests/browser/fixture_model.cpp)
To be run where the version of the format changes; files of earlier versions stay.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

VECTORS = pathlib.Path(__file__).resolve().parents[2] / "docs" / "reference" / "vectors"
TIMES = (0, 0.25, 0.7, 1)
WINDOW_TIMES = (0, 0.25, 0.5, 0.7, 1)  # 0.5: a border


def columns(ply):
    """{name: [N]} of a 3DGS .ply."""
    data = ply.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    names = [line.split()[-1] for line in data[:end].decode().splitlines() if line.startswith("property")]
    rows = np.frombuffer(data[end:], "<f4").reshape(-1, len(names)).astype(np.float64)
    return dict(zip(names, rows.T))


def covariance(rotation, scale):
    """[N, 6] xx, xy, xz, yy, yz, zz: the same of every order and sign of the axes."""
    w, x, y, z = rotation.T
    axes = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1)
    scaled = axes.reshape(-1, 3, 3) * scale[:, None]
    return (scaled @ scaled.transpose(0, 2, 1))[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]


def gaussians(program, file, t):
    """Those of a Tessera 4D file that are drawn at t, by the program: means ascend in x."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "export", file, "--format", "ply", "--time", str(t), "-o", folder],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return gaussians_of(pathlib.Path(folder) / "frame_0000.ply")


def gaussians_of(ply):
    """Those of a 3DGS file: means ascend in x."""
    c = columns(ply)
    order = np.argsort(c["x"])
    stacked = lambda *names: np.stack([c[name][order] for name in names], 1)
    rest = sorted((name for name in c if name.startswith("f_rest_")), key=lambda name: int(name[7:]))
    rotation = stacked("rot_0", "rot_1", "rot_2", "rot_3")
    rotation /= np.linalg.norm(rotation, axis=1, keepdims=True)
    return {
        "mean": stacked("x", "y", "z"),
        "covariance": covariance(rotation, np.exp(stacked("scale_0", "scale_1", "scale_2"))),
        "opacity": 1 / (1 + np.exp(-c["opacity"][order])),
        "colour": stacked("f_dc_0", "f_dc_1", "f_dc_2"),
        "sh_sum": sum((np.abs(c[name][order]) for name in rest), np.zeros(len(order))),
    }


def listed(arrays):
    """For JSON."""
    return {key: np.round(array, 8).tolist() for key, array in arrays.items()}


def write_rows(name, rows):
    lines = ",\n".join(" " + json.dumps(row) for row in rows)
    (VECTORS / f"{name}.json").write_text(f"[\n{lines}\n]\n")


def main(program, fixture):
    VECTORS.mkdir(exist_ok=True)
    for name in ("static", "moving", "carried"):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([program, "export", fixture / f"few_{name}.ply", "--format", "tessera", "--single",
                            "-o", folder], check=True, stdout=subprocess.DEVNULL)
            file = VECTORS / f"{name}.t4d"
            file.write_bytes((pathlib.Path(folder) / "scene.t4d").read_bytes())
        write_rows(name, [{"t": t} | listed(gaussians(program, file, t)) for t in TIMES])
    # of windows, sliced by tests/browser/fixture_windows.cpp
    (VECTORS / "windows.t4d").write_bytes((fixture / "few_windows.t4d").read_bytes())
    write_rows("windows", [{"t": t} | listed(gaussians_of(fixture / f"few_windows_{i:04}.ply"))
                           for i, t in enumerate(WINDOW_TIMES)])


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], pathlib.Path(sys.argv[2]))
