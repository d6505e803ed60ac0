#!/usr/bin/env python3
"""Puts known bugs (mutations.json) back into a copy of the source, one at a time; after each the tests
that .ci/run runs must fail. The tree from which it is called is not changed.

The tests named in a row run first, alone. Where they pass, everything is built and ctest runs; tests
that fail without a bug are not counted. Exit code 1: more than one row survives, or one does not
compile.
"""
import argparse
import contextlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
USUAL = "-DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DTESSERA_CUDA=OFF"
LEFT_OUT = "nightly|cuda|batch|browser"  # labels
LIMIT = 300  # seconds, for a test named in a row
Row = dict[str, Any]  # id, group, mode (of the failure modes), file, old, new, what, tests
Test = dict[str, str]  # target; and filter, where it is not all of its cases


def git(*command: str) -> str:
    return subprocess.run(["git", *command], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def media_files() -> set[str]:
    """The sources of the target tessera_ingest_media."""
    lists = (ROOT / "ingest/CMakeLists.txt").read_text("utf-8").split("NAME ingest_media")[1:]
    return {"ingest/" + name for text in lists for name in re.findall(r"[\w/]+\.cpp", text.split("PUBLIC")[0])}


def copy_source(to: Path, worktree: bool) -> str:
    """HEAD, what git would take, or all but builds; with times of now, for ninja. Returns the commit."""
    shutil.rmtree(to, ignore_errors=True)
    if not (ROOT / ".git").exists():
        shutil.copytree(ROOT, to, symlinks=True, copy_function=shutil.copy, ignore=lambda folder, names: {
            n for n in names if Path(folder, n) in (ROOT / "build", ROOT / ".carry", to.parent)})
        return "unknown"
    commit = git("rev-parse", "HEAD").strip()
    if not worktree:
        git("clone", "--quiet", "--no-hardlinks", str(ROOT), str(to))
        return commit
    for name in filter(None, git("ls-files", "-coz", "--exclude-standard").split("\0")):
        if os.path.lexists(ROOT / name):
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, to / name, follow_symlinks=False)
    return commit + " with uncommitted changes"


@contextlib.contextmanager
def bug_in(tree: Path, row: Row) -> Iterator[None]:
    path = tree / row["file"]
    text = path.read_text("utf-8")
    path.write_text(text.replace(row["old"], row["new"]), "utf-8")
    try:
        yield
    finally:
        path.write_text(text, "utf-8")


class Build:
    def __init__(self, folder: Path, tree: Path, cmake: list[str], jobs: int) -> None:
        self.folder, self.jobs, self.log = folder, str(jobs), folder.parent / "build.log"
        self.usual: set[str] | None = None  # what fails of all tests without a bug
        if not self.succeeds("cmake", "-S", str(tree), "-B", str(folder), *cmake):
            sys.exit(f"cmake does not configure; see {self.log}")

    def succeeds(self, *command: str) -> bool:
        with open(self.log, "w", encoding="utf-8") as log:
            return subprocess.run(command, stdout=log, stderr=log, check=False).returncode == 0

    def make(self, tests: list[Test], has_bug: bool = True) -> bool:
        """What the tests need; everything where there are none."""
        targets = [word for test in tests for word in ("--target", test["target"])]
        made = self.succeeds("cmake", "--build", str(self.folder), "-j", self.jobs, *targets)
        if not (made or has_bug):
            sys.exit(f"without a bug it does not compile; see {self.log}")
        return made

    def ctest(self, *command: str) -> str:
        return subprocess.run(["ctest", "--test-dir", str(self.folder), *command], check=False,
                              capture_output=True, text=True).stdout

    def programs(self) -> dict[str, Row]:
        """By target, what ctest runs of it: parts are numbered."""
        tests = json.loads(self.ctest("--show-only=json-v1"))["tests"]
        return {re.sub(r"/\d+$", "_test", test["name"]): test for test in tests}

    def run(self, test: Test) -> tuple[str, int]:
        """What fails, or nothing, and how many cases pass. As ctest runs it, but all parts at once."""
        program = self.programs()[test["target"]]
        properties = {entry["name"]: entry["value"] for entry in program["properties"]}
        settings = os.environ | dict(entry.split("=", 1) for entry in properties["ENVIRONMENT"])
        settings |= {"GTEST_TOTAL_SHARDS": "1", "GTEST_SHARD_INDEX": "0"}
        command = [*program["command"], "--gtest_filter=" + test.get("filter", "*")]
        try:
            ended = subprocess.run(command, cwd=properties["WORKING_DIRECTORY"], env=settings,
                                   check=False, timeout=LIMIT, errors="replace",
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        except subprocess.TimeoutExpired:
            return f"{test['target']}: no end within {LIMIT} s", 0
        passed = re.search(r"\[  PASSED  \] (\d+) test", ended.stdout)
        if ended.returncode == 0:
            return "", int(passed[1]) if passed else 0
        failed = re.search(r"\[  FAILED  \] (\w[\w/]*\.[\w/]+)", ended.stdout)
        return f"{test['target']} {failed[1] if failed else f'ends with {ended.returncode}'}", 0

    def failing(self) -> set[str]:
        said = self.ctest("-LE", LEFT_OUT, "-j", self.jobs)
        if "tests passed," not in said:
            sys.exit(f"ctest runs nothing: {said[-500:]}")
        return set(re.findall(r"^\s*\d+ - (\S+) \((?!Skipped|Disabled)", said, re.MULTILINE))

    def own_tests(self, rows: list[Row]) -> dict[str, list[Test]]:
        """The tests of each row that this build has; without a bug they pass."""
        built = self.programs()
        chosen = {row["id"]: [test for test in row["tests"] if test["target"] in built] for row in rows}
        self.make([test for tests in chosen.values() for test in tests], has_bug=False)
        for name, tests in chosen.items():
            for test in list(tests):
                failed, passed = self.run(test)
                if failed:
                    sys.exit(f"{name}: without a bug, too, {failed}; correct mutations.json")
                if passed == 0:
                    tests.remove(test)
        return chosen

    def result(self, tree: Path, row: Row, tests: list[Test]) -> list[str]:
        """caught, survives or does not compile; then which tests catch the bug."""
        with bug_in(tree, row):
            if tests and not self.make(tests):
                return ["does not compile"]
            for test in tests:
                if failed := self.run(test)[0]:
                    return ["caught", failed]
        if self.usual is None:
            self.make([], has_bug=False)
            self.usual = self.failing()
        with bug_in(tree, row):
            if not self.make([]):
                return ["does not compile"]
            names = sorted(self.failing() - self.usual)
        return ["caught" if names else "survives", *names]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--build", default=USUAL, help="a preset, or --build='arguments of cmake'")
    parser.add_argument("--only", nargs="+", metavar="ID")
    parser.add_argument("--group", choices=("failure_modes", "math", "recon4d_ingest"))
    parser.add_argument("--folder", type=Path, default=ROOT / "build/mutations")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=Path, metavar="OUT")
    parser.add_argument("--worktree", action="store_true", help="with uncommitted changes, not HEAD")
    parser.add_argument("--trainer-only", action="store_true", help="without media and player")
    parser.add_argument("-D", action="append", metavar="KEY=VALUE", default=[], help="for cmake")
    args = parser.parse_args()
    begin, tree = time.monotonic(), args.folder.resolve() / "source"
    known = json.loads((ROOT / "scripts/mutations.json").read_text("utf-8"))
    rows = [row for row in known if row["id"] in (args.only or [row["id"]])
            and args.group in (None, row["group"])
            and not (args.trainer_only and row["file"] in media_files())]
    commit = copy_source(tree, args.worktree)
    wrong = [row["id"] for row in rows if (tree / row["file"]).read_text("utf-8").count(row["old"]) != 1]
    wrong += set(args.only or []) - {row["id"] for row in known}
    if wrong or not rows:
        sys.exit(f"no such row, or its old text is not in its file once: {wrong}")
    cmake = shlex.split(args.build) if args.build.startswith("-") else ["--preset", args.build]
    cmake += ["-DTESSERA_TESTS=ON"] + ["-GNinja"] * bool(shutil.which("ninja"))
    cmake += ["-DTESSERA_INGEST=OFF", "-DTESSERA_PLAYER=OFF"] * args.trainer_only
    build = Build(tree.parent / "build", tree, cmake + [f"-D{value}" for value in args.D], args.jobs)
    chosen = build.own_tests(rows)
    table = []
    try:
        for row in [row for row in rows if chosen[row["id"]] or not args.trainer_only]:
            start = time.monotonic()
            result, *by = build.result(tree, row, chosen[row["id"]])
            seconds = round(time.monotonic() - start, 1)
            shown = f"caught by {', '.join(by[:3])}" if by else result.upper()
            shown += "" if chosen[row["id"]] else " (no test of its own runs here)"
            print(f"{row['id']:22} {row['file']:42} {shown}  {seconds} s", flush=True)
            table.append({key: row[key] for key in ("id", "group", "mode", "file", "what")} |
                         {"result": result, "by": by, "seconds": seconds})
    finally:
        results = [entry["result"] for entry in table]
        print(f"{results.count('caught')} of {len(table)} caught, {len(rows) - len(table)} not tried")
        version = re.findall(r"project\(tessera VERSION ([\d.]+)", (tree / "CMakeLists.txt").read_text())
        if args.json:
            args.json.write_text(json.dumps({
                "version": "".join(version), "commit": commit, "cores": os.cpu_count(),
                "seconds": round(time.monotonic() - begin), "rows": table}, indent=1) + "\n", "utf-8")
    sys.exit(int(results.count("survives") > 1 or "does not compile" in results))


if __name__ == "__main__":
    main()
