"""Tests of scripts/make_tables.py on a small tree: correct files pass, and each planted mistake is
reported in one line."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"
BLOCK = "<!-- table: quality_a -->\n<!-- end table -->\n"


def row(scene, psnr, seconds):
    return {"scene": scene, "preset": "fast", "seeds": [1, 2, 3], "psnr": psnr, "ssim": None,
            "seconds": seconds, "num_gaussians": [46981, 47020, 47010],
            "shipped_bytes": [5 * 2**20] * 3}


RESULT = {"id": "quality_a", "version": "0.1.0", "commit": "abc", "date": "2026-11-24",
          "device": "a device", "command": "tessera train",
          "rows": [row("room", [27.1, 27.3, 27.2], [60, 62, 61]),
                   row("yard", [31.0, 30.0, 32.0], [120, 122, 121])]}


class MakeTables(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for name in ("docs", "results"):
            (self.root / name).mkdir()
        (self.root / "docs/results.md").write_text("# Results\n\n" + BLOCK)
        (self.root / "results/quality_a.json").write_text(json.dumps(RESULT))
        self.text("")
        self.run_script()

    def tearDown(self):
        self.folder.cleanup()

    def text(self, text):
        (self.root / "README.md").write_text(text)

    def run_script(self, *options):
        return subprocess.run([sys.executable, SCRIPTS / "make_tables.py", "--root", self.root,
                               *options], capture_output=True, text=True, check=False)

    def complaints(self, text=""):
        self.text(text)
        result = self.run_script("--check")
        lines = result.stderr.splitlines()
        self.assertEqual(result.returncode, 1 if lines else 0)
        return lines

    def test_fills_blocks_with_median_and_range(self):
        page = (self.root / "docs/results.md").read_text()
        self.assertIn("| `room` | `fast` | 27.20 | 61.0 | 5.0 |", page)
        self.assertIn("| measure | `room` `fast` | `yard` `fast` |", page)
        self.assertIn("| PSNR, dB | 27.20 (27.10–27.30) | 31.00 (30.00–32.00) |", page)
        self.assertIn("Version 0.1.0 (commit abc), a device, 2026-11-24, seeds 1, 2, 3:", page)
        self.assertEqual(self.complaints(), [])

    def test_reports_blocks_that_are_wrong(self):
        page = self.root / "docs/results.md"
        page.write_text(page.read_text().replace("27.20", "27.21"))
        self.assertIn("quality_a is stale", self.complaints()[0])
        page.write_text(BLOCK.replace("_a", "_b"))
        self.assertIn("results/quality_b.json does not exist", self.complaints()[0])
        page.write_text(BLOCK.splitlines()[0] + "\n")
        self.assertIn("has no <!-- end table -->", self.complaints()[0])
        page.write_text("```\n" + BLOCK + "```\n")
        self.assertEqual(self.complaints(), [])

    def test_accepts_figures_at_their_printed_precision(self):
        self.assertEqual(self.complaints("In room 27.2 dB, 27 dB, 61 s, 1.0 min, 5.2 MB.\n"), [])
        self.assertEqual(self.complaints("In room 47,000 Gaussians, 47,010 Gaussians.\n"), [])
        self.assertEqual(self.complaints("`--max-bytes 9MB`, ` 9 dB`\n```sh\n9 dB\n```\n"), [])
        self.assertEqual(self.complaints("8 × 4 pixels, 600 × 600, cam03, 1280x720\n"), [])
        self.assertEqual(self.complaints("within 9 dB <!-- setting --> of it\n"), [])

    def test_rejects_planted_figures(self):
        for wrong in ("27.3 dB", "27.20001 dB", "62 s", "6 MB", "46,000 Gaussians", "47,011 Gaussians",
                      "0.06 million Gaussians", "28.0 dB"):
            lines = self.complaints(f"# Title\n\nIn room it is {wrong}.\n")
            self.assertEqual(len(lines), 1, wrong)
            self.assertTrue(lines[0].startswith(f"README.md:3: {wrong}: "), lines[0])
        self.assertEqual(len(self.complaints("| room | 31.0 dB |\n| yard | 31.0 dB |\n")), 1)

    def test_sources_settle_ambiguity(self):
        self.assertIn("room, yard have it; name one", self.complaints("5.0 MiB\n")[0])
        room = "quality_a room fast"
        self.assertEqual(self.complaints(f"5.0 MiB <!-- from: {room} shipped_bytes -->\n"), [])
        self.assertEqual(self.complaints(f"27.3 dB <!-- from: {room} psnr max -->\n"), [])
        self.assertIn("is 27.2", self.complaints(f"27.3 dB <!-- from: {room} psnr -->\n")[0])
        self.assertIn("is not in dB", self.complaints(f"61 dB <!-- from: {room} seconds -->\n")[0])
        self.assertIn("results/ has no", self.complaints("1 s <!-- from: a b c d -->\n")[0])

    def test_ratios_and_differences(self):
        ratio = "<!-- from: quality_a yard fast seconds / quality_a room fast seconds -->"
        more = "<!-- from: quality_a yard fast psnr - quality_a room fast psnr -->"
        self.assertEqual(self.complaints(f"2.0 times as fast {ratio}, 3.8 dB {more} more\n"), [])
        self.assertIn("is 1.98", self.complaints(f"2.1× {ratio}\n")[0])
        self.assertIn("a ratio names its source", self.complaints("2× faster\n")[0])
        self.assertIn("a ratio names its source", self.complaints("2 times smaller\n")[0])


if __name__ == "__main__":
    unittest.main()
