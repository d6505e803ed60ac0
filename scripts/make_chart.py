#!/usr/bin/env python3
"""Draws PSNR against the seconds of a training from results/*.json.

    make_chart.py           writes docs/charts/SCENE.svg
    make_chart.py --check   writes nothing; exit code 1 where the files are not what it would write

A chart has a scene, and is as wide as a phone. Its colours follow the colour scheme of the page.
A point is a preset: the median PSNR over the seeds (of `val` where there is one), and the
seconds of one training alone on the card, where the results files have both.
"""

import argparse
import math
import pathlib
import statistics
import sys

from make_tables import ROOT, load_results

OUT = ROOT / "docs" / "charts"
SCENES = {"studio": "studio, ten cameras", "basketball": "basketball, 27 cameras",
          "dnerf_lego": "dnerf_lego, one camera", "figure": "figure, one camera",
          "mic": "mic, rendered images", "bonsai": "bonsai, photos"}
WIDTH, HEIGHT, MARGIN_X, MARGIN_Y = 360, 230, 42, 44
SECONDS = (1, 500)
STYLE = """<style>
svg { --ground: #fff; --ink: #333; --grid: #ddd; --ours: #1d4ed8; --other: #b45309; fill: var(--ink); }
@media (prefers-color-scheme: dark) {
  svg { --ground: #2e303e; --ink: #e2e4e9; --grid: #4a4d5e; --ours: #8fb0ff; --other: #fbbf24; }
}
rect { fill: var(--ground); }
path { fill: none; stroke: var(--grid); }
.curve { stroke: var(--ours); stroke-width: 2; }
circle { fill: var(--ours); }
.other { fill: var(--other); }
</style>"""
NAMES = {"official": "Faster-GS, H200"}  # of what another program made, elsewhere


def points(results):
    """{scene: [(seconds, PSNR, preset)]}, ascending by seconds."""
    quality, seconds = {}, {}
    for result in results.values():
        for row in result["rows"]:
            place = row.get("scene"), row.get("preset")
            scores = row.get("psnr_val") or row.get("psnr")
            if scores:
                quality[place] = statistics.median(scores)
            if row.get("seconds"):
                seconds[place] = statistics.median(row["seconds"])
    scenes = {}
    for scene, preset in sorted(quality.keys() & seconds.keys()):
        if scene in SCENES:
            scenes.setdefault(scene, []).append(
                (seconds[scene, preset], quality[scene, preset], preset))
    return {scene: sorted(of_scene) for scene, of_scene in scenes.items()}


def text(left, top, words, more=""):
    return f'<text x="{left:.1f}" y="{top:.1f}"{more}>{words}</text>'


def drawn(title, of_scene):
    """The chart of a scene."""
    low = math.floor(min(psnr for _, psnr, _ in of_scene)) - 1
    high = math.ceil(max(psnr for _, psnr, _ in of_scene)) + 1
    left, top, right, bottom = MARGIN_X, 26, WIDTH - 14, HEIGHT - MARGIN_Y

    def x(value):
        share = math.log(value / SECONDS[0]) / math.log(SECONDS[1] / SECONDS[0])
        return left + (right - left) * share

    def y(value):
        return bottom - (bottom - top) * (value - low) / (high - low)

    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             f'width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" font-size="12">',
             STYLE, f'<rect width="{WIDTH}" height="{HEIGHT}"/>',
             text(left, 16, f"{title}: PSNR, dB", ' font-weight="bold"'),
             text((left + right) / 2, bottom + 34, "seconds of a training",
                  ' text-anchor="middle"')]
    for tick in (1, 2, 5, 10, 20, 50, 100, 200, 500):
        lines += [f'<path d="M{x(tick):.1f} {top}V{bottom}"/>',
                  text(x(tick), bottom + 17, tick, ' text-anchor="middle"')]
    for tick in range(low, high + 1, 1 if high - low < 6 else 2):
        lines += [f'<path d="M{left} {y(tick):.1f}H{right}"/>',
                  text(left - 6, y(tick) + 4, tick, ' text-anchor="end"')]
    curve = [point for point in of_scene if point[2] in ("fast", "balanced", "best")]
    path = "L".join(f"{x(seconds):.1f} {y(psnr):.1f}" for seconds, psnr, _ in curve)
    lines.append(f'<path class="curve" d="M{path}"/>')
    for seconds, psnr, preset in of_scene:
        elsewhere = preset in NAMES
        ends = preset == "balanced" or elsewhere  # where its mark is
        below = preset == "fast" or elsewhere
        mark = ' class="other"' if elsewhere else ""
        lines += [f'<circle cx="{x(seconds):.1f}" cy="{y(psnr):.1f}" r="4"{mark}/>',
                  text(x(seconds) + (6 if elsewhere else -6), y(psnr) + (18 if below else -8),
                       NAMES.get(preset, preset), ' text-anchor="end"' if ends else "")]
    return "\n".join(lines + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    of_scenes = points(load_results(ROOT / "results"))
    charts = {OUT / f"{scene}.svg": drawn(title, of_scenes[scene])
              for scene, title in SCENES.items()}
    if not asked.check:
        OUT.mkdir(exist_ok=True)
        for path, chart in charts.items():
            path.write_text(chart)
    elif {path: path.read_text() for path in OUT.glob("*")} != charts:
        sys.exit(f"{OUT}: is not what results/ say; run scripts/make_chart.py")


if __name__ == "__main__":
    main()
