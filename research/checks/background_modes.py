#!/usr/bin/env python3
"""background_modes.py VIDEO WIDTH HEIGHT FRAMES: pixels that the background of a long clip leaves out.

For every third pixel of a video of a rig: whether it is masked as ingest/derived/static_scene.cpp does
(limits of a rig without noise), and whether its masked pixels have one colour in 40 % of the images and
in 25 % of those of each quarter. Needs ffmpeg.
"""
import subprocess
import sys

QUARTERS, MOMENTS = 4, 31
GOLDEN_RATIO = 0.6180339887498949
MOST_BESIDE_MEDIAN, MOST_BETWEEN_QUARTERS = 12, 10  # 8-bit units
AT_REST, SHARE, SHARE_OF_QUARTER = 0.6, 0.4, 0.25


def chosen_frames(count):
    frames = []
    for quarter in range(QUARTERS):
        begin, end = quarter * count // QUARTERS, (quarter + 1) * count // QUARTERS
        for i in range(MOMENTS):
            within = i * GOLDEN_RATIO % 1
            frames.append(begin + int((i + within) * (end - begin) / MOMENTS))
    return frames


def near(a, b, most):
    return all(abs(x - y) <= most for x, y in zip(a, b))


def share_of(values, value):
    return sum(near(other, value, MOST_BESIDE_MEDIAN) for other in values) / len(values)


def main(video, width, height, count):
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-f", "rawvideo", "-pix_fmt",
                          "rgb24", "-"], stdout=subprocess.PIPE, check=True).stdout
    size = 3 * width * height
    images = [raw[k * size:(k + 1) * size] for k in chosen_frames(count)]
    pixels = masked = changed = restless = one_colour = 0
    for at in range(0, size, 9):
        pixels += 1
        values = [tuple(image[at:at + 3]) for image in images]
        parts = [values[MOMENTS * q:MOMENTS * (q + 1)] for q in range(QUARTERS)]
        medians = [tuple(sorted(v[c] for v in part)[MOMENTS // 2] for c in range(3))
                   for part in parts]
        differs = not all(near(a, b, MOST_BETWEEN_QUARTERS) for a in medians for b in medians)
        rest = sum(share_of(part, median) for part, median in zip(parts, medians)) / QUARTERS
        if not differs and rest >= AT_REST:
            continue
        masked += 1
        changed += differs
        restless += rest < AT_REST
        most = max(values[::2], key=lambda value: share_of(values, value))
        one_colour += (share_of(values, most) >= SHARE and
                       all(share_of(part, most) >= SHARE_OF_QUARTER for part in parts))
    print(f"{video}: {masked / pixels:.3f} masked; {changed / pixels:.3f} by medians, "
          f"{restless / pixels:.3f} seldom at rest; of these {one_colour / max(masked, 1):.2f} "
          f"mostly of one colour")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
