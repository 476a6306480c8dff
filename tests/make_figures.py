#!/usr/bin/env python3
"""make_figures.py [BUILD] - measures the program and writes tests/FIGURES.md and the table of results in README.md; `make figures`.

Each table comes from the CSV of `enfilade bench`, or from the JSON of another command, as it stands in build/figures. A table may hold
counts and errors, which a commit repeats, and columns of times and memory, whose heads end in ms, µs, ns, s or MB, which depend on the machine.
The inputs are the bundled samples. Real homes are measured as well where ../shared/data/sh3d is there, in a part of their own.
`--keep` takes the results that are in build/figures instead of measuring again; `--only NAME` measures that one alone.
"""
import csv, json, os, re, resource, subprocess, sys, time

MAPS = "build/maps"
FOLDER = "build/figures"
HOMES = "../shared/data/sh3d"
REAL = ("2BedroomHouseWithBasement.Home.xml", "3BedroomApartment.Home.xml", "4-BedroomHouse.sh3d")
SAMPLES = ("two-rooms.plan", "house.plan", "office.plan", "office-plain.plan", "flat.Home.xml", "hillside.sh3d", "villa.sh3d")
ORIGIN = (
    ("two-rooms.plan", "by hand, an introduction to the `.plan` format"),
    ("house.plan", "by hand, a furnished house of two storeys"),
    ("office.plan", "`maps/buildings/generate.c`, seed 1, after the office in Oki's paper (66 cells, 16,719 polygons)"),
    ("office-plain.plan", "`maps/buildings/generate.c`, seed 1, a grid of 66 rooms with 115 aligned doorways"),
    ("flat.Home.xml", "`maps/buildings/homes.py`, a flat drawn carelessly, without models"),
    ("hillside.sh3d", "`maps/buildings/homes.py`, a house with cellar, garage and gable roof"),
    ("villa.sh3d", "`maps/buildings/homes.py`, round walls, and furniture of 56,000 polygons"),
    ("rooms-30.plan, rooms-1000.plan", "`maps/buildings/generate.c`, rooms as in office-plain, doorways anywhere along the walls"),
    ("enfilade-1000.plan", "`maps/buildings/generate.c`, the same with all doorways in line"),
)


def at(names):
    return [f"{MAPS}/{name}" for name in names]


# Name -> arguments of `enfilade`. A second entry of results is read from the JSON of a command, the others from CSV.
RUNS = {
    "walk": ["bench", "walk", *at(SAMPLES), "--frames", "200"],
    "visibility": ["bench", "visibility", *at(SAMPLES)],
    "collision": ["bench", "collision", *at(("house.plan", "office-plain.plan", "villa.sh3d")), "--steps", "100000"],
    "formfactors": ["bench", "formfactors", *at(("office-plain.plan",)), "--quick", "--resolutions", "50,100,200"],
    "light": ["bench", "light", *at(("two-rooms.plan", "office-plain.plan")), "--methods", "default", "--error", "0.01"],
    "meshes": ["bench", "meshes", *at(("two-rooms.plan", "office-plain.plan")), "--points", "300", "--error", "0.1"],
    "radiosity": ["bench", "radiosity"],
    "rooms": ["bench", "rooms", *at(("rooms-30.plan", "rooms-1000.plan", "enfilade-1000.plan"))],
    "rays": ["bench", "rays", *at(("house.plan", "office.plan"))],
    "hidden": ["bench", "hidden", *at(("house.plan", "office.plan", "office-plain.plan"))],
    "breaks": ["bench", "breaks"],
    "bake-default": ["bake", *at(("office-plain.plan",)), "-o", f"{FOLDER}/a.rad", "--json"],
    "bake-depth": ["bake", *at(("office-plain.plan",)), "-o", f"{FOLDER}/b.rad", "--culling", "depth", "--json"],
    "bake-none": ["bake", *at(("office-plain.plan",)), "-o", f"{FOLDER}/c.rad", "--no-cull", "--json"],
    "bake-house": ["bake", *at(("house.plan",)), "-o", f"{FOLDER}/house.rad", "--json"],
    "bake-hillside": ["bake", *at(("hillside.sh3d",)), "-o", f"{FOLDER}/d.rad", "--json"],
    "bake-hillside-off": ["bake", *at(("hillside.sh3d",)), "-o", f"{FOLDER}/e.rad", "--proxies", "off", "--json"],
    "render": ["render", *at(("house.plan",)), "--light", f"{FOLDER}/house.rad", "--view", "still", "--samples", "4", "--json",
               "-o", f"{FOLDER}/still.png"],
    "verify": ["walk", *at(("house.plan",)), "--offscreen", f"{FOLDER}/frames", "--every", "1000000", "--verify", "--random", "500",
               "--json"],
}
REAL_RUNS = {
    "real-walk": ["bench", "walk", *[f"{HOMES}/{name}" for name in REAL], "--frames", "100"],
    "real-visibility": ["bench", "visibility", *[f"{HOMES}/{name}" for name in REAL], "--methods", "flow,proof"],
    "real-collision": ["bench", "collision", *[f"{HOMES}/{name}" for name in REAL[:2]], "--steps", "100000"],
}


def shown(name):
    """The command of a run as one types it, without the folders of inputs."""
    words = [os.path.basename(word) if "/" in word else word for word in (RUNS.get(name) or REAL_RUNS[name])]
    return "`enfilade " + " ".join(words) + "`"


def measure(build, name, arguments):
    """Runs the program; leaves its output and, of the process, CPU seconds, wall seconds and peak memory."""
    os.makedirs(FOLDER, exist_ok=True)
    environment = dict(os.environ, XDG_CACHE_HOME=os.path.abspath(f"{FOLDER}/cache"))
    print(f"{name}: enfilade {' '.join(arguments)}", file=sys.stderr)
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    with open(f"{FOLDER}/{name}.new", "w") as out:
        process = subprocess.Popen([f"{build}/enfilade", *arguments], stdout=out, stderr=subprocess.DEVNULL, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"make_figures: enfilade {' '.join(arguments)} ends with status {os.waitstatus_to_exitcode(status)}")
    os.replace(f"{FOLDER}/{name}.new", f"{FOLDER}/{name}.out")
    cost = {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": time.monotonic() - started, "peak_mb": usage.ru_maxrss / 1024}
    with open(f"{FOLDER}/{name}.cost", "w") as out:
        json.dump(cost, out)


def rows(name):
    with open(f"{FOLDER}/{name}.out") as file:
        return list(csv.DictReader(file))


def record(name):
    with open(f"{FOLDER}/{name}.out") as file, open(f"{FOLDER}/{name}.cost") as cost:
        return {**json.load(file), **json.load(cost)}


def number(text, digits=3):
    """A number to some digits, thousands parted; other text as it is."""
    try:
        value = float(text)
    except (TypeError, ValueError):
        return "" if text in ("", "skipped", None) else str(text)
    if value == int(value) or abs(value) >= 10 ** digits / 10:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def percent(part, whole, digits=3):
    return number(100 * float(part) / float(whole), digits) + " %" if float(whole) else ""


def table(head, lines):
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in [head, ["---"] * len(head), *lines])


def plain(path):
    return re.sub(r"\.(plan|sh3d|Home\.xml)$", "", os.path.basename(path))


def walk_table(name):
    found = {}
    for row in rows(name):
        found.setdefault(row["building"], {})[row["method"]] = row
    head = ["building", "polygons", "drawn: frustum", "portals", "plan (Oki)", "**stab trees**", "portals tested, stab", "objects tested, stab",
            "query, stab, µs", "frame: none, frustum, portals, stab, ms"]
    lines = []
    for building, by in found.items():
        share = lambda method: percent(by[method]["polygons_drawn_mean"], by[method]["polygons_total"])
        stab = by["stab"]
        lines.append([plain(building), number(stab["polygons_total"]), share("frustum"), share("portals"), share("plan"), f"**{share('stab')}**",
                      number(stab["portals_tested_mean"]), number(stab["objects_tested_mean"]), number(stab["query_us_mean"], 2),
                      ", ".join(number(by[m]["frame_ms_mean"], 2) for m in ("none", "frustum", "portals", "stab"))])
    return table(head, lines)


def visibility_table(name):
    lines = [[plain(r["building"]), r["method"], number(r["cells"]), number(r["portals"]), number(r["visible_pairs"]), number(r["over_percent"]),
              r["misses"], number(r["undecided"]), number(r["chains"]), number(r["clips"]), number(float(r["cpu_s_1_thread"]) * 1000, 2)]
             for r in rows(name) if r["method"] != "peer"]
    return table(["building", "method", "cells", "portals", "visible pairs", "over-estimate, %", "misses", "undecided", "chains", "clips",
                  "CPU, ms"], lines)


def collision_table(name):
    lines = [[plain(r["building"]), f"{number(r['wall_tests_per_step'])} of {number(r['walls_total'])}", number(r["object_tests_per_step"]),
              r["violations"], f"{r['flood_lost']} of {number(r['flood_ways'])}", number(r["us_per_step"], 2)] for r in rows(name)]
    return table(["building", "walls tested a step", "furniture polygons a step", "steps into solids", "reachable floor steps refused",
                  "a step, µs"], lines)


def generic_table(name, columns, keep=lambda row: True):
    """Columns are (head, key); times are in milliseconds or microseconds already."""
    return table([head for head, _ in columns],
                 [[plain(r[key]) if key in ("building", "scene") else number(r[key]) for _, key in columns] for r in rows(name) if keep(r)])


def bake_table():
    head = ["building", "options", "elements", "patches", "shots", "polygons in light", "wall, s", "CPU, s", "peak, MB"]
    lines = []
    for name in ("bake-default", "bake-depth", "bake-none", "bake-house", "bake-hillside", "bake-hillside-off"):
        r = record(name)
        arguments = RUNS[name]
        options = " ".join(f"`{a}`" for a in arguments[4:] if a != "--json") or "defaults"
        lines.append([plain(arguments[1]), options.replace("` `", " "), number(r["elements"]), number(r["patches"]), number(r["shots"]),
                      number(r["polygons"]), number(r["wall_s"], 2), number(r["cpu_s"], 2),
                      number(r["peak_mb"])])
    return table(head, lines)


def light_table():
    head = ["building", "elements", "shots", "gathered: median, %", "RMS, %", "largest, %", "shown: median, %", "truth to, %", "bake, s"]
    return table(head, [[plain(r["building"]), number(r["elements"]), number(r["shots"]), number(r["gather_median"], 2), number(r["gather_rms"], 2),
                         number(r["gather_max"], 2), number(r["vertex_median"], 2), number(r["truth_error"], 2), number(r["bake_seconds"], 2)]
                        for r in rows("light")])


def machine():
    with open("/proc/cpuinfo") as file:
        name = re.search(r"model name\s*: (.*)", file.read())
    return f"{name.group(1) if name else 'unknown CPU'}, {os.cpu_count()} cores"


def commit():
    return subprocess.run(["git", "log", "-1", "--format=%h", "--", "engine", "maps", "visibility", "radiosity", ":!*.md"], capture_output=True, text=True,
                          check=True).stdout.strip()


def results():
    """The table of README.md: a few figures of the others, each with its command."""
    shown_buildings = ("house.plan", "office.plan", "villa.sh3d")
    paths = " ".join(at(shown_buildings))
    walk = {(r["building"], r["method"]): r for r in rows("walk")}
    rooms = {(r["building"], r["method"], r["culling"]): r for r in rows("rooms")}
    pairs = [r for r in rows("visibility") if r["method"] == "proof" and r["building"] in shown_buildings]
    share = lambda b: percent(walk[b, "stab"]["polygons_drawn_mean"], walk[b, "stab"]["polygons_total"], 2)
    shot = lambda culling: " and ".join(number(rooms[f"rooms-{n}.plan", "hemisphere", culling]["faces_drawn"]) for n in (30, 1000))
    verified, bake, none = record("verify"), record("bake-default"), record("bake-none")
    office = next(r for r in rows("light") if "office-plain" in r["building"])
    lines = [
        ["polygons drawn a frame, of all", ", ".join(f"{plain(b)} {share(b)}" for b in shown_buildings), f"`enfilade bench walk {paths}`"],
        [f"pixels that culling changes, in {number(verified['frames'] + verified['random_frames'])} frames of the house",
         number(verified["mismatched_pixels"]), "`enfilade walk build/maps/house.plan --offscreen frames --verify --random 500`"],
        ["visible pairs of cells that are missed", f"{sum(int(r['misses']) for r in pairs)} of {sum(int(r['proven_pairs']) for r in pairs):,}",
         f"`enfilade bench visibility {paths}`"],
        ["polygons in view of a shot of light, of 30 and 1,000 rooms", shot("stab"), "`make bench bench=rooms`"],
        ["the same, nothing culled", shot("none"), "`make bench bench=rooms`"],
        ["CPU time of a bake of an office of 66 rooms, culled and not", f"{number(bake['cpu_s'], 2)} s and {number(none['cpu_s'], 2)} s",
         "`enfilade bake build/maps/office-plain.plan`, then with `--no-cull`"],
        ["median error of its light, against path tracing", f"{number(office['gather_median'], 2)} %",
         "`enfilade bench light build/maps/office-plain.plan --methods default --error 0.01`"],
    ]
    return table(["measurement", "result", "command"], lines)


def write(path, text):
    old = open(path).read() if os.path.exists(path) else ""
    if text != old:
        with open(path, "w") as file:
            file.write(text)


def main():
    arguments = sys.argv[1:]
    only = arguments[arguments.index("--only") + 1] if "--only" in arguments else None
    build = next((a for i, a in enumerate(arguments) if not a.startswith("-") and (i == 0 or arguments[i - 1] != "--only")), "build/release")
    have_real = all(os.path.exists(f"{HOMES}/{name}") for name in REAL)
    runs = {**RUNS, **(REAL_RUNS if have_real else {})}
    for name, command in runs.items():
        if name == only or not only and "--keep" not in arguments:
            measure(build, name, command)
    with open("tests/figures.in.md") as file:
        text = file.read()

    def fill(match):
        word, name = match.group(1), match.group(2)
        if name.startswith("real-") and not have_real:
            return "Real homes are not beside this copy."
        if word == "command":
            return shown(name)
        return {"bake": bake_table, "light": light_table, "machine": machine, "commit": commit,
                "inputs": lambda: table(["input", "origin"], ORIGIN)}.get(name, lambda: by_name(name))()

    write("tests/FIGURES.md", re.sub(r"@(table|command):([\w-]+)@", fill, text))
    readme = open("README.md").read()
    write("README.md", re.sub(r"(<!-- results -->\n).*?(<!-- end of results -->)", lambda m: m.group(1) + results() + "\n" + m.group(2), readme,
                              flags=re.S))


def by_name(name):
    if name.endswith("walk"):
        return walk_table(name)
    if name.endswith("visibility"):
        return visibility_table(name)
    if name.endswith("collision"):
        return collision_table(name)
    if name == "formfactors":
        return generic_table(name, [("method", "method"), ("resolution", "resolution"), ("culling", "culling"), ("sum of differences", "l1"),
                                    ("polygons looked at", "faces_drawn"), ("samples", "samples"), ("tests", "tests"), ("a shot, ms", "ms_a_shot")],
                             lambda r: r["resolution"] == "100")
    if name == "rooms":
        return generic_table(name, [("building", "building"), ("polygons", "polygons"), ("method", "method"), ("culling", "culling"),
                                    ("polygons looked at", "faces_drawn"), ("elements reached", "elements_drawn"), ("a shot, ms", "ms_a_shot")],
                             lambda r: r["culling"] in ("none", "depth", "stab"))
    if name == "radiosity":
        return generic_table(name, [("table", "table"), ("scene", "building"), ("method", "method"), ("culling", "culling"), ("elements", "elements"),
                                    ("shots", "shots"), ("elements drawn a shot", "elements_drawn"), ("mean error, %", "error_percent"),
                                    ("all, s", "seconds"), ("drawing, s", "drawing_seconds"), ("visibility, s", "visibility_seconds")])
    if name == "meshes":
        return generic_table(name, [("building", "building"), ("mesh", "mesh"), ("elements", "elements"), ("patches", "patches"),
                                    ("RMS of elements, %", "element_rms"), ("RMS shown, %", "vertex_rms"), ("elements, of an even mesh's", "of_even_element"),
                                    ("bake, s", "bake_seconds")])
    if name == "rays-patches":
        return generic_table("rays", [("shape", "shape"), ("method", "method"), ("clips", "clips"), ("halvings", "halvings"), ("steps", "steps"),
                                      ("undecided", "undecided"), ("roots", "roots"), ("missed", "missed"), ("false", "false"), ("a hit, ns", "ns_hit"),
                                      ("a miss, ns", "ns_miss")], lambda r: "plan " not in r["shape"])
    if name == "hidden-polygons":
        return generic_table("hidden", [("method", "method"), ("polygons", "polygons"), ("edges", "edges"), ("comparisons", "comparisons"),
                                        ("splits", "splits"), ("depth tests", "depth_tests"), ("wrong pixels, share", "wrong_share"), ("a picture, ms", "ms")],
                             lambda r: r["table"] == "polygons" and r["scene"] == "random" and r["polygons"] in ("100", "2500", "60000"))
    if name == "hidden-buildings":
        found = {}
        for r in rows("hidden"):
            if r["table"] in ("culled", "unculled"):
                key = (plain(r["scene"]), r["table"], number(r["polygons"]), number(r["depth_complexity"]))
                found.setdefault(key, {})[r["method"]] = number(r["ms"], 2)
        methods = list(next(iter(found.values())))
        return table(["building", "culling", "polygons", "depth complexity", *(f"{m}, ms" for m in methods)],
                     [[*key, *(by.get(m, "") for m in methods)] for key, by in found.items()])
    if name == "rays-buildings":
        return generic_table("rays", [("building, rays", "shape"), ("method", "method"), ("rays", "rays"), ("share of hits", "hit_share"),
                                      ("roots", "roots"), ("missed", "missed"), ("a ray, ns", "ns_hit")], lambda r: "plan " in r["shape"])
    if name == "breaks":
        worst = {}
        for r in rows(name):
            worst.setdefault(r["method"], {}).setdefault(r["break"], []).append(float(r["error"]))
        series = sorted({r["break"] for r in rows(name)})
        return table(["method", *series], [[method, *(number(max(by[s])) if s in by else "" for s in series)] for method, by in worst.items()])
    if name == "render":
        r = record(name)
        return table(["rays", "matt ends", "escaped", "faint", "at the limit of depth", "picture, s", "peak, MB"],
                     [[number(r["rays"]), number(r["ended_matt"]), number(r["ended_escaped"]), number(r["ended_faint"]), number(r["ended_deep"]),
                       number(r["seconds"], 2), number(r["peak_mb"])]])
    sys.exit(f"make_figures: no table `{name}`")


if __name__ == "__main__":
    main()
