#!/usr/bin/env python3
"""homes.py FOLDER - writes three homes as people draw them in Sweet Home 3D: flat.Home.xml, hillside.sh3d and villa.sh3d.

The flat is drawn carelessly, in an old version of the program, without models: walls miss each other by a centimetre, doors stand
beside their walls, a room has no wall on one side. The house on the hillside has a cellar, a garage half a storey down and rooms
under a gable roof, with textures. The villa has round walls, glass fronts and fine furniture. The same Python gives the same bytes.
Lengths are metres, x to the right and y up on the plan, angles degrees counter-clockwise from above."""
import math
import os
import random
import struct
import sys
import zlib

sys.dont_write_bytecode = True  # no __pycache__ among the samples
from house_sh3d import Obj, cubics, number, tag, write_home

MATERIALS = {  # RRGGBB, alpha
    "white": ("F2F0EA", 1), "cream": ("EFE4CC", 1), "oak": ("B58A58", 1), "walnut": ("6E4A30", 1), "beech": ("D8B684", 1),
    "black": ("2A2A2C", 1), "grey": ("8C9096", 1), "steel": ("B4B8BC", 1), "brass": ("C29C4A", 1), "linen": ("D9D2C3", 1),
    "moss": ("76835A", 1), "leaf": ("4F7D3E", 1), "petrol": ("3D6470", 1), "rust": ("A9583A", 1), "clay": ("B46A48", 1),
    "wine": ("7C3540", 1), "sky": ("A8C4D8", 1), "sun": ("E6C15C", 1), "stone": ("A39C90", 1), "earth": ("4C3B2E", 1),
    "glass": ("DCE8EA", 0.25), "shade": ("F4E8CE", 1), "paper": ("E9E4D6", 1), "tyre": ("26262A", 1), "red": ("B03A32", 1)}
BOOKS = ("wine", "petrol", "moss", "sun", "rust", "cream", "black", "sky")


def colour(name):
    return "FF" + MATERIALS[name][0]


def png(width, height, pixel):
    """A picture; pixel(x, y) is its (r, g, b)."""
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def planks(dark, light, seed):
    r = random.Random(seed)
    shade = [[r.random() for _ in range(4)] for _ in range(4)]

    def pixel(x, y):
        board = shade[y // 16][(x + 8 * (y // 16 % 2)) // 16 % 4]
        t = 0.15 if y % 16 == 0 or (x + 8 * (y // 16 % 2)) % 16 == 0 else 0.4 + 0.6 * board
        return tuple(round(a + (b - a) * t) for a, b in zip(dark, light))
    return png(64, 64, pixel)


def tiles(joint, one, two):
    return png(32, 32, lambda x, y: joint if x % 16 == 0 or y % 16 == 0 else (one, two)[(x // 16 + y // 16) % 2])


# ---- models: z up, front at -y, standing at z = 0

def rounded(obj, low, high, material, square=0.35, around=20, up=10):
    """A cushion: a superellipsoid that fills the box; square 1 is an ellipsoid, 0 a box."""
    bend = lambda v: math.copysign(abs(v) ** square, v)
    centre, half = [(a + b) / 2 for a, b in zip(low, high)], [(b - a) / 2 for a, b in zip(low, high)]
    rings = []
    for k in range(up + 1):
        v = -math.pi / 2 + math.pi * k / up
        wide, z = (0 if k in (0, up) else abs(bend(math.cos(v)))), round(centre[2] + half[2] * bend(math.sin(v)), 5)
        rings.append([(round(centre[0] + half[0] * wide * bend(math.cos(2 * math.pi * i / around)), 5),
                       round(centre[1] + half[1] * wide * bend(math.sin(2 * math.pi * i / around)), 5), z)
                      for i in range(around)])
    for one, two in zip(rings, rings[1:]):
        for i in range(around):
            j = (i + 1) % around
            corners = [one[i], one[j], two[j], two[i]]
            corners = [c for k, c in enumerate(corners) if c != corners[k - 1]]
            if len(corners) > 2:
                obj.face(corners, material)


def lathe(obj, at, points, material, around=14):
    obj.turned(at, [(r, round(z + (at[2] if len(at) > 2 else 0), 5)) for r, z in cubics(points)], material, around)


def turned_leg(obj, x, y, height, radius, material, around=10):
    h, r = height, radius
    lathe(obj, (x, y), [(0, 0), (r, 0), (r, 0), (.6 * r, .02 * h), (.5 * r, .3 * h), (1.5 * r, .35 * h), (1.2 * r, .5 * h),
                        (.8 * r, .6 * h), (.7 * r, .7 * h), (.9 * r, .8 * h), (1.1 * r, .9 * h), (r, .95 * h), (0, h)],
          material, around)


def tube(obj, points, radius, material, around=8):
    """Along points of a curve in an upright plane; rings stand square to it."""
    across = (points[0][1] - points[-1][1], points[-1][0] - points[0][0], 0)
    size = math.hypot(*across) or 1
    side = (across[0] / size, across[1] / size, 0) if math.hypot(*across) else (1, 0, 0)
    rings = []
    for i, p in enumerate(points):
        a, b = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
        d = [v - u for u, v in zip(a, b)]
        size = math.sqrt(sum(v * v for v in d))
        d = [v / size for v in d]
        up = (side[1] * d[2], -side[0] * d[2], side[0] * d[1] - side[1] * d[0])
        rings.append([tuple(round(p[k] + radius * (math.cos(t) * side[k] + math.sin(t) * up[k]), 5) for k in range(3))
                      for t in (2 * math.pi * n / around for n in range(around))])
    for one, two in zip(rings, rings[1:]):
        for i in range(around):
            j = (i + 1) % around
            obj.face([one[j], one[i], two[i], two[j]], material)


def fine_chair(wood, seat):
    obj = Obj()
    for x, y in ((-.19, -.19), (.19, -.19), (-.19, .19), (.19, .19)):
        turned_leg(obj, x, y, .44, .02, wood)
    rounded(obj, (-.23, -.23, .43), (.23, .23, .485), seat, .4, 24, 8)
    for x in (-.2, .2):
        lathe(obj, (x, .2, .45), [(0, 0), (.02, 0), (.02, .1), (.014, .2), (.022, .3), (.012, .4), (.02, .5), (.02, .55),
                                  (.02, .56), (0, .57)], wood, 12)
    for x in (-.12, -.04, .04, .12):
        lathe(obj, (x, .2, .47), [(0, 0), (.01, 0), (.006, .1), (.016, .2), (.006, .3), (.01, .4), (0, .42)], wood, 10)
    rounded(obj, (-.24, .17, .9), (.24, .23, .99), wood, .5, 20, 8)
    return obj


def plain_chair(wood):
    obj = Obj()
    for x, y in ((-.2, -.2), (.17, -.2), (-.2, .17), (.17, .17)):
        obj.box((x, y, 0), (x + .03, y + .03, .9 if y > 0 else .44), wood)
    obj.box((-.21, -.21, .44), (.21, .17, .47), wood)
    obj.box((-.17, .175, .6), (.17, .19, .88), wood)
    return obj


def table(wood, width, depth, legs=True):
    obj = Obj()
    x, y = width / 2, depth / 2
    obj.box((-x, -y, .71), (x, y, .75), wood)
    obj.box((-x + .06, -y + .06, .63), (x - .06, y - .06, .71), wood, ("top",))
    for sx in (-1, 1):
        for sy in (-1, 1):
            if legs:
                turned_leg(obj, sx * (x - .1), sy * (y - .1), .66, .035, wood, 16)
            else:
                obj.box((sx * (x - .08) - .03, sy * (y - .08) - .03, 0), (sx * (x - .08) + .03, sy * (y - .08) + .03, .66), wood)
    return obj


def round_table(wood, radius):
    obj = Obj()
    obj.turned((0, 0), [(0, .71), (radius, .71), (radius + .01, .73), (radius, .75), (0, .75)], wood, 40)
    lathe(obj, (0, 0), [(0, 0), (.3, 0), (.32, .02), (.3, .04), (.1, .08), (.05, .1), (.03, .3), (.12, .4), (.04, .5), (.05, .6),
                        (.1, .68), (.3, .7), (0, .71)], wood, 28)
    return obj


def sofa(cloth, width, corner=False):
    obj, x = Obj(), width / 2
    seats = max(2, round(width / .8))
    for k in range(seats):
        a, b = -x + .18 + (width - .36) * k / seats, -x + .18 + (width - .36) * (k + 1) / seats
        rounded(obj, (a, -.42, .2), (b, .3, .45), cloth, .3, 24, 8)
        rounded(obj, (a + .02, .15, .4), (b - .02, .42, .86), cloth, .4, 24, 8)
    for side in (-1, 1):
        rounded(obj, (side * x - (.2 if side > 0 else 0), -.45, .06), (side * x + (.2 if side < 0 else 0), .45, .62), cloth, .3, 24, 8)
    if corner:
        rounded(obj, (x - .98, -1.2, .2), (x - .18, -.42, .45), cloth, .3, 24, 8)
        rounded(obj, (x - .2, -1.2, .06), (x, -.44, .62), cloth, .3, 20, 8)
    obj.box((-x + .1, -.4, .04), (x - .1, .4, .22), "black")
    return obj


def bed(wood, cloth, width):
    obj, x = Obj(), width / 2
    obj.box((-x, -1.05, .12), (x, 1.0, .32), wood)
    obj.box((-x, 1.0, 0), (x, 1.06, .95), wood)
    for sx in (-x + .03, x - .09):
        obj.box((sx, -1.0, 0), (sx + .06, -.94, .12), wood)
    rounded(obj, (-x + .03, -1.02, .3), (x - .03, .98, .52), "white", .18, 28, 8)
    rounded(obj, (-x + .01, -1.04, .4), (x - .01, .4, .57), cloth, .2, 28, 8)
    for k in range(2 if width > 1.2 else 1):
        a = -x + .1 + k * (width - .2) / 2
        rounded(obj, (a, .5, .5), (a + min(.75, width / 2 - .12 if width > 1.2 else width - .2), .92, .66), "linen", .45, 20, 8)
    return obj


def cupboard(wood, width, depth, height, doors, feet=.08):
    obj, x = Obj(), width / 2
    obj.box((-x, -depth / 2 + .02, feet), (x, depth / 2, height), wood)
    obj.box((-x + .03, -depth / 2 + .06, 0), (x - .03, depth / 2 - .02, feet), "black", ("top",))
    for k in range(doors):
        a, b = -x + width * k / doors + .006, -x + width * (k + 1) / doors - .006
        obj.box((a, -depth / 2, feet + .01), (b, -depth / 2 + .02, height - .01), wood, ("back",))
        knob = b - .05 if k % 2 == 0 else a + .05
        obj.box((knob - .008, -depth / 2 - .03, height * .5), (knob + .008, -depth / 2, height * .5 + .12), "steel", ("back",))
    return obj


def shelf(wood, width, height, seed):
    obj, r, x = Obj(), random.Random(seed), width / 2
    obj.box((-x, .13, 0), (x, .15, height), wood)
    for sx in (-x, x - .025):
        obj.box((sx, -.15, 0), (sx + .025, .13, height), wood)
    levels = max(2, round(height / .36))
    for k in range(levels + 1):
        z = min(height - .025, .06 + (height - .085) * k / levels)
        obj.box((-x + .025, -.15, z), (x - .025, .13, z + .025), wood)
        at = -x + .03
        while k < levels and at < x - .12:
            thick, tall, book = .015 + .03 * r.random(), .2 + .1 * r.random(), r.choice(BOOKS)
            if r.random() < .82:
                obj.box((round(at, 4), -.11, z + .025), (round(at + thick, 4), round(.03 + .08 * r.random(), 4),
                                                         round(z + .025 + min(tall, (height - .085) / levels - .05), 4)), book, ("bottom",))
            at += thick + .001
    return obj


def plant(height, leaves, seed, pot="clay"):
    """A pot with leaves that bend outwards; each is a strip seen from both sides where the piece shows its backs."""
    obj, r = Obj(), random.Random(seed)
    wide = .13 + .06 * height
    lathe(obj, (0, 0), [(0, 0), (.7 * wide, 0), (.8 * wide, .1), (wide, .2), (wide, .3), (1.1 * wide, .31), (1.1 * wide, .34),
                        (.95 * wide, .34), (.9 * wide, .34), (.9 * wide, .3), (.85 * wide, .28), (.3, .28), (0, .28)][:10] +
          [(.85 * wide, .29), (.4 * wide, .29), (0, .29)], pot, 20)
    obj.turned((0, 0), [(.85 * wide, .29), (0, .29)], "earth", 20)
    for k in range(leaves):
        t = 2 * math.pi * (k * .381966 + .1 * r.random())
        reach, top, size = (.25 + .4 * r.random()) * height * .6, .3 + (height - .3) * (.45 + .5 * r.random()), .03 + .05 * r.random()
        c, s = math.cos(t), math.sin(t)
        rows = []
        for n in range(7):
            u = n / 6
            out, z = .03 + reach * u ** 1.6, .28 + (top - .28) * (1.9 * u - .9 * u * u)
            w = size * math.sin(math.pi * min(1, .08 + .92 * u)) if n < 6 else 0
            rows.append([(round(c * out - s * v, 4), round(s * out + c * v, 4), round(z, 4)) for v in ((-w, w) if w else (0,))])
        for one, two in zip(rows, rows[1:]):
            obj.face([one[0], one[1]] + two[::-1], "leaf")
    return obj


def pendant(drop, shade="shade"):
    obj = Obj()
    lathe(obj, (0, 0), [(.03, .29), (.045, .28), (.19, .19), (.205, 0), (.21, 0), (.215, 0), (.22, 0), (.2, .2), (.05, .29),
                        (.03, .3)], shade, 28)
    obj.turned((0, 0), [(.006, .29), (.006, .3 + drop), (.05, .3 + drop), (.05, .32 + drop), (0, .32 + drop)], "black", 12)
    return obj


def floor_lamp():
    obj = Obj()
    lathe(obj, (0, 0), [(0, 0), (.16, 0), (.16, .01), (.16, .02), (.05, .03), (.012, .04), (.012, .2), (.012, 1.2), (.012, 1.4),
                        (.012, 1.45), (0, 1.46)], "brass", 20)
    lathe(obj, (0, 0, 1.3), [(.2, 0), (.19, .1), (.16, .25), (.13, .33), (.125, .33), (.155, .24), (.195, 0)], "shade", 28)
    return obj


def chandelier():
    obj = Obj()
    lathe(obj, (0, 0), [(0, 0), (.04, .01), (.07, .06), (.05, .12), (.02, .16), (.03, .22), (.05, .3), (.012, .34), (.012, .5),
                        (.012, .6), (.05, .62), (.06, .64), (0, .65)], "brass", 20)
    for k in range(6):
        c, s = math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)
        curve = [(c * (.05 + .33 * u), s * (.05 + .33 * u), .12 - .16 * math.sin(math.pi * u) * (1 - .4 * u) + .12 * u * u)
                 for u in (n / 10 for n in range(11))]
        tube(obj, curve, .008, "brass", 8)
        lathe(obj, (c * .38, s * .38, .23), [(0, 0), (.02, 0), (.05, .02), (.05, .03), (.015, .035), (.012, .05), (.012, .13),
                                            (.01, .14), (0, .14)], "cream", 12)
    return obj


def worktop(width, sink=False, hob=False):
    obj, x = Obj(), width / 2
    obj.box((-x, -.28, .1), (x, .3, .88), "cream", ("top",))
    obj.box((-x, -.3, .88), (x, .3, .92), "stone")
    obj.box((-x + .02, -.22, 0), (x - .02, .3, .1), "black", ("top",))
    n = max(1, round(width / .6))
    for k in range(n):
        a, b = -x + width * k / n + .008, -x + width * (k + 1) / n - .008
        obj.box((a, -.3, .12), (b, -.28, .86), "white", ("back",))
        obj.box((a + .1, -.325, .78), (b - .1, -.3, .795), "steel", ("back",))
    if sink:
        lathe(obj, (.1, 0), [(.21, .935), (.2, .935), (.19, .93), (.18, .925), (.05, .925), (.03, .925), (0, .925)], "steel", 24)
        tube(obj, [(.1, .22 - .2 * u, .93 + .3 * math.sin(math.pi * min(1, .55 + .6 * u)) if u else .93) for u in
                   (n / 8 for n in range(9))], .012, "steel", 8)
    if hob:
        for hx, hy in ((-.3, -.13), (-.3, .13), (-.05, -.13), (-.05, .13)):
            obj.turned((hx, hy), [(.085, .92), (.085, .925), (0, .925)], "black", 24)
    return obj


def bath_tub():
    obj = Obj()
    rounded(obj, (-.85, -.38, 0), (.85, .38, .3), "white", .3, 32, 8)
    obj.box((-.85, -.38, .1), (.85, .38, .54), "white", ("top",))
    ring = lambda a, b, n=36: [(round(a * math.copysign(abs(math.cos(t)) ** .5, math.cos(t)), 4),
                                round(b * math.copysign(abs(math.sin(t)) ** .5, math.sin(t)), 4)) for t in
                               (2 * math.pi * (k + .5) / n for k in range(n))]
    outer, inner, floor = ring(.85, .38), ring(.76, .3), ring(.62, .2)
    for k in range(36):
        j = (k + 1) % 36
        obj.face([(*outer[k], .54), (*outer[j], .54), (*inner[j], .56), (*inner[k], .56)], "white")
        obj.face([(*inner[k], .56), (*inner[j], .56), (*floor[j], .16), (*floor[k], .16)], "white")
    obj.face([(*p, .16) for p in floor], "white")
    return obj


def basin():
    obj = Obj()
    lathe(obj, (0, 0), [(0, 0), (.12, 0), (.1, .1), (.06, .3), (.06, .6), (.08, .72), (.24, .74), (.27, .84), (.27, .86), (.25, .86),
                        (.24, .84), (.2, .76), (.03, .75), (.02, .75), (.02, .75), (0, .75)], "white", 28)
    tube(obj, [(0, .26, .86), (0, .26, .98), (0, .22, 1.03), (0, .15, 1.03), (0, .12, 1.0)], .012, "steel", 8)
    return obj


def toilet():
    obj = Obj()
    lathe(obj, (0, -.1), [(0, 0), (.13, 0), (.12, .1), (.1, .2), (.16, .34), (.2, .38), (.2, .4), (.19, .41), (.16, .41), (.15, .41),
                          (.1, .2), (.05, .18), (0, .18)], "white", 24)
    obj.box((-.19, .12, .36), (.19, .3, .76), "white")
    obj.box((-.12, .05, 0), (.12, .3, .36), "white", ("top",))
    return obj


def piano():
    """A grand piano; its lid is a single sheet that stands open."""
    ring = [(-.74, -.75), (.74, -.75), (.74, -.1), (.6, .25), (.3, .5), (.15, .85), (-.1, 1.0), (-.5, 1.0), (-.74, .8)]
    obj = Obj()
    obj.prism(ring, .62, .95, "black")
    obj.box((-.62, -.95, .66), (.62, -.75, .74), "black")
    obj.box((-.6, -.94, .74), (.6, -.76, .755), "white", ("bottom",))
    for k in range(36):
        if k % 7 not in (2, 6):
            obj.box((-.575 + k * .0327, -.87, .755), (-.56 + k * .0327, -.76, .767), "black", ("bottom",))
    for x, y in ((-.62, -.6), (.62, -.6), (-.3, .8)):
        lathe(obj, (x, y), [(0, 0), (.03, 0), (.04, .03), (.03, .06), (.03, .2), (.05, .5), (.07, .6), (.07, .62), (0, .63)], "black", 18)
    lid = [(x, y, .96 + (x + .74) * .7) for x, y in ring[3:] + [(-.74, -.1), (.74, -.1)]]
    obj.face([(round(x, 4), round(y, 4), round(z, 4)) for x, y, z in lid], "black")
    return obj


def car():
    obj = Obj()
    rounded(obj, (-.85, -2.1, .25), (.85, 2.1, .85), "red", .3, 24, 8)
    rounded(obj, (-.72, -1.2, .6), (.72, 1.5, 1.42), "black", .5, 24, 8)
    rounded(obj, (-.68, -.9, 1.1), (.68, 1.2, 1.45), "red", .4, 24, 6)
    for x in (-.83, .63):
        for y in (-1.35, 1.3):
            ring = [(y + .31 * math.cos(2 * math.pi * k / 20), .31 + .31 * math.sin(2 * math.pi * k / 20)) for k in range(20)]
            for (a, b), (c, d) in zip(ring, ring[1:] + ring[:1]):
                obj.face([(x, a, b), (x, c, d), (x + .2, c, d), (x + .2, a, b)], "tyre")
            obj.face([(x, a, b) for a, b in ring[::-1]], "steel")
            obj.face([(x + .2, a, b) for a, b in ring], "steel")
    return obj


def curtain(width, height, waves):
    """A wavy sheet with a front alone: the piece says that its back is shown."""
    obj, n = Obj(), waves * 8
    at = [(round(-width / 2 + width * k / n, 4), round(.035 * math.sin(2 * math.pi * k / 8), 4)) for k in range(n + 1)]
    for (a, b), (c, d) in zip(at, at[1:]):
        obj.face([(a, b, 0), (c, d, 0), (c, d, height), (a, b, height)], "linen")
    return obj


def rug(width, depth):
    obj = Obj()
    obj.box((-width / 2, -depth / 2, 0), (width / 2, depth / 2, .012), "wine")
    return obj


def screen_tv():
    obj = Obj()
    obj.box((-.6, -.02, .1), (.6, .02, .78), "black")
    obj.box((-.2, -.12, 0), (.2, .12, .02), "black")
    obj.box((-.03, -.02, .02), (.03, .02, .1), "black")
    return obj


def stair(width, depth, height, steps, railing=True):
    """A straight flight with turned balusters; rises towards the back."""
    obj = Obj()
    for k in range(steps):
        y, z = -depth / 2 + depth * k / steps, height * (k + 1) / steps
        obj.box((-width / 2, y, z - .05), (width / 2, y + depth / steps + (.02 if k + 1 < steps else 0), z), "oak")
        obj.box((-width / 2 + .03, y + depth / steps - .02, max(0, z - .05 - height / steps)),
                (width / 2 - .03, y + depth / steps, z - .05), "white")
        if railing:
            lathe(obj, (width / 2 - .05, y + depth / steps / 2, z), [(0, 0), (.02, 0), (.02, .1), (.01, .2), (.024, .35), (.01, .5),
                                                                     (.018, .7), (.018, .78), (.015, .8), (0, .82)], "white", 8)
    for x in (-width / 2, width / 2 - .03):
        corners = [(-depth / 2, 0), (-depth / 2 + .25, 0), (depth / 2, height - .3), (depth / 2, height - .06), (-depth / 2, .12)]
        for at, turn in ((x, -1), (x + .03, 1)):
            obj.face([(at, y, round(z, 4)) for y, z in corners[::turn]], "white")
    if railing:
        x = width / 2 - .05
        a, b = (-depth / 2 + .05, height / steps + .82), (depth / 2 - .05, height + .80)
        for s, t in ((-.03, -1), (.03, 1)):
            obj.face([(x + s, *p) for p in ([a, b, (b[0], b[1] + .05), (a[0], a[1] + .05)][::t])], "oak")
        obj.face([(x - .03, a[0], a[1] + .05), (x + .03, a[0], a[1] + .05), (x + .03, b[0], b[1] + .05), (x - .03, b[0], b[1] + .05)],
                 "oak")
    return obj


def door_model(width, height, depth, leaf, leaves=1, slides=False, glazed=False, arch=False):
    obj, f, h = Obj(), .05, depth / 2 + .005
    top = height - (.32 * width if arch else f)
    obj.box((-width / 2, -h, 0), (-width / 2 + f, h, top + (0 if arch else f)), "white")
    obj.box((width / 2 - f, -h, 0), (width / 2, h, top + (0 if arch else f)), "white")
    if arch:
        arcs = [[(-(width / 2 - g) * math.cos(math.pi * k / 12), top + (height - top - g) * math.sin(math.pi * k / 12)) for k in range(13)]
                for g in (0, f)]
        for k in range(12):
            a, b, c, d = arcs[0][k], arcs[0][k + 1], arcs[1][k + 1], arcs[1][k]
            obj.face([(round(x, 4), -h, round(z, 4)) for x, z in (d, c, b, a)], "white")
            obj.face([(round(x, 4), h, round(z, 4)) for x, z in (a, b, c, d)], "white")
            obj.face([(round(x, 4), y, round(z, 4)) for x, z, y in ((*d, -h), (*d, h), (*c, h), (*c, -h))], "white")
    else:
        obj.box((-width / 2 + f, -h, top), (width / 2 - f, h, height), "white")
    for k in range(leaves):
        group = "sweethome3d_opening_on_%s_%d" % ("rail" if slides else "hinge", k + 1)
        a, b = -width / 2 + f + (width - 2 * f) * k / leaves, -width / 2 + f + (width - 2 * f) * (k + 1) / leaves
        y = .022 * (k % 2 * 2 - 1) if slides else 0
        tall = top - .005 if not arch else top - .01
        if glazed:
            for low, high in (((a, y - .02, .005), (a + .08, y + .02, tall)), ((b - .08, y - .02, .005), (b, y + .02, tall)),
                              ((a + .08, y - .02, .005), (b - .08, y + .02, .13)),
                              ((a + .08, y - .02, tall - .09), (b - .08, y + .02, tall))):
                obj.box(low, high, leaf, (), group + "_door")
            obj.box((a + .08, y - .004, .13), (b - .08, y + .004, tall - .09), "glass", ("left", "right", "top", "bottom"),
                    "sweethome3d_window_pane_on_%s_%d" % ("rail" if slides else "hinge", k + 1))
        else:
            obj.box((a, y - .02, .005), (b, y + .02, tall), leaf, (), group + "_door")
            for z0, z1 in ((.15, .85), (1.0, tall - .15)):
                for s in (-1, 1):
                    obj.box((a + .12, y + s * .026 - .006, z0), (b - .12, y + s * .026 + .006, z1), leaf, (), group + "_door")
        knob = b - .06 if k == 0 else a + .06
        for s in (-1, 1):
            obj.box((knob - .012, y + s * .045 - .025, 1.0), (knob + .012, y + s * .045 + .025, 1.03), "steel", (), group + "_handle")
    return obj


def window_model(width, height, depth, parts=2, sill=True):
    obj, f, h = Obj(), .05, depth / 2
    for a, b in (((-width / 2, -h, 0), (-width / 2 + f, h, height)), ((width / 2 - f, -h, 0), (width / 2, h, height)),
                 ((-width / 2 + f, -h, height - f), (width / 2 - f, h, height)), ((-width / 2 + f, -h, 0), (width / 2 - f, h, f))):
        obj.box(a, b, "white")
    if sill:
        obj.box((-width / 2, -h - .12, .0), (width / 2, -h, .03), "white")
    for k in range(parts):
        a, b = -width / 2 + f + (width - 2 * f) * k / parts, -width / 2 + f + (width - 2 * f) * (k + 1) / parts
        if k:
            obj.box((a - .02, -.03, f), (a + .02, .03, height - f), "white")
        obj.face([(a, 0, f), (b, 0, f), (b, 0, height - f), (a, 0, height - f)], "glass", "sweethome3d_window_pane_%d" % (k + 1))
    return obj


def round_window(size, depth):
    obj, h, n = Obj(), depth / 2, 24
    ring = lambda r: [(round(r * math.cos(2 * math.pi * k / n), 4), round(size / 2 + r * math.sin(2 * math.pi * k / n), 4))
                      for k in range(n)]
    outer, inner = ring(size / 2), ring(size / 2 - .05)
    for k in range(n):
        j = (k + 1) % n
        obj.face([(outer[k][0], -h, outer[k][1]), (outer[j][0], -h, outer[j][1]), (inner[j][0], -h, inner[j][1]),
                  (inner[k][0], -h, inner[k][1])][::-1], "white")
        obj.face([(outer[k][0], h, outer[k][1]), (outer[j][0], h, outer[j][1]), (inner[j][0], h, inner[j][1]),
                  (inner[k][0], h, inner[k][1])], "white")
        obj.face([(inner[k][0], -h, inner[k][1]), (inner[j][0], -h, inner[j][1]), (inner[j][0], h, inner[j][1]),
                  (inner[k][0], h, inner[k][1])], "white")
    obj.face([(x, 0, z) for x, z in inner[::-1]], "glass", "sweethome3d_window_pane_1")
    return obj


# ---- a home: centimetres, y down

RECTANGLE = "M0,0 v1 h1 v-1 z"


class Home:
    def __init__(self, name, version, wall_height, bare=False):
        self.head = {"version": version, "name": name, "camera": "observerCamera", "wallHeight": 100 * wall_height}
        self.lines, self.environment, self.cameras, self.entries, self.models = [], [], [], {}, {}
        self.count, self.bare, self.open = 0, bare, []

    def id(self, kind):
        self.count += 1
        return "%s-%d" % (kind, self.count)

    def add(self, kind, attributes, children=()):
        (self.open[-1][1] if self.open else self.lines).extend(tag(kind, {k: v for k, v in attributes.items() if v is not None}, children))

    def level(self, name, floor, height, slab, **more):
        self.add("level", {"id": name, "name": name, "elevation": 100 * floor, "floorThickness": 100 * slab, "height": 100 * height,
                           "elevationIndex": 0, **more})

    def texture(self, attribute, name, size):
        a = {"attribute": attribute, "name": name, "width": 100 * size, "height": 100 * size}
        if not self.bare:
            a["image"] = "textures/%s.png" % name
        return tag("texture", a)

    def wall(self, level, a, b, thick, height=None, end=None, arc=None, left=None, right=None, names=(None, None, None), children=()):
        number_or_none = lambda v: None if v is None else 100 * v
        own = names[0] or self.id("wall")
        self.add("wall", {"id": own, "level": level, "wallAtStart": names[1], "wallAtEnd": names[2], "xStart": 100 * a[0],
                          "yStart": -100 * a[1], "xEnd": 100 * b[0], "yEnd": -100 * b[1], "height": number_or_none(height),
                          "heightAtEnd": number_or_none(end), "thickness": 100 * thick, "arcExtent": arc,
                          "pattern": "hatchUp", "leftSideColor": left and colour(left), "rightSideColor": right and colour(right)},
                          children)
        return own

    def walls(self, level, points, thick, height=None, closed=True, left=None, right=None, tops=None, arcs=None, **more):
        """Walls along a line that know each other, so that their corners are mitred; `tops` are the heights at both ends of each."""
        pairs = list(zip(points, points[1:] + points[:1] if closed else points[1:]))
        ids = [self.id("wall") for _ in pairs]
        for k, (a, b) in enumerate(pairs):
            low, high = tops[k] if tops else (height, None)
            self.wall(level, a, b, thick, low, high, arcs[k] if arcs else None, left=left, right=right,
                      names=(ids[k], ids[k - 1] if closed or k else None, ids[(k + 1) % len(ids)] if closed or k + 1 < len(ids) else None),
                      **more)

    def room(self, level, name, points, floor=None, ceiling="white", floor_texture=None, size=.8, **more):
        self.add("room", {"id": self.id("room"), "level": level, "name": name, "areaVisible": "true",
                          "floorColor": floor and colour(floor), "ceilingColor": ceiling and colour(ceiling), **more},
                 ([self.texture("floorTexture", floor_texture, size)] if floor_texture else []) +
                 [tag("point", {"x": 100 * x, "y": -100 * y}) for x, y in points])

    def model(self, name, obj):
        """The entry of a model, stored once."""
        if self.bare:
            return None
        if name not in self.models:
            folder = len(self.models) + 1
            self.models[name] = "%d/%s.obj" % (folder, name)
            self.entries[self.models[name]] = obj.text(name + ".mtl")
            self.entries["%d/%s.mtl" % (folder, name)] = obj.library(MATERIALS)
        return self.models[name]

    def piece(self, level, name, obj, at, angle=0, size=None, kind="pieceOfFurniture", children=(), **more):
        """A piece about the middle of its model's box; `size` resizes it. A tuple of three in place of a model: none, a box so large."""
        low, high = (obj.low, obj.high) if isinstance(obj, Obj) else ([0, 0, 0], obj)
        dims = size or [b - a for a, b in zip(low, high)]
        a = {"id": self.id(kind), "level": level, "name": name, "x": 100 * at[0], "y": -100 * at[1],
             "elevation": 100 * at[2] if len(at) > 2 and at[2] else None, "angle": math.radians(-angle % 360) if angle else None,
             "width": 100 * dims[0], "depth": 100 * dims[1], "height": 100 * dims[2]}
        if isinstance(obj, Obj):
            a["model"] = self.model(more.pop("entry", name.lower().replace(" ", "-")), obj)
        a.update(more)
        self.add(kind, a, children)

    def light(self, level, name, obj, at, power, source=(.5, .5, .3), angle=0, tint="00FFE8C8", diameter=None, size=None, **more):
        spots = [{"x": x, "y": y, "z": z, "color": tint} for x, y, z in ([source] if source else [])]
        self.piece(level, name, obj, at, angle, size, "light", [tag("lightSource", {**a, **({"diameter": diameter} if diameter else {})})
                                                                for a in spots], power=power, **more)

    def opening(self, level, name, obj, at, angle=0, sashes=(), size=None, **more):
        self.piece(level, name, obj, at, angle, size, "doorOrWindow",
                   [tag("sash", {"xAxis": x, "yAxis": y, "width": w, "startAngle": math.radians(a), "endAngle": math.radians(b)})
                    for x, y, w, a, b in sashes], **{"wallThickness": 1.0, "wallDistance": 0.0, "cutOutShape": RECTANGLE,
                                                     "movable": "false", **more})

    def door(self, level, name, at, width, height, depth, angle=0, leaf="oak", leaves=1, slides=False, glazed=False, arch=False,
             right=False, swing=-90, **more):
        key = "door-%d-%d-%d-%s-%d%s%s%s" % (round(100 * width), round(100 * height), round(100 * depth), leaf, leaves,
                                             "-rail" if slides else "",
                                             "-glass" if glazed else "", "-arch" if arch else "")
        pair = [(0., .5, .5, 0, swing), (1., .5, .5, 180, 180 - swing)]
        sashes = [] if slides else [(0., .5, 1. / leaves, 0, swing)] if leaves == 1 else pair
        if arch:
            more["cutOutShape"] = "M0,1 v-0.84 a0.5,0.16 0 0,1 1,0 v0.84 z"
        # Its frame stands out of the wall by 5 mm on either side.
        share = depth / (depth + .01)
        self.opening(level, name, door_model(width, height, depth, leaf, leaves, slides, glazed, arch), at, angle, sashes,
                     size=(width, depth + .01, height), entry=key, modelMirrored="true" if right else None, wallThickness=share,
                     wallDistance=(1 - share) / 2, wallCutOutOnBothSides="true", **more)

    def window(self, level, name, at, width, height, depth, sill, angle=0, parts=2, **more):
        board = .12
        share = depth / (depth + board)
        self.opening(level, name, window_model(width, height, depth, parts), (at[0] + board / 2 * math.sin(math.radians(angle)),
                     at[1] - board / 2 * math.cos(math.radians(angle)), sill), angle, entry="window-%d-%d-%d-%d" % (
                         round(100 * width), round(100 * height), round(100 * depth), parts), wallThickness=share, wallDistance=0., **more)

    def group(self, level, name, at):
        """What is added until `end` belongs to it."""
        self.open.append(({"id": self.id("group"), "level": level, "name": name, "x": 100 * at[0], "y": -100 * at[1], "width": 100.,
                           "depth": 100., "height": 100.}, []))

    def end(self):
        attributes, members = self.open.pop()
        self.add("furnitureGroup", attributes, [members])

    def camera(self, attribute, at, yaw, pitch=0, fov=63, name=None):
        t = math.radians(yaw)
        return tag("observerCamera", {k: v for k, v in {
            "attribute": attribute, "name": name, "lens": "PINHOLE", "x": 100 * at[0], "y": -100 * at[1], "z": 100 * at[2],
            "yaw": math.atan2(-math.cos(t), -math.sin(t)), "pitch": -math.radians(pitch), "fieldOfView": math.radians(fov),
            "time": "1750000000000"}.items() if v is not None})

    def view(self, name, at, yaw, pitch=0, fov=70):
        self.cameras += self.camera("storedCamera", at, yaw, pitch, fov, name)

    def observer(self, at, yaw, pitch=0):
        self.cameras += self.camera("observerCamera", at, yaw, pitch)

    def path(self, points):
        self.environment += [self.camera("cameraPath", at, yaw) for at, yaw in points]

    def xml(self, ground):
        body = tag("environment", {"groundColor": ground, "skyColor": "FFCCE4FC", "lightColor": "00D0D0D0",
                                   "ceillingLightColor": "00D0D0D0"},
                   self.environment)
        body += tag("compass", {"x": -100., "y": 50., "diameter": 100., "northDirection": 0.4, "longitude": 0.12, "latitude": 0.84,
                                "timeZone": "Europe/Berlin"})
        body += self.cameras + tag("camera", {"attribute": "topCamera", "lens": "PINHOLE", "x": 500., "y": 900., "z": 1800.,
                                              "yaw": 37.6991118, "pitch": 1.1, "fieldOfView": 1.0995574,
                                              "time": "1750000000000"}) + self.lines
        attributes = " ".join("%s='%s'" % (k, number(v) if isinstance(v, float) else v) for k, v in self.head.items())
        return "<?xml version='1.0'?>\n<home %s>\n%s</home>\n" % (attributes, "".join("  %s\n" % line for line in body))


# ---- the flat: a bare Home.xml of an old version, drawn by hand on a rainy evening

def flat():
    h = Home("flat.sh3d", 5500, 3.1, bare=True)
    w, sun = "cream", "sun"
    # The front and the side to the street know each other; the rest was drawn piece by piece, and corners gape or overlap.
    h.walls(None, [(-.19, 9.39), (-.19, -.19), (11.59, -.19)], .38, closed=False, left="stone", right=w)
    h.wall(None, (11.585, -.2), (11.594, 4.9), .38, left=w, right="stone")
    h.wall(None, (11.59, 4.885), (11.59, 8.95), .38, left=w, right="stone")  # stops short of the corner
    h.wall(None, (11.783, 9.39), (-.2, 9.386), .38, left=w, right="stone")
    board = [tag("baseboard", {"attribute": "leftSideBaseboard", "thickness": 1., "height": 9., "color": colour("white")})]
    h.wall(None, (4.675, 0.01), (4.675, 4.79), .15, left=w, right=w, children=board)
    h.wall(None, (8.275, -.012), (8.275, 4.795), .15, left=w, right="sky")
    h.wall(None, (.013, 4.875), (11.41, 4.872), .15, left=w, right=w, children=board)
    h.wall(None, (3.675, 4.94), (3.675, 9.188), .15, left=w, right=w)
    h.wall(None, (3.76, 6.425), (9.07, 6.425), .15, left=sun, right=w)
    h.wall(None, (5.975, 6.51), (5.975, 9.205), .12, left="white", right=sun)
    h.wall(None, (9.075, 6.36), (9.075, 9.195), .15, left=sun, right="white")
    # Where the box room should have its wall to the corridor there is a stub on either side, and the way is open.
    h.wall(None, (9.15, 6.425), (9.6, 6.425), .15)
    h.wall(None, (11.15, 6.425), (11.4, 6.425), .15)
    h.wall(None, (8.27, 4.15), (8.28, 4.8), 1.0, left=w, right=w)           # a chimney
    h.wall(None, (5.3, 7.4), (5.3, 9.2), .01, left="sky", right="sky")       # a sheet of glass beside the shower
    h.wall(None, (9.0, 1.3), (9.9, 1.7), .01, height=1.7, left="rust", right="rust")  # a folding screen
    h.wall(None, (9.9, 1.7), (10.7, 1.3), .01, height=1.7, left="rust", right="rust")
    h.wall(None, (2.2, 6.7), (3.6, 6.7), .12, height=1.1, left=w, right=w)  # a counter
    # The balcony's railing: three low walls, one of them sloping down to the neighbours.
    h.wall(None, (.95, -.38), (.95, -1.72), .06, height=.95, end=.8)
    h.wall(None, (.92, -1.7), (4.05, -1.7), .06, height=.95)
    h.wall(None, (4.02, -1.67), (4.02, -.38), .06, height=.95)
    h.room(None, "Living room", [(0, 0), (4.6, 0), (4.6, 4.8), (0, 4.8)], "oak", floor_texture="parquet")
    h.room(None, "Dining room", [(4.75, 0), (8.2, 0), (8.2, 4.8), (4.75, 4.8)], "oak", floor_texture="parquet")
    h.room(None, "Bedroom", [(8.35, .0), (11.4, 0), (11.4, 4.8), (8.35, 4.8)], "beech")
    h.room(None, "Corridor", [(3.75, 4.95), (11.4, 4.95), (11.4, 6.35), (3.75, 6.35)], "stone", areaXOffset=12.5, nameYOffset=-20.)
    h.room(None, "Kitchen", [(0, 4.95), (3.6, 4.95), (3.6, 9.2), (0, 9.2)], "clay")
    h.room(None, "", [(3.75, 6.5), (5.915, 6.5), (5.915, 9.2), (3.75, 9.2)], "grey")
    h.room(None, "Child", [(6.035, 6.5), (9.0, 6.5), (9.0, 9.2), (6.035, 9.2)], "beech")
    h.room(None, "Box room", [(9.15, 6.5), (11.4, 6.5), (11.4, 9.2), (9.15, 9.2)], None)
    h.room(None, "Balcony", [(.98, -.38), (3.99, -.38), (3.99, -1.67), (.98, -1.67)], "stone", None, ceilingVisible="false")
    # Openings, a hand's breadth beside their walls or not quite along them, as boxes: their models are not in this file.
    def way(name, at, width, height, depth, angle=0, sill=0., sashes=(), **more):
        h.opening(None, name, (width, depth, height), (*at, sill) if sill else at, angle, sashes, **more)
    left, both = [(0., .5, 1., 0, -90)], [(0., .5, .5, 0, -90), (1., .5, .5, 180, 270)]
    way("Front door", (11.57, 5.6), 1.0, 2.2, .4, 90, sashes=left, catalogId="eTeks#frontDoor", color=colour("wine"))
    way("Double door", (4.69, 2.4), 1.6, 2.3, .2, 90, sashes=both, color=colour("white"))
    way("Door", (3.71, 5.55), .9, 2.1, .12, 90.9, sashes=left, modelMirrored="true")
    way("Door", (6.5, 4.83), .9, 2.1, .18, 0, sashes=left)
    way("Door", (10.94, 4.9), .87, 2.1, .16, 180, sashes=left)                # in the corner
    way("Door", (4.5, 6.44), .8, 2.05, .15, 0, sashes=left)
    way("Porte ouverte", (7.1, 6.2), .9, 2.1, .6, 0, sashes=left, wallThickness=.25, wallDistance=.0)  # drawn open, deep
    way("French window", (2.5, -.16), 1.5, 2.3, .38, 0, sashes=both)
    way("Opening", (8.26, 2.0), .95, 2.15, .22, 90, catalogId="eTeks#doorFrame")
    for x, y, width, angle, sill, high in ((-.19, 2.4, 1.6, 90, .85, 1.5), (6.5, -.18, 1.5, 0, .85, 1.5), (9.9, -.2, 1.4, 0, .85, 1.5),
                                           (-.2, 5.9, 1.3, 90, 1.0, 1.3), (4.6, 9.38, .6, 0, 1.4, .8), (7.5, 9.4, 1.4, 180, .85, 1.5),
                                           (10.4, 9.39, .5, 0, 1.6, .5)):
        way("Window", (x, y), width, high, .38, angle, sill)
    def put(name, at, size, angle=0, tint="oak", **more):
        h.piece(None, name, size, at, angle, color=colour(tint), **more)
    put("Sofa", (.55, 2.4), (2.1, .95, .8), 270 - 180, "petrol")
    put("Armchair", (3.6, 3.9), (.85, .85, .8), 160, "rust")
    put("Coffee table", (1.9, 2.4), (1.1, .6, .4), 90)
    put("Rug", (2.1, 2.4), (2.4, 1.7, .01), 90, "wine")
    put("TV unit", (4.35, .7), (1.2, .4, .5), 270, "black")
    put("TV", (4.38, .7, .5), (1.1, .08, .65), 270, "black")
    put("Bookcase", (.9, 4.62), (1.4, .32, 2.2), 0, "white")
    put("Bookcase", (2.3, 4.62), (1.4, .32, 2.2), 0, "white")
    h.group(None, "Table and chairs", (6.4, 2.4))
    put("Table", (6.4, 2.4), (1.8, .95, .75), 90, "walnut")
    for k, (x, y, angle) in enumerate(((5.75, 1.9, 90), (5.75, 2.9, 88), (7.05, 1.9, 270), (7.05, 2.9, 274), (6.4, 1.2, 180),
                                       (6.4, 3.65, 0))):
        put("Chair", (x, y), (.44, .46, .92), angle, "walnut")
    h.end()
    put("Sideboard", (5.2, 4.5), (.8, .42, .9), 0, "walnut")
    put("Piano", (7.85, .9), (1.45, .6, 1.25), 270, "black")
    put("Double bed", (10.3, 3.2), (1.7, 2.1, .55), 270, "linen")
    put("Nightstand", (11.1, 2.1), (.45, .4, .5), 270, "beech")
    put("Wardrobe", (8.7, 3.0), (1.8, .62, 2.25), 90, "white")
    put("Stool", (9.2, .7), (.4, .4, .45), 30, "sun")
    h.group(None, "Fitted kitchen", (.5, 8.0))
    put("Worktop", (.31, 7.2), (2.6, .6, .92), 90, "stone")
    put("Cooker", (.31, 8.85), (.6, .6, .92), 90, "grey")
    put("Sink", (.31, 6.6, .92), (.6, .5, .02), 90, "steel")
    put("Wall unit", (.19, 8.0, 1.45), (2.2, .36, .7), 90, "white")
    h.end()
    put("Fridge", (3.28, 8.85), (.6, .65, 1.85), 270, "steel")
    put("Kitchen table", (2.2, 8.2), (1.1, .75, .75), 0)
    for x, y, angle in ((1.9, 7.65, 180), (2.5, 7.65, 175), (2.2, 8.75, 0)):
        put("Chair", (x, y), (.42, .42, .9), angle)
    put("Bar stool", (2.5, 6.35), (.36, .36, .75), 12, "black")
    put("Bar stool", (3.2, 6.38), (.36, .36, .75), 0, "black")
    put("Shower tray", (5.6, 8.3), (.55, .9, .06), 0, "white")
    put("Washbasin", (4.05, 7.5), (.6, .48, .85), 90, "white", modelMirrored="true")
    put("Toilet", (4.2, 8.85), (.38, .65, .78), 0, "white")
    put("Washing machine", (5.55, 6.85), (.6, .6, .85), 180, "white")
    put("Mirror", (3.78, 7.5, 1.1), (.6, .03, .8), 90, "sky")
    put("Bunk bed", (6.55, 8.1), (.95, 2.05, 1.6), 0, "beech")
    put("Desk", (8.65, 8.0), (1.3, .65, .74), 270, "beech")
    put("Swivel chair", (8.0, 7.95), (.5, .5, .95), 110, "petrol")
    put("Globe", (8.7, 8.4, .74), (.25, .25, .35), 0, "sky")
    put("Beanbag", (7.9, 6.95), (.8, .8, .55), 0, "red")
    for x, y, size in ((9.5, 8.9, .5), (10.05, 8.92, .55), (9.55, 8.85, .45), (11.1, 8.8, .6)):
        put("Box", (x, y, .5 if size == .45 else 0.), (size, .4, .4), 10 * size, "beech")
    put("Ladder", (11.2, 7.4), (.45, .12, 1.9), 90, "steel", pitch=-.12)
    put("Skis", (9.3, 7.0), (.2, .1, 1.8), 0, "red", roll=.08)
    put("Coat rack", (4.1, 6.2, 1.5), (.9, .2, .3), 180, "walnut")
    put("Shoe cupboard", (5.9, 6.22), (1.0, .26, .9), 0, "white")
    put("Runner", (7.6, 5.65), (3.0, .8, .01), 0, "moss")
    put("Old armchair", (10.3, 7.5), (.9, .9, .9), 45, "moss", visible="false")
    put("Balcony table", (2.0, -1.1), (.6, .6, .72), 0, "white")
    put("Flower box", (2.9, -1.64, .7), (.9, .2, .2), 0, "clay")
    for x, y, name in ((2.3, 2.4, "Living"), (6.4, 2.4, "Dining"), (9.9, 2.4, "Bed"), (7.5, 5.65, "Corridor"), (2.0, 7.6, "Kitchen"),
                       (4.6, 7.4, "Bath"), (7.5, 7.8, "Child")):
        h.light(None, name + " lamp", (.45, .45, .35), (x, y, 2.6), .7, (.5, .5, .2), color=colour("shade"))
    h.light(None, "Floor lamp", (.35, .35, 1.6), (.4, .9), .5, (.5, .5, .9), tint="00FFD8A0", color=colour("brass"))
    h.light(None, "Reading lamp", (.15, .15, .4), (11.1, 2.1, .5), .3, (.5, .5, .8), color=colour("brass"))
    h.light(None, "Lava lamp", (.12, .12, .4), (5.2, 4.5, .9), .2, None, color=colour("red"))  # without a source
    h.add("dimensionLine", {"xStart": 0., "yStart": 60., "xEnd": 460., "yEnd": 60., "offset": 40.})
    h.add("polyline", {"thickness": 2., "capStyle": "BUTT", "joinStyle": "MITER", "color": "FF000000"},
          [tag("point", {"x": x, "y": y}) for x, y in ((1100., -560.), (900., -560.), (600., -480.))])
    h.add("label", {"x": 240., "y": 110., "color": "FF8B0000"}, [["<text>sunny till five</text>"]])
    h.observer((6.9, 5.65, 1.68), 180)
    h.view("Living", (4.2, .5, 1.6), 140, -10)
    h.view("Kitchen", (3.3, 5.2, 1.6), 118, -12)
    h.view("Bedroom", (8.7, .5, 1.6), 60, -12)
    h.path([((10.5, 5.65, 1.6), 180), ((6.5, 5.6, 1.6), 270), ((6.5, 4.2, 1.6), 200), ((5.2, 2.4, 1.6), 180), ((2.3, 3.4, 1.6), 230)])
    return h, "FF7C9A55"


# ---- the house on the hillside: cellar, garage half a storey down, ground floor, rooms under the roof

CELLAR, GARAGE, GROUND, ROOF = "Cellar", "Garage", "Ground floor", "Under the roof"
KNEE, RIDGE = 1.1, 3.2  # above the floor under the roof


def hillside_shell(h):
    h.level(CELLAR, -1.8, 2.3, .2)
    h.level(GARAGE, .05, 2.9, .15)
    h.level(GROUND, .75, 2.6, .25)
    h.level(ROOF, 3.6, 3.2, .25, visible="false")
    # Outer faces at x 0 .. 10, y 0 .. 8; walls stand on their middle lines.
    block = [(.15, .15), (9.85, .15), (9.85, 7.85), (.15, 7.85)]
    h.walls(CELLAR, block, .3, left="white", right="stone")
    h.wall(CELLAR, (4.3, .3), (4.3, 7.7), .2, left="white", right="white")
    h.wall(CELLAR, (4.4, 3.9), (9.7, 3.9), .12, left="white", right="white")
    h.walls(GROUND, block, .3, left="cream", right="white")
    h.walls(GARAGE, [(0, 7.1), (-3.75, 7.1), (-3.75, .9), (0, .9)], .3, closed=False, left="grey", right="white")
    h.wall(GARAGE, (-.05, .75), (-.05, 7.25), .1, left="grey", right="grey")
    # Ground floor: hall with stairs, kitchen, living room along the garden, study, guests' bath.
    h.wall(GROUND, (4.3, .3), (4.3, 4.6), .12, left="white", right="cream")
    h.wall(GROUND, (.3, 4.6), (4.36, 4.6), .12, left="white", right="cream")
    h.wall(GROUND, (2.0, 4.66), (2.0, 7.7), .12, left="sky", right="white")
    h.wall(GROUND, (4.3, 4.66), (4.3, 7.7), .12, left="cream", right="white")
    h.wall(GROUND, (7.0, .3), (7.0, 2.4), .1, height=1.05, left="cream", right="cream")       # bar of the kitchen
    h.wall(GROUND, (6.9, 4.95), (6.9, 5.05), .35, left="stone", right="stone")               # a pillar
    h.wall(GROUND, (4.36, 4.6), (5.2, 4.6), .12, height=2.6, end=1.4, left="cream", right="cream")  # slanting screen
    # The terrace: low walls of stone, and a pergola post.
    h.walls(GROUND, [(9.85, 6.8), (12.4, 6.8), (12.4, 1.4), (9.85, 1.4)], .25, .55, closed=False, left="stone", right="stone")
    # Under the roof: knee walls along the eaves and gables up to the ridge at y = 4, in one ring.
    def under(y):
        return KNEE + (RIDGE - KNEE) * (min(y, 8 - y) - .15) / 3.85
    ring = [(.15, .15), (9.85, .15), (9.85, 4.0), (9.85, 7.85), (.15, 7.85), (.15, 4.0)]
    h.walls(ROOF, ring, .3, tops=[(KNEE, None), (KNEE, RIDGE), (RIDGE, KNEE), (KNEE, None), (KNEE, RIDGE), (RIDGE, KNEE)], left="cream",
            right="white")
    for x in (4.3, 6.2):
        h.wall(ROOF, (x, .3), (x, 4.0), .12, under(.3), under(4.0), left="white", right="cream")
        h.wall(ROOF, (x, 4.0), (x, 7.7), .12, under(4.0), under(7.7), left="white", right="cream")
    h.wall(ROOF, (6.26, 4.3), (9.7, 4.3), .12, under(4.3), left="sky", right="white")
    h.room(CELLAR, "Workshop", [(.3, .3), (4.2, .3), (4.2, 7.7), (.3, 7.7)], "grey")
    h.room(CELLAR, "Laundry", [(4.4, .3), (9.7, .3), (9.7, 3.84), (4.4, 3.84)], None, floor_texture="tiles", size=.6)
    h.room(CELLAR, "Cellar", [(4.4, 3.96), (9.7, 3.96), (9.7, 7.7), (4.4, 7.7)], "stone")
    h.room(GARAGE, "Garage", [(-3.6, 1.05), (-.1, 1.05), (-.1, 6.95), (-3.6, 6.95)], "grey", None)
    h.room(GROUND, "Study", [(.3, .3), (4.24, .3), (4.24, 4.54), (.3, 4.54)], None, floor_texture="planks", size=1.2)
    h.room(GROUND, "Guests", [(.3, 4.66), (1.94, 4.66), (1.94, 7.7), (.3, 7.7)], None, floor_texture="tiles", size=.6)
    h.room(GROUND, "Hall", [(2.06, 4.66), (4.24, 4.66), (4.24, 7.7), (2.06, 7.7)], None, floor_texture="tiles", size=.8)
    h.room(GROUND, "Kitchen", [(4.36, .3), (7.0, .3), (7.0, 2.4), (7.0, 4.6), (4.36, 4.6)], None, floor_texture="tiles", size=.6)
    h.room(GROUND, "Living room", [(7.0, .3), (9.7, .3), (9.7, 7.7), (4.36, 7.7), (4.36, 4.6), (7.0, 4.6)], None, floor_texture="planks",
           size=1.2)
    h.room(GROUND, "Terrace", [(10.0, 1.5), (12.3, 1.5), (12.3, 6.7), (10.0, 6.7)], "stone", None, ceilingVisible="false")
    h.room(ROOF, "Bedroom", [(.3, .3), (4.24, .3), (4.24, 7.7), (.3, 7.7)], None, floor_texture="planks", size=1.2)
    h.room(ROOF, "Landing", [(4.36, .3), (6.14, .3), (6.14, 7.7), (4.36, 7.7)], None, floor_texture="planks", size=1.2)
    h.room(ROOF, "Child", [(6.26, .3), (9.7, .3), (9.7, 4.24), (6.26, 4.24)], "beech")
    h.room(ROOF, "Bath", [(6.26, 4.36), (9.7, 4.36), (9.7, 7.7), (6.26, 7.7)], None, floor_texture="tiles", size=.6)


def hillside_openings(h):
    h.door(CELLAR, "Door", (4.3, 6.6), .85, 2.0, .2, 90, "white", swing=-95)
    h.door(CELLAR, "Laundry door", (7.6, 3.9), .85, 2.0, .12, 0, "white")
    for x in (1.2, 5.6):
        h.window(CELLAR, "Cellar window", (x, 7.85), .9, .38, .3, 1.88, 180, 1)
    h.window(CELLAR, "Cellar window", (6.6, .15), .9, .38, .3, 1.88, 0, 1)
    h.door(GARAGE, "Garage door", (-1.9, .9), 2.6, 2.15, .3, 180, "grey", slides=True)
    h.window(GARAGE, "Window", (-3.75, 4.5), 1.2, .6, .3, 1.4, 270, 2)
    h.door(GROUND, "Front door", (3.1, 7.85), 1.0, 2.15, .3, 180, "wine")
    h.door(GROUND, "Garage stairs", (.15, 4.1), .85, 2.0, .3, 90, "grey")
    h.opening(GARAGE, "Opening", door_model(.85, 2.0, .1, "white", 0), (-.05, 4.1, .7), 90, catalogId="own#opening", entry="opening")
    h.door(GROUND, "Door", (3.7, 4.6), .85, 2.05, .12, 0, right=True)
    h.door(GROUND, "Door", (2.0, 5.2), .75, 2.0, .12, 90, "white", right=True, swing=80)
    h.door(GROUND, "Glass door", (4.3, 5.5), 1.5, 2.1, .12, 90, "oak", leaves=2, glazed=True)
    h.door(GROUND, "Arched door", (4.3, 2.6), .95, 2.2, .12, 90, "walnut", arch=True, swing=90)
    h.door(GROUND, "Sliding patio door", (9.85, 4.0), 3.0, 2.2, .3, 90, "white", leaves=2, slides=True, glazed=True)
    h.window(GROUND, "Window", (2.2, .15), 1.6, 1.3, .3, .85, 0, 2)
    h.window(GROUND, "Kitchen window", (5.6, .15), 1.8, 1.1, .3, 1.05, 0, 3)
    h.window(GROUND, "Window", (8.4, .15), 1.4, 1.3, .3, .85, 0, 2)
    h.window(GROUND, "Window", (7.0, 7.85), 2.2, 1.4, .3, .8, 180, 3)
    h.window(GROUND, "Window", (1.1, 7.85), .6, .9, .3, 1.3, 180, 1)
    h.door(ROOF, "Door", (4.3, 4.9), .85, 2.0, .12, 90)
    h.door(ROOF, "Door", (6.2, 3.3), .85, 2.0, .12, 90, right=True)
    h.door(ROOF, "Door", (6.2, 5.0), .8, 2.0, .12, 90, "white")
    h.window(ROOF, "Gable window", (.15, 4.0), 1.4, 1.3, .3, .8, 270, 2)
    h.window(ROOF, "Gable window", (9.85, 2.9), .9, 1.2, .3, .9, 90, 1)
    for y in (4.0 + 1.9,):
        h.opening(ROOF, "Round window", round_window(.7, .3), (9.85, y, 1.0), 90,
                  cutOutShape="M0,0.5 a0.5,0.5 0 1,0 1,0 a0.5,0.5 0 1,0 -1,0 z")
    # Dormer-less: the landing has its light from a low window in the knee wall.
    h.window(ROOF, "Knee window", (5.25, .15), .9, .6, .3, .4, 0, 1)


def hillside_pieces(h):
    whole = {"staircaseCutOutShape": RECTANGLE}
    h.piece(CELLAR, "Cellar stairs", stair(.95, 3.3, 2.55, 14, False), (9.15, 5.95), 180, entry="cellar-stairs", **whole)
    h.piece(GROUND, "Staircase", stair(.95, 3.2, 2.85, 15), (4.95, 6.0), 0, entry="stairs", staircaseCutOutShape="M0,0 v1 h1 v-1 z")
    h.piece(GARAGE, "Garage steps", stair(.9, 1.0, .7, 4, False), (-.6, 4.1), 270)
    h.piece(GROUND, "Garden steps", stair(1.4, .9, .7, 4, False), (3.1, 8.5, -.75), 180, entry="garden-steps")
    # Cellar
    h.piece(CELLAR, "Workbench", table("beech", 2.2, .7, False), (.7, 2.0), 90)
    for y in (4.6, 5.7, 6.8):
        h.piece(CELLAR, "Storage shelf", shelf("beech", 1.0, 1.9, 40), (.5, y), 90, entry="shelf", kind="shelfUnit")
    h.piece(CELLAR, "Washing machine", cupboard("white", .6, .6, .85, 1), (9.35, .8), 270)
    h.piece(CELLAR, "Dryer", cupboard("white", .6, .6, .85, 1), (9.35, 1.5), 270, entry="washing-machine")
    h.piece(CELLAR, "Boiler", (.5, .5, 1.4), (4.75, .7), color=colour("steel"))
    h.piece(CELLAR, "Wine rack", cupboard("walnut", 1.6, .35, 1.6, 4), (6.2, 7.5), 0)
    h.piece(GARAGE, "Car", car(), (-1.95, 3.7), 180)
    h.piece(GARAGE, "Cupboard", cupboard("grey", 1.6, .45, 1.9, 3), (-1.6, 6.7), 0, entry="garage-cupboard")
    # Ground floor
    h.piece(GROUND, "Desk", table("walnut", 1.6, .75, False), (.75, 2.3), 90)
    h.piece(GROUND, "Swivel chair", plain_chair("petrol"), (1.45, 2.4), 255, entry="chair-petrol")
    for k in range(3):
        h.piece(GROUND, "Bookcase", shelf("oak", 1.1, 2.1, 7 + k % 2), (.9 + 1.13 * k, .49 + 3.86), 0, entry="books-%d" % (k % 2))
    h.piece(GROUND, "Armchair", sofa("rust", .95), (3.4, .95), 205, size=(.95, .9, .8))
    h.piece(GROUND, "Wardrobe", cupboard("oak", 1.5, .6, 2.1, 3), (2.4, 6.95), 90, size=(1.2, .5, 2.1), entry="wardrobe")
    h.piece(GROUND, "Toilet", toilet(), (.65, 7.3), 0)
    h.piece(GROUND, "Basin", basin(), (.58, 5.7), 90)
    h.group(GROUND, "Fitted kitchen", (5.6, .6))
    h.piece(GROUND, "Worktop", worktop(1.9, True, False), (6.0, .62), 180, entry="worktop-sink")
    h.piece(GROUND, "Cooker", worktop(1.2, False, True), (4.68, .95), 90, size=(1.2, .625, .925))
    h.piece(GROUND, "Fridge", cupboard("steel", .62, .62, 1.85, 2), (4.7, 3.75 - .05), 90, entry="fridge")
    h.end()
    h.group(GROUND, "Table and chairs", (8.3, 2.2))
    h.piece(GROUND, "Dining table", table("oak", 1.8, .95), (8.4, 2.1), 90)
    for x, y, angle in ((7.7, 1.6, 90), (7.7, 2.55, 94), (9.1, 1.6, 270), (9.1, 2.55, 266), (8.4, .8, 180), (8.4, 3.3, 3)):
        h.piece(GROUND, "Chair", fine_chair("oak", "linen"), (x, y), angle, entry="chair")
    h.end()
    for y in (.9, 1.7):
        h.piece(GROUND, "Bar stool", plain_chair("black"), (7.35, y), 90, size=(.36, .36, 1.0), entry="bar-stool")
    h.piece(GROUND, "Corner sofa", sofa("moss", 2.4, True), (7.6, 6.7), 0, modelMirrored="true")
    h.piece(GROUND, "Coffee table", round_table("walnut", .45), (7.7, 5.6), 0, size=(.9, .9, .42))
    h.piece(GROUND, "Rug", rug(2.4, 1.7), (7.7, 5.5), 4)
    h.piece(GROUND, "TV", screen_tv(), (6.3, 5.0), 180, entry="tv")
    h.piece(GROUND, "Stove", (.55, .5, 1.2), (5.9, 7.4), 0, color=colour("black"))
    h.piece(GROUND, "Curtain", curtain(.8, 2.3, 5), (9.6, 2.1), 90, backFaceShown="true", entry="curtain")
    h.piece(GROUND, "Curtain", curtain(.8, 2.3, 5), (9.6, 5.9), 90, backFaceShown="true", entry="curtain", color=colour("sun"))
    h.piece(GROUND, "Plant", plant(1.5, 18, 3), (10.6, 1.8), 0, backFaceShown="true", entry="plant-high")
    h.piece(GROUND, "Old piano", piano(), (8.0, 5.0), 0, visible="false")
    h.piece(GROUND, "Garden table", round_table("white", .55), (11.2, 4.0), 0, entry="garden-table")
    for angle in (20, 140, 260):
        t = math.radians(angle)
        h.piece(GROUND, "Garden chair", plain_chair("white"), (11.2 + .9 * math.cos(t), 4.0 + .9 * math.sin(t)), angle - 90,
                entry="garden-chair")
    # Under the roof
    h.piece(ROOF, "Double bed", bed("oak", "petrol", 1.7), (1.7, 2.4), 90)
    for y in (1.15, 3.65):
        h.piece(ROOF, "Nightstand", cupboard("oak", .45, .4, .5, 1, .05), (.55, y), 90)
    h.piece(ROOF, "Wardrobe", cupboard("oak", 1.5, .6, 2.1, 3), (3.35, 4.0 - .4), 270, entry="wardrobe", size=(1.5, .6, 1.9),
            modelMirrored="true")
    h.piece(ROOF, "Chest", cupboard("walnut", 1.2, .45, .7, 2), (1.6, 7.0), 0)
    h.piece(ROOF, "Single bed", bed("beech", "sun", .95), (9.1, 1.6), 0)
    h.piece(ROOF, "Toy chest", (.8, .4, .45), (7.0, .75), 180, color=colour("sky"))
    h.piece(ROOF, "Toy car", car(), (7.6, 2.2), 30, size=(.2, .5, .17), entry="car")
    h.piece(ROOF, "Desk", table("beech", 1.1, .6, False), (6.65, 1.9), 90, entry="small-desk")
    h.piece(ROOF, "Bathtub", bath_tub(), (8.75, 7.2), 0)
    h.piece(ROOF, "Basin", basin(), (6.6, 6.3), 90)
    h.piece(ROOF, "Toilet", toilet(), (9.3, 5.0), 270, entry="toilet")
    h.piece(ROOF, "Leaning ladder", (.45, .1, 1.8), (5.85, 1.0), 90, pitch=.25, color=colour("beech"))
    h.piece(ROOF, "Railing", (3.3, .05, .9), (5.47, 6.0), 90, color=colour("white"))
    # A model that was drawn lying and is stood up by its rotation.
    h.piece(ROOF, "Mirror", rug(1.6, .6), (4.17, 2.0), 270, size=(.6, .012, 1.6), modelRotation="0 0 1 1 0 0 0 1 0", entry="mirror",
            color=colour("sky"))
    for level, name, x, y, z, drop, power in ((CELLAR, "Workshop", 2.2, 4.0, 1.75, .25, .6), (CELLAR, "Laundry", 7.0, 2.0, 1.75, .25, .6),
                                              (CELLAR, "Cellar", 6.5, 5.8, 1.75, .25, .5), (GARAGE, "Garage", -1.9, 4.0, 1.95, .25, .6),
                                              (GROUND, "Study", 2.2, 2.3, 1.9, .4, .7), (GROUND, "Hall", 3.1, 6.2, 1.9, .4, .6),
                                              (GROUND, "Guests", 1.1, 6.2, 2.05, .25, .5), (GROUND, "Kitchen", 5.6, 2.3, 1.9, .4, .7),
                                              (GROUND, "Dining", 8.4, 2.1, 1.6, .7, .8), (GROUND, "Living", 7.6, 5.6, 1.9, .4, .8),
                                              (ROOF, "Bedroom", 2.2, 4.0, 2.2, .6, .7), (ROOF, "Landing", 5.25, 4.0, 2.2, .6, .6),
                                              (ROOF, "Child", 8.0, 3.6, 1.9, .4, .7), (ROOF, "Bath", 8.0, 4.9, 1.9, .4, .7)):
        h.light(level, name + " lamp", pendant(drop), (x, y, z), power, (.5, .5, .1), diameter=.3, entry="pendant-%d" % round(100 * drop))
    h.light(GROUND, "Floor lamp", floor_lamp(), (4.75, 7.35), .6, (.5, .5, .9), tint="00FFD8A0", entry="floor-lamp")
    h.light(ROOF, "Reading lamp", floor_lamp(), (.55, 3.65, .5), .3, (.5, .5, .9), tint="00FFD8A0", entry="floor-lamp", size=(.16, .16, .5))


def hillside():
    h = Home("hillside.sh3d", 7200, 2.6)
    h.entries = {"textures/planks.png": planks((92, 60, 34), (196, 152, 102), 5),
                 "textures/tiles.png": tiles((120, 116, 110), (214, 208, 196), (198, 190, 178))}
    hillside_shell(h)
    hillside_openings(h)
    hillside_pieces(h)
    h.observer((3.1, 7.2, 2.4), 260, -4)
    h.view("Living", (6.0, 4.9, 2.35), 30, -10)
    h.view("Dining", (9.4, 5.4, 2.35), 235, -10)
    h.view("Study", (3.9, 4.2, 2.35), 222, -12)
    h.view("Kitchen", (6.6, 4.2, 2.35), 240, -15)
    h.view("Bedroom", (3.9, 6.6, 5.2), 235, -10)
    h.view("Bath", (6.7, 4.7, 5.2), 45, -15)
    h.view("Cellar", (4.8, 7.3, -.2), 320, -8)
    h.view("Garage", (-3.2, 6.5, 1.65), 300, -10)
    h.view("From the garden", (15.5, -3.5, 2.4), 132, 2)
    h.path([((3.1, 9.6, 1.6), 270), ((3.1, 7.0, 2.35), 270), ((3.6, 5.6, 2.35), 0), ((5.6, 5.0, 2.35), 350), ((8.2, 4.2, 2.35), 270),
            ((6.0, 3.4, 2.35), 200), ((5.0, 5.0, 2.35), 100)])
    return h, "FF6F8F4A"


# ---- the villa: a round bay, a round library, fronts of glass, and furniture with turned legs

def villa_shell(h):
    w, c = "white", "cream"
    bay, room = 2.5, 2.8
    half = math.asin(1.0392 / room)
    south = [(-.15, -.15), (2.0, -.15), (7.0, -.15), (14.65, -.15), (14.65, 10.15), (-.15, 10.15)]
    h.walls(None, south, .3, left=w, right=c, arcs=[None, -math.pi, None, None, None, None])
    # The library's tower stands against the living room: two arcs.
    h.walls(None, [(-.15, 4.5 + 1.0392), (-.15 - math.sqrt(room ** 2 - 1.0392 ** 2) - room, 4.5), (-.15, 4.5 - 1.0392)], .3, closed=False,
            left="moss", right=c, arcs=[half - math.pi, half - math.pi])
    h.wall(None, (0, 6.56), (14.5, 6.56), .12, left=w, right=w)
    h.wall(None, (4.5, 6.62), (4.5, 10), .12, left=w, right=w)
    h.wall(None, (9.06, 0), (9.06, 10), .12, left=w, right="sky")
    h.wall(None, (9.12, 4.2), (14.5, 4.2), .12, left=w, right="sky")
    h.wall(None, (11.8, 4.26), (11.8, 6.5), .12, left=w, right=w)
    h.wall(None, (5.2, 4.2), (7.6, 4.2), .1, arc=1.6, left="rust", right="petrol")       # a curved partition, free on both sides
    h.wall(None, (5.2, 8.9), (5.2, 10.0), .02, height=2.0, left="walnut", right="walnut")  # a screen beside the entrance
    h.wall(None, (1.0, -4.6), (8.0, -4.6), .3, height=.5, arc=-1.2, left="stone", right="stone")  # around the terrace
    h.room(None, "Living room", [(0, 0), (2.0, 0)] + [(4.5 + 2.35 * math.cos(t), -.15 + 2.35 * math.sin(t)) for t in
           (math.pi * (1 + k / 12) for k in range(13))] + [(7.0, 0), (9, 0), (9, 6.5), (0, 6.5)], None, floor_texture="parquet", size=1.0)
    h.room(None, "Library",
           [(-2.75 + 2.6 * math.cos(t), 4.5 + 2.6 * math.sin(t)) for t in (.4 + (2 * math.pi - .8) * k / 28 for k in range(29))],
           None, floor_texture="parquet", size=1.0)
    h.room(None, "Kitchen", [(0, 6.62), (4.44, 6.62), (4.44, 10), (0, 10)], None, floor_texture="tiles", size=.8)
    h.room(None, "Hall", [(4.56, 6.62), (9, 6.62), (9, 10), (4.56, 10)], None, floor_texture="tiles", size=1.2)
    h.room(None, "Bedroom", [(9.12, 0), (14.5, 0), (14.5, 4.14), (9.12, 4.14)], "linen")
    h.room(None, "Bath", [(9.12, 4.26), (11.74, 4.26), (11.74, 6.5), (9.12, 6.5)], None, floor_texture="tiles", size=.8)
    h.room(None, "Dressing room", [(11.86, 4.26), (14.5, 4.26), (14.5, 6.5), (11.86, 6.5)], "linen")
    h.room(None, "Guests", [(9.12, 6.62), (14.5, 6.62), (14.5, 10), (9.12, 10)], None, floor_texture="parquet", size=1.0)
    h.room(None, "Terrace", [(1.0, -4.4), (8.0, -4.4), (8.0, -3.0), (1.0, -3.0)], "stone", None, ceilingVisible="false")


def villa_openings(h):
    for k, t in enumerate((225, 270, 315)):  # in the round bay, along its tangent
        c, s = math.cos(math.radians(t)), math.sin(math.radians(t))
        h.window(None, "Bay window", (4.5 + 2.5 * c, -.15 + 2.5 * s), 1.3, 1.9, .42, .45, t + 90, 2)
    for t in (120, 180, 240):                # and in the library
        c, s = math.cos(math.radians(t)), math.sin(math.radians(t))
        h.window(None, "Library window", (-2.75 + 2.8 * c, 4.5 + 2.8 * s), .7, 1.6, .4, .8, t + 90, 1)
    h.door(None, "Glass front", (1.0, -.15), 1.6, 2.4, .3, 0, "black", leaves=2, glazed=True)
    h.door(None, "Sliding glass front", (8.0, -.15), 1.8, 2.5, .3, 0, "black", leaves=2, slides=True, glazed=True)
    h.door(None, "Sliding glass front", (11.8, -.15), 3.6, 2.5, .3, 0, "black", leaves=3, slides=True, glazed=True)
    h.door(None, "Front door", (6.8, 10.15), 1.4, 2.3, .3, 180, "wine", leaves=2)
    h.door(None, "Arched door", (-.15, 4.5), 1.3, 2.45, .3, 90, "walnut", leaves=2, arch=True)
    h.door(None, "Kitchen sliding door", (2.6, 6.56), 1.6, 2.2, .12, 0, "white", leaves=2, slides=True, glazed=True)
    h.door(None, "Double door", (6.8, 6.56), 1.7, 2.3, .12, 0, "white", leaves=2)
    h.door(None, "Door", (9.06, 3.3), .9, 2.1, .12, 90, "white")
    h.door(None, "Door", (9.06, 7.2), .9, 2.1, .12, 90, "white", right=True)
    h.door(None, "Door", (10.0, 4.2), .85, 2.1, .12, 0, "white")
    h.door(None, "Door", (13.4, 4.2), .85, 2.1, .12, 0, "white", swing=90)
    h.window(None, "Kitchen window", (2.2, 10.15), 2.4, 1.2, .3, 1.1, 180, 3)
    h.window(None, "Kitchen window", (-.15, 8.3), 1.4, 1.2, .3, 1.1, 270, 2)
    h.window(None, "Corner window", (13.55, 10.15), 1.7, 1.5, .3, .8, 180, 2)
    h.window(None, "Corner window", (14.65, 9.05), 1.7, 1.5, .3, .8, 90, 2)
    h.window(None, "Window", (14.65, 2.0), 1.6, 1.5, .3, .8, 90, 2)
    h.window(None, "Bath window", (11.0, 6.56), .9, .5, .12, 1.9, 180, 1)  # to the guests' room, under the ceiling


def villa_pieces(h):
    chair = fine_chair("walnut", "wine")
    h.group(None, "Dining table and chairs", (2.4, 4.6))
    h.piece(None, "Dining table", round_table("walnut", .85), (2.4, 4.6))
    for k in range(6):
        t = math.radians(60 * k + 10)
        h.piece(None, "Dining chair", chair, (2.4 + 1.08 * math.cos(t), 4.6 + 1.08 * math.sin(t)), 60 * k + 10 - 90)
    h.end()
    h.piece(None, "Tea table", round_table("walnut", .85), (4.5, -1.2), size=(.9, .9, .7), entry="dining-table")
    for k, t in enumerate((30, 150, 270)):
        c, s = math.cos(math.radians(t)), math.sin(math.radians(t))
        h.piece(None, "Chair", chair, (4.5 + .8 * c, -1.2 + .8 * s), t - 90, entry="dining-chair", color=None if k else colour("cream"))
    h.piece(None, "Grand piano", piano(), (7.9, 5.3), 200, backFaceShown="true")
    h.piece(None, "Piano stool", chair, (8.25, 4.2), 20, size=(.45, .4, .5), entry="dining-chair")
    h.piece(None, "Sofa", sofa("petrol", 2.6), (5.0, 2.6), 0)
    h.piece(None, "Small sofa", sofa("petrol", 1.7), (3.3, 1.2), 90)
    h.piece(None, "Small sofa", sofa("petrol", 1.7), (6.9, 1.2), 270, entry="small-sofa")
    h.piece(None, "Coffee table", round_table("walnut", .85), (5.0, 1.2), size=(1.3, .9, .4), entry="dining-table")
    h.piece(None, "Rug", rug(3.4, 2.4), (5.0, 1.3), 2)
    h.piece(None, "Rug", rug(3.4, 2.4), (-2.75, 4.5), 90, size=(2.2, 1.8, .012), entry="rug", color=colour("petrol"))
    for k in range(6):
        t = math.radians((75, 97, 150, 210, 263, 285)[k])
        h.piece(None, "Library shelf", shelf("walnut", .9, 2.3, 60 + k % 2), (-2.75 + 2.28 * math.cos(t), 4.5 + 2.28 * math.sin(t)),
                math.degrees(t) - 90, entry="library-shelf-%d" % (k % 2), kind="shelfUnit")
    h.piece(None, "Reading chair", sofa("rust", 1.1), (-3.7, 4.1), 70)
    h.piece(None, "Globe", round_table("brass", .85), (-3.9, 5.3), size=(.4, .4, .6), entry="dining-table")
    for x, y, size, turn in ((.5, 3.0, 1.0, 0), (8.6, .9, 1.15, 40), (3.0, -1.3, .8, 80), (6.0, -1.4, .9, 120), (.5, 6.1, 1.1, 200),
                             (8.6, 9.6, 1.2, 250), (9.5, .5, .8, 300), (13.9, 7.1, .9, 10)):
        h.piece(None, "Palm", plant(1.7, 26, 12), (x, y), turn, size=(.95 * size, .95 * size, 1.7 * size), backFaceShown="true")
    for k in range(5):
        h.piece(None, "Curtain", curtain(.5, 2.6, 4), (9.75 + (.1 * k if k < 3 else 3.2 + .1 * k), .12), 0, backFaceShown="true",
                color=colour("sky") if k % 2 else None)
    h.piece(None, "Kitchen sink", worktop(2.4, True, False), (2.2, 9.68), 0)
    h.piece(None, "Kitchen hob", worktop(1.8, False, True), (.33, 8.3), 90)
    h.piece(None, "Kitchen island", worktop(1.8, False, False), (2.6, 8.0), 180, size=(1.8, .9, .92))
    h.piece(None, "Fridge", cupboard("steel", .7, .65, 2.0, 2), (4.05, 9.6), 0)
    for x in (2.1, 2.7, 3.3):
        h.piece(None, "Bar stool", plain_chair("black"), (x, 7.3), 180, size=(.4, .4, .95))
    h.piece(None, "Wardrobe", cupboard("walnut", 1.8, .6, 2.3, 3), (4.9 + .0, 7.9), 90, size=(1.6, .55, 2.3))
    h.piece(None, "Console", cupboard("walnut", 1.2, .35, .85, 2), (8.75, 8.6), 270)
    h.piece(None, "Bed", bed("walnut", "linen", 1.9), (13.3, 2.0), 270)
    h.piece(None, "Bedside", cupboard("walnut", .5, .42, .5, 1, .05), (14.2, .7), 270)
    h.piece(None, "Bedside", cupboard("walnut", .5, .42, .5, 1, .05), (14.2, 3.3), 270, modelMirrored="true")
    h.piece(None, "Dressing wardrobe", cupboard("white", 2.4, .6, 2.4, 4), (13.1, 6.15), 0)
    h.piece(None, "Bathtub", bath_tub(), (9.6, 5.5), 90)
    h.piece(None, "Basin", basin(), (11.4, 5.4), 270)
    h.piece(None, "Toilet", toilet(), (11.3, 6.15), 0)
    h.piece(None, "Guest bed", bed("walnut", "moss", 1.5), (13.3, 8.2), 270, modelMirrored="true")
    h.piece(None, "Desk", table("walnut", 1.5, .7), (10.4, 9.5), 0)
    h.piece(None, "Desk chair", chair, (10.4, 8.9), 0, entry="dining-chair")
    for x, angle in ((3.0, 160), (6.0, 200)):
        h.piece(None, "Deck chair", bed("beech", "sun", .95), (x, -3.7), angle, size=(.7, 1.8, .4))
    h.light(None, "Chandelier", chandelier(), (2.4, 4.6, 1.9), 1., (.5, .5, .55), diameter=.6)
    h.light(None, "Chandelier", chandelier(), (5.0, 1.4, 2.0), 1., (.5, .5, .55), diameter=.6)
    for x, y, power in ((-2.75, 4.5, .8), (2.6, 8.0, .8), (1.2, 8.8, .5), (6.8, 8.3, .8), (11.6, 2.0, .8), (10.4, 5.4, .6),
                        (13.1, 5.3, .6), (11.6, 8.3, .8),
                        (4.5, -1.0, .5), (8.0, 2.6, .4)):
        h.light(None, "Pendant", pendant(.5), (x, y, 2.0), power, (.5, .5, .1), diameter=.3)
    for x, y in ((7.9, 3.6), (3.1, 2.5), (-4.2, 3.4), (9.6, 8.7)):
        h.light(None, "Floor lamp", floor_lamp(), (x, y), .5, (.5, .5, .9), tint="00FFD8A0")
    for y in (.7, 3.3):
        h.light(None, "Table lamp", floor_lamp(), (14.2, y, .5), .3, (.5, .5, .9), tint="00FFD8A0", size=(.2, .2, .45), entry="floor-lamp")


def villa():
    h = Home("villa.sh3d", 7200, 2.9)
    h.entries = {"textures/parquet.png": planks((110, 74, 44), (184, 138, 92), 11),
                 "textures/tiles.png": tiles((168, 160, 150), (226, 222, 214), (206, 200, 190))}
    villa_shell(h)
    villa_openings(h)
    villa_pieces(h)
    h.observer((6.8, 9.3, 1.65), 265, -4)
    h.view("Living", (8.6, 2.6, 1.6), 190, -10)
    h.view("Bay", (4.6, 3.8, 1.6), 268, -12)
    h.view("Dining", (.5, 2.2, 1.6), 50, -12)
    h.view("Library", (-1.0, 4.9, 1.6), 190, -8)
    h.view("Kitchen", (4.1, 7.0, 1.6), 135, -12)
    h.view("Bedroom", (9.7, 1.3, 1.6), 20, -10)
    h.view("Guests", (9.5, 9.6, 1.6), 325, -12)
    h.view("Garden", (4.5, -9.5, 1.8), 80, 0)
    h.path([((6.8, 9.3, 1.65), 270), ((6.8, 5.8, 1.65), 230), ((4.2, 3.6, 1.65), 180), ((.8, 4.5, 1.65), 180), ((-2.4, 4.5, 1.65), 150)])
    return h, "FF7F9A58"


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: homes.py FOLDER")
    h, ground = flat()
    with open(os.path.join(sys.argv[1], "flat.Home.xml"), "w", encoding="utf-8") as out:
        out.write(h.xml(ground))
    for draw in (hillside, villa):
        h, ground = draw()
        write_home(os.path.join(sys.argv[1], h.head["name"]), h.xml(ground), h.entries)


if __name__ == "__main__":
    main()
