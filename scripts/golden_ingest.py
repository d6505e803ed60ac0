"""What compare_ingest.py stores of a case, and whether a result is like it.

A description is a dictionary without levels: exit code, messages, what `info` and `doctor` print,
files by folder and kind, and of a scene what its transforms.json states: of each camera the lens,
the first pose, numbers of frames by split and times. Bytes of images are not in it, which another
version of a decoder may change.
"""
import json
import math
import re
from collections import Counter

DIGITS = 4  # of a measured number
NEAR = 0.01  # of a number, by its size: another machine may measure so much less or more
# Of files, whose bytes another version of an encoder may change.
BYTES = {"source_hashes_fnv1a64", "bytes", "sample", "hash", "scene_hash", "files"}
LENS = ("w", "h", "fl_x", "fl_y", "cx", "cy")
PLACE = re.compile(r"/\S*?/(?=scene|capture)")  # of the capture, which is made anew
FLOAT = re.compile(r"-?\d+\.\d+(?:e[-+]?\d+)?")


def short(value):
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if abs(value) > 1e-9 else 0.0
    if isinstance(value, dict):
        return {k: short(v) for k, v in value.items() if k not in BYTES}
    return [short(v) for v in value] if isinstance(value, list) else value


def of_pose(matrix):
    """Where a camera stands, and the axis against which it looks."""
    return [round(row[i], 3) + 0.0 for i in (3, 2) for row in matrix[:3]]


def of_camera(frames, common):
    first = frames[0]
    made = {key: short(first.get(key, common.get(key))) for key in LENS}
    made["pose"] = of_pose(first["transform_matrix"])
    made["frames"] = dict(Counter(frame.get("split", "") for frame in frames))
    times = [frame["time"] for frame in frames if "time" in frame]
    made["times"] = short(times[:2] + times[-1:])
    if any("mask_path" in frame for frame in frames):
        made["masks"] = sum("mask_path" in frame for frame in frames)
    return made


def of_scene(transforms):
    made = {}
    frames, ours = transforms.pop("frames", []), transforms.pop("tessera", {})
    cameras = {}
    for frame in frames:
        name = frame.get("tessera", {}).get("camera", frame["file_path"].rpartition("/")[0])
        cameras.setdefault(name, []).append(frame)
    for name, of_it in cameras.items():
        made["camera " + name] = of_camera(of_it, transforms)
    for clip in ours.pop("clips", []):
        clip["pose"] = of_pose(clip.pop("transform_matrix"))
        made["clip " + clip["camera"]] = short(clip)
    for key, value in [*transforms.items(), *ours.items()]:
        if key not in BYTES:
            made[key] = short(value)
    return made


def of_output(text):
    """Of what a command prints: texts and single numbers of JSON, and lists of texts."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    if not isinstance(value, dict):
        return text
    plain = {k: short(v) for k, v in value.items()
             if not isinstance(v, (dict, list)) and k not in BYTES}
    for key in ("findings", "warnings", "notes"):
        if key in value:
            plain[key] = short(value[key])
    return plain


def kinds_of_files(names):
    kinds = Counter(re.sub(r"[^/]*(\.\w+)$", r"*\1", name) for name in names)
    return {kind: count for kind, count in sorted(kinds.items()) if "." in kind}


def described(parts):
    """-> {name: value} of what Place.outcome() returns"""
    made = {"exit code": int(parts["exit code"]), "messages": parts["messages"].splitlines(),
            "output": of_output(parts["output"])}
    if parts["commands of COLMAP"]:
        made["commands of COLMAP"] = [PLACE.sub("", line)
                                      for line in parts["commands of COLMAP"].splitlines()]
    files = [n[len("scene/"):] for n in parts if n.startswith("scene/")]
    if files:
        made["files"] = kinds_of_files(files)
    if "scene/transforms.json" in parts:
        made.update(of_scene(json.loads(parts["scene/transforms.json"])))
    beside = parts["list of files beside the scene"].splitlines()
    made["beside"] = [name for name in beside if name not in ("colmap", "colmap_commands.txt")]
    return made


def stored(description, first):
    """What differs from the first case of the capture; null: what that has and this has not."""
    if first is None:
        return description
    changed = {k: v for k, v in description.items() if k not in first or first[k] != v}
    return {**changed, **{k: None for k in first if k not in description}}


def restored(line, first):
    whole = {**(first or {}), **line}
    return {k: v for k, v in whole.items() if v is not None}


def alike(a, b):
    if isinstance(a, bool) or isinstance(b, bool):
        return a is b
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        if isinstance(a, int) and isinstance(b, int) and max(abs(a), abs(b)) < 1000:
            return a == b
        return math.isclose(a, b, rel_tol=NEAR, abs_tol=NEAR / 10)
    if isinstance(a, str) and isinstance(b, str):
        return a == b or (FLOAT.split(a) == FLOAT.split(b) and all(
            math.isclose(float(x), float(y), rel_tol=NEAR, abs_tol=NEAR)
            for x, y in zip(FLOAT.findall(a), FLOAT.findall(b))))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(alike(a[k], b[k]) for k in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(alike(x, y) for x, y in zip(a, b))
    return a == b
