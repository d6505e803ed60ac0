#!/usr/bin/env python3
"""Compares what tessera makes of captures of every layout with what is stored of it, or what two
builds make of them, byte by byte.

    compare_ingest.py BINARY [--only TEXT] [--store]
    compare_ingest.py BINARY_A BINARY_B [--only TEXT] [--cases MK.PY] [--keep FOLDER]

The captures, options and damaged captures are those of ingest_captures.py. Each build runs `ingest`
on each with each set of options, and `info` and `doctor` with the first. Stored is
tests/ingest/golden.jsonl, a line a case: exit code, messages, and the scene's cameras, times,
splits and files; measured numbers may differ from it by a hundredth. A line per case says
whether exit code, output, messages, names and bytes of all files are the same, and shows the first
difference where they are not. Exit code 1: something differs.

--only   runs the cases whose names contain the text
--store  stores what BINARY makes of them, where that is intended: `git diff` shows what it is
--cases  adds the cases of a script: its functions of one argument `d`, which is the capture to
         make; `python3 MK.PY CASE FOLDER` runs one
--keep   keeps captures and results, for a closer look

BINARY_A renders some of the captures (`synth`), with ffmpeg. A change that is intended (of a
message) shows as a difference, too: read the lines. COLMAP is not run: a program in its place logs
the commands, which are compared, and answers with known poses.
"""
import argparse
import concurrent.futures
import contextlib
import difflib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import capture_files
import golden_ingest
import ingest_captures

GOLDEN = Path(__file__).resolve().parent.parent / "tests" / "ingest" / "golden.jsonl"
THREADS = ["--threads", "2"]
SHOWN_LINES, SHOWN_CHARACTERS = 8, 300
# Keys of JSON whose values are measured, or name the build.
UNSTABLE = {"seconds", "commit", "version", "at"}
PROGRESS = re.compile(r"^(ingest|doctor) .*( left |\(\d+ %\)|\d+:\d\d|colmap: ).*\n?", re.MULTILINE)
# "in 6.8 s"
SECONDS = re.compile(r"\bin \d+\.\d+ s\b|, \d+\.\d+ s$", re.MULTILINE)
TEMPORARY = re.compile(r"\btessera_([a-z]+)_\w{6}\b")


def stable_json(value):
    """Without what differs from run to run. The order of keys is kept."""
    if isinstance(value, dict):
        return {k: stable_json(v) for k, v in value.items() if k not in UNSTABLE}
    if isinstance(value, str):
        return without_seconds(value)
    return [stable_json(v) for v in value] if isinstance(value, list) else value


def without_seconds(text):
    return SECONDS.sub(lambda found: re.sub(r" *\d+\.\d+", " …", found[0]), text)


def stable_text(data, binary):
    """Text that a program printed, without the program's path, progress and seconds."""
    text = data.decode(errors="backslashreplace").replace(str(binary), "tessera")
    with contextlib.suppress(ValueError):
        return json.dumps(stable_json(json.loads(text)), indent=1)
    text = PROGRESS.sub("", text.replace("\r", "\n"))
    return TEMPORARY.sub(r"tessera_\1_…", without_seconds(text))


def stable_file(path):
    if path.is_symlink():
        return b"link to " + os.readlink(path).encode()
    data = path.read_bytes()
    if path.suffix == ".json":
        with contextlib.suppress(ValueError):
            return json.dumps(stable_json(json.loads(data)), indent=1)
    return data


def files_below(folder):
    """name -> content; folders have the content of an empty text"""
    return {str(p.relative_to(folder)): "" if p.is_dir() and not p.is_symlink() else stable_file(p)
            for p in sorted(folder.rglob("*"))}


class Place:
    """The folder of one capture. Both builds run in it with the same relative paths, one after the
    other, so that paths in messages are equal."""

    def __init__(self, folder, maker):
        self.folder = folder
        folder.mkdir(parents=True)
        maker(folder)
        self.made = {path.name for path in folder.iterdir()}

    def clear(self):
        """Removes what a run left: a scene, a cache, and poses for the next run (scene.work)."""
        for path in self.folder.iterdir():
            if path.name in self.made:
                continue
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()
        (self.folder / "tmp").mkdir()

    def environment(self):
        stand_in = self.folder / "colmap"
        script = Path(capture_files.__file__).resolve()
        log = self.folder / "colmap_commands.txt"
        command = shlex.join([sys.executable, "-I", "-S", str(script), str(log)])
        stand_in.write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        stand_in.chmod(0o755)
        return {**os.environ, "TESSERA_COLMAP": str(stand_in), "OMP_NUM_THREADS": "2",
                "XDG_CACHE_HOME": str(self.folder / "cache"), "TMPDIR": str(self.folder / "tmp"),
                "LC_ALL": "C.UTF-8", "PYTHONDONTWRITEBYTECODE": "1"}

    def outcome(self, binary, arguments):
        """Of one command: what it returned, printed and wrote, by name."""
        self.clear()
        done = subprocess.run([binary, *arguments], cwd=self.folder, env=self.environment(),
                              capture_output=True, timeout=300)
        parts = {"exit code": str(done.returncode), "messages": stable_text(done.stderr, binary),
                 "output": stable_text(done.stdout, binary)}
        log = self.folder / "colmap_commands.txt"
        parts["commands of COLMAP"] = stable_text(log.read_bytes(), binary) \
            if log.exists() else ""
        scene, capture = self.folder / "scene", self.folder / "capture"
        written = files_below(scene) if scene.is_dir() else {}
        parts["list of files"] = "\n".join(written)
        parts.update({"scene/" + name: content for name, content in written.items()})
        # a capture is never written to, and nothing is left beside the scene
        parts["list of files of the capture"] = "\n".join(
            f"{p.relative_to(capture)} {p.lstat().st_size}" for p in sorted(capture.rglob("*")))
        parts["list of files beside the scene"] = "\n".join(sorted(
            p.name for p in [*self.folder.iterdir(), *(self.folder / "tmp").iterdir()]))
        return parts

    def keep(self, results, case, side):
        if (self.folder / "scene").exists():
            results.mkdir(exist_ok=True)
            name = re.sub(r"[^\w.,=-]+", "_", case).strip("_") + "." + side
            (self.folder / "scene").rename(results / name)


def shown(text):
    return text if len(text) <= SHOWN_CHARACTERS else text[:SHOWN_CHARACTERS] + "…"


def difference(a, b):
    """Lines that show how two contents differ."""
    if a is None or b is None:
        return ["only %s has it" % ("the second" if a is None else "the first")]
    if isinstance(a, bytes) or isinstance(b, bytes):
        if type(a) is not type(b):
            return ["one is text, the other is not"]
        first = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
        return [f"{len(a)} and {len(b)} bytes, byte {first} is the first that differs"]
    a, b = (x if isinstance(x, str) else json.dumps(x, indent=1, ensure_ascii=False)
            for x in (a, b))
    lines = difflib.unified_diff(a.splitlines(), b.splitlines(), "A", "B", n=0, lineterm="")
    lines = [shown(line) for line in lines if not line.startswith(("---", "+++"))]
    more = len(lines) - SHOWN_LINES
    return lines[:SHOWN_LINES] + ([f"… and {more} more lines"] if more > 0 else [])


class Comparison:
    """Of two builds, by all that they print and write."""

    def __init__(self, binaries, root, keep):
        self.binaries, self.root, self.keep = binaries, root, keep

    def results(self, place, case, arguments):
        parts = []
        for side, binary in zip("AB", self.binaries):
            parts.append(place.outcome(binary, arguments))
            if self.keep:
                place.keep(self.root / "results", case, side)
        return parts

    @staticmethod
    def equal(a, b):
        return a == b


class Golden:
    """Of a build with what is stored."""

    def __init__(self, binary, store):
        self.binary, self.store, self.lines, self.first = binary, store, {}, {}
        if not store:
            for line in GOLDEN.read_text().splitlines():
                line = json.loads(line)
                case = line.pop("case")
                capture = case.rpartition(": ")[0]
                self.lines[case] = golden_ingest.restored(line, self.first.get(capture))
                self.first.setdefault(capture, self.lines[case])

    def results(self, place, case, arguments):
        made = golden_ingest.described(place.outcome(self.binary, arguments))
        if not self.store:
            return [self.lines.get(case, {"exit code": "is not stored: --store"}), made]
        first = self.first.setdefault(case.rpartition(": ")[0], made)
        self.lines[case] = golden_ingest.stored(made, None if first is made else first)
        return [made, made]

    @staticmethod
    def equal(a, b):
        return golden_ingest.alike(a, b)

    def write(self):
        # by capture, whichever ends first; of each the case first that others are told by
        by_capture = sorted(self.lines.items(), key=lambda line: line[0].rpartition(": ")[0])
        with GOLDEN.open("w") as file:
            for case, line in by_capture:
                file.write(json.dumps({"case": case, **line}, ensure_ascii=False) + "\n")


class Cases:
    """Runs the cases of captures; several captures at once, in the order in which they are given."""

    def __init__(self, judge, root, only, keep):
        self.judge, self.root, self.only, self.keep = judge, root, only, keep
        self.same, self.different, self.exit_codes = 0, 0, {}

    def judged(self, case, parts):
        """-> lines to print"""
        code = str(parts[0]["exit code"])
        self.exit_codes[code] = self.exit_codes.get(code, 0) + 1
        names = [name for name in [*parts[0], *(n for n in parts[1] if n not in parts[0])]
                 if not self.judge.equal(*(p.get(name) for p in parts))]
        if not names:
            self.same += 1
            return [f"same {case}" + (f" (exit code {code})" if code != "0" else "")]
        self.different += 1
        lines = [f"DIFFERENT {case}: {', '.join(names[:4])}"
                 + (f" and {len(names) - 4} more" if len(names) > 4 else "")]
        # another exit code alone tells little: its message is shown, too
        for name in names[:2 if names[0] == "exit code" else 1]:
            lines += [f"    {name}: {line}" for line in difference(*(p.get(name) for p in parts))]
        return lines

    def capture(self, name, maker, option_sets):
        """All cases of one capture, which is made only where one of them is asked for."""
        cases = [(f"{name}: ingest {options}".rstrip(),
                  ["ingest", "capture", "-o", "scene", *THREADS, *options.split()])
                 for options in option_sets]
        cases += [(f"{name}: info", ["info", "capture", "--json"]),
                  (f"{name}: doctor", ["doctor", "capture", "--json", *THREADS,
                                       *option_sets[0].split()])]
        cases = [case for case in cases if not self.only or self.only in case[0]]
        if not cases:
            return []
        place = Place(self.root / re.sub(r"\W+", "_", name), maker)
        made = [(case, self.judge.results(place, case, arguments)) for case, arguments in cases]
        if not self.keep:
            shutil.rmtree(place.folder)
        return made

    def run(self, captures):
        with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            for made in pool.map(lambda capture: self.capture(*capture), captures):
                for case, parts in made:
                    print("\n".join(self.judged(case, parts)), flush=True)


def cases_of(script):
    """-> (name, maker, option sets) of each function of one argument `d`"""
    text = script.read_text()
    names = re.findall(r"^def (\w+)\(d\):", text, re.MULTILINE)

    def maker(name):
        def make(folder):
            (folder / "capture").mkdir()
            subprocess.run([sys.executable, script, name, folder / "capture"], check=True)
            if (folder / "capture" / "rig.json").exists():  # cameras of videos, which options name
                (folder / "capture" / "rig.json").rename(folder / "cameras.json")
        return make

    def options(name):
        body = re.split(r"\n(?=\S)", text.split(f"def {name}(d):")[1])[0]
        return ["--poses cameras.json --sync none --cloud none"] if "rig_json(" in body else \
            ["--cloud none", "--cloud none --strict"]
    return [(f"{script.stem} {name}", maker(name), options(name)) for name in names]


def program(text):
    found = shutil.which(text)
    if not found:
        sys.exit(f"{text}: no such program")
    return Path(found).resolve()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", nargs="+", metavar="BINARY", type=program)
    parser.add_argument("--only", metavar="TEXT", default="")
    parser.add_argument("--cases", metavar="MK.PY", type=Path)
    parser.add_argument("--keep", metavar="FOLDER", type=Path)
    parser.add_argument("--store", action="store_true")
    arguments = parser.parse_args()
    two = len(arguments.binaries) == 2
    if len(arguments.binaries) > 2 or (arguments.store and (two or arguments.only)):
        parser.error("name one build, or two; --store is of one, and of all cases")
    if not two and (arguments.cases or arguments.keep):
        parser.error("--cases and --keep are of two builds")
    ingest_captures.TESSERA = str(arguments.binaries[0])
    start = time.monotonic()
    with contextlib.ExitStack() as stack:
        root = arguments.keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        root.mkdir(parents=True, exist_ok=True)
        if any(root.iterdir()):
            sys.exit(f"{root}: is not empty; name a new folder")
        judge = Comparison(arguments.binaries, root.resolve(), arguments.keep) if two else \
            Golden(arguments.binaries[0], arguments.store)
        run = Cases(judge, root.resolve(), arguments.only, arguments.keep)
        captures = [(maker.__name__, maker, sets)
                    for maker, sets in ingest_captures.CAPTURES.items()]
        captures += [(name, *made) for name, made in ingest_captures.BAD.items()]
        run.run(captures + (cases_of(arguments.cases.resolve()) if arguments.cases else []))
    codes = ", ".join(f"{count} exit with {code}" for code, count in sorted(run.exit_codes.items()))
    print(f"{run.same} same, {run.different} different ({codes}); {time.monotonic() - start:.0f} s")
    if run.same + run.different == 0:
        sys.exit(f"no case has '{arguments.only}' in its name")
    if arguments.store:
        judge.write()
    return 1 if run.different else 0


if __name__ == "__main__":
    sys.exit(main())
