#!/usr/bin/env python3
"""Reads a Tessera 4D file as docs/reference/tessera4d.md describes it, and slices it at a time.

    tessera4d.py FILE.t4d|manifest.json T OUT.ply    writes the Gaussians at t = T (0 to 1) as 3DGS .ply

From Python: Scene("scene.t4d").at(0.5) has arrays mean [N,3], rotation [N,4] (w, x, y, z), scale
[N,3], opacity [N], sh [N,16,3] of all Gaussians that are drawn at that time. Needs numpy alone.
"""

import gzip
import json
import pathlib
import sys
import zlib

import numpy as np

VERSION = 3
MIN_MARGINAL, MIN_OPACITY = 0.05, 1 / 255  # of exp(-z²/2) and of opacity: below, nothing is drawn
GREY = 0.5 / 0.28209479177387814 * np.eye(16, 1)  # sh of what a colour has beside its own sh: 0.5


class Scene:
    def __init__(self, path):
        path = pathlib.Path(path)
        data = path.read_bytes()
        if data[:4] == b"TES4":
            length = int.from_bytes(data[8:12], "little")
            self.manifest, rest = json.loads(data[12:12 + length]), data[12 + length:]
            load = lambda block: rest[block["offset"]:block["offset"] + block["bytes"]]
        else:
            self.manifest = json.loads(data)
            load = lambda block: (path.parent / block["file"]).read_bytes()
        if self.manifest.get("format") != "tessera-4d" or self.manifest["version"] > VERSION:
            raise ValueError(f"{path}: no Tessera 4D file of version 1 to {VERSION}")
        self.blocks = []
        for block in self.manifest["blocks"]:
            content = load(block)
            if len(content) != block["bytes"] or zlib.crc32(content) != block["crc32"]:
                raise ValueError(f"{path}: a block is damaged")
            head = block.get("head", 0)  # of a file of windows: JSON in front of the streams
            listed = json.loads(content[:head])["streams"] if head else block["streams"]
            self.blocks.append((block, {s["name"]: stream(s, content[head:]) for s in listed}))

    def at(self, t):
        windows, drawn, tau, light = self.manifest.get("windows", []), None, t, 1
        for i, window in enumerate(windows):
            if i == 0 or window["drawn"][0] <= t:  # the last that has begun
                low, high = window["time"]
                drawn, tau, light = i, (t - low) / (high - low), window.get("light", 1)
        parts = [gaussians(block, s, self.manifest["anchor"], tau, 1 if "window" in block else light)
                 for block, s in self.blocks if block["visible"][0] <= t <= block["visible"][1]
                 and block.get("window", drawn) == drawn]
        shapes = {"mean": (0, 3), "rotation": (0, 4), "scale": (0, 3), "opacity": (0,), "sh": (0, 16, 3)}
        return {k: np.concatenate([np.zeros(shapes[k]), *[p[k] for p in parts]]) for k in shapes}


def stream(info, block):
    """[count, components] of float64."""
    data = block[info["offset"]:info["offset"] + info["bytes"]]
    if info["codec"] not in ("gzip", "none"):
        raise ValueError(f"codec {info['codec']}")
    data = gzip.decompress(data) if info["codec"] == "gzip" else data
    width = int(info["type"][1:]) // 8
    count, components = info["count"], info["components"]
    planes = np.frombuffer(data, np.uint8).reshape(components, width, count).astype(np.uint64)
    integers = sum(planes[:, k] << np.uint64(8 * k) for k in range(width))  # [components, count]
    if info["type"] == "f32":
        return integers.astype(np.uint32).view(np.float32).T.astype(np.float64)
    if info.get("delta"):
        signed = integers.astype(np.int64)
        integers = np.cumsum((signed >> 1) ^ -(signed & 1), axis=1) % 2 ** (8 * width)
    values = np.array(info["bias"]) + np.array(info["scale"]) * integers.T.astype(np.float64)
    return values.astype(np.float32).astype(np.float64)


def rotations(s):
    if "rotation_largest" not in s:
        return s["rotation"] / np.linalg.norm(s["rotation"], axis=1, keepdims=True)
    small, largest = s["rotation"], s["rotation_largest"][:, 0].astype(int)
    q = np.empty((len(small), 4))
    rows = np.arange(len(small))
    for k in range(3):  # the parts that are stored go around the largest
        q[rows, k + (largest <= k)] = small[:, k]
    q[rows, largest] = np.sqrt(np.maximum(0, 1 - (small ** 2).sum(1)))
    return q


def harmonics(s, count):
    sh = np.zeros((count, 16, 3))
    sh[:, 0] = s["colour"]
    for degree, (first, last) in {1: (1, 4), 2: (4, 9), 3: (9, 16)}.items():
        values = s.get(f"sh{degree}", np.zeros((0, 3 * (last - first))))
        sh[:len(values), first:last] = values.reshape(len(values), last - first, 3)
    return sh


def gaussians(block, s, anchor, t, light):
    """Those of a block that are drawn at t, in a light."""
    count = block["count"]
    opacity = s["opacity"] if "opacity" in s else 1 / (1 + np.exp(-s["opacity_logit"]))
    opacity, mean, rotation = opacity[:, 0], s["position"], rotations(s)
    drawn = np.ones(count, bool)
    if block["kind"] == "dynamic":
        centre, width = s["time_mean"][:, 0], np.exp(s["log_time_scale"][:, 0])
        marginal = np.exp(-0.5 * ((t - centre) / width) ** 2)
        since = t - (np.clip(centre, 0, 1) if anchor == "clip" else centre)
        mean, opacity = mean + s["velocity"] * since[:, None], opacity * marginal
        drawn = marginal >= MIN_MARGINAL
    elif block["kind"] == "canonical":
        mean, rotation = carried(block, s, mean, rotation, t)
    drawn &= opacity >= MIN_OPACITY
    values = {"mean": mean, "rotation": rotation, "scale": np.exp(s["log_scale"]),
              "opacity": opacity, "sh": (harmonics(s, count) + GREY) * light - GREY}
    return {key: value[drawn] for key, value in values.items()}


def product(a, b):
    """Of quaternions."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([aw * bw - (av * bv).sum(-1, keepdims=True),
                           aw * bv + bw * av + np.cross(av, bv)], -1)


def carried(block, s, mean, rotation, t):
    """Means and rotations at t of Gaussians that motion nodes move."""
    nodes, knots = block["nodes"], block["knots"]
    a = np.abs(np.clip(t, 0, 1) * (knots - 3) + 1 - np.arange(knots))
    basis = np.where(a < 1, 2 / 3 - a ** 2 + a ** 3 / 2, np.clip(2 - a, 0, None) ** 3 / 6)
    shift = np.einsum("i,nic->nc", basis, s["node_translation"].reshape(nodes, knots, 3))
    turn = np.einsum("i,nic->nc", basis, s["node_rotation"].reshape(nodes, knots, 4))
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    bound = s["node"].astype(int)  # [N, 8]
    place, q = s["node_position"][bound], turn[bound]  # [N, 8, 3], [N, 8, 4]
    offset = mean[:, None] - place
    if "node_weight" in s:
        weight = np.concatenate([1 - s["node_weight"].sum(1, keepdims=True), s["node_weight"]], 1)
    else:
        radius = np.exp(s["node_log_radius"][:, 0])[bound]
        logit = s["node_logit"] - (offset ** 2).sum(-1) / (2 * radius ** 2)
        logit = np.where(bound < 0, -np.inf, logit)
        weight = np.exp(logit - logit.max(1, keepdims=True))
        weight /= weight.sum(1, keepdims=True)
    weight = np.where(bound < 0, 0, weight)[..., None]
    turned = product(product(q, np.concatenate([np.zeros_like(offset[..., :1]), offset], -1)),
                     q * [1, -1, -1, -1])[..., 1:]
    moved = (weight * (turned + place + shift[bound])).sum(1)
    leading = np.take_along_axis(q, weight.argmax(1)[..., None], 1)
    sign = np.where((q * leading).sum(-1, keepdims=True) < 0, -1, 1)
    blended = product((sign * weight * q).sum(1), rotation)
    return moved, blended / np.linalg.norm(blended, axis=1, keepdims=True)


def write_ply(path, g):
    names = ["x", "y", "z", *(f"f_dc_{c}" for c in range(3)), *(f"f_rest_{i}" for i in range(45)),
             "opacity", *(f"scale_{k}" for k in range(3)), *(f"rot_{k}" for k in range(4))]
    opacity = np.clip(g["opacity"], 1e-7, 1 - 1e-7)[:, None]
    rest = g["sh"][:, 1:].transpose(0, 2, 1).reshape(-1, 45)  # channel by channel
    rows = np.concatenate([g["mean"], g["sh"][:, 0], rest, np.log(opacity / (1 - opacity)),
                           np.log(g["scale"]), g["rotation"]], 1).astype("<f4")
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n"
    header += "".join(f"property float {name}\n" for name in names) + "end_header\n"
    pathlib.Path(path).write_bytes(header.encode() + rows.tobytes())


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    write_ply(sys.argv[3], Scene(sys.argv[1]).at(float(sys.argv[2])))
