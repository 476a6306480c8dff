#!/usr/bin/env python3
"""compare_pictures.py A.png B.png [SHARE] - are two pictures the same to the eye? Prints how much they differ; exit status 1 if
they are not alike, in no more than SHARE of their pixels. Reads the PNGs that the program writes: 8 bits a channel, RGB or RGBA, not interlaced."""
import struct
import sys
import zlib

# A channel that differs by no more than this is the same, levels of 256: other versions of a software OpenGL round
# colours otherwise by a level or two, and what is interpolated along an edge by some more.
LEVELS = 24
# Pixels on the edges of surfaces may fall to either side: a view of a furnished room at 480x270 has some 10,000 of
# them, of which few do. A chair that is missing is more than this share of the picture.
SHARE = 0.004


class Picture:
    def __init__(self, width, height, rows):
        self.width, self.height, self.rows = width, height, rows  # rows: bytes, three a pixel


def unfilter(kind, row, above, step):
    """Undoes a PNG filter in place (PNG specification, section 9)."""
    if kind == 1:
        for i in range(step, len(row)):
            row[i] = row[i] + row[i - step] & 255
    elif kind == 2:
        for i in range(len(row)):
            row[i] = row[i] + above[i] & 255
    elif kind == 3:
        for i in range(len(row)):
            left = row[i - step] if i >= step else 0
            row[i] = row[i] + (left + above[i]) // 2 & 255
    elif kind == 4:
        for i in range(len(row)):
            a, c = (row[i - step], above[i - step]) if i >= step else (0, 0)
            b = above[i]
            p = a + b - c
            near_a, near_b, near_c = abs(p - a), abs(p - b), abs(p - c)
            best = a if near_a <= near_b and near_a <= near_c else b if near_b <= near_c else c
            row[i] = row[i] + best & 255
    elif kind != 0:
        raise ValueError(f"filter {kind} (allowed: 0 to 4)")


def read_png(path):
    data = open(path, "rb").read()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError(f"{path}: is not a PNG")
    at, packed, header = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        at += length + 12
    width, height, depth, colour, _, _, interlace = header
    if depth != 8 or colour not in (2, 6) or interlace:
        raise ValueError(f"{path}: depth {depth}, colour type {colour} (allowed: 8 and 2 or 6, not interlaced)")
    step = 3 if colour == 2 else 4
    raw, rows, above = zlib.decompress(packed), [], bytearray(width * step)
    for y in range(height):
        start = y * (width * step + 1)
        row = bytearray(raw[start + 1:start + 1 + width * step])
        unfilter(raw[start], row, above, step)
        above = row
        rows.append(bytes(row) if step == 3 else bytes(v for i, v in enumerate(row) if i % 4 != 3))
    return Picture(width, height, rows)


def difference(a, b, levels=LEVELS):
    """How many pixels differ by more than `levels` in some channel, and by how much at most; None for other sizes."""
    if (a.width, a.height) != (b.width, b.height):
        return None
    count = greatest = 0
    for one, other in zip(a.rows, b.rows):
        if one == other:
            continue
        for x in range(0, len(one), 3):
            most = max(abs(one[x] - other[x]), abs(one[x + 1] - other[x + 1]), abs(one[x + 2] - other[x + 2]))
            greatest = max(greatest, most)
            count += most > levels
    return count, greatest


def compare(path, reference, levels=LEVELS, share=SHARE):
    """Alike, and a sentence about it."""
    a, b = read_png(path), read_png(reference)
    found = difference(a, b, levels)
    if found is None:
        return False, f"{a.width}x{a.height} pixels instead of {b.width}x{b.height}"
    count, greatest = found
    allowed = int(share * a.width * a.height)
    text = f"{count} pixels differ by more than {levels} levels (allowed {allowed}), at most by {greatest}"
    return count <= allowed, text


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    alike, text = compare(sys.argv[1], sys.argv[2], share=float(sys.argv[3]) if len(sys.argv) == 4 else SHARE)
    print(text)
    sys.exit(not alike)
