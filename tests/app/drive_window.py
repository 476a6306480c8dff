#!/usr/bin/env python3
"""drive_window.py PROGRAM HOUSE.plan WORK SCREEN REFERENCES [--keep] - a walk through the house in the real window, by
keys and mouse: doors, stairs, windows, every debug view, screenshots that are held against references.

WORK is a folder for what is written, SCREEN the file in which Xvfb keeps its screen (-fbdir). With --keep the
screenshots become the references, with --lit only the walk in baked light is done, and with --threads only what several threads
do at once: in any building with lamps, and in WORK/closet.plan, whose light comes soon. Prints a line for each part of the walk; exit status 1 when anything is wrong."""
import math
import os
import shutil
import struct
import subprocess
import sys
import time

from compare_pictures import Picture, compare, difference, read_png
from window_driver import Lost, Trace, Walker, Xdotool, wrapped

SIZE = (1280, 720)
PICTURE_SIZE = (480, 270)       # of the references: small files, and every surface still shows
MESSAGE_SECONDS = 9             # until a message has faded, at most
PANEL = 2000                    # pixels: less than any panel covers, more than figures that change
HALF_TURN = math.pi
# The viewpoints of the house, in the order of the keys 1 to 9.
LIT_VIEWS = ["courtyard", "bedroom", "hall", "living"]
VIEWS = ["living", "courtyard", "kitchen", "study", "hall", "landing", "bedroom", "bath", "lookout"]


class Visit:
    """The program under test, a walker in it, and what was found wrong."""

    def __init__(self, program, house, work, screen, references, keep, options=("--no-bake",)):
        self.work, self.screen, self.references, self.keep = work, screen, references, keep
        self.house = os.path.join(work, "house.plan")
        shutil.copy(house, self.house)
        open(os.path.join(work, "trace"), "w", encoding="utf-8").close()     # not that of a walk before
        self.errors = open(os.path.join(work, "errors"), "w+", encoding="utf-8")
        self.program = subprocess.Popen(
            [program, "walk", self.house, "--night", "--size", "%dx%d" % SIZE, "--pictures", work, "--trace",
             os.path.join(work, "trace"), *options], stderr=self.errors)
        self.faults = []
        self.hands = Xdotool()
        self.walker = None

    def begin(self):
        self.find_window()
        trace = Trace(os.path.join(self.work, "trace"), lambda: self.program.poll() is None)
        self.walker = Walker(self.hands, trace)
        self.take_mouse()
        self.walker.calibrate()

    def find_window(self):
        search = ["xdotool", "search", "--onlyvisible", "--pid", str(self.program.pid)]
        for _ in range(300):
            found = subprocess.run(search, capture_output=True, text=True).stdout.split()
            if found:
                self.window = found[0]
                self.hands.send(f"windowfocus {self.window}")
                return
            if self.program.poll() is not None:
                raise Lost("the program ended before it had a window")
            time.sleep(0.1)
        raise Lost("no window appears")

    def take_mouse(self):
        self.hands.send(f"mousemove --window {self.window} 300 200")
        self.hands.send("click 1")
        self.walker.wait(0.3)

    def expect(self, good, text):
        if not good:
            self.faults.append(text)
            print(f"  wrong: {text}")

    def resize(self, width, height):
        self.hands.send(f"windowsize {self.window} {width} {height}")
        self.walker.wait(0.5)

    def press_all(self, names):
        for name in names:
            self.walker.key(name)

    def screenshot(self):
        """The path of a new one."""
        before = self.walker.now["message"]
        self.walker.key("p")
        self.walker.until(lambda now: now["message"].endswith(".png") and now["message"] != before, "a screenshot")
        return self.walker.now["message"]


# ---- the ways of the house: doors are stood before at such a distance that their leaves pass

def ground_floor(v):
    w = v.walker
    v.expect(w.now["room"] == "hall" and w.now["storey"] == "ground", f"the walk begins at {w.place()}")
    w.go(6.75, 2.2)
    w.open_door("salon", 5.46, 2.2, 1.0)
    w.go(4.6, 2.2)
    v.expect(w.now["room"] == "living", f"beyond the salon door is {w.place()}")
    w.go(4.4, 5.3)
    w.go(3.3, 5.3)
    w.open_door("study", 2.2, 6.56, 1.0)
    w.go(2.2, 5.3, 0.2)
    w.go(2.2, 7.7)
    v.expect(w.now["room"] == "study", f"beyond the study door is {w.place()}")


def out_of_one_window_in_at_another(v):
    """From the study across the courtyard into the guest room: more cells are seen than in the corner of the study."""
    w = v.walker
    w.go(2.6, 8.6)
    w.turn(math.radians(-50), math.radians(-40))
    corner = w.now["cells_visible"]
    w.turn(0, 0)
    w.look()
    seen = w.now["cells_visible"]
    v.expect(seen > corner, f"{seen} cells are seen through the window, {corner} in the corner")


def courtyard(v):
    w = v.walker
    for x, y in ((2.2, 7.7), (2.2, 5.3), (4.4, 5.3), (4.6, 2.2), (6.6, 2.2), (6.4, 5.0)):
        w.go(x, y)
    w.open_door("courtyard", 6.4, 6.65, 1.0)
    w.go(6.4, 8.0)
    v.expect(w.now["room"] not in ("hall", "study"), f"beyond the courtyard door is {w.place()}")
    v.expect(w.now["eye"][2] < 1.55, f"the ground lies lower than the floor, the eye is at {w.now['eye'][2]:.2f}")
    w.look_at(4.65, 8.6)
    w.look()
    w.go(6.4, 5.0)


def closed_door(v):
    """The sliding door of the pantry: closed, it hides the hall and cannot be passed."""
    w = v.walker
    w.go(6.6, 1.0)
    w.go(6.9, 0.8, 0.2)
    w.open_door("pantry", 8.26, 0.75, 1.0)
    w.go(8.0, 0.9, 0.2)
    w.go(9.1, 1.2)
    v.expect(w.now["room"] == "kitchen", f"beyond the pantry door is {w.place()}")
    w.look_at(8.26, 0.75, 1.0)
    w.look()
    open_cells = w.now["cells_visible"]
    w.key("e")
    w.until(lambda now: now["doors"]["pantry"] == 0, "the pantry's door should close")
    closed_cells = w.look()["cells_visible"]
    v.expect(closed_cells < open_cells, f"{closed_cells} cells are seen with the door closed, {open_cells} before")
    w.hold("w")
    w.wait(1.5)
    w.let_go("w")
    v.expect(w.now["room"] == "kitchen", f"the closed door was passed: {w.place()}")
    w.go(9.1, 1.2)
    w.open_door("pantry", 8.26, 0.75, 1.0)
    w.go(8.7, 0.9, 0.2)
    w.go(7.3, 0.85, 0.2)


def upstairs(v):
    w = v.walker
    w.go(7.7, 0.8, 0.2)
    w.go(7.7, 3.3)
    v.expect(0.5 < w.now["eye"][2] - 1.6 < 2.5, f"in the middle of the stairs: {w.place()}")
    w.go(7.7, 5.7)
    up = w.now["storey"] == "upper" and abs(w.now["eye"][2] - 4.5) < 0.1
    v.expect(up, f"at the head of the stairs: {w.place()}")
    w.go(6.3, 6.0)
    w.turn(math.radians(95), math.radians(-28))
    w.go(6.6, 2.6)
    w.open_door("bedroom", 5.46, 2.6, 3.9)
    w.go(4.5, 2.4)
    v.expect(w.now["room"] == "bedroom", f"beyond the bedroom door is {w.place()}")


# ---- what keys do

def debug_views(v):
    """Each on and off again, with its flag."""
    w = v.walker
    for key, flag in (("x", "wireframe"), ("t", "stab tree"), ("v", "frozen"), ("b", "none"), ("f", "flight")):
        w.key(key)
        v.expect(flag in w.now["flags"], f"{key} does not show `{flag}` but {w.now['flags']}")
        w.wait(0.5)
        w.key(key)
        v.expect(w.now["flags"] == [], f"{key} again leaves {w.now['flags']}")
    for method in ("none", "frustum", "portals", "plan"):
        w.key("n")
        v.expect(method in w.now["flags"], f"n does not show `{method}` but {w.now['flags']}")
    w.key("n")
    v.expect(w.now["flags"] == [], f"n a fifth time leaves {w.now['flags']}")


def panels(v):
    """What has no flag shows on the screen: help, plan, figures, the other look, a narrower view."""
    w = v.walker
    for key in ("h", "m", "i", "g"):
        before = read_screen(v)
        w.key(key)
        w.wait(0.3)
        count, _ = difference(before, read_screen(v))
        v.expect(count > PANEL, f"{key} changes {count} pixels of the screen only")
        w.key(key)
    before = read_screen(v)
    v.hands.send("click 4")
    v.hands.send("click 4")
    w.wait(0.3)
    count, _ = difference(before, read_screen(v))
    v.expect(count > PANEL, f"the wheel changes {count} pixels of the screen only")
    v.hands.send("click 5")
    v.hands.send("click 5")


def flight(v):
    w = v.walker
    height = w.now["eye"][2]
    w.key("f")
    w.hold("space")
    w.wait(0.8)
    w.let_go("space")
    w.wait(0.3)
    v.expect(w.now["eye"][2] > height + 1, f"flight rises from {height:.2f} to {w.now['eye'][2]:.2f} only")
    w.key("f")
    w.wait(1)
    v.expect(w.now["flags"] == [], f"after the flight: {w.now['flags']}, {w.place()}")


def storeys(v):
    w = v.walker
    for key, storey in (("Prior", "upper"), ("Next", "ground"), ("Prior", "upper")):
        w.key(key)
        w.wait(0.5)
        v.expect(w.now["storey"] == storey, f"{key} leads to `{w.now['storey']}`")


def recording(v):
    """A recorded path leads the same way again, to the same place, with the same view and the doors as they were."""
    w = v.walker
    jump(v, "bedroom")
    w.key("r")
    begin = w.now["eye"]
    w.hold("w")
    w.wait(0.8)
    w.let_go("w")
    w.move_mouse(150, 40)
    w.key("o")
    w.wait(1.2)
    w.key("r")
    end = w.now
    path = end["message"]
    v.expect(path.endswith(".path") and os.path.exists(path), f"after recording the message is `{path}`")
    w.key("1")
    w.key("o")
    w.wait(1.2)
    w.key("l")
    v.expect("replay" in w.now["flags"], f"flags while replaying: {w.now['flags']}")
    nearer = math.dist(w.now["eye"], begin) < math.dist(w.now["eye"], end["eye"])
    v.expect(nearer, f"the replay starts at {w.place()}, recorded was {begin}")
    w.until(lambda now: "replay" not in now["flags"], "the end of the replay")
    v.expect(math.dist(w.now["eye"], end["eye"]) < 0.02, f"the replay ends at {w.place()}, recorded was {end['eye']}")
    turned = abs(wrapped(w.now["yaw"] - end["yaw"])) + abs(w.now["pitch"] - end["pitch"])
    v.expect(turned < 1e-9, f"the replay ends with a view turned by {turned:g}")
    wrong = [name for name, share in end["doors"].items() if abs(share - w.now["doors"][name]) > 1e-6]
    v.expect(not wrong, f"after the replay these doors stand otherwise: {wrong}")


def focus(v):
    """With the window goes the key that is held; with the window back all goes on."""
    w = v.walker
    w.key("0")
    w.hold("w")
    w.wait(0.2)
    v.hands.send(f"windowunmap {v.window}")
    w.wait(0.6)
    place = w.now["eye"]
    w.wait(0.5)
    v.expect(math.dist(w.now["eye"], place) < 0.01, "a key that was held when the focus went is held still")
    w.let_go("w")
    v.hands.send(f"windowmap {v.window}")
    w.wait(0.5)
    v.hands.send(f"windowfocus {v.window}")
    v.take_mouse()
    w.turn(HALF_TURN / 2)


def sizes(v):
    w = v.walker
    for width, height in ((1, 1), (333, 777), (200, 100)):
        v.resize(width, height)
        picture = read_png(v.screenshot())
        size = picture.width, picture.height
        v.expect(size == (width, height), f"a screenshot of {size} pixels in a window of {width}x{height}")
    v.resize(*SIZE)
    w.key("F11")
    w.wait(0.7)
    full = read_png(v.screenshot())
    w.key("F11")
    w.wait(0.7)
    back = read_png(v.screenshot())
    v.expect(full.width > SIZE[0], f"full screen is {full.width}x{full.height}")
    v.expect((back.width, back.height) == SIZE, f"back from full screen it is {back.width}x{back.height}")


def change_file(v, text, says):
    with open(v.house + ".new", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(v.house + ".new", v.house)
    v.walker.until(lambda now: says in now["message"], f"message `{says}` after a change of the file", 10)


def changed_file(v):
    """The file is read again when it was changed; what cannot be read is said, and the walk goes on."""
    w = v.walker
    whole = open(v.house, encoding="utf-8").read()
    for text, says in ((whole + "# changed\n", "read again"), ("nonsense\n", ":1:"), (whole, "read again")):
        place = w.now["eye"]
        change_file(v, text, says)
        v.expect(math.dist(w.now["eye"], place) < 0.05, f"the change of the file moved the eye to {w.place()}")
        # The next change's message is not to be taken for this one.
        w.key("m")
        w.key("m")
        w.key("n")
        for _ in range(4):
            w.key("n")


# ---- pictures

def read_screen(v):
    """The window as it is on the screen: an X window dump, big-endian header, 32 bits a pixel, blue first."""
    data = open(v.screen, "rb").read()
    header, _, _, _, _, height, _, _, _, _, _, _, stride = struct.unpack(">13I", data[:52])
    colours = struct.unpack(">20I", data[:80])[19]
    start = header + colours * 12
    rows = []
    for y in range(min(SIZE[1], height)):
        line = data[start + y * stride:start + y * stride + SIZE[0] * 4]
        rgb = bytearray(SIZE[0] * 3)
        rgb[0::3], rgb[1::3], rgb[2::3] = line[2::4], line[1::4], line[0::4]
        rows.append(bytes(rgb))
    return Picture(SIZE[0], len(rows), rows)


def screen_shows_the_frame(v):
    """What is on the screen is what the screenshot has, upright."""
    w = v.walker
    jump(v, "lookout")       # no door in reach: no word about one
    v.press_all(["Escape"])  # no crosshair
    v.hands.send("mousemove 1390 890")
    w.wait(MESSAGE_SECONDS)
    screen = read_screen(v)
    found = difference(screen, read_png(v.screenshot()), levels=8)
    v.expect(found is not None and found[0] == 0, f"screen and screenshot differ: {found} (pixels, most levels)")
    v.take_mouse()


def hold_against(v, name):
    path = v.screenshot()
    reference = os.path.join(v.references, name + ".png")
    if v.keep:
        shutil.copy(path, reference)
        return
    alike, text = compare(path, reference)
    v.expect(alike, f"picture `{name}`: {text}; it is {path}")


def open_all_doors(v):
    """From a place where no leaf meets the body. The key closes them instead if all were to be open already."""
    w = v.walker
    jump(v, "courtyard")
    for _ in range(2):
        w.key("o")
        w.wait(2)
        if min(w.now["doors"].values()) > 0.99:
            return
    raise Lost(f"not all doors open: {w.now['doors']}")


def jump(v, name):
    v.walker.key(str(VIEWS.index(name) + 1))
    v.walker.wait(0.8)       # a body that is put down comes to rest


def pictures(v):
    """Stored viewpoints with all doors open, then the debug views from one of them, without changing figures."""
    w = v.walker
    v.resize(*PICTURE_SIZE)
    open_all_doors(v)
    v.press_all("m")
    for name in VIEWS:
        jump(v, name)
        hold_against(v, name)
    jump(v, "hall")
    for key, name in (("x", "hall-wireframe"), ("g", "hall-other-look")):
        w.key(key)
        w.wait(0.3)
        hold_against(v, name)
        w.key(key)
    v.press_all("mt")
    hold_against(v, "hall-plan")
    v.press_all("tmv")
    jump(v, "lookout")
    hold_against(v, "lookout-frozen")
    v.press_all("v")


def culling_loses_nothing(v):
    """With nothing culled each picture is the same to the last bit."""
    for name in VIEWS:
        jump(v, name)
        culled = v.screenshot()
        v.press_all("b")
        whole = v.screenshot()
        v.press_all("b")
        found = difference(read_png(culled), read_png(whole), levels=0)
        v.expect(found[0] == 0, f"`{name}` without culling: {found[0]} pixels differ, by {found[1]} levels at most")
    v.press_all("m")
    v.resize(*SIZE)


def pace(v):
    """Says how fast it goes; no fault, since others may be using the machine."""
    w = v.walker
    rates = []
    for name in VIEWS:
        jump(v, name)
        w.wait(1)
        rates.append((w.now["fps"], w.now["frame_ms"], name))
    walked = sorted(w.frames)
    print(f"  while walking: {walked[len(walked) // 2][0]:.0f} frames a second in the median")
    print("  at the viewpoints: " + ", ".join(f"{name} {rate:.0f} ({ms:.1f} ms)" for rate, ms, name in rates))


def leave(v):
    """The first Escape frees the mouse, the second ends the program. It ends well and has said nothing."""
    for _ in range(3):
        if v.program.poll() is None:
            v.hands.send("key Escape")
            time.sleep(0.5)
    try:
        code = v.program.wait(10)
    except subprocess.TimeoutExpired:
        v.program.kill()
        code = "none: Escape does not end it"
    v.hands.close()
    v.errors.seek(0)
    text = v.errors.read().strip()
    v.expect(code == 0, f"exit status {code}")
    v.expect(text == "", f"standard error: {text[:500]}")


def light_arrives(v):
    """Nothing was baked: the light comes while one walks, the look changes by itself, and keys expose it."""
    w = v.walker
    v.expect(w.now["look"] == "fast" or w.now["light"]["shown"], f"the walk begins in the look {w.now['look']}")
    w.until(lambda now: now["light"]["shown"], "light", 60)
    v.expect(w.now["look"] == "baked", f"light is shown in the look {w.now['look']}")
    before = w.now["light"]["exposure"]
    w.until(lambda now: now["light"]["done"] == 1, "all of the light", 400)
    w.wait(2)
    settled = w.now["light"]["exposure"]
    v.expect(0.1 < settled / before < 10, f"exposure goes from {before} to {settled} as light arrives")
    w.key("u")
    v.press_all(["equal", "equal"])
    w.wait(0.5)
    v.expect(w.now["light"]["fixed"] and w.now["light"]["stops"] == 1, f"exposure is {w.now['light']}")
    v.press_all(["minus", "minus", "u"])


def small(v):
    """Frames that cost little, where the question is what goes on beside them."""
    v.resize(64, 36)


def changed_while_lit(v):
    """The file changes while its light arrives, to one that cannot be read and back; then the walk is left with a bake under way."""
    w = v.walker
    whole = open(v.house, encoding="utf-8").read()
    for text, says in ((whole + "# changed\n", "read again"), ("nonsense\n", ":1:"), (whole + "# back\n", "read again")):
        w.until(lambda now: now["light"]["shown"], "light", 60)
        v.expect(w.now["light"]["done"] < 1, "all light has arrived already")
        change_file(v, text, says)
    w.key("F5")


def light_follows(v):
    """Doors move: the light that is shown is behind them at first, and then theirs."""
    w = v.walker
    w.until(lambda now: now["light"]["lamps_known"], "the light of each lamp", 400)
    v.expect(not w.now["light"]["behind"], "light is behind doors that have not moved")
    w.key("o")
    w.until(lambda now: now["light"]["behind"], "light that is behind the doors", 10)
    open_all_doors(v)
    w.until(lambda now: not now["light"]["behind"], "light that has followed the doors", 120)


def lit_pictures(v):
    """The light of the lamps, and a view in each of the false colours with its scale."""
    w = v.walker
    v.resize(*PICTURE_SIZE)
    open_all_doors(v)
    w.until(lambda now: not now["light"]["behind"], "light that has followed the doors", 120)
    v.press_all("m")
    for name in LIT_VIEWS:
        jump(v, name)
        w.wait(2)            # the eye adapts
        hold_against(v, name + "-lit")
    for name in ("radiosity", "irradiance", "illuminance"):
        w.key("k")
        w.wait(0.3)
        v.expect(w.now["light"]["false_colour"] == name, f"false colours are {w.now['light']['false_colour']}")
    hold_against(v, LIT_VIEWS[-1] + "-illuminance")
    v.press_all("km")


def lamps(v):
    """The lamps of a room go out and on again: the eye adapts to the dark, and the picture is as it was."""
    w = v.walker
    w.until(lambda now: now["light"]["lamps_known"], "the light of each lamp", 400)
    v.expect(w.now["light"]["lamps"] == 24, f"the house has {w.now['light']['lamps']} lamps")
    jump(v, "living")
    w.wait(2)
    before = w.now["light"]["exposure"]
    w.key("q")
    off = w.now["light"]["lamps_off"]
    v.expect(off >= 1, "no lamp is off")
    w.until(lambda now: now["light"]["exposure"] > 1.1 * before, "the eye adapts to fewer lamps", 60)
    w.key("q")
    v.expect(w.now["light"]["lamps_off"] == 0, f"{w.now['light']['lamps_off']} lamps are off")
    w.until(lambda now: abs(now["light"]["exposure"] / before - 1) < 0.02, "the eye adapts back", 60)
    w.wait(2)
    v.press_all("m")
    hold_against(v, "living-lit")
    v.press_all("mj")
    v.press_all(["Down", "bracketleft"])
    v.expect("90 %" in w.now["message"], f"a lamp is dimmed: {w.now['message']}")
    v.press_all(["bracketright", "j"])
    v.expect(w.now["light"]["lamps_off"] == 0 and " on" in w.now["message"], f"it is bright: {w.now['message']}")
    # Keys that chose a lamp walk again.
    before = w.now["eye"]
    w.hold("Up")
    w.wait(0.7)
    w.let_go("Up")
    v.expect(math.dist(before, w.now["eye"]) > 0.3, "the key up walks no more")


def hour_comes(v):
    """The building is lit at another hour in the background, and at a third one before that has come."""
    w = v.walker
    w.key("period")
    v.expect(w.now["light"]["coming"], "no other hour comes")
    w.key("period")
    w.until(lambda now: not now["light"]["coming"], "the light of another hour", 400)
    v.expect(w.now["light"]["hour"] == "10:20", f"it is {w.now['light']['hour']}")


def hour_turns(v):
    """It is night. The light of another hour comes while that of the night is shown, and then a sun shines; back again at once."""
    w = v.walker
    v.press_all("i")
    night = w.now["light"]["exposure"]
    for key, hour in (("period", "10:10"), ("shift+period", "11:10")):
        w.key(key)
        v.expect(w.now["light"]["hour"] == hour and w.now["light"]["coming"], f"it is {w.now['light']['hour']}")
    v.expect(w.now["light"]["shown"], "no light is shown until other light is there")
    w.until(lambda now: not now["light"]["coming"], "the light of another hour", 400)
    v.expect(w.now["message"] == "11:10", f"the message is `{w.now['message']}`")
    w.until(lambda now: now["light"]["exposure"] < night / 2, "the eye adapts to the day", 60)
    w.key("period")
    w.key("comma")
    v.expect(not w.now["light"]["coming"] and w.now["light"]["hour"] == "11:10", "the hour was turned back")
    v.press_all("i")


PARTS = [ground_floor, out_of_one_window_in_at_another, courtyard, closed_door, upstairs, debug_views, panels, flight,
         storeys, recording, focus, sizes, changed_file, screen_shows_the_frame, pictures, culling_loses_nothing, pace]


def visit(arguments, keep, options, parts):
    """Whether nothing was wrong."""
    v = Visit(*arguments, keep=keep, options=options)
    try:
        v.begin()
        for part in parts:
            start = time.monotonic()
            print(part.__name__.replace("_", " "), flush=True)
            part(v)
            print(f"  {time.monotonic() - start:.0f} s")
    except Lost as lost:
        v.expect(False, str(lost))
    finally:
        leave(v)
    return not v.faults


def main():
    arguments = [a for a in sys.argv[1:] if a not in ("--keep", "--lit", "--threads")]
    if len(arguments) != 5:
        sys.exit(__doc__)
    keep = "--keep" in sys.argv
    if "--threads" in sys.argv:
        good = visit(arguments, keep, [], [small, changed_while_lit])
        arguments[1] = os.path.join(arguments[2], "closet.plan")
        sys.exit(not (visit(arguments, keep, [], [small, light_arrives, hour_comes]) and good))
    good = "--lit" in sys.argv or visit(arguments, keep, ["--no-bake"], PARTS)
    # In the end a walk that is lit as it goes on; with --lit this one alone.
    good = visit(arguments, keep, [], [light_arrives, light_follows, lit_pictures, lamps, hour_turns]) and good
    sys.exit(not good)


if __name__ == "__main__":
    main()
