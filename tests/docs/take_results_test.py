"""Tests of scripts/take_results.py on small reports of batches."""

import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"


def run_of(seed, scene="room", variant="fast", **changes):
    """A run as report.json has it."""
    run = {"scene": scene, "variant": variant, "preset": variant, "seed": seed, "state": "done",
           "split": "test", "version": "0.2.0", "commit": "abc", "device": "cuda, a device",
           "host": "here", "started": f"2026-11-28T05:{10 * seed:02}:00Z",
           "options": {"seed": seed, "iterations": 40},
           "command": f"tessera train scenes/{scene} -o runs/{scene}/{variant}/seed-{seed} "
                      f"--resume=auto --overwrite --preset {variant} --iterations 40 --seed {seed} "
                      "--deterministic false --backend cuda --threads 2 --json",
           "scores": {"psnr": 27 + seed / 10, "psnr_dynamic": None, "psnr_static": None,
                      "psnr_fit": 28.0, "ssim": 0.9, "lpips": None},
           "worst": {"frame_number": 3, "psnr": 26.0}, "objects": [],
           "size": {"static": 4, "dynamic": 6, "peak_bytes": 2**20, "shipped_bytes": 100},
           "seconds": {"training": 60.0 + seed, "command": 90.0 + seed}, "files": []}
    return run | changes


class TakeResults(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def report(self, runs, name="OUT", **changes):
        path = self.root / name / "report/report.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        report = {"schema": 1, "kind": "batch", "runs": runs} | changes
        path.write_text(json.dumps(report))
        return path

    def take(self, runs, *options, reports=()):
        """The results file, or what the script complains of."""
        reports = reports or [self.report(runs)]
        result = subprocess.run([sys.executable, SCRIPTS / "take_results.py", *reports, "--id", "q",
                                 "-o", self.root, *options], capture_output=True, text=True, check=False)
        if result.returncode != 0:
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            return result.stderr
        return json.loads((self.root / "q.json").read_text())

    # Bug put back: runs in the order of the report; seen to fail.
    def test_rows_are_scenes_and_presets_with_seeds_ascending(self):
        result = self.take([run_of(3), run_of(1), run_of(2), run_of(1, variant="best", host="b")],
                           "--presets", "fast")
        rows = result.pop("rows")
        self.assertEqual(result, {
            "id": "q", "version": "0.2.0", "commit": "abc", "date": "2026-11-28",
            "device": "a device",
            "command": "tessera train room -o RUN --preset PRESET --seed SEED --iterations 40"})
        self.assertEqual(rows, [
            {"scene": "room", "preset": "fast", "seeds": [1, 2, 3], "psnr": [27.1, 27.2, 27.3],
             "psnr_moving": None, "psnr_static": None, "ssim": [0.9] * 3,
             "seconds": [61.0, 62.0, 63.0], "whole_seconds": [91.0, 92.0, 93.0],
             "num_gaussians": [10] * 3, "shipped_bytes": [100] * 3, "psnr_fit": [28.0] * 3,
             "psnr_lowest": [26.0] * 3, "peak_bytes": [2**20] * 3}])

    # Bug put back: every scene with the presets of all; seen to fail.
    def test_reports_are_joined_where_scenes_have_other_presets(self):
        yard = run_of(1, "yard", "best", started="2026-11-29T06:00:00Z")
        result = self.take([], reports=[self.report([run_of(1)]), self.report([yard], "SECOND")])
        self.assertEqual([(row["scene"], row["preset"]) for row in result["rows"]],
                         [("room", "fast"), ("yard", "best")])
        self.assertEqual(result["date"], "2026-11-29")
        self.assertEqual(result["command"],
                         "tessera train SCENE -o RUN --preset PRESET --seed SEED --iterations 40")

    # Bugs put back, each seen to fail: the value of an option of the session kept as a word; options
    # that were given to some runs only left out.
    def test_command_has_the_options_that_its_model_depends_on(self):
        words = ("tessera train scenes/room -o=runs/r --preset=best --seed=1 --deterministic true "
                 "--time-limit 5 --checkpoint-every=9 --background '1, 2,3'")
        result = self.take([run_of(1), run_of(1, variant="best", command=words, host="b")])
        start = "tessera train room -o RUN --preset PRESET --seed SEED "
        self.assertEqual(result["command"],
                         f"{start}--iterations 40; {start}--deterministic --background '1, 2,3'")

    # Bugs put back, each seen to fail: scores as they are; sizes as they are.
    def test_scores_have_four_decimals_and_sizes_none(self):
        run = run_of(1)
        run["scores"] |= {"psnr": 27.123456789, "lpips": 0.12345678}
        run["size"]["shipped_bytes"] = 15457.0
        row = self.take([run])["rows"][0]
        self.assertEqual((row["psnr"], row["lpips"]), ([27.1235], [0.1235]))
        self.assertEqual(json.dumps(row["shipped_bytes"]), "[15457]")

    # Bugs put back, each seen to fail: the mean of an object for its lowest timestep; `val` of every
    # scene.
    def test_more_scores_are_in_the_file_that_the_report_names(self):
        scores = {"splits": {"test": {"psnr": 27.1}, "val": {"psnr": 25.5}},
                  "objects": [{"name": "ball", "psnr": 19, "worst": {"psnr": 14.5}},
                              {"name": "arm", "psnr": 20, "worst": {"psnr": 13.5}}]}
        file = self.root / "OUT/runs/metrics.json"
        file.parent.mkdir(parents=True)
        file.write_text(json.dumps(scores))
        run = run_of(1, files=[{"name": "Scores", "path": "../runs/metrics.json", "bytes": 1}])
        row = self.take([run], "--val", "yard,room")["rows"][0]
        self.assertEqual((row["psnr_val"], row["psnr_object"]), ([25.5], [13.5]))
        self.assertNotIn("psnr_val", self.take([run], "--val", "yard")["rows"][0])

    # Bug put back: the file written as if it were new; seen to fail.
    def test_repeated_measurement_keeps_the_words_of_the_file(self):
        (self.root / "q.json").write_text(json.dumps(
            {"id": "q", "version": "0.0.1", "commit": "old", "note": "A note.", "columns": ["psnr"],
             "rows": []}))
        result = self.take([run_of(1)])
        self.assertEqual((result["note"], result["columns"]), ("A note.", ["psnr"]))
        self.assertEqual((result["version"], result["commit"], len(result["rows"])),
                         ("0.2.0", "abc", 1))

    # Bug put back: --commit for runs that have another one; seen to fail.
    def test_commit_is_told_where_the_report_does_not_have_it(self):
        bare = run_of(1)
        del bare["commit"]
        self.assertIn("its commit is not known", self.take([copy.deepcopy(bare)]))
        self.assertEqual(self.take([bare], "--commit", "def")["commit"], "def")
        self.assertEqual(self.take([run_of(1)], "--commit", "def")["commit"], "abc")

    # Bugs put back, each seen to fail: no comparison of the fields; a seed that occurs twice counts.
    def test_refuses_what_does_not_belong_together(self):
        self.assertIn("a seed occurs twice",
                      self.take([run_of(1), run_of(1, started="2026-11-28T07:00:00Z")]))
        for field in ("version", "commit", "device"):
            self.assertIn(f"differ in {field}", self.take([run_of(1), run_of(2, **{field: "other"})]))
        self.assertIn("differ in options",
                      self.take([run_of(1), run_of(2, options={"iterations": 30})]))
        self.assertIn("no training of yard with fast", self.take([run_of(1)], "--scenes", "yard"))
        self.assertIn("expected the report of a batch",
                      self.take([], reports=[self.report([run_of(1)], kind="run")]))

    # Bugs put back, each seen to fail: a run that failed, training views, and a row with fewer seeds
    # than another taken.
    def test_refuses_runs_without_their_scores(self):
        self.assertIn("room fast seed 2: is failed", self.take([run_of(1), run_of(2, state="failed")]))
        self.assertIn("scored on the split train", self.take([run_of(1, split="train")]))
        best = run_of(1, variant="best", host="b")
        self.assertIn("room best: has no seed 2", self.take([run_of(1), run_of(2), best]))
        unscored = run_of(2)
        unscored["scores"]["ssim"] = None
        self.assertIn("scores ssim is null for some seeds only", self.take([run_of(1), unscored]))

    # Bugs put back, each seen to fail: no comparison of times; none of the machines.
    def test_refuses_trainings_that_ran_side_by_side(self):
        beside = run_of(2, started="2026-11-28T05:10:30Z")
        self.assertIn("room fast seed 2: began while room fast seed 1 ran",
                      self.take([beside, run_of(1)]))
        self.assertEqual(len(self.take([run_of(1), beside | {"host": "there"}])["rows"]), 1)


if __name__ == "__main__":
    unittest.main()
