#!/usr/bin/env python3
"""frame_rate.py PROGRAM [ROUNDS] - what a bake in the background costs the frames of a walk. The bundled film's path is replayed in
a window on a virtual screen, ROUNDS times (5) with the bake under way and as often without, by turns, in the look `fast` and in the light that
arrives. Compared are the same seconds of the path: those of the bake. Run it from the project's folder, on an idle machine; not run
by `make test`, which shares the machine."""
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

BUILDING, PATH = "build/maps/house.plan", "tests/pictures/walk.path"
SIZE = "960x540"
LASTS = 29           # seconds of the path
SETTLED = 1.0        # of them the first, in which the window opens


def start_screen(work):
    """An X server of our own; it says which display it took."""
    reads, writes = os.pipe()
    with open(os.path.join(work, "server"), "w", encoding="utf-8") as said:
        server = subprocess.Popen(["Xvfb", "-noreset", "-displayfd", str(writes), "-screen", "0", "1400x900x24", "-nolisten", "tcp"],
                                  stderr=said, pass_fds=[writes])
    os.environ["DISPLAY"] = ":" + os.read(reads, 16).decode().strip()
    os.environ.pop("WAYLAND_DISPLAY", None)
    return server


def walk(program, work, options):
    """The lines of the trace of one walk along the path."""
    trace = os.path.join(work, "trace")
    open(trace, "w", encoding="utf-8").close()
    with tempfile.TemporaryDirectory(dir=work) as cache:
        walker = subprocess.Popen([program, "walk", BUILDING, "--replay", PATH, "--size", SIZE, "--no-vsync", "--trace", trace,
                                   *options], env={**os.environ, "XDG_CACHE_HOME": cache})
        while not os.path.getsize(trace) and walker.poll() is None:
            time.sleep(0.05)
        time.sleep(LASTS)
        walker.terminate()
        walker.wait()
    with open(trace, encoding="utf-8") as lines:
        return [json.loads(line) for line in lines if line.endswith("\n")]


def frames(lines, begin, end):
    """Milliseconds of the frames drawn between two times of a walk."""
    first = lines[0]["t"]
    return sorted(ms for line in lines if begin <= line["t"] - first <= end for ms in line["periods_ms"])


def compare(program, work, look, light):
    """(mean, 99th percentile) with the bake under way and without, ms, and how long the bake was under way."""
    baking = walk(program, work, ["--look", look])
    resting = walk(program, work, ["--look", look, "--no-bake", "--light", light])
    first = baking[0]["t"]
    under_way = [line["t"] - first for line in baking
                 if line["light"]["done"] < 1 and (look == "fast" or line["light"]["shown"])]
    begin, end = max(under_way[0], SETTLED), under_way[-1]
    found = []
    for lines in baking, resting:
        drawn = frames(lines, begin, end)
        found.append((statistics.fmean(drawn), drawn[int(0.99 * (len(drawn) - 1))]))
    return found, end, baking[-1]["light"]["done"]


def main():
    program, rounds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 5
    with tempfile.TemporaryDirectory() as work:
        light = os.path.join(work, "house.rad")
        subprocess.run([program, "bake", BUILDING, "-o", light], check=True, stdout=subprocess.DEVNULL)
        server = start_screen(work)
        try:
            for look in "fast", "baked":
                ratios = []
                for _ in range(rounds):
                    (baking, resting), end, done = compare(program, work, look, light)
                    ratios.append((baking[0] / resting[0], baking[1] / resting[1]))
                    print(f"{look}: mean {baking[0]:.2f} against {resting[0]:.2f} ms, 99th percentile {baking[1]:.2f} against "
                          f"{resting[1]:.2f} ms, {100 * done:.0f} % baked after {end:.0f} s", flush=True)
                mean, tail = (statistics.median(r[i] for r in ratios) for i in (0, 1))
                print(f"{look}: median of the ratios: mean {mean:.3f}, 99th percentile {tail:.3f}", flush=True)
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
