#!/usr/bin/env python3
"""compare_pictures.py A.png B.png [--share SHARE] [--step STEP] - are two pictures the same to the eye? Prints what differs; exit status
1 if they are not alike. SHARE: of the pixels that may differ. STEP: B is kept in levels of so many, A is brought to these first.
compare_pictures.py --check REFERENCE.png... - a uniform shift, a tint, a blur and a missing object in each are told apart from
it, rounding and moved edges are not.

Reads the PNGs that the program writes: 8 bits a channel, RGB or RGBA, not interlaced."""
import argparse
import random
import struct
import sys
import zlib

# A channel that differs by no more than this is the same, levels of 256: other versions of a software OpenGL round
# colours otherwise by a level or two, and what is interpolated along an edge by some more.
LEVELS = 24
# Pixels on the edges of surfaces may fall to either side: a view of a furnished room at 480x270 has some 10,000 of
# them, of which few do. A chair that is missing is more than this share of the picture.
SHARE = 0.004


# The mean of a channel may drift so far, levels: half of the two by which colours are rounded otherwise, and half as much again
# for edges.
MEAN = 1.5
# Structure (SSIM: Wang et al. 2004, equation 13) in blocks of BLOCK x BLOCK pixels, of luminance: below LIKE a block shows something
# else. So do blocks in which an edge falls to the other side; CHANGED of them are as many as SHARE allows pixels, if a line of
# eight pixels changes a block. A missing object changes blocks side by side, so that no more than TOGETHER may touch.
BLOCK, LIKE, CHANGED, TOGETHER = 8, 0.6, 0.01, 4
# How much less may change from pixel to pixel, as a share of the squares of all steps of more than STEEP levels: moved edges keep
# them, a blur over three pixels leaves a third of an edge's. More may change: a driver without multisampling draws edges harder.
SHARPNESS, STEEP = 0.15, 24


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


def luminance(picture):
    """Rows of levels of 256."""
    return [[(77 * r + 150 * g + 29 * b) >> 8 for r, g, b in zip(row[0::3], row[1::3], row[2::3])] for row in picture.rows]


def means(picture):
    return [sum(sum(row[c::3]) for row in picture.rows) / (picture.width * picture.height) for c in range(3)]


def likeness(a, b, x, y):
    """SSIM of the blocks at x, y."""
    n = BLOCK * BLOCK
    p = [v for row in a[y:y + BLOCK] for v in row[x:x + BLOCK]]
    q = [v for row in b[y:y + BLOCK] for v in row[x:x + BLOCK]]
    if p == q:
        return 1
    mp, mq = sum(p) / n, sum(q) / n
    vp, vq = sum(v * v for v in p) / n - mp * mp, sum(v * v for v in q) / n - mq * mq
    both = sum(map(int.__mul__, p, q)) / n - mp * mq
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    return (2 * mp * mq + c1) * (2 * both + c2) / ((mp * mp + mq * mq + c1) * (vp + vq + c2))


def most_together(blocks):
    """The largest group of blocks that touch, by corners too."""
    left, most = set(blocks), 0
    while left:
        todo, size = [left.pop()], 0
        while todo:
            x, y = todo.pop()
            size += 1
            near = {(x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= near
            todo += near
        most = max(most, size)
    return most


def sharpness(rows):
    across = sum((p - q) ** 2 for row in rows for p, q in zip(row, row[1:]) if abs(p - q) > STEEP)
    return across + sum((p - q) ** 2 for one, next in zip(rows, rows[1:]) for p, q in zip(one, next) if abs(p - q) > STEEP)


def rounded(picture, step):
    levels = bytes(min((v + step // 2) // step * step, 255) for v in range(256))
    return Picture(picture.width, picture.height, [bytes(row).translate(levels) for row in picture.rows])


def faults_of(a, b, levels=LEVELS, share=SHARE):
    """Sentences on what a and b differ in, more than they may."""
    found = difference(a, b, levels)
    if found is None:
        return [f"{a.width}x{a.height} pixels instead of {b.width}x{b.height}"]
    faults, (count, greatest), area = [], found, a.width * a.height
    if count > share * area:
        faults.append(f"{count} pixels differ by more than {levels} levels (allowed {int(share * area)}), at most by {greatest}")
    for channel, one, other in zip(("red", "green", "blue"), means(a), means(b)):
        if abs(one - other) > MEAN:
            faults.append(f"{channel} is {one - other:+.1f} levels off in the mean (allowed {MEAN})")
    one, other = luminance(a), luminance(b)
    blocks = [(x, y) for y in range(a.height // BLOCK) for x in range(a.width // BLOCK)]
    changed = [(x, y) for x, y in blocks if likeness(one, other, x * BLOCK, y * BLOCK) < LIKE]
    allowed = int(max(CHANGED, 2 * share) * len(blocks))
    if len(changed) > allowed:
        faults.append(f"{len(changed)} blocks show something else (allowed {allowed})")
    together = most_together(changed)
    if together > TOGETHER * max(1, share / SHARE):
        faults.append(f"{together} blocks side by side show something else (allowed {TOGETHER})")
    before, now = sharpness(other), sharpness(one)
    if before - now > SHARPNESS * max(1, share / SHARE) * before:
        faults.append(f"edges are {now / before:.2f} times as sharp (allowed {1 - SHARPNESS:.2f})")
    return faults


def compare(path, reference, share=SHARE, step=1):
    """Alike, and a sentence about it."""
    a, b = read_png(path), read_png(reference)
    faults = faults_of(rounded(a, step) if step > 1 else a, b, share=share)
    return not faults, "; ".join(faults) or "alike"


# ---- what must be told apart

def changed(picture, change):
    """change(x, y, pixel) of all pixels, brought to 0 .. 255."""
    rows = []
    for y, row in enumerate(picture.rows):
        pixels = [change(x, y, row[3 * x:3 * x + 3]) for x in range(picture.width)]
        rows.append(bytes(min(max(v, 0), 255) for pixel in pixels for v in pixel))
    return Picture(picture.width, picture.height, rows)


def blurred(picture):
    def mean(x, y, _):
        near = [(min(max(x + i, 0), picture.width - 1), min(max(y + j, 0), picture.height - 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        return [sum(picture.rows[v][3 * u + c] for u, v in near) // 9 for c in range(3)]
    return changed(picture, mean)


def without_an_object(picture):
    """What fills 24 x 24 pixels, where most is to be seen, becomes as it is to the left of them."""
    light, side = luminance(picture), 24
    places = [(x, y) for y in range(0, picture.height - side, 8) for x in range(8, picture.width - side, 8)]
    busy = max(places, key=lambda at: sharpness([row[at[0]:at[0] + side] for row in light[at[1]:at[1] + side]]))
    left, top = busy
    inside = lambda x, y: left <= x < left + side and top <= y < top + side
    return changed(picture, lambda x, y, pixel: picture.rows[y][3 * left - 3:3 * left] if inside(x, y) else pixel)


def check(path):
    """Lines on what is told apart wrongly."""
    picture, dice = read_png(path), random.Random(1)
    noise = lambda: dice.choice((-2, -1, 0, 1, 2))
    alike = {
        "itself": picture,
        "rounded otherwise": changed(picture, lambda x, y, pixel: [v + noise() for v in pixel]),
        # A pixel in 300, of what lies beside it.
        "moved edges": changed(picture, lambda x, y, pixel: picture.rows[y][3 * x - 3:3 * x] if x and dice.random() < 1 / 300 else pixel),
    }
    other = {
        "24 levels brighter": changed(picture, lambda x, y, pixel: [v + 24 for v in pixel]),
        "4 levels darker": changed(picture, lambda x, y, pixel: [v - 4 for v in pixel]),
        "a tint": changed(picture, lambda x, y, pixel: [pixel[0] + 3, pixel[1], pixel[2] - 3]),
        "a blur over three pixels": blurred(picture),
        "one object less": without_an_object(picture),
        "another size": Picture(picture.width, picture.height - 1, picture.rows[:-1]),
    }
    for name, one in alike.items():
        faults = faults_of(one, picture)
        if faults:
            yield f"{path}: {name} counts as another picture: {'; '.join(faults)}"
    for name, one in other.items():
        if not faults_of(one, picture):
            yield f"{path}: {name} counts as the same picture"


def main():
    parser = argparse.ArgumentParser(description="are two pictures the same to the eye?")
    parser.add_argument("pictures", nargs="+")
    parser.add_argument("--share", type=float, default=SHARE)
    parser.add_argument("--step", type=int, default=1)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    if options.check:
        wrong = [line for path in options.pictures for line in check(path)]
        print("\n".join(wrong), end="\n" if wrong else "")
        sys.exit(bool(wrong))
    if len(options.pictures) != 2:
        parser.error("two pictures are compared")
    alike, text = compare(*options.pictures, share=options.share, step=options.step)
    print(text)
    sys.exit(not alike)


if __name__ == "__main__":
    main()
