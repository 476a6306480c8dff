#!/usr/bin/env python3
"""textures_sh3d.py TEXTURES.sh3d - writes a home that uses every way in which Sweet Home 3D lays pictures on things.

Each picture has sides of its own, so that a script can tell them apart, and a corner of another colour in each quarter, so that a
person sees which way it lies: red at the upper left, green at the upper right, blue at the lower left. The same Python gives the
same bytes. Lengths are centimetres, x to the right and y down, as in the program's files."""
import struct
import sys
import zlib

sys.dont_write_bytecode = True  # no __pycache__ among the samples
from house_sh3d import write_home

# Sides in texels of each picture by the file's entry.
PICTURES = {"bricks": (64, 32), "paper": (32, 64), "tiles": (32, 32), "oak": (128, 32), "stone": (128, 128), "plaster": (16, 64),
            "lawn": (64, 16), "sky": (256, 64), "board": (16, 32), "cloth": (32, 16), "crate": (64, 64), "label": (16, 16),
            "leaf": (32, 128), "grid": (128, 64), "plan": (128, 16), "dots": (16, 128)}
BOX = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
FACES = [(5, 6, 7, 8), (2, 1, 4, 3), (6, 2, 3, 7), (1, 5, 8, 4), (8, 7, 3, 4), (1, 2, 6, 5)]


def png(width, height, pixel):
    """A picture with opacity; pixel(x, y) is its (r, g, b, a)."""
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def picture(name):
    """A chequer of eight by eight with a mark in three corners; every other square of the leaf is a hole."""
    width, height = PICTURES[name]
    shade = 90 + 37 * len(name) % 100

    def pixel(x, y):
        across, down = 8 * x // width, 8 * y // height
        marks = {(0, 0): (220, 40, 40), (7, 0): (40, 180, 60), (0, 7): (50, 70, 220)}
        light = (across + down) % 2
        colour = marks.get((across, down), (shade + 60, shade + 50, shade + 30) if light else (shade, shade - 10, shade - 20))
        return colour + (0 if name == "leaf" and light and (across, down) not in marks else 255,)
    return png(width, height, pixel)


def tag(element, inner="", **attributes):
    text = "".join(" %s='%s'" % (key, value) for key, value in attributes.items() if value is not None)
    return "<%s%s>%s</%s>\n" % (element, text, inner, element)


def texture(name, width, height, **more):
    return tag("texture", name=name, width=width, height=height, image=name, **more)


def box(width, height, depth, material, places=False):
    """A box as an OBJ file, its corner off the origin; with texture coordinates each face shows the whole picture."""
    lines = ["mtllib box.mtl"]
    lines += ["v %g %g %g" % (10 + x * width, 20 + y * height, -5 + z * depth) for x, y, z in BOX]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1", "usemtl " + material]
    corner = "%d/%d" if places else "%d"
    lines += ["f " + " ".join(corner % ((v, k + 1) if places else v) for k, v in enumerate(face)) for face in FACES]
    return "\n".join(lines) + "\n"


def wall(name, start, end, left, right, inner="", **more):
    return tag("wall", (left or "") + (right or "") + inner, id=name, xStart=start[0], yStart=start[1], xEnd=end[0],
               yEnd=end[1], thickness=more.pop("thickness", 12), height=more.pop("height", 250), **more)


def walls():
    bricks = lambda **more: texture("bricks", 80, 40, attribute="leftSideTexture", **more)
    paper = lambda **more: texture("paper", 50, 100, attribute="rightSideTexture", **more)
    ends = ((100, 100), (700, 100), (700, 500), (100, 500))
    looks = ((bricks(), paper()),
             (bricks(angle=0.3, scale=1.5, xOffset=0.25, yOffset=0.4), paper(angle=-0.2, scale=0.7, xOffset=0.6, yOffset=0.1)),
             (bricks(leftToRightOriented="false"), paper(leftToRightOriented="false")),
             (bricks(xOffset=0.5), texture("tiles", 30, 30, attribute="rightSideTexture")))
    boards = (tag("baseboard", attribute="rightSideBaseboard", thickness=1.5, height=8, color="FF2060A0"),
              tag("baseboard", texture("board", 20, 8), attribute="rightSideBaseboard", thickness=2, height=10),
              tag("baseboard", attribute="rightSideBaseboard", thickness=1, height=7) +
              tag("baseboard", texture("board", 20, 8, angle=0.5), attribute="leftSideBaseboard", thickness=3, height=12),
              "")
    out = ""
    for i in range(4):
        out += wall("w%d" % i, ends[i], ends[(i + 1) % 4], looks[i][0], looks[i][1], boards[i],
                    wallAtStart="w%d" % ((i + 3) % 4), wallAtEnd="w%d" % ((i + 1) % 4))
    out += wall("between", (400, 106), (400, 494), texture("plaster", 60, 120, attribute="leftSideTexture", angle=0.1),
                texture("tiles", 30, 30, attribute="rightSideTexture"))
    out += wall("low", (150, 400), (250, 420), texture("tiles", 30, 30, attribute="leftSideTexture"), None, height=90,
                thickness=8)
    out += wall("arc", (780, 200), (780, 400), texture("stone", 70, 70, attribute="leftSideTexture"),
                texture("grid", 90, 45, attribute="rightSideTexture"), arcExtent=1.9)
    out += wall("arc back", (950, 400), (950, 200), texture("stone", 70, 70, attribute="leftSideTexture"),
                texture("grid", 90, 45, attribute="rightSideTexture"), arcExtent=-1.4)
    return out


def room(name, corners, floor, ceiling):
    points = "".join(tag("point", x=x, y=y) for x, y in corners)
    return tag("room", floor + ceiling + points, id=name, name=name, areaVisible="true")


def rooms():
    west = ((106, 106), (394, 106), (394, 494), (106, 494))
    east = ((406, 106), (694, 106), (694, 494), (406, 494))
    return room("west", west, texture("oak", 120, 30, attribute="floorTexture", angle=0.4, scale=1.25, xOffset=0.3, yOffset=0.7),
                texture("plaster", 60, 120, attribute="ceilingTexture", angle=0.15, xOffset=0.2)) + \
        room("east", east, texture("plan", 100, 100, attribute="floorTexture", fittingArea="true"),
             texture("dots", 100, 100, attribute="ceilingTexture", fittingArea="true"))


def pieces():
    piece = lambda name, inner="", **more: tag("pieceOfFurniture", inner, id=name, name=name, **more)
    cloth = lambda **more: texture("cloth", 40, 20, **more)
    label = lambda **more: tag("material", texture("label", 30, 30, **more), name="skin", key="skin")
    at = dict(width=60, depth=40, height=50)
    return piece("whole", cloth(), model="plain/box.obj", x=200, y=200, **at) + \
        piece("whole, turned", cloth(angle=0.4, scale=1.3, xOffset=0.2, yOffset=0.1), model="plain/box.obj", x=320, y=200,
              angle=0.7, **at) + \
        piece("whole, mirrored", cloth(leftToRightOriented="false"), model="plain/box.obj", x=200, y=320, modelMirrored="true",
              **at) + \
        piece("whole, laid on its side", cloth(), model="plain/box.obj", x=320, y=320, modelRotation="1 0 0 0 0 -1 0 1 0", **at) + \
        piece("own", model="crate/box.obj", x=480, y=200, **at) + \
        piece("own without coordinates", model="flat/box.obj", x=600, y=200, **at) + \
        piece("material, by coordinates", label(angle=0.3, scale=0.5, xOffset=0.25), model="crate/box.obj", x=480, y=320, **at) + \
        piece("material, by the box", label(angle=0.3, scale=0.5, xOffset=0.25), model="plain/box.obj", x=600, y=320, **at) + \
        piece("coloured", color="FF3366AA", model="crate/box.obj", x=480, y=440, **at) + \
        piece("leaves", model="leaf/box.obj", x=600, y=440, **at) + \
        tag("doorOrWindow", id="door", name="Door", model="plain/box.obj", x=400, y=250, angle=1.5707964, width=91.5, depth=12,
            height=208) + \
        tag("doorOrWindow", id="front", name="Front door", model="plain/box.obj", x=250, y=500, width=91.5, depth=12, height=208) + \
        tag("doorOrWindow", id="window", name="Window", model="plain/box.obj", x=700, y=300, angle=1.5707964, elevation=90, width=120,
            depth=12, height=110)


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: textures_sh3d.py TEXTURES.sh3d")
    environment = tag("environment", tag("observerCamera", attribute="cameraPath", x=150, y=450, z=170, yaw=3.9, pitch=0.1,
                                         fieldOfView=1.1) + texture("lawn", 200, 50, attribute="groundTexture", angle=0.2) +
                      texture("sky", 100, 100, attribute="skyTexture", xOffset=0.1), groundColor="FFA8A8A8", skyColor="FFCCE4FC")
    camera = lambda kind, name, x, y, yaw: tag("observerCamera", attribute=kind, name=name, id=name, x=x, y=y, z=170, yaw=yaw,
                                               pitch=0.15, time=1718971200000, fieldOfView=1.3)
    views = camera("observerCamera", "observer", 150, 470, 3.9) + camera("storedCamera", "west", 150, 470, 3.9) + \
        camera("storedCamera", "east", 680, 470, 2.4) + camera("storedCamera", "outside", 900, 650, 2.6)
    xml = "<?xml version='1.0'?>\n" + tag(
        "home", environment + tag("compass", x=50, y=50, diameter=100, latitude=0.85, longitude=0.04, timeZone="Europe/Paris") +
        views + pieces() + walls() + rooms(), version=7000, name="textures.sh3d", wallHeight=250, camera="observerCamera")
    entries = {name: picture(name) for name in PICTURES}
    skin = "newmtl skin\nKd 0.8 0.7 0.6\n"
    for folder, library, places in (("plain", skin, False), ("crate", skin + "map_Kd crate.png\n", True),
                                    ("flat", skin + "map_Kd crate.png\n", False), ("leaf", skin + "map_Kd leaf.png\n", True)):
        entries[folder + "/box.obj"] = box(2, 3, 1.5, "skin", places)
        entries[folder + "/box.mtl"] = library
        for name in ("crate", "leaf"):
            entries["%s/%s.png" % (folder, name)] = entries[name]
    write_home(sys.argv[1], xml, entries)


if __name__ == "__main__":
    main()
