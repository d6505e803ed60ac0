"""Files of captures: images of one scene, videos, and poses in the forms that `ingest` reads.

ingest_captures.py makes captures of them. The scene is a ball that moves over a floor with a
pattern. As a program it stands in for COLMAP: capture_files.py LOG COMMAND [OPTION=VALUE...].
"""
import json
import math
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path

WIDTH, HEIGHT, FOCAL = 48, 36, 45.0
LENS_IDS = {"SIMPLE_PINHOLE": 0, "PINHOLE": 1, "SIMPLE_RADIAL": 2, "OPENCV": 4}


# --- images -----------------------------------------------------------------------------------

def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


class Camera:
    """It looks at the origin of a world with z up; `axes` are right, down and forward."""

    def __init__(self, position):
        forward = unit([-x for x in position])
        right = unit(cross(forward, [0, 0, 1]))
        self.position, self.axes = list(position), [right, cross(forward, right), forward]

    def to_world(self):
        """-> camera to world, OpenGL axes"""
        right, down, forward = self.axes
        rows = [[right[i], -down[i], -forward[i], self.position[i]] for i in range(3)]
        return rows + [[0, 0, 0, 1]]

    def translation(self):
        return [-dot(axis, self.position) for axis in self.axes]

    def quaternion(self):
        m = self.axes
        trace = m[0][0] + m[1][1] + m[2][2]
        if trace > 0:
            k = 2 * math.sqrt(trace + 1)
            return [k / 4, (m[2][1] - m[1][2]) / k, (m[0][2] - m[2][0]) / k,
                    (m[1][0] - m[0][1]) / k]
        i = max(range(3), key=lambda a: m[a][a])
        j, n = (i + 1) % 3, (i + 2) % 3
        k = 2 * math.sqrt(m[i][i] - m[j][j] - m[n][n] + 1)
        q = [(m[n][j] - m[j][n]) / k, 0, 0, 0]
        q[1 + i], q[1 + j], q[1 + n] = k / 4, (m[j][i] + m[i][j]) / k, (m[n][i] + m[i][n]) / k
        return q


def arc(count):
    """Cameras side by side, so that neighbours see the same things."""
    angles = [0.9 * (i / max(1, count - 1) - 0.5) for i in range(count)]
    return [Camera((4 * math.cos(a), 4 * math.sin(a), 1.6 + 0.3 * (i % 3)))
            for i, a in enumerate(angles)]


def colour(origin, ray, time):
    offset = [origin[0], origin[1] - 1.2 * time + 0.6, origin[2]]
    b = dot(offset, ray)
    q = b * b - dot(offset, offset) + 0.36
    if q > 0 and -b > math.sqrt(q):
        normal = [x / 0.6 for x in (offset[i] - (b + math.sqrt(q)) * ray[i] for i in range(3))]
        light = 0.5 + 0.5 * normal[2]
        return [210 * light, 60 + 60 * math.sin(9 * normal[1]), 80 * light + 40]
    if ray[2] < 0:
        k = (-0.7 - origin[2]) / ray[2]
        x, y = origin[0] + k * ray[0], origin[1] + k * ray[1]
        check = 60 if (math.floor(2 * x) + math.floor(2 * y)) % 2 else 0
        return [90 + check + 30 * math.sin(7 * x + 3 * y), 90 + 40 * math.sin(5 * y) + check, 80]
    return [120, 150, 190 + 40 * ray[2]]


def image(camera, time=0.0, width=WIDTH, height=HEIGHT):
    rows = []
    for v in range(height):
        row = bytearray()
        for u in range(width):
            p = ((u + 0.5 - width / 2) / FOCAL, (v + 0.5 - height / 2) / FOCAL, 1)
            ray = unit([sum(p[a] * camera.axes[a][i] for a in range(3)) for i in range(3)])
            row += bytes(max(0, min(255, int(c))) for c in colour(camera.position, ray, time))
        rows.append(bytes(row))
    return rows


def write_png(path, rows, channels=3, width=WIDTH):
    def chunk(kind, data):
        check = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(rows), 8, kind, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows), 6))
        + chunk(b"IEND", b""))


def write_mask(path, width=WIDTH, height=HEIGHT):
    write_png(path, [b"\0" * width] * (height // 3) + [b"\xff" * width] * (height - height // 3), 1,
              width)


def ffmpeg(*arguments):
    command = ["ffmpeg", "-v", "error", "-y", "-threads", "1", *map(str, arguments)]
    subprocess.run(command, check=True)


def write_video(path, images, rate="24", options="-c:v libx264 -crf 8 -pix_fmt yuv420p"):
    path.parent.mkdir(parents=True, exist_ok=True)
    size = "%dx%d" % (WIDTH, HEIGHT)
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
                    "-s", size, "-r", rate, "-i", "-", *options.split(), "-threads", "1",
                    str(path)],
                   input=b"".join(b"".join(rows) for rows in images), check=True)


# --- poses ------------------------------------------------------------------------------------

def floor_points():
    return [((0.3 * i - 1.8, 0.3 * j - 1.8, -0.7), (90 + 9 * i, 90 + 9 * j, 80))
            for i in range(12) for j in range(12)]


def write_json(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value, indent=1))


def intrinsics(**more):
    return {"fl_x": FOCAL, "fl_y": FOCAL, "cx": WIDTH / 2, "cy": HEIGHT / 2,
            "w": WIDTH, "h": HEIGHT, **more}


def write_transforms(path, cameras, files, of_frame=lambda i: {}, **top):
    frames = [{"file_path": name, "transform_matrix": camera.to_world(), **of_frame(i)}
              for i, (camera, name) in enumerate(zip(cameras, files))]
    write_json(path, {**intrinsics(), **top, "frames": frames})


def write_cameras(path, cameras, names, **lens):
    write_json(path, {**intrinsics(**lens), "cameras": [
        {"name": name, "transform_matrix": c.to_world()} for c, name in zip(cameras, names)]})


def write_points(folder):
    (folder / "points3D.txt").write_text("".join(
        f"{i + 1} {p[0]!r} {p[1]!r} {p[2]!r} {rgb[0]} {rgb[1]} {rgb[2]} 0.5\n"
        for i, (p, rgb) in enumerate(floor_points())))


def write_model(folder, cameras, names, lens="PINHOLE", parameters=None, binary=False,
                size=(WIDTH, HEIGHT)):
    """A COLMAP model: one lens, the points of the floor, no observations."""
    folder.mkdir(parents=True, exist_ok=True)
    parameters = parameters or [FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2]
    poses = [c.quaternion() + c.translation() for c in cameras]
    if binary:
        pack = struct.pack
        (folder / "cameras.bin").write_bytes(
            pack("<QIiQQ%dd" % len(parameters), 1, 1, LENS_IDS[lens], *size, *parameters))
        (folder / "images.bin").write_bytes(pack("<Q", len(names)) + b"".join(
            pack("<I7dI", i + 1, *pose, 1) + name.encode() + b"\0" + pack("<Q", 0)
            for i, (pose, name) in enumerate(zip(poses, names))))
        points = floor_points()
        (folder / "points3D.bin").write_bytes(pack("<Q", len(points)) + b"".join(
            pack("<Q3d3BdQ", i + 1, *p, *rgb, 0.5, 0) for i, (p, rgb) in enumerate(points)))
        return
    (folder / "cameras.txt").write_text(
        f"1 {lens} {size[0]} {size[1]} {' '.join(map(repr, parameters))}\n")
    (folder / "images.txt").write_text("".join(
        f"{i + 1} {' '.join(map(repr, pose))} 1 {name}\n\n"
        for i, (pose, name) in enumerate(zip(poses, names))))
    write_points(folder)


def write_poses_bounds(path, cameras, bad=None):
    rows = []
    for camera in cameras:
        right, down, forward = camera.axes
        size = (HEIGHT, WIDTH, FOCAL)
        for i in range(3):
            rows += [down[i], right[i], -forward[i], camera.position[i], size[i]]
        rows += [1.0, 9.0]
    if bad is not None:
        rows[3] = bad
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (%d, 17), }" % len(cameras)
    header += " " * (117 - len(header)) + "\n"
    path.write_bytes(b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode()
                     + struct.pack("<%dd" % len(rows), *rows))


def write_ply(path):
    lines = ["%r %r %r %d %d %d" % (*p, *rgb) for p, rgb in floor_points()]
    path.write_text("ply\nformat ascii 1.0\nelement vertex %d\n" % len(lines)
                    + "".join("property float %s\n" % name for name in "xyz")
                    + "".join("property uchar %s\n" % name for name in ("red", "green", "blue"))
                    + "end_header\n" + "\n".join(lines) + "\n")


# --- in place of COLMAP -----------------------------------------------------------------------

def stand_in(arguments, log):
    """Takes COLMAP's commands: it logs them and states the poses of arc(). COLMAP itself takes long
    and does not give equal results twice. Images without a shape folder are those of photos."""
    command, options = arguments[0], dict(a.split("=", 1) for a in arguments[1:] if "=" in a)
    if command == "help":
        print("COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo")
        return
    with open(log, "a", encoding="utf-8") as file:
        file.write(" ".join(arguments) + "\n")
    if command == "feature_extractor":
        Path(options["--database_path"]).write_bytes(b"database")
    out = Path(options.get("--output_path", "."))
    if command == "mapper":
        images = Path(options["--image_path"])
        files = sorted(p for p in images.rglob("*") if p.suffix.lower() in (".png", ".jpg"))
        size = struct.unpack(">II", files[0].read_bytes()[16:24])
        write_model(out / "0", arc(len(files)), [str(p.relative_to(images)) for p in files],
                    "SIMPLE_RADIAL", [FOCAL * size[0] / WIDTH, size[0] / 2, size[1] / 2, -0.05],
                    size=size)
    elif "--input_path" in options:  # point_triangulator, bundle_adjuster
        shutil.copytree(options["--input_path"], out, dirs_exist_ok=True)
        if command == "point_triangulator":
            write_points(out)


if __name__ == "__main__":
    stand_in(sys.argv[2:], sys.argv[1])
