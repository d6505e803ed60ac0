"""The captures of a batch, and the stamps by which a changed capture is recognised."""
import dataclasses
import glob
import hashlib
import json
import os

from checks import Wrong, check_keys, check_name, list_of, safe_name, shown

SPLITS = ("test", "val", "train")
FILE_OPTIONS = ("--poses", "--offsets", "--masks")


@dataclasses.dataclass(frozen=True)
class Scene:
    name: str
    path: str
    ingest: tuple
    split: str = ""  # that is scored; "": what is held out, else train


def read_scenes(given, base):
    scenes = {}

    def add(name, path, ingest, split=""):
        name = check_name(name or safe_name(os.path.basename(path.rstrip("/"))), path)
        if name in scenes:
            raise Wrong(f"scenes: two are named '{name}' ({scenes[name].path} and {path}); give one "
                        "of them another `name`")
        if os.path.isdir(path) and (within(base, path) or within(path, base)):
            raise Wrong(f"scenes: {path} and the folder of results, {base}, lie in each other; captures "
                        "are never written to: move one of them")
        scenes[name] = Scene(name, path.rstrip("/"), tuple(ingest), split)

    for entry in list_of(given, "scenes", None, [], filled=True) if given.get("scenes") else []:
        entry = {"path": entry} if isinstance(entry, str) else entry
        if not isinstance(entry, dict) or not isinstance(entry.get("path"), str):
            raise Wrong(f"scenes: {shown(entry)} has no `path`; write {{name: a, path: /data/a}}")
        check_keys(entry, ("name", "path", "ingest", "split"), f"scenes: {entry['path']}")
        words = entry.get("ingest") or []
        if not isinstance(words, list):
            raise Wrong(f"scenes: {entry['path']}: ingest: expected a list of words, not "
                        f"{shown(words)}; write ingest: [--scale, 0.5]")
        split = entry.get("split") or ""
        if split and split not in SPLITS:
            raise Wrong(f"scenes: {entry['path']}: split: unknown split {shown(split)}; there are "
                        f"{', '.join(SPLITS)}")
        add(str(entry.get("name") or ""), os.path.join(base, entry["path"]),
            absolute_files([str(w) for w in words], base), split)
    for pattern in list_of(given, "captures", str, []):
        found = [p for p in sorted(glob.glob(os.path.join(glob.escape(base), pattern)))
                 if os.path.isdir(p) and not within(base, p)]  # a batch is no scene of itself
        if not found:
            raise Wrong(f"captures: no folder matches {pattern}; correct the pattern or take it out")
        for path in found:
            add("", path, [])
    if not scenes:
        raise Wrong("no scenes: give `captures: [/data/*/]`, or `scenes:` with a list of "
                    "{name, path}")
    return scenes


def absolute_files(words, base):
    """Files that options name lie relative to batch.yaml, as captures do."""
    for i, word in enumerate(words[:-1]):
        path = os.path.join(base, words[i + 1])
        if word in FILE_OPTIONS and os.path.exists(path):
            words[i + 1] = path
    return words


def within(inner, outer):
    inner, outer = os.path.realpath(inner), os.path.realpath(outer)
    return os.path.commonpath([inner, outer]) == outer


def files_below(path, out):
    """Of a file, of a folder or of nothing: name and size and time of each file, but of those in
    the folder of results."""
    files = [path] if os.path.isfile(path) else []
    for folder, below, names in os.walk(path, followlinks=True):
        below[:] = sorted(b for b in below if not within(os.path.join(folder, b), out))
        files += [os.path.join(folder, name) for name in sorted(names)]
    found = []
    for file in files:
        try:
            stat = os.stat(file)
        except OSError:  # a broken link, or gone in the meantime
            continue
        found.append((os.path.relpath(file, path), stat.st_size, stat.st_mtime_ns))
    return found


def stamp(scene, out):
    """Changes when a file of the capture or an option of its preparation does."""
    digest = hashlib.sha256(json.dumps(scene.ingest).encode())
    for path in (scene.path, *(w for w in scene.ingest if os.path.isabs(w))):
        for name, size, time in files_below(path, out):
            digest.update(os.fsencode(name) + f" {size} {time}\n".encode())
    return digest.hexdigest()[:16]


def stamp_file(scene):
    """Of the capture that the prepared scene was made from."""
    return f"stamps/{scene.name}.json"


def stamp_record(scene, out):
    return {"stamp": stamp(scene, out)}
