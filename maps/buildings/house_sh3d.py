#!/usr/bin/env python3
"""house_sh3d.py HOUSE.plan HOUSE.sh3d - writes house.plan as a Sweet Home 3D home: a ZIP of Home.xml and OBJ models.

Reads only what house.plan uses of the format; all its rooms have edges along x or y. Walls, which the plan leaves
to its rooms, become walls with two sides; inlays become thin boxes. Round shapes become polygons, metaballs are left
out, mirrors are light grey. The same input gives the same bytes."""
import hashlib
import math
import shlex
import sys
import zipfile
from xml.sax.saxutils import quoteattr

MM = 1000.0
WATTS_AT_FULL_POWER = 36.5   # flux of the strongest lamp: power 1
LIGHTEST = 0.85              # reflectance: what a mirror throws back and more is drawn as this
AROUND, UPWARDS = 16, 4      # sides of round shapes, steps along a curve of a profile
RUG = 0.012                  # metres, thickness of what was an inlay
FRAME = 0.05                 # metres, width of door and window frames


def point(word):
    return tuple(float(part) for part in word.split(","))


def srgb(linear):
    return round(255 * (12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055))


def colour_of(w):
    """RRGGBB of a material's words."""
    if w[2] != "reflectance":
        return w[2][1:]
    numbers = [float(x) for x in w[3:6]] if len(w) > 5 and w[4][0].isdigit() else 3 * [float(w[3])]
    mirror = float(w[w.index("mirror", 3) + 1]) if "mirror" in w[3:] else 0.0
    return "%02X%02X%02X" % tuple(srgb(min(LIGHTEST, x + mirror)) for x in numbers)


class House:
    def __init__(self, path):
        self.materials, self.models, self.storeys = {"plain": ("C8C8C8", 1.0)}, {}, []
        self.ground = ("7C9A55", 0.0)
        self.views, self.tour, self.start, self.facade = [], [], None, "plain"
        model = None
        for line in open(path, encoding="utf-8"):
            text = line.split(" # ")[0].strip()
            if not text or text.startswith("# ") or text == "#":
                continue
            words = shlex.split(text)
            if model is not None:
                if words[0] == "end":
                    model = None
                else:
                    self.models[model].append(words)
            elif words[0] == "model":
                model = words[1]
                self.models[model] = [] if len(words) < 4 else [["kind", words[3]]]
            else:
                self.statement(words)

    def statement(self, w):
        if w[0] == "material":
            alpha = float(w[w.index("alpha") + 1]) if "alpha" in w else 1.0
            self.materials[w[1]] = (colour_of(w), alpha)
        elif w[0] == "storey":
            o = options(w[2:])
            self.storeys.append({"name": w[1], "floor": float(o["floor"]), "height": float(o["height"]),
                                 "slab": float(o["slab"]), "rooms": [], "openings": [], "places": [], "inlays": [],
                                 "stairs": [], "wells": []})
        elif w[0] == "ground":
            self.ground = (self.materials[w[1]][0], 0.0)
        elif w[0] == "facade":
            self.facade = w[1]
        elif w[0] == "eye":
            self.tour.append((self.storeys[-1]["floor"], point(w[1]), options(w[2:])))
        elif w[0] == "view":
            self.views.append((w[1], self.storeys[-1]["floor"], point(w[2]), options(w[3:])))
        elif w[0] == "start":
            self.start = (self.storeys[-1]["floor"] + 1.6, point(w[1]), options(w[2:]))
        elif w[0] in ("plan", "slabs", "tour", "end"):
            pass
        else:
            self.storeyed(w)

    def storeyed(self, w):
        s = self.storeys[-1]
        corners = [point(x) for x in w if "," in x and x[0] in "-0123456789"]
        if w[0] == "room":
            s["rooms"].append((w[1], corners, options(w[2 + len(corners):])))
        elif w[0] in ("door", "window"):
            s["openings"].append((w[0], w[1], corners[0], options(w[3:]), corners[1:]))
        elif w[0] == "stair":
            s["stairs"].append((w[1], corners[0], options(w[3:])))
        elif w[0] == "stairwell":
            s["wells"].append(corners)
        elif w[0] == "inlay":
            s["inlays"].append((w[1], w[2], corners))
        elif w[0] == "place":
            s["places"].append((w[1], corners[0], options(w[3:])))
        else:
            sys.exit("house_sh3d.py: statement %s is not known here" % w[0])


def options(words):
    out, i = {}, 0
    while i < len(words):
        if words[i] in ("glazed", "mirror", "round"):
            out[words[i]] = True
            i += 1
        elif words[i] == "shape":
            break
        else:
            out[words[i]] = words[i + 1]
            i += 2
    return out


# ---- models as OBJ: x to the right, y up, z to the front (-y on the plan)

class Obj:
    def __init__(self):
        self.vertices, self.faces, self.low, self.high = [], [], [1e9] * 3, [-1e9] * 3
        self.ids = {}

    def face(self, corners, material, group="body"):
        ids = []
        for x, y, z in corners:
            v = (x, z, -y)
            self.low = [min(a, b) for a, b in zip(self.low, (x, y, z))]
            self.high = [max(a, b) for a, b in zip(self.high, (x, y, z))]
            if v not in self.ids:
                self.vertices.append(v)
                self.ids[v] = len(self.vertices)
            ids.append(self.ids[v])
        self.faces.append((group, material, ids))

    def box(self, a, b, material, without=(), group="body"):
        (x0, y0, z0), (x1, y1, z1) = a, b
        sides = {"top": [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
                 "bottom": [(x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)],
                 "left": [(x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)],
                 "right": [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
                 "front": [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
                 "back": [(x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)]}
        for name, corners in sides.items():
            if name not in without:
                self.face(corners, material, group)

    def prism(self, ring, z0, z1, material, without=()):
        area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1]))
        ring = ring if area > 0 else ring[::-1]
        for a, b in zip(ring, ring[1:] + ring[:1]):
            self.face([(*a, z0), (*b, z0), (*b, z1), (*a, z1)], material)
        if "top" not in without:
            self.face([(*p, z1) for p in ring], material)
        if "bottom" not in without:
            self.face([(*p, z0) for p in ring[::-1]], material)

    def turned(self, centre, profile, material, around=AROUND):
        """A profile of (r, z) turned about the upright axis through `centre`; outside lies to its right."""
        rings = [[(centre[0] + r * math.cos(2 * math.pi * i / around), centre[1] + r * math.sin(2 * math.pi * i / around),
                   z) for i in range(around + 1)] if r > 0 else [(centre[0], centre[1], z)] * (around + 1)
                 for r, z in profile]
        for low, high in zip(rings, rings[1:]):
            for i in range(around):
                corners = [low[i], low[i + 1], high[i + 1], high[i]]
                self.face([c for k, c in enumerate(corners) if c != corners[k - 1]], material)

    def text(self, library):
        lines = ["# written by house_sh3d.py", "mtllib " + library] if library else ["# written by house_sh3d.py"]
        lines += ["v %.4f %.4f %.4f" % v for v in self.vertices]
        group = material = None
        for g, m, ids in self.faces:
            if g != group:
                lines.append("g " + g)
                group = g
            if library and m != material:
                lines.append("usemtl " + m)
                material = m
            lines.append("f " + " ".join(map(str, ids)))
        return "\n".join(lines) + "\n"

    def library(self, materials):
        lines = []
        for name in sorted({m for _, m, _ in self.faces}):
            rgb, alpha = materials[name]
            lines += ["newmtl " + name, "Kd %.4f %.4f %.4f" % tuple(int(rgb[i:i + 2], 16) / 255 for i in (0, 2, 4)),
                      "d %g" % alpha, ""]
        return "\n".join(lines)


def cubics(points):
    """Points along cubic Bezier curves set end to end."""
    out = points[:1]
    for k in range(0, len(points) - 3, 3):
        for i in range(1, UPWARDS + 1):
            t = i / UPWARDS
            b = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3)
            out.append(tuple(round(sum(b[j] * points[k + j][c] for j in range(4)), 6) for c in (0, 1)))
    return out


def round_obj(obj, w):
    """Spheres, upright cones, what a lathe turns."""
    if w[0] == "sphere":
        (x, y, z), r = point(w[2]), float(options(w[3:])["radius"])
        half = AROUND // 2
        obj.turned((x, y), [(0 if i in (0, half) else r * math.sin(math.pi * i / half), z - r * math.cos(math.pi * i / half))
                            for i in range(half + 1)], w[1])
    elif w[0] == "cone":
        (x, y, z), top, o = point(w[2]), point(w[3]), options(w[4:w.index("without")] if "without" in w else w[4:])
        ends = [(float(o["radius"]), z), (float(o.get("top", 0)), top[2])]
        without = w[w.index("without"):] if "without" in w else ()
        obj.turned((x, y), ([] if "bottom" in without else [(0, z)]) + ends + ([] if "top" in without else [(0, top[2])]),
                   w[1])
    elif w[0] == "lathe":
        obj.turned(point(w[2]), cubics([point(x) for x in w[4:] if "," in x]), w[1])


def model_obj(statements):
    obj, lights = Obj(), []
    for w in statements:
        without = w[w.index("without") + 1:] if "without" in w else ()
        round_obj(obj, w)
        if w[0] == "box":
            obj.box(point(w[1]), point(w[2]), w[3], without)
        elif w[0] == "prism":
            obj.prism([point(x) for x in w[4:] if "," in x], float(w[2]), float(w[3]), w[1], without)
        elif w[0] == "cylinder":
            o = options(w[5:w.index("without")] if without else w[5:])
            (cx, cy), n, r = point(w[4]), int(o.get("sides", AROUND if "round" in o else 8)), float(o["radius"])
            ring = [(cx + r * math.cos(2 * math.pi * (i + .5) / n), cy + r * math.sin(2 * math.pi * (i + .5) / n))
                    for i in range(n)]
            obj.prism(ring, float(w[2]), float(w[3]), w[1], without)
        elif w[0] == "poly":
            obj.face([point(x) for x in w[2:]], w[1])
        elif w[0] == "light":
            lights.append((point(w[1]), [float(x) for x in w[3:6]]))
    return obj, lights


def framed(window, width, height, depth, leaf, double, slides):
    obj, f, h = Obj(), FRAME, depth / 2
    obj.box((-width / 2, -h, 0), (-width / 2 + f, h, height), "white")
    obj.box((width / 2 - f, -h, 0), (width / 2, h, height), "white")
    obj.box((-width / 2 + f, -h, height - f), (width / 2 - f, h, height), "white")
    if window:
        obj.box((-width / 2 + f, -h, 0), (width / 2 - f, h, f), "white")
        obj.face([(-width / 2 + f, 0, f), (width / 2 - f, 0, f), (width / 2 - f, 0, height - f),
                  (-width / 2 + f, 0, height - f)], "pane")
        return obj
    parts = [(-width / 2 + f, width / 2 - f)]
    if double:
        parts = [(-width / 2 + f, 0), (0, width / 2 - f)]
    for i, (x0, x1) in enumerate(parts):
        obj.box((x0, -0.02, 0.005), (x1, 0.02, height - f), leaf, (),
                "sweethome3d_opening_on_%s_%d" % ("rail" if slides else "hinge", i + 1))
    return obj


def stair_obj(width, depth, height, steps):
    obj = Obj()
    for i in range(steps):
        y0, y1, z = -depth / 2 + i * depth / steps, -depth / 2 + (i + 1) * depth / steps, height * i / steps
        top = height * (i + 1) / steps
        obj.box((-width / 2, y0, 0), (width / 2, y1, top), "oak", ("bottom", "front") if i + 1 == steps else
                ("bottom", "front", "back"))
        obj.face([(-width / 2, y0, z), (width / 2, y0, z), (width / 2, y0, top), (-width / 2, y0, top)], "oak")
    return obj


# ---- walls from the rooms' edges; whole millimetres

def inside(rooms, x, y):
    for name, ring, _ in rooms:
        hit = False
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
            if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
                hit = not hit
        if hit:
            return name
    return None


class Walls:
    def __init__(self, storey):
        self.rooms = [(n, [(round(x * MM), round(y * MM)) for x, y in c], o) for n, c, o in storey["rooms"]]
        self.found = {}
        for name, ring, o in self.rooms:
            area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1]))
            ring = ring if area > 0 else ring[::-1]
            for a, b in zip(ring, ring[1:] + ring[:1]):
                self.edge(name, a, b, round(float(o["wall"]) * MM))

    def edge(self, name, a, b, thick):
        along = 0 if a[1] == b[1] else 1
        cuts = {a[along], b[along]}
        for _, ring, _ in self.rooms:
            for p in ring:
                if min(a[along], b[along]) < p[along] < max(a[along], b[along]):
                    cuts.add(p[along])
        cuts = sorted(cuts)
        out = (1 if b[0] > a[0] else -1) if along == 0 else (1 if b[1] > a[1] else -1)
        # Outside lies to the right of the direction a -> b.
        way = -out if along == 0 else out
        for low, high in zip(cuts, cuts[1:]):
            self.piece(name, along, low, high, a[1 - along], way, thick)

    def piece(self, name, along, low, high, face, way, thick):
        middle, gap, other = (low + high) / 2, None, None
        for d in range(10, thick + 1, 10):
            p = (middle, face + way * d) if along == 0 else (face + way * d, middle)
            other = inside(self.rooms, *p)
            if other:
                break
        if other:
            # The other room's face: the nearest millimetre inside it.
            gap = next(g for g in range(d - 10, d + 1) if inside(self.rooms, *(
                (middle, face + way * (g + 0.5)) if along == 0 else (face + way * (g + 0.5), middle))))
        if not other and high - low < thick / 2:
            return  # the end of a wall between two rooms beyond: the walls that meet there close it
        width = gap if other else thick
        key = (along, round(face + way * width / 2, 1), width)
        sides = self.found.setdefault(key, {}).setdefault((low, high), {})
        sides[-way] = name

    def blocked(self, along, axis, width, low, high):
        """Whether the strip overlaps a room."""
        for t in (0.02, 0.25, 0.5, 0.75, 0.98):
            for s in (-0.48, 0, 0.48):
                u, v = low + (high - low) * t, axis + width * s
                if inside(self.rooms, *((u, v) if along == 0 else (v, u))):
                    return True
        return False

    def list(self):
        """(start, end, thickness, room on the left, room on the right), metres; pieces of like sides are joined."""
        out = []
        for (along, axis, width), runs in sorted(self.found.items()):
            joined = []
            for (low, high), sides in sorted(runs.items()):
                if joined and joined[-1][1] == low and joined[-1][2] == sides:
                    joined[-1][1] = high
                else:
                    joined.append([low, high, sides])
            for low, high, sides in joined:
                for reach in (300, 150, 120, 60):
                    if not self.blocked(along, axis, width, low - reach, low):
                        low -= reach
                        break
                for reach in (300, 150, 120, 60):
                    if not self.blocked(along, axis, width, high, high + reach):
                        high += reach
                        break
                # Towards +x the left is +y, towards +y it is -x.
                left, right = (sides.get(1), sides.get(-1)) if along == 0 else (sides.get(-1), sides.get(1))
                a, b = ((low, axis), (high, axis)) if along == 0 else ((axis, low), (axis, high))
                out.append(((a[0] / MM, a[1] / MM), (b[0] / MM, b[1] / MM), width / MM, left, right))
        return out


# ---- Home.xml: centimetres, y down

def number(value):
    text = "%.4f" % value
    return text.rstrip("0").rstrip(".") if "." in text else text


def tag(name, attributes, children=()):
    text = "<%s %s" % (name, " ".join("%s=%s" % (k, quoteattr(number(v) if isinstance(v, float) else str(v)))
                                      for k, v in attributes.items()))
    if not children:
        return [text + "/>"]
    return [text + ">"] + ["  " + line for child in children for line in child] + ["</%s>" % name]


class Home:
    def __init__(self, house):
        self.house, self.entries, self.lines, self.ids = house, {}, [], {}

    def colour(self, material):
        return "FF" + self.house.materials[material][0]

    def model(self, name, obj):
        """The entry's name; models are stored once."""
        if name not in self.ids:
            number_ = len(self.ids) + 1
            self.ids[name] = "%d/%s.obj" % (number_, name)
            self.entries["%d/%s.obj" % (number_, name)] = obj.text(name + ".mtl")
            self.entries["%d/%s.mtl" % (number_, name)] = obj.library(self.house.materials)
        return self.ids[name]

    def bare(self, name, obj):
        """A model without materials of its own, at a bare numbered entry."""
        if name not in self.ids:
            self.ids[name] = "%d" % (len(self.ids) + 1)
            self.entries[self.ids[name]] = obj.text(None)
        return self.ids[name]

    def piece(self, level, storey, name, entry, obj, at, o, extra=None, kind="pieceOfFurniture", children=()):
        angle = math.radians(float(o.get("angle", 0)))
        mirror = "mirror" in o
        cx, cy = (obj.low[0] + obj.high[0]) / 2 * (-1 if mirror else 1), (obj.low[1] + obj.high[1]) / 2
        x = at[0] + math.cos(angle) * cx - math.sin(angle) * cy
        y = at[1] + math.sin(angle) * cx + math.cos(angle) * cy
        up = (at[2] if len(at) > 2 else 0) + obj.low[2]
        a = {"id": "%s-%d" % (kind, len(self.lines)), "level": level, "name": name, "model": entry,
             "x": 100 * x, "y": -100 * y, "elevation": max(0.0, 100 * up), "angle": -angle % (2 * math.pi),
             "width": 100 * (obj.high[0] - obj.low[0]), "depth": max(0.1, 100 * (obj.high[1] - obj.low[1])),
             "height": max(0.1, 100 * (obj.high[2] - obj.low[2]))}
        if mirror:
            a["modelMirrored"] = "true"
        a.update(extra or {})
        self.lines += tag(kind, a, children)

    def levels(self):
        for i, s in enumerate(self.house.storeys):
            self.lines += tag("level", {"id": "level%d" % i, "name": s["name"], "elevation": 100 * s["floor"],
                                        "floorThickness": 100 * s["slab"], "height": 100 * s["height"],
                                        "elevationIndex": 0})

    def opening(self, level, walls, opening):
        kind, name, at, o, shape = opening
        width, height = float(o["width"]), float(o["height"])
        upright = float(o.get("angle", 0)) == 90
        depth = next(t for a, b, t, _, _ in walls if (a[0] == b[0]) == upright and
                     abs((at[0] - a[0]) if upright else (at[1] - a[1])) < t / 2 + 0.002 and
                     (min(a[1], b[1]) < at[1] < max(a[1], b[1]) if upright else min(a[0], b[0]) < at[0] < max(a[0], b[0])))
        double, glass = o.get("hinge") == "both", "glazed" in o
        leaf = "pane" if glass else o.get("material", "plain")
        slides = "slide" in o
        obj = framed(kind == "window", width, height, depth, leaf, double, slides)
        key = "%s-%d-%d-%d-%s%s%s" % (kind, width * 100, height * 100, depth * 100, leaf, "-2" if double else "",
                                      "-rail" if slides else "")
        extra = {"wallThickness": 1.0, "wallDistance": 0.0, "wallCutOutOnBothSides": "true", "boundToWall": "true",
                 "cutOutShape": "M0,0 v1 h1 v-1 z", "movable": "false"}
        if shape:
            extra["cutOutShape"] = "M" + " L".join("%g,%g" % (x, 1 - y) for x, y in shape) + " z"
        if o.get("material") and not glass:
            extra["color"] = self.colour(o["material"])
        swing, sashes = math.radians(float(o.get("swing", 90))), []
        if kind == "door" and not slides:
            if o.get("hinge") != "right":
                sashes.append((0.0, 0.0, swing))
            if o.get("hinge") in ("right", "both"):
                s = -swing if double else swing
                sashes.append((1.0, math.pi, math.pi + s))
        label = ("Glass door " if glass else kind.capitalize() + " ") + name
        self.piece(level, None, label, self.model(key, obj), obj, (at[0], at[1], float(o.get("sill", 0))), o, extra,
                   "doorOrWindow",
                   [tag("sash", {"xAxis": x, "yAxis": 0.5, "width": 0.5 if double else 1.0, "startAngle": a,
                                 "endAngle": b}) for x, a, b in sashes])

    def storey(self, index, s):
        level, house = "level%d" % index, self.house
        walls = Walls(s).list()
        for opening in s["openings"]:
            self.opening(level, walls, opening)
        for name, at, o in s["places"]:
            self.furniture(level, name, at, o)
        for name, at, o in s["stairs"]:
            obj = stair_obj(float(o["width"]), float(o["depth"]), float(o["height"]), int(o["steps"]))
            self.piece(level, s, "Staircase " + name, self.bare("stair", obj), obj, at, o,
                       {"staircaseCutOutShape": "M0,0 v1 h1 v-1 z", "color": self.colour(o["material"])})
        for material, where, ring in s["inlays"]:
            self.inlay(level, s, material, where, ring)
        colours = {n: self.colour(o["walls"]) for n, _, o in s["rooms"]}
        colours[None] = self.colour(house.facade)
        for i, (a, b, t, left, right) in enumerate(walls):
            self.lines += tag("wall", {"id": "wall%d-%d" % (index, i), "level": level, "xStart": 100 * a[0],
                                       "yStart": -100 * a[1], "xEnd": 100 * b[0], "yEnd": -100 * b[1],
                                       "height": 100 * s["height"], "thickness": 100 * t,
                                       "leftSideColor": colours[left], "rightSideColor": colours[right]})
        for i, (name, ring, o) in enumerate(s["rooms"]):
            self.lines += tag("room", {"id": "room%d-%d" % (index, i), "level": level, "name": name,
                                       "floorColor": self.colour(o["floor"]), "ceilingColor": self.colour(o["ceiling"])},
                              [tag("point", {"x": 100 * x, "y": -100 * y}) for x, y in ring])

    def furniture(self, level, name, at, o):
        statements = self.house.models[name]
        obj, lights = model_obj(statements)
        entry = self.model(name, obj)
        if not lights:
            self.piece(level, None, name, entry, obj, at, o)
            return
        (x, y, z), flux = lights[0]
        top = max(flux)
        colour = "00%02X%02X%02X" % tuple(round(255 * f / top) for f in flux)
        size = [max(1e-6, b - a) for a, b in zip(obj.low, obj.high)]
        source = tag("lightSource", {"x": (x - obj.low[0]) / size[0], "y": 1 - (y - obj.low[1]) / size[1],
                                     "z": min(1.0, max(0.0, (z - obj.low[2]) / size[2])), "color": colour})
        self.piece(level, None, name, entry, obj, at, o, {"power": min(1.0, sum(flux) / WATTS_AT_FULL_POWER)}, "light",
                   [source])

    def inlay(self, level, s, material, where, ring):
        obj, ceiling = Obj(), where == "ceiling"
        obj.box((-0.5, -0.5, 0), (0.5, 0.5, 1), material)
        x0, x1 = min(p[0] for p in ring), max(p[0] for p in ring)
        y0, y1 = min(p[1] for p in ring), max(p[1] for p in ring)
        extra = {"width": 100 * (x1 - x0), "depth": 100 * (y1 - y0), "height": 100 * RUG, "color": self.colour(material)}
        at = ((x0 + x1) / 2, (y0 + y1) / 2, s["height"] - RUG if ceiling else 0.0)
        if ceiling:
            extra["power"] = 0.3
        self.piece(level, s, "ceiling panel" if ceiling else "rug", self.bare("box", obj), obj, at, {}, extra,
                   "light" if ceiling else "pieceOfFurniture",
                   [tag("lightSource", {"x": 0.5, "y": 0.5, "z": 0.0, "color": "00FFFFFF"})] if ceiling else ())

    def camera(self, attribute, floor, at, o, name=None):
        a = {"attribute": attribute, "lens": "PINHOLE", "x": 100 * at[0], "y": -100 * at[1],
             "z": 100 * (floor + (at[2] if len(at) > 2 else 0))}
        yaw = math.radians(float(o.get("yaw", 0)))
        a.update({"yaw": math.atan2(-math.cos(yaw), -math.sin(yaw)), "pitch": -math.radians(float(o.get("pitch", 0))),
                  "fieldOfView": math.radians(float(o.get("fov", 70))), "time": "1750000000000"})
        if name:
            a["name"] = name
        return tag("observerCamera", a)

    def xml(self):
        h = self.house
        self.lines += tag("environment", {"groundColor": "FF" + h.ground[0], "skyColor": "FFCCE4FC",
                                          "lightColor": "00D0D0D0", "ceillingLightColor": "00D0D0D0"},
                          [self.camera("cameraPath", f, at, o) for f, at, o in h.tour])
        self.lines += self.camera("observerCamera", h.start[0], h.start[1], h.start[2])
        for name, floor, at, o in h.views:
            self.lines += self.camera("storedCamera", floor, at, o, name)
        self.levels()
        for i, s in enumerate(h.storeys):
            self.storey(i, s)
        head = "<?xml version='1.0'?>\n<home version='7200' name='house.sh3d' camera='observerCamera' " \
               "selectedLevel='level0' wallHeight='260'>\n"
        return head + "".join("  %s\n" % line for line in self.lines) + "</home>\n"


def write_home(path, xml, contents):
    """The ZIP of a home; contents are text or bytes by the names of their entries."""
    contents = {name: c if isinstance(c, bytes) else c.encode() for name, c in contents.items()}
    digests = "ContentDigests-Version: 1.0\n\n"
    for name, content in contents.items():
        digests += "Name: %s\nSHA-1-Digest: %s\n\n" % (name, hashlib.sha1(content).hexdigest())
    entries = {"Home.xml": xml.encode(), **contents, "ContentDigests": digests.encode()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as out:
        for name, content in entries.items():
            out.writestr(zipfile.ZipInfo(name, (2025, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED, 9)


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: house_sh3d.py HOUSE.plan HOUSE.sh3d")
    home = Home(House(sys.argv[1]))
    write_home(sys.argv[2], home.xml(), home.entries)


if __name__ == "__main__":
    main()
