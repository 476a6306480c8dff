"""window_driver.py - hands and eyes for a walk in the real window: keys and mouse go in through xdotool, where one is
comes back through the program's trace. All waiting is by the trace's time: a slow machine only makes it longer."""
import json
import math
import os
import subprocess
import time

# A trace line comes ten times a second; a machine that is busy may take far longer.
PATIENCE = 20.0          # seconds without a line
COAST = 0.14             # metres: what a walk goes on after its key is let go
STUCK = 2.0              # seconds without getting on
STRAIGHT = math.radians(3)


class Lost(Exception):
    """The walk cannot go on."""


def wrapped(angle):
    return math.remainder(angle, 2 * math.pi)


class Xdotool:
    """One xdotool that takes a command a line."""

    def __init__(self):
        self.process = subprocess.Popen(["xdotool", "-"], stdin=subprocess.PIPE, text=True, bufsize=1)

    def send(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Trace:
    """The program's trace file, read as it grows."""

    def __init__(self, path, alive):
        self.path, self.alive, self.file, self.part = path, alive, None, ""

    def newest(self):
        """The last whole line that has not been read, or None."""
        if self.file is None and os.path.exists(self.path):
            self.file = open(self.path, encoding="utf-8")
        lines = (self.part + (self.file.read() if self.file else "")).split("\n")
        self.part = lines.pop()
        return lines[-1] if lines else None

    def next(self):
        """The newest line as a dictionary, later than the one before: waits for it."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            line = self.newest()
            if line:
                return json.loads(line)
            if not self.alive():
                raise Lost("the program has ended")
            time.sleep(0.01)
        raise Lost(f"no line in the trace for {PATIENCE:g} seconds")


class Walker:
    """Walks by looking where it is. `hands` has send(command), `trace` next()."""

    def __init__(self, hands, trace):
        self.hands, self.trace = hands, trace
        self.now = trace.next()
        self.frames = []              # (fps, frame_ms) while walking
        self.points_a_radian = None   # of the mouse

    # ---- time

    def look(self):
        """The newest line."""
        self.now = self.trace.next()
        return self.now

    def see_effect(self):
        """The first line that shows what was done: one may have been written already, another be under way."""
        for _ in range(3):
            self.look()

    def wait(self, seconds):
        self.look()
        end = self.now["t"] + seconds
        while self.now["t"] < end:
            self.look()

    def until(self, condition, what, seconds=8.0):
        end = self.now["t"] + seconds
        while not condition(self.now):
            if self.now["t"] > end:
                raise Lost(f"{what}: not within {seconds:g} seconds; last message `{self.now['message']}`")
            self.look()

    # ---- keys

    def key(self, name):
        """Strikes a key and waits until its effect shows in the trace."""
        self.hands.send(f"key {name}")
        self.see_effect()

    def hold(self, name):
        self.hands.send(f"keydown {name}")

    def let_go(self, name):
        self.hands.send(f"keyup {name}")

    # ---- turning

    def move_mouse(self, x, y):
        self.hands.send(f"mousemove_relative -- {round(x)} {round(y)}")

    def calibrate(self):
        """How many points of the mouse make a radian; shows too that the mouse is held."""
        before = self.now["yaw"]
        self.move_mouse(100, 0)
        self.wait(0.4)
        turned = wrapped(before - self.now["yaw"])
        if turned < 0.01:
            raise Lost(f"the mouse went 100 points to the right, the view turned by {turned:.3f}")
        self.points_a_radian = 100 / turned

    def turn(self, yaw, pitch=0.0, within=math.radians(1)):
        for _ in range(30):
            left, up = wrapped(yaw - self.now["yaw"]), pitch - self.now["pitch"]
            if abs(left) < within and abs(up) < within:
                return
            self.move_mouse(-left * self.points_a_radian, -up * self.points_a_radian)
            self.see_effect()
        raise Lost(f"cannot turn to yaw {math.degrees(yaw):.0f}, pitch {math.degrees(pitch):.0f}")

    def look_at(self, x, y, z=None):
        eye = self.now["eye"]
        across = math.hypot(x - eye[0], y - eye[1])
        self.turn(math.atan2(y - eye[1], x - eye[0]), 0.0 if z is None else math.atan2(z - eye[2], across))

    # ---- walking

    def distance(self, x, y):
        return math.hypot(x - self.now["eye"][0], y - self.now["eye"][1])

    def go(self, x, y, within=0.3):
        """Walks to a place, straight."""
        for _ in range(6):
            if self.distance(x, y) <= within:
                return
            self.look_at(x, y)
            self.approach(x, y, within)
            self.wait(0.4)
        raise Lost(f"cannot get to {x:g},{y:g}; stands at {self.place()}")

    def approach(self, x, y, within):
        nearest, since = self.distance(x, y), self.now["t"]
        self.hold("w")
        try:
            while self.distance(x, y) > max(within - COAST, COAST):
                self.look()
                self.frames.append((self.now["fps"], self.now["frame_ms"]))
                left = self.distance(x, y)
                if left < nearest - 0.05:
                    nearest, since = left, self.now["t"]
                elif left > nearest + 0.1:
                    return
                elif self.now["t"] - since > STUCK:
                    raise Lost(f"stuck on the way to {x:g},{y:g} at {self.place()}")
                self.steer(x, y)
        finally:
            self.let_go("w")

    def steer(self, x, y):
        eye = self.now["eye"]
        left = wrapped(math.atan2(y - eye[1], x - eye[0]) - self.now["yaw"])
        # Half of it: the line shows what was, and the last correction may not be in it yet.
        if abs(left) > STRAIGHT:
            self.move_mouse(-left * self.points_a_radian / 2, 0)

    def place(self):
        x, y, z = self.now["eye"]
        return f"{x:.2f},{y:.2f},{z:.2f} in room `{self.now['room']}`"

    # ---- doors

    def open_door(self, name, x, y, z):
        """Looks at a place on the door and opens it."""
        self.look_at(x, y, z)
        self.until(lambda now: now["door"] == name, f"`{name}` should be the door looked at", 2)
        self.key("e")
        self.until(lambda now: now["doors"][name] > 0.99, f"door `{name}` should open")


class FakeWindow:
    """Stands for program and xdotool in the test of the driver: an empty plain, one door that takes a second to open.
    Mouse and keys work a little late, as they do."""

    STEP = 1 / 60

    def __init__(self):
        self.time = self.yaw = self.pitch = self.speed = self.x = self.y = 0.0
        self.held, self.late, self.door, self.wanted, self.flags = set(), [], 0.0, 0.0, []
        self.blocked_at = math.inf

    def send(self, command):
        self.late.append((self.time + 0.07, command.split()))

    def obey(self, words):
        if words[0] == "mousemove_relative":
            self.yaw = wrapped(self.yaw - 0.0024 * int(words[2]))
            self.pitch -= 0.0024 * int(words[3])
        elif words[0] == "keydown":
            self.held.add(words[1])
        elif words[0] == "keyup":
            self.held.discard(words[1])
        elif words[1] == "e":
            self.wanted = 1.0 - self.wanted

    def step(self):
        while self.late and self.late[0][0] <= self.time:
            self.obey(self.late.pop(0)[1])
        self.time += self.STEP
        self.speed += (1.7 * ("w" in self.held) - self.speed) * (1 - math.exp(-14 * self.STEP))
        self.x = min(self.x + self.speed * math.cos(self.yaw) * self.STEP, self.blocked_at)
        self.y += self.speed * math.sin(self.yaw) * self.STEP
        self.door += max(-self.STEP, min(self.STEP, self.wanted - self.door))

    def next(self):
        for _ in range(6):
            self.step()
        return {"t": self.time, "eye": [self.x, self.y, 1.6], "yaw": self.yaw, "pitch": self.pitch, "room": "plain",
                "fps": 60.0, "frame_ms": 10.0, "door": "gate" if self.x > 3 else "", "doors": {"gate": self.door},
                "message": ""}


def test():
    """The driver against the fake: it arrives, it opens, and it says when it cannot."""
    fake = FakeWindow()
    walker = Walker(fake, fake)
    walker.calibrate()
    for x, y in ((5, 0), (5, 4), (-3, 2), (-3, 1.5), (4, -4)):
        walker.go(x, y, 0.2)
        assert walker.distance(x, y) <= 0.2, (x, y, walker.place())
    walker.look_at(10, -4, 3)
    assert abs(walker.now["pitch"] - math.atan2(1.4, 10 - walker.now["eye"][0])) < math.radians(1.1)
    walker.open_door("gate", 6, -4, 1)
    assert fake.door > 0.99
    fake.blocked_at = 6
    try:
        walker.go(8, -4)
        raise AssertionError("it walked through a wall")
    except Lost as lost:
        assert "stuck" in str(lost) or "cannot get" in str(lost), lost


if __name__ == "__main__":
    test()
