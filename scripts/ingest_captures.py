"""Captures of a few small images, one of every layout that `tessera ingest` reads.

compare_ingest.py uses them. A maker gets an empty folder, makes the capture in its subfolder
`capture`, and places files that options name (masks, offsets, cameras) beside it. CAPTURES has the
makers with their options; BAD has captures and options that `ingest` must refuse or warn of.
"""
import json
import math
import shutil
import struct
import subprocess
import zlib

from capture_files import (FOCAL, HEIGHT, WIDTH, arc, ffmpeg, image, write_cameras, write_mask,
                           write_model, write_ply, write_png, write_poses_bounds, write_transforms,
                           write_video)

PHOTOS = ["img_%02d.png" % i for i in range(10)]
TESSERA = ""  # the program that renders; set by compare_ingest.py


def synth(folder, *arguments):
    subprocess.run([TESSERA, "synth", *arguments, "-o", str(folder / "capture"), "--supersampling",
                    "1", "--points", "100", "--threads", "1", "-q"], check=True,
                   capture_output=True)


def write_photos(folder, names=tuple(PHOTOS)):
    for camera, name in zip(arc(len(names)), names):
        write_png(folder / name, image(camera))


def dnerf(folder):
    synth(folder, "object", "--layout", "dnerf", "--frames", "6", "--held-out-frames", "2",
          "--width", "32", "--height", "32")


def nerfstudio(folder):
    """With a lens, masks of frames and a cloud."""
    capture = folder / "capture"
    write_photos(capture / "images")
    for name in PHOTOS:
        write_mask(capture / "masks" / name)
        write_mask(folder / "other_masks" / "images" / name)
    write_ply(capture / "cloud.ply")
    write_transforms(capture / "transforms.json", arc(10), ["images/" + n for n in PHOTOS],
                     lambda i: {"mask_path": "masks/" + PHOTOS[i]}, camera_model="OPENCV", k1=-0.08,
                     k2=0.01, p1=0.001, p2=-0.001, ply_file_path="cloud.ply")


def transforms_rig(folder):
    """Cameras of a transforms file that film together, with times."""
    capture = folder / "capture"
    frames = [(c, "cam%02d/%04d.png" % (i, t), t / 3)
              for i, c in enumerate(arc(3)) for t in range(4)]
    for camera, name, time in frames:
        write_png(capture / name, image(camera, time))
    write_transforms(capture / "transforms.json", [f[0] for f in frames], [f[1] for f in frames],
                     lambda i: {"time": frames[i][2]})


def image_formats(folder):
    """RGBA, 16 bits, grey, palette, TIFF, JPEG and EXR."""
    images = folder / "capture" / "images"
    names = PHOTOS[:4] + ["e.tif", "f.jpg", "g.exr", "h.png", "i.png", "j.bmp"]
    write_photos(folder / "source")
    sources = [folder / "source" / name for name in PHOTOS]
    images.mkdir(parents=True)
    kinds = ["rgba", "rgb48be", "gray", "pal8", "rgb24", "yuvj444p", "gbrpf32le", "rgba64be", "ya8",
             "bgr24"]
    for source, name, kind in zip(sources, names, kinds):
        to = ["-vf", "format=rgba,geq=r='r(X,Y)':g='g(X,Y)':b='b(X,Y)':a='255*gt(X,9)'"] \
            if kind in ("rgba", "rgba64be", "ya8") else []
        ffmpeg("-i", source, *to, "-pix_fmt", kind, images / name)
    write_transforms(folder / "capture" / "transforms.json", arc(10),
                     ["images/" + name for name in names])


def prepared(folder):
    """The result of `ingest`, given to it again."""
    transforms_rig(folder / "first")
    subprocess.run([TESSERA, "ingest", str(folder / "first" / "capture"), "-o",
                    str(folder / "capture"), "--threads", "1", "-q", "--cloud", "none"], check=True,
                   capture_output=True)


def write_rig_files(folder, names):
    for name in names:
        write_mask(folder / "masks" / (name + ".png"), 64, 48)
    (folder / "offsets.txt").write_text("".join("%s %.3f\n" % (n, 0.011 * i)
                                                for i, n in enumerate(names)))
    (folder / "two_offsets.txt").write_text("%s 0\n" % names[0])
    (folder / "bad_offsets.txt").write_text("%s what\n" % names[0])


def n3dv(folder):
    synth(folder, "room", "--cameras", "4", "--frames", "8", "--width", "64", "--height", "48")
    shutil.rmtree(folder / "capture" / "ground_truth")
    write_rig_files(folder, ["cam%02d" % i for i in range(4)])


def n3dv_gains(folder):
    """Larger images: motion and gains are measured on features."""
    synth(folder, "room", "--cameras", "4", "--frames", "8", "--width", "160", "--height", "120",
          "--camera-gains", "--shift", "cam02=1.5")
    shutil.rmtree(folder / "capture" / "ground_truth")


def video_rig(folder):
    """Videos without poses, and a file of cameras with a lens beside them."""
    capture, cameras = folder / "capture", arc(3)
    for i, camera in enumerate(cameras):
        write_video(capture / ("cam%02d.mp4" % i), [image(camera, t / 5) for t in range(6)])
    names = ["cam%02d" % i for i in range(3)]
    write_cameras(folder / "cameras.json", cameras, names)
    write_cameras(folder / "lens.json", cameras, names, k1=-0.1, k2=0.02)
    write_cameras(folder / "two.json", cameras[:2], names)
    write_cameras(folder / "larger.json", cameras, names, w=2 * WIDTH, h=2 * HEIGHT)
    write_cameras(folder / "bad_focal.json", cameras, names, fl_x=-1)
    write_poses_bounds(folder / "poses_bounds.npy", cameras)
    (folder / "text.txt").write_text("no poses\n")
    write_rig_files(folder, names)
    for name in names:
        write_mask(folder / "masks" / (name + ".png"))


def video_formats(folder):
    """Containers, depths and ranges of colour, a timecode, a gap, an early end, a sound track."""
    capture, cameras = folder / "capture", arc(6)
    films = [[image(camera, t / 7) for t in range(8)] for camera in cameras]
    plain = " -c:v libx264 -crf 8 -pix_fmt yuv420p"
    write_video(capture / "a.mkv", films[0], options=plain + " -bf 0")
    write_video(capture / "b.mp4", films[1], options="-f lavfi -i anoisesrc=seed=3:d=0.3 -c:a aac"
                + plain)
    write_video(capture / "c.mov", films[2],
                options="-c:v libx264 -pix_fmt yuv420p10le")
    write_video(capture / "d.mp4", films[3], options=plain + " -timecode 00:00:00:02")
    write_video(capture / "e.mp4", films[4][:6],
                options=plain + " -colorspace bt709 -color_range pc")
    write_video(capture / "f.mp4", films[5],
                options="-vf select='not(eq(n,3))' -vsync vfr" + plain)
    write_cameras(folder / "cameras.json", cameras, "abcdef")


def odd_videos(folder):
    """Flags that a decoder must undo or refuse."""
    capture, cameras = folder / "capture", arc(4)
    films = [[image(camera, t / 3) for t in range(4)] for camera in cameras]
    for i, name in enumerate("abcd"):
        write_video(folder / (name + ".mp4"), films[i])
    capture.mkdir()
    ffmpeg("-i", folder / "a.mp4", "-c", "copy", capture / "a.mp4")
    ffmpeg("-i", folder / "b.mp4", "-c", "copy", "-metadata:s:v:0", "rotate=180", capture / "b.mp4")
    ffmpeg("-i", folder / "c.mp4", "-vf", "tinterlace=interleave_top,fieldorder=tff", "-c:v",
           "libx264", "-flags", "+ildct+ilme", "-pix_fmt", "yuv420p", capture / "c.mp4")
    ffmpeg("-i", folder / "d.mp4", "-c:v", "libx264", "-pix_fmt", "yuv420p10le", "-color_trc",
           "arib-std-b67", "-color_primaries", "bt2020", "-colorspace", "bt2020nc",
           capture / "d.mp4")
    write_cameras(folder / "cameras.json", cameras, "abcd")


def timecodes(folder):
    capture, cameras = folder / "capture", arc(3)
    for i, camera in enumerate(cameras):
        write_video(capture / ("cam%02d.mp4" % i), [image(camera, (t + i) / 9) for t in range(8)],
                    options="-c:v libx264 -crf 8 -pix_fmt yuv420p -timecode 01:00:00:%02d" % i)
    write_cameras(folder / "cameras.json", cameras, ["cam%02d" % i for i in range(3)])


def sounds(folder):
    """Two seconds with a sound that all cameras record, from different times on."""
    capture, cameras = folder / "capture", arc(3)
    ffmpeg("-f", "lavfi", "-i", "anoisesrc=seed=5:duration=3:sample_rate=16000", folder / "all.wav")
    for i, camera in enumerate(cameras):
        write_video(folder / ("cam%02d.mp4" % i), [image(camera, t / 19) for t in range(20)], "10")
        capture.mkdir(exist_ok=True)
        ffmpeg("-i", folder / ("cam%02d.mp4" % i), "-ss", "%.2f" % (0.13 * i), "-i",
               folder / "all.wav", "-map", "0:v", "-map", "1:a", "-c:v", "copy", "-c:a", "aac",
               "-t", "2", capture / ("cam%02d.mp4" % i))
    write_cameras(folder / "cameras.json", cameras, ["cam%02d" % i for i in range(3)])


def colmap(folder, **model):
    capture = folder / "capture"
    write_photos(capture / "images")
    write_model(capture / "sparse" / "0", arc(10), PHOTOS, **model)
    for name in PHOTOS:
        write_mask(folder / "masks" / name)
    write_mask(folder / "few_masks" / (PHOTOS[0] + ".png"))
    write_mask(folder / "small_masks" / PHOTOS[0], 24, 20)
    (folder / "no_masks").mkdir()


def colmap_text(folder):
    colmap(folder)


def colmap_binary(folder):
    colmap(folder, binary=True, lens="SIMPLE_RADIAL",
           parameters=[FOCAL, WIDTH / 2, HEIGHT / 2, -0.1])


def colmap_opencv(folder):
    colmap(folder, lens="OPENCV",
           parameters=[FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, -0.1, 0.02, 0.001, 0.001])


def colmap_damaged(folder):
    """One image is missing, one is cut off, one has no pose, one is no image by its name."""
    colmap(folder)
    images = folder / "capture" / "images"
    (images / PHOTOS[1]).unlink()
    (images / PHOTOS[2]).write_bytes((images / PHOTOS[2]).read_bytes()[:400])
    write_png(images / "extra.png", image(arc(10)[3]))
    (images / "film.HEIC").write_bytes(b"\0\0\0\x18ftypheic")
    (images / "._img_00.png").write_bytes(b"\0\5\x16\7")


def colmap_folders(folder):
    """Reduced images beside the full ones, and names in other letters."""
    colmap(folder)
    capture = folder / "capture"
    (capture / "images_2").mkdir()
    for name in PHOTOS:
        ffmpeg("-i", capture / "images" / name, "-vf", "scale=24:18", capture / "images_2" / name)
        (capture / "images" / name).rename(capture / "images" / name.upper())


def llff(folder):
    write_photos(folder / "capture" / "images")
    write_poses_bounds(folder / "capture" / "poses_bounds.npy", arc(10))


def sequences(folder, name="cam%02d/%04d.png", first=0, fields=lambda i, t: (i, t)):
    capture = folder / "capture"
    for i, camera in enumerate(arc(3)):
        for t in range(first, first + 4):
            write_png(capture / (name % fields(i, t)), image(camera, t / 4))
    write_poses_bounds(capture / "poses_bounds.npy", arc(3))
    names = ["cam%02d" % i for i in range(3)]
    write_cameras(folder / "cameras.json", arc(3), names)
    write_rig_files(folder, names)
    for camera in names:
        write_mask(folder / "masks" / (camera + ".png"))


def sequence_folders(folder):
    sequences(folder)


def sequence_names(folder):
    sequences(folder, "images/cam%02d_frame_%04d.png", 1)


def sequence_gap(folder):
    sequences(folder)
    (folder / "capture" / "cam01" / "0002.png").unlink()
    (folder / "capture" / "cam02" / "0001.png").write_bytes(b"\x89PNG\r\n\x1a\n")


def sequence_times(folder):
    """Names are nanoseconds since 1970, of each camera a little later than of the one before."""
    sequences(folder, "cam%02d/%d.png", 0,
              lambda i, t: (i, 1764000000866666667 + i * 1000 + t * 33333333))


def sequence_places(folder):
    """Colour beside depths, in a folder of another name."""
    sequences(folder, "day 2/cam%02d/colour/%04d.png")
    for camera in sorted((folder / "capture" / "day 2").iterdir()):
        for image_file in sorted((camera / "colour").iterdir()):
            (camera / "z").mkdir(exist_ok=True)
            ffmpeg("-i", image_file, "-pix_fmt", "gray16be", camera / "z" / image_file.name)


def sequence_timesteps(folder):
    """A folder a timestep, with a model each, and a lens under a key of another program."""
    sequences(folder, "step_%02d/images/cam%02d.png", 0, lambda i, t: (t, i))
    (folder / "capture" / "poses_bounds.npy").unlink()
    names = ["cam%02d" % i for i in range(3)]
    for step in sorted((folder / "capture").iterdir()):
        write_model(step / "sparse" / "0", arc(3), [name + ".png" for name in names])
    write_cameras(folder / "lens.json", arc(3), names, distCoef=[-0.05, 0.01, 0, 0, 0])
    write_cameras(folder / "other_lens.json", arc(3), names, radial_fit=[-0.05, 0.01])


def films(folder):
    """Photos with a film each, beside a table that states cameras to another program."""
    write_photos(folder / "capture")
    for camera, name in zip(arc(10), PHOTOS):
        write_video((folder / "capture" / name).with_suffix(".MOV"), [image(camera)] * 3)
    (folder / "capture" / "export.toml").write_text("[cam]\nmatrix = [[1.0]]\nrotation = [0.0]\n")


def gammas(folder):
    """Linear PNG by gAMA, which is what they state."""
    names = ["images/" + name for name in PHOTOS]
    for camera, name in zip(arc(10), names):
        write_png(folder / "capture" / name, image(camera))
        path = folder / "capture" / name
        data = path.read_bytes()
        chunk = b"gAMA" + struct.pack(">I", 100000)
        path.write_bytes(data[:33] + struct.pack(">I", 4) + chunk
                         + struct.pack(">I", zlib.crc32(chunk)) + data[33:])
    write_transforms(folder / "capture" / "transforms.json", arc(10), names)


def rooms(folder):
    """Equal numbers in folders whose names are no cameras'."""
    for place, camera in zip(("garden", "kitchen"), arc(2)):
        for t in range(3):
            write_png(folder / "capture" / place / ("%d.png" % t), image(camera, t / 3))


def photos(folder):
    write_photos(folder / "capture" / "images")


def consecutive(folder):
    write_photos(folder / "capture", ["frame_%04d.png" % i for i in range(8)])


def moving(folder):
    write_video(folder / "capture" / "walk.mp4", [image(c, 0) for c in arc(12)])


def without_cloud(*option_sets):
    """The plane sweep takes longer than all else, and is the default of these captures."""
    return [o if "--cloud" in o else (o + " --cloud none").strip() for o in option_sets]


# Sets of options of each capture; `doctor` gets the first, too.
RIG = "--poses cameras.json"
CAPTURES = {
    dnerf: without_cloud("", "--scale 0.5", "--held-out r_001", "--keep-world --json",
                         "--frames 3", "--test-every 3", "--strict"),
    nerfstudio: ["", "--scale 0.5", "--test-every 4", "--test-every 0", "--cloud none",
                 "--held-out images/img_03.png", "--masks other_masks", "--invert-masks",
                 "--strict", "--images images", "--static", "--poses colmap --cloud none",
                 "--cloud sparse --scale 50%"],
    transforms_rig: without_cloud("", "--held-out cam02", "--scale 0.5", "--fit-exposure",
                                  "--frames 2", "--cameras cam01"),
    image_formats: without_cloud("", "--scale 0.5", "--test-every 0"),
    prepared: without_cloud("", "--scale 0.5"),
    n3dv: without_cloud("", "--frames 3 --scale 0.5 --cloud-points 600", "--sync none --json",
                        "--sync motion", "--offsets offsets.txt", "--frames 3", "--fps 12",
                        "--start 0.1 --duration 0.15", "--held-out cam01,cam02",
                        "--cameras cam00,cam02", "--scale 0.5", "--masks masks",
                        "--masks masks --invert-masks --scale 0.5",
                        "--masks masks --frames 2 --scale 0.5 --cloud dense", "--keep-world",
                        "--cloud sparse", "--poses n3dv --frames 2 -v", "--poses colmap",
                        "--poses colmap --cloud sparse", "--offsets two_offsets.txt",
                        "--frames 2 --quiet", "--offsets bad_offsets.txt", "--fit-exposure",
                        "--layout rig"),
    n3dv_gains: without_cloud("--sync motion --fit-exposure"),
    video_rig: without_cloud(RIG, "--poses lens.json --masks masks",
                             "--poses lens.json --scale 0.5 --frames 2",
                             "--poses poses_bounds.npy", "--poses two.json",
                             "--poses two.json --strict", "--poses larger.json",
                             "--poses bad_focal.json", "--poses text.txt", "--poses none.json", "",
                             "--intrinsics per-camera --strict",
                             "--camera-model OPENCV --cloud sparse --held-out cam02",
                             "--static " + RIG, "--sync container " + RIG, "--sync audio " + RIG,
                             "--layout moving " + RIG, "--masks . " + RIG,
                             "--duration 9 --start 9 " + RIG, "--layout photos"),
    video_formats: without_cloud(RIG, RIG + " --sync none --strict", RIG + " --cameras a,b,c",
                                 RIG + " --cameras f,b --sync audio",
                                 RIG + " --cameras b,d,f --frames 5 --fps 10"),
    odd_videos: without_cloud(RIG + " --sync none"),
    timecodes: without_cloud(RIG, RIG + " --sync none", RIG + " --sync container --frames 3"),
    sounds: without_cloud(RIG + " --sync audio --scale 0.5", RIG + " --fps 5"),
    colmap_text: ["", "--scale 0.5", "--test-every 3 --json", "--held-out img_02.png",
                  "--masks masks", "--masks masks --invert-masks", "--masks few_masks",
                  "--masks small_masks", "--masks no_masks", "--invert-masks", "--keep-world",
                  "--cloud none", "--cloud dense --scale 0.25", "--strict --test-every 0",
                  "--images images_4", "--frames 3", "--sync none", "--poses colmap",
                  "--poses llff", "--layout photos", "--layout moving", "--fit-exposure",
                  "--test-every 1", "--quiet", "--static"],
    colmap_binary: ["", "--scale 0.5 --masks masks", "--keep-world --verbose"],
    colmap_opencv: ["--masks masks", "--scale 0.7 --masks masks --invert-masks"],
    colmap_damaged: ["", "--strict"],
    colmap_folders: ["", "--images images_2"],
    llff: without_cloud("", "--scale 0.5 --test-every 4", "--poses llff --keep-world",
                        "--poses colmap", "--layout rig", "--poses n3dv"),
    sequence_folders: without_cloud("", RIG + " --fps 10", "--layout photos",
                                    "--masks masks --scale 0.5", "--layout moving", "--start 0.05",
                                    "--offsets offsets.txt", "--sync motion --frames 3",
                                    "--held-out cam01 --cameras cam00,cam01"),
    sequence_names: without_cloud("", "--frames 2 --keep-world", "--layout rig --fps 25"),
    sequence_gap: without_cloud("", "--strict"),
    sequence_times: without_cloud(RIG, RIG + " --held-out none --frames 3"),
    sequence_places: without_cloud(RIG),
    sequence_timesteps: without_cloud("", "--poses lens.json", "--poses other_lens.json"),
    films: without_cloud(""),
    gammas: without_cloud("", "--strict --test-every 4"),
    rooms: without_cloud("", "--layout photos", "--layout rig"),
    photos: without_cloud("", "--camera-model SIMPLE_RADIAL --intrinsics per-camera",
                          "--layout rig", "--poses llff", "--strict --test-every 4 --scale 0.5",
                          "--poses none.json"),
    consecutive: without_cloud("", "--layout moving", "--layout moving --static --test-every 3"),
    moving: without_cloud("--static", "", "--static --frames 6 --test-every 3",
                          "--fps 12 --strict", "--layout photos", "--fit-exposure"),
}


# --- captures that are refused ----------------------------------------------------------------

def edit_json(path, change):
    value = json.loads(path.read_text())
    change(value)
    path.write_text(json.dumps(value))


def empty_folder(folder):
    (folder / "capture").mkdir()


def no_folder(folder):
    pass


def several(folder):
    """A folder of captures."""
    for name in ("first", "second"):
        (folder / name).mkdir()
        llff(folder / name)
        shutil.move(folder / name / "capture", folder / "capture" / name)
    (folder / "capture" / "notes").mkdir()


def is_a_file(folder):
    (folder / "capture").write_text("text")


def empty_model_folder(folder):
    photos(folder)
    (folder / "capture" / "sparse").mkdir()


def two_layouts(folder):
    colmap_text(folder)
    write_transforms(folder / "capture" / "transforms.json", arc(10),
                     ["images/" + name for name in PHOTOS])
    write_poses_bounds(folder / "capture" / "poses_bounds.npy", arc(10))


def with_transforms(change):
    def make(folder):
        nerfstudio(folder)
        edit_json(folder / "capture" / "transforms.json", change)
    return make


def with_file(maker, place, change):
    """`maker`'s capture with the bytes of one file changed; None removes it."""
    def make(folder):
        maker(folder)
        path = folder / "capture" / place
        content = change(path.read_bytes())
        path.unlink()
        if content is not None:
            path.write_bytes(content)
    return make


def of_frame(number, **values):
    return with_transforms(lambda value: value["frames"][number].update(values))


def bad_pose(value):
    return [[1, 0, 0, value], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def other_size(folder):
    nerfstudio(folder)
    write_png(folder / "capture" / "images" / PHOTOS[4], image(arc(10)[4], 0, 40, 30), 3, 40)


def sequence_size(folder):
    sequences(folder)
    write_png(folder / "capture" / "cam01" / "0001.png", image(arc(3)[1], 0, 40, 30), 3, 40)


def llff_rows(folder):
    write_photos(folder / "capture" / "images")
    write_poses_bounds(folder / "capture" / "poses_bounds.npy", arc(7))


def llff_nan(folder):
    write_photos(folder / "capture" / "images")
    write_poses_bounds(folder / "capture" / "poses_bounds.npy", arc(10), math.nan)


def half(data):
    return data[:len(data) // 2]


def removed(data):
    return None


def nothing(data):
    return b""


MODEL = "sparse/0/"
BAD = {
    "empty folder": (empty_folder, ["", "--layout photos", "--layout moving"]),
    "several captures": (several, [""]),
    "no folder": (no_folder, [""]),
    "a file": (is_a_file, [""]),
    "empty sparse": (empty_model_folder, without_cloud("", "--poses colmap")),
    "two layouts": (two_layouts, without_cloud("", "--poses colmap", "--poses llff")),
    "cut PNG": (with_file(nerfstudio, "images/img_03.png", half), ["", "--strict"]),
    "empty PNG": (with_file(nerfstudio, "images/img_03.png", nothing), ["", "--strict"]),
    "missing PNG": (with_file(nerfstudio, "images/img_03.png", removed), ["", "--strict"]),
    "missing mask": (with_file(nerfstudio, "masks/img_03.png", removed), [""]),
    "cut mask": (with_file(nerfstudio, "masks/img_03.png", half), [""]),
    "cut cloud": (with_file(nerfstudio, "cloud.ply", half), ["", "--cloud none"]),
    "missing cloud": (with_file(nerfstudio, "cloud.ply", removed), ["--cloud sparse"]),
    "cut transforms": (with_file(nerfstudio, "transforms.json", half), [""]),
    "other size": (other_size, ["", "--strict"]),
    "NaN pose": (of_frame(2, transform_matrix=bad_pose(math.nan)), [""]),
    "text pose": (of_frame(2, transform_matrix=bad_pose("x")), [""]),
    "scaled pose": (of_frame(2, transform_matrix=[[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]), [""]),
    "no pose": (of_frame(2, transform_matrix=None), [""]),
    "path of number": (of_frame(2, file_path=3), [""]),
    "image twice": (of_frame(2, file_path="images/img_01.png"), [""]),
    "one time": (of_frame(2, time=0.5), [""]),
    "Windows path": (of_frame(2, file_path="C:\\Users\\me\\images\\img_02.png"), [""]),
    "no frames": (with_transforms(lambda v: v.pop("frames")), [""]),
    "no focal length": (with_transforms(lambda v: (v.pop("fl_x"), v.pop("fl_y"))), [""]),
    "negative focal length": (with_transforms(lambda v: v.update(fl_x=-3)), [""]),
    "fisheye": (with_transforms(lambda v: v.update(camera_model="EQUIRECTANGULAR")), [""]),
    "strong lens": (with_transforms(lambda v: v.update(k1=-3.0)), [""]),
    "equal times": (with_transforms(lambda v: [f.update(time=1) for f in v["frames"]]),
                    ["", "--static"]),
    "cut images.txt": (with_file(colmap_text, MODEL + "images.txt", half), [""]),
    "cut images.bin": (with_file(colmap_binary, MODEL + "images.bin", half), ["", "--strict"]),
    "long cameras.bin": (with_file(colmap_binary, MODEL + "cameras.bin", lambda d: d + b"1"), [""]),
    "no cameras.bin": (with_file(colmap_binary, MODEL + "cameras.bin", removed), ["--cloud none"]),
    "no points3D": (with_file(colmap_text, MODEL + "points3D.txt", removed), ["--cloud sparse"]),
    "unknown lens": (with_file(colmap_text, MODEL + "cameras.txt",
                               lambda d: d.replace(b"PINHOLE", b"WIDE")), [""]),
    "fewer parameters": (with_file(colmap_text, MODEL + "cameras.txt", lambda d: d[:-5]), [""]),
    "NaN quaternion": (with_file(colmap_text, MODEL + "images.txt",
                                 lambda d: d.replace(b"3 ", b"nan ", 1)), ["", "--strict"]),
    "LLFF rows": (llff_rows, ["--cloud none"]),
    "LLFF NaN": (llff_nan, ["--cloud none"]),
    "cut npy": (with_file(llff, "poses_bounds.npy", half), without_cloud("", "--poses llff")),
    "rig rows": (with_file(n3dv, "cam03.mp4", removed), ["--cloud none"]),
    "cut video": (with_file(n3dv, "cam02.mp4", half), ["--cloud none", "--cloud none --strict"]),
    "late cut": (with_file(n3dv, "cam02.mp4", lambda d: d[:-40]), ["--cloud none"]),
    "empty video": (with_file(n3dv, "cam02.mp4", nothing), ["--cloud none"]),
    "text video": (with_file(n3dv, "cam02.mp4", lambda d: b"text"), without_cloud("", "--strict")),
    "cut mkv": (with_file(video_formats, "a.mkv", half), [RIG + " --sync none --cloud none"]),
    "sequence size": (sequence_size, ["--cloud none"]),
    "prepared version": (with_file(prepared, "transforms.json", lambda d: d.replace(
        b'"format_version": 1', b'"format_version": 99')), [""]),
    "options": (colmap_text, [
        "--scale 0", "--scale 2", "--frames 0", "--test-every -1", "--cloud-points 0",
        "--cloud all", "--held-out none.png", "--poses what", "--cameras cam00", "--masks nowhere",
        "--held-out " + ",".join(PHOTOS), "--sync audio", "--fps 0", "--start 1 --duration 1",
        "--offsets none.txt", "--camera-model OPENCV", "--overwrite", "--intrinsics shared"]),
    "rig options": (n3dv, without_cloud(
        "--cameras cam09", "--held-out cam09", "--held-out cam00,cam01,cam02,cam03", "--start 60",
        "--offsets none.txt", "--test-every 3", "--images x", "--duration -1", "--sync clock",
        "--cameras cam01", "--cameras cam01,cam01", "--masks nowhere", "--poses llff",
        "--camera-model OPENCV --cloud none", "--fps 1000", "--sync container", "--sync audio")),
}
