#!/usr/bin/env python3
"""textures.py FOLDER - draws the pictures of studio.plan: oak boards, tiles, bricks, wallpaper and a carpet, as small PNGs that repeat."""
import math
import random
import struct
import sys
import zlib


def write(path, width, height, colour):
    """Writes the picture whose pixel (x, y) has `colour(x, y)`, three channels 0 to 255."""
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    rows = b''.join(b'\0' + bytes(max(0, min(255, int(c))) for x in range(width) for c in colour(x, y)) for y in range(height))
    with open(path, 'wb') as file:
        file.write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) +
                   chunk(b'IDAT', zlib.compress(rows, 9)) + chunk(b'IEND', b''))


def noise(seed, count):
    """Random numbers -1 to 1, smoothed, that repeat after `count`."""
    r = random.Random(seed)
    values = [r.uniform(-1, 1) for _ in range(count)]
    return [(values[i - 1] + 2 * values[i] + values[(i + 1) % count]) / 4 for i in range(count)]


def shade(base, by):
    return [c * (1 + by) for c in base]


def oak(x, y, board=32, width=256):
    """Eight boards side by side, along x; each second one begins half a length further on."""
    i, inside = divmod(y, board)
    along = (x + (i % 2) * width // 2 + 37 * i) % width
    seam = inside == 0 or along == 0
    grain = noise(('grain', i, inside).__repr__(), width)[along] * 0.05
    rings = 0.05 * math.sin(inside * 0.9 + 2.2 * math.sin(2 * math.pi * along / width + i))
    tone = random.Random(i * 7 + 3).uniform(-0.12, 0.1)
    return shade((178, 132, 84), -0.45 if seam else tone + rings + grain)


def tiles(x, y, side=64, joint=3):
    i, j = x // side, y // side
    if x % side < joint or y % side < joint:
        return (172, 168, 160)
    return shade((228, 232, 230) if (i + j) % 2 == 0 else (72, 104, 118), 0.03 * math.sin(x * 0.7) * math.sin(y * 0.5))


def bricks(x, y, length=64, height=21, joint=3):
    course = y // height
    along = (x + (course % 2) * length // 2) % 128
    if y % height < joint or along % length < joint:
        return (186, 178, 166)
    tone = random.Random(course * 31 + along // length).uniform(-0.15, 0.12)
    return shade((168, 84, 62), tone + 0.06 * random.Random(x * 131 + y).uniform(-1, 1))


def paper(x, y):
    stripe = (x // 16) % 2
    dot = (x % 32 - 8) ** 2 + (y % 32 - 16) ** 2 < 14
    return (196, 170, 104) if dot and stripe == 0 else (220, 226, 212) if stripe else (206, 216, 200)


def carpet(x, y):
    u, v = abs(x - 63.5), abs(y - 63.5)
    edge = max(u, v)
    if edge > 58:
        return (64, 40, 44)
    if edge > 50:
        return (196, 160, 96) if (x + y) // 6 % 2 else (120, 44, 44)
    return (196, 160, 96) if abs((u + v) % 24 - 12) < 3 else (140, 52, 50)


folder = sys.argv[1]
write(folder + '/oak.png', 256, 256, oak)
write(folder + '/tiles.png', 128, 128, tiles)
write(folder + '/bricks.png', 128, 126, bricks)
write(folder + '/paper.png', 64, 64, paper)
write(folder + '/carpet.png', 128, 128, carpet)
