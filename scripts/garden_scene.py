#!/usr/bin/env python3
"""test_garden.npz (points, colours, three cameras of Mip-NeRF360 garden) -> prepared scene.

The images are grey, because the scene is only a load for `tessera bench`.
usage: garden_scene.py test_garden.npz OUT
"""
import ast
import json
import os
import struct
import sys
import zipfile
import zlib

TYPES = {"f4": "f", "f8": "d", "i4": "i", "i8": "q", "u1": "B"}


def read_npy(data):
    """-> (shape, flat tuple of numbers)"""
    length = struct.unpack("<H", data[8:10])[0] if data[6] == 1 else struct.unpack("<I", data[8:12])[0]
    start = (10 if data[6] == 1 else 12) + length
    header = ast.literal_eval(data[start - length:start].decode())
    shape = header["shape"]
    count = 1
    for n in shape:
        count *= n
    if header["fortran_order"] and len(shape) > 1:
        raise SystemExit("garden_scene.py: an array in Fortran order is not expected")
    return shape, struct.unpack_from("<%d%s" % (count, TYPES[header["descr"][1:]]), data, start)


def grey_png(width, height):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    rows = (b"\0" + b"\x80" * (3 * width)) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def inverse_rigid(m):
    """world-to-camera [4][4], rotation and translation -> camera-to-world"""
    r = [[m[j][i] for j in range(3)] for i in range(3)]
    t = [-sum(r[i][k] * m[k][3] for k in range(3)) for i in range(3)]
    return [r[i] + [t[i]] for i in range(3)] + [[0, 0, 0, 1]]


def main(source, out):
    with zipfile.ZipFile(source) as archive:
        arrays = {name[:-4]: read_npy(archive.read(name)) for name in archive.namelist()}
    for name, (shape, _) in arrays.items():
        print(name, shape)
    width, height = int(arrays["width"][1][0]), int(arrays["height"][1][0])
    os.makedirs(os.path.join(out, "images"), exist_ok=True)
    views, ks = arrays["viewmats"][1], arrays["Ks"][1]
    frames = []
    for i in range(arrays["viewmats"][0][0]):
        m = [views[16 * i + 4 * r:16 * i + 4 * r + 4] for r in range(4)]
        c2w = inverse_rigid(m)
        for row in c2w[:3]:  # +x right +y down +z forward -> OpenGL axes
            row[1], row[2] = -row[1], -row[2]
        k = ks[9 * i:9 * i + 9]
        name = "images/%02d.png" % i
        with open(os.path.join(out, name), "wb") as file:
            file.write(grey_png(width, height))
        frames.append({"file_path": name, "time": 0.0, "transform_matrix": c2w, "fl_x": k[0],
                       "fl_y": k[4], "cx": k[2], "cy": k[5], "w": width, "h": height,
                       "split": "train"})
    points, colours = arrays["means3d"][1], arrays["colors"][1]
    count = len(points) // 3
    scale = 255 if max(colours) <= 1.0 else 1
    with open(os.path.join(out, "points.ply"), "wb") as file:
        file.write(("ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % count
                    + "".join("property float %s\n" % c for c in "xyz")
                    + "".join("property uchar %s\n" % c for c in ("red", "green", "blue"))
                    + "end_header\n").encode())
        for i in range(count):
            file.write(struct.pack("<fff", *points[3 * i:3 * i + 3]))
            file.write(bytes(min(255, int(scale * c + 0.5)) for c in colours[3 * i:3 * i + 3]))
    with open(os.path.join(out, "transforms.json"), "w") as file:
        json.dump({"ply_file_path": "points.ply", "frames": frames}, file, indent=1)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2])
