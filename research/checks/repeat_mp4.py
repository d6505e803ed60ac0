#!/usr/bin/env python3
"""repeat_mp4.py IN OUT N: an MP4 whose tables list the samples of IN N times over.

The samples are stored once, so that ten minutes of a rig take the bytes of some seconds. IN begins
with a keyframe, has one track and an edit list of one entry at most, as `tessera synth` writes it.
"""
import struct
import sys

CONTAINERS = (b"moov", b"trak", b"mdia", b"minf", b"edts")
DURATIONS = {b"mvhd": (16, 24), b"mdhd": (16, 24), b"tkhd": (20, 28), b"elst": (8, 8)}


def boxes(data, start, end):
    """(kind, start, bytes of the head, bytes of the box) of each box."""
    while start < end:
        size, kind = struct.unpack_from(">I4s", data, start)
        head = 8
        if size == 1:
            size, head = struct.unpack_from(">Q", data, start + 8)[0], 16
        elif size == 0:
            size = end - start
        yield kind, start, head, size
        start += size


def box(kind, body):
    return struct.pack(">I4s", 8 + len(body), kind) + body


def with_longer_duration(kind, body, times):
    wide = body[0] == 1
    form, at = (">Q" if wide else ">I"), DURATIONS[kind][wide]
    duration = struct.unpack_from(form, body, at)[0] * times
    return body[:at] + struct.pack(form, duration) + body[at + struct.calcsize(form):]


def sample_tables(data, start, end, times, shift):
    """The body of an stbl box; chunks move by -shift bytes."""
    found = {kind: data[at + head:at + size] for kind, at, head, size in boxes(data, start, end)}

    def rows(kind, form):
        body, size = found[kind], struct.calcsize(form)
        count = struct.unpack_from(">I", body, 4)[0]
        return [struct.unpack_from(form, body, 8 + i * size) for i in range(count)]

    def table(kind, form, of_rows):
        packed = b"".join(struct.pack(form, *row) for row in of_rows)
        return found[kind][:4] + struct.pack(">I", len(of_rows)) + packed

    same, samples = struct.unpack_from(">II", found[b"stsz"], 4)
    if same:
        raise SystemExit("all samples have one size, which no video has")
    chunks = [(offset - shift,) for offset, in rows(b"stco", ">I")]
    runs, per_chunk = rows(b"stsc", ">III"), []
    for i, (first, count, entry) in enumerate(runs):
        last = runs[i + 1][0] - 1 if i + 1 < len(runs) else len(chunks)
        per_chunk += [(count, entry)] * (last - first + 1)
    made = []
    for kind, at, head, size in boxes(data, start, end):
        if kind == b"stsz":
            body = found[kind][:8] + struct.pack(">I", samples * times) + found[kind][12:] * times
        elif kind == b"stco":
            body = table(kind, ">I", chunks * times)
        elif kind == b"stsc":
            body = table(kind, ">III", [(i + 1, *of) for i, of in enumerate(per_chunk * times)])
        elif kind in (b"stts", b"ctts"):
            body = table(kind, ">II", rows(kind, ">II") * times)
        elif kind == b"stss":
            keys = rows(kind, ">I")
            body = table(kind, ">I", [(key + k * samples,) for k in range(times) for key, in keys])
        elif kind == b"sdtp":
            body = found[kind][:4] + found[kind][4:] * times
        elif kind in (b"sbgp", b"sgpd"):
            continue  # groups of samples, which players do not need
        else:
            body = found[kind]
        made.append(box(kind, body))
    return b"".join(made)


def repeated(kind, data, start, end, times, shift):
    """The body of a box below moov."""
    if kind == b"stbl":
        return sample_tables(data, start, end, times, shift)
    if kind in CONTAINERS:
        return b"".join(box(inner, repeated(inner, data, at + head, at + size, times, shift))
                        for inner, at, head, size in boxes(data, start, end))
    body = data[start:end]
    return with_longer_duration(kind, body, times) if kind in DURATIONS else body


def main(source, target, times):
    with open(source, "rb") as file:
        data = file.read()
    top = list(boxes(data, 0, len(data)))
    moov = next(one for one in top if one[0] == b"moov")
    mdat = next(one for one in top if one[0] == b"mdat")
    shift = moov[3] if moov[1] < mdat[1] else 0  # moov comes last
    with open(target, "wb") as out:
        for kind, at, _, size in top:
            if kind != b"moov":
                out.write(data[at:at + size])
        _, at, head, size = moov
        out.write(box(b"moov", repeated(b"moov", data, at + head, at + size, times, shift)))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
