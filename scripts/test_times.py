#!/usr/bin/env python3
"""Prints the seconds of all tests of a build together and its ten slowest; --store keeps them.

test_times.py [build/ci] [--store]    --store writes results/tests.json

The times are those that ctest keeps of the last runs; tests that run side by side count each.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import time

arguments = [a for a in sys.argv[1:] if a != "--store"]
build = pathlib.Path(arguments[0] if arguments else "build/ci")
seconds = {}
for line in (build / "Testing/Temporary/CTestCostData.txt").read_text().splitlines():
    words = line.split()
    if len(words) == 3:
        seconds[words[0]] = float(words[2])
slowest = sorted(seconds, key=seconds.get, reverse=True)[:10]
total = sum(seconds.values())
print(f"{len(seconds)} tests, {total:.0f} s; the slowest:")
for name in slowest:
    print(f"{seconds[name]:8.1f} s  {name}")
if "--store" in sys.argv:
    version = re.search(r"VERSION ([\d.]+)", pathlib.Path("CMakeLists.txt").read_text()).group(1)
    commit = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], capture_output=True, text=True)
    rows = [{"test": name, "seeds": [1], "seconds": [round(s, 1)]}
            for name, s in [("all", total), *((name, seconds[name]) for name in slowest)]]
    facts = {"id": "tests", "version": version, "commit": commit.stdout.strip(), "date": time.strftime("%Y-%m-%d"),
             "device": f"CPU, {os.cpu_count()} threads", "command": "scripts/test.sh ci", "labels": ["test"],
             "columns": ["seconds"], "rows": rows}
    pathlib.Path("results/tests.json").write_text(json.dumps(facts, indent=1) + "\n")
