#!/usr/bin/env python3
"""Draws PSNR against the seconds of a training from results/*.json.

    make_chart.py           writes docs/quality_seconds.svg
    make_chart.py --check   writes nothing; exit code 1 where the file is not what it would write

A point is a scene and a preset: the median PSNR over the seeds (of `val` where there is one), and the
seconds of one training alone on the card, where the results files have both.
"""

import argparse
import math
import pathlib
import statistics
import sys

from make_tables import ROOT, load_results

OUT = ROOT / "docs" / "quality_seconds.svg"
SCENES = {"studio": "studio, ten cameras", "basketball": "basketball, 27 cameras",
          "dnerf_lego": "dnerf_lego, one camera", "figure": "figure, one camera",
          "mic": "mic, rendered images", "bonsai": "bonsai, photos"}
WIDTH, HEIGHT, MARGIN_X, MARGIN_Y = 360, 230, 50, 44  # of a panel, of which two are in a row
SECONDS = (1, 500)
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


def panel(title, of_scene, left, top):
    """The lines of a panel whose corner is at (left, top)."""
    low = math.floor(min(psnr for _, psnr, _ in of_scene)) - 1
    high = math.ceil(max(psnr for _, psnr, _ in of_scene)) + 1
    right, bottom = left + WIDTH - 12, top + HEIGHT - MARGIN_Y

    def x(value):
        share = math.log(value / SECONDS[0]) / math.log(SECONDS[1] / SECONDS[0])
        return left + MARGIN_X + (right - left - MARGIN_X) * share

    def y(value):
        return bottom - (bottom - top - 26) * (value - low) / (high - low)

    lines = [text(left + MARGIN_X, top + 16, title, ' font-weight="bold"'),
             text((left + MARGIN_X + right) / 2, bottom + 34, "seconds of a training",
                  ' text-anchor="middle"')]
    for tick in (1, 2, 5, 10, 20, 50, 100, 200, 500):
        lines += [f'<path d="M{x(tick):.1f} {top + 26}V{bottom}" stroke="#ddd"/>',
                  text(x(tick), bottom + 17, tick, ' text-anchor="middle"')]
    for tick in range(low, high + 1, 1 if high - low < 6 else 2):
        lines += [f'<path d="M{left + MARGIN_X} {y(tick):.1f}H{right}" stroke="#ddd"/>',
                  text(left + MARGIN_X - 6, y(tick) + 4, tick, ' text-anchor="end"')]
    curve = [point for point in of_scene if point[2] in ("fast", "balanced", "best")]
    path = "L".join(f"{x(seconds):.1f} {y(psnr):.1f}" for seconds, psnr, _ in curve)
    lines.append(f'<path d="M{path}" fill="none" stroke="#1d4ed8" stroke-width="2"/>')
    for seconds, psnr, preset in of_scene:
        elsewhere = preset in NAMES
        ends = preset == "balanced" or elsewhere  # where its mark is
        below = preset == "fast" or elsewhere
        lines += [f'<circle cx="{x(seconds):.1f}" cy="{y(psnr):.1f}" r="4" '
                  f'fill="{"#b45309" if elsewhere else "#1d4ed8"}"/>',
                  text(x(seconds) + (6 if elsewhere else -6), y(psnr) + (18 if below else -8),
                       NAMES.get(preset, preset), ' text-anchor="end"' if ends else "")]
    return lines


def drawn(scenes):
    size = 2 * WIDTH, (len(SCENES) + 1) // 2 * HEIGHT
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" '
             'font-family="sans-serif" font-size="12" fill="#333">',
             f'<rect width="{size[0]}" height="{size[1]}" fill="#fff"/>']
    for i, (scene, title) in enumerate(SCENES.items()):
        lines += panel(f"{title}: PSNR, dB", scenes[scene], i % 2 * WIDTH, i // 2 * HEIGHT)
    return "\n".join(lines + ["</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    chart = drawn(points(load_results(ROOT / "results")))
    if asked.check and (not OUT.exists() or OUT.read_text() != chart):
        sys.exit(f"{OUT}: is not what results/ say; run scripts/make_chart.py")
    if not asked.check:
        OUT.write_text(chart)


if __name__ == "__main__":
    main()
