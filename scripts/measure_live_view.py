#!/usr/bin/env python3
"""Measures the cost of viewing a training while it runs.

    measure_live_view.py SCENE [--tessera build/release/tessera] [--runs 5] [--out FILE.json]
                         [-- OPTION...]

Trains in pairs: alone, and with a `tessera view` from which every snapshot is fetched as soon as it
exists, as the page does. No browser is involved. Options after -- are
passed to every training. Prints the seconds of each and the medians; the models must be equal.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse
import urllib.request


def output_of(command):
    """What a command prints; ends this program where it fails."""
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {result.returncode}\n{result.stderr[-2000:]}")
    return result.stdout.strip()


def arguments_and_options():
    """The words of the command line before -- and after it."""
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    return words[:split], words[split + 1:]


class Visitor:
    """Somebody who looks at a training from another machine."""

    def __init__(self, tessera, run):
        self.server = subprocess.Popen([tessera, "view", str(run), "--no-browser", "--json", "-q"],
                                       stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        lines = []
        while not lines or not lines[-1].startswith("}"):  # its JSON; it runs on
            lines.append(self.server.stdout.readline())
            if lines[-1] == "":
                sys.exit(f"tessera view {run} ended with exit code {self.server.wait()}")
        self.address = json.loads("".join(lines))["url"]
        self.opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        self.opener.open(self.address).read()  # takes the token
        self.snapshots = self.scores = 0
        self.leaves = threading.Event()
        self.thread = threading.Thread(target=self.look)
        self.thread.start()

    def get(self, path):
        with self.opener.open(urllib.parse.urljoin(self.address, path)) as answer:
            return answer.read()

    def look(self):
        while not self.leaves.wait(1):
            state = json.loads(self.get(f"/api/state?seen={self.snapshots}"))
            self.scores = max(self.scores, len(state["scores"]))
            if state["snapshot"] and state["state"]["snapshot"] > self.snapshots:
                self.get(state["snapshot"])
                self.snapshots = state["state"]["snapshot"]

    def leave(self):
        self.leaves.set()
        self.thread.join()
        self.server.terminate()
        self.server.wait()


def train(tessera, scene, options, watched):
    with tempfile.TemporaryDirectory() as folder:
        run = pathlib.Path(folder) / "run"
        command = [tessera, "train", scene, "-o", str(run), *options, "--json"]
        training = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                    text=True)
        visitor = None
        if watched:
            while not (run / "config.json").exists() and training.poll() is None:
                time.sleep(0.05)
            visitor = Visitor(tessera, run)
        out, err = training.communicate()
        if visitor:
            visitor.leave()
        if training.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit code {training.returncode}\n{err[-2000:]}")
        record = json.loads(out)
        return {"watched": watched, "seconds": record["seconds"], "device": record["device"],
                "snapshots": visitor.snapshots if visitor else 0,
                "scores": visitor.scores if visitor else 0,
                "model": (run / "model.ply").read_bytes()}


def result_of(asked, options, runs, equal):
    """A results file, see docs/development/results.md."""
    def row(watched):
        these = [run for run in runs if run["watched"] == watched]
        return {"training": "watched" if watched else "alone",
                "seconds": [run["seconds"] for run in these],
                "snapshots": [run["snapshots"] for run in these]}
    scene = pathlib.Path(asked.scene).name
    return {
        "id": asked.out.stem, "version": output_of([asked.tessera, "--version"]).split()[-1],
        "commit": asked.commit or output_of(["git", "rev-parse", "--short", "HEAD"]),
        "date": time.strftime("%Y-%m-%d"), "device": runs[0]["device"],
        "command": " ".join(["measure_live_view.py", scene, *(["--", *options] if options else [])]),
        "note": f"The models are {'equal' if equal else 'not equal'} to the bit.",
        "labels": ["training"],
        "columns": ["seconds", {"key": "snapshots", "heading": "snapshots", "digits": 0}],
        "rows": [row(False), row(True)],
    }


def main():
    arguments, options = arguments_and_options()
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--tessera", default="build/release/tessera")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--commit", help="of the program; default: what git says")
    parser.add_argument("--out", type=pathlib.Path)
    asked = parser.parse_args(arguments)
    runs, model, equal = [], None, True
    for pair in range(asked.runs):
        for watched in (False, True) if pair % 2 == 0 else (True, False):
            run = train(asked.tessera, asked.scene, options, watched)
            bytes_of_model = run.pop("model")
            model = model or bytes_of_model
            equal = equal and model == bytes_of_model
            runs.append(run)
            print(json.dumps(run), flush=True)
    median = {watched: statistics.median(r["seconds"] for r in runs if r["watched"] == watched)
              for watched in (False, True)}
    cost = median[True] / median[False] - 1
    if asked.out:
        asked.out.write_text(json.dumps(result_of(asked, options, runs, equal), indent=1) + "\n")
    print(f"alone {median[False]:.2f} s, watched {median[True]:.2f} s: {cost:+.1%};",
          "equal models" if equal else "the models differ")


if __name__ == "__main__":
    main()
