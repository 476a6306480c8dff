#!/usr/bin/env python3
"""mutants.py - plants faults of one line in core logic and runs the tests that should notice each (`make mutants`).

A mutant is one change of one line (OPERATORS). Its file is compiled to an object of its own, the test binary is linked with that
object in place of the original's, and the suites of TABLE run until a test fails, crashes or exceeds its limits. The tree
is never changed: all work is done in build/mutants. A mutant whose object equals the original's byte for byte is no fault and
not counted, and so is one that does not compile.

Which lines are changed depends on the seed and on the text of the line alone, so that an edit elsewhere keeps the others. PLANTED
are faults that the tests once let pass; they always run. tests/mutants.md lists the survivors with the reason for each.
With config=asan the survivors run once more under the sanitizers, which see what is read beyond the end of an array.
Results go to build/mutants/results.csv; a second run goes on where the first ended (--again runs the survivors anew).
"""
import argparse, collections, concurrent.futures, csv, glob, hashlib, json, os, re, resource, shlex, shutil, signal, subprocess
import sys, threading, time

WORK = "build/mutants"
RESULTS = WORK + "/results.csv"
BASELINE = WORK + "/baseline.json"
SURVIVORS = "tests/mutants.md"
MEMORY = 6 << 30  # bytes a test may map: several times what any of them takes

# Files, and stages of tests: filters of Criterion, run in this order until one notices. The quick ones come first.
TABLE = [
    (r"engine/core/vec\.c", ["predicates/*", "@(sightline|query_oracle|soup)/!(polygons_*)"]),
    (r"engine/core/polygon\.c", ["sums/@(plans|files|*sight)", "@(polygon|building|soup_split|cells)/*", "@(curved|soup|mesh|near_pairs)/!(polygons_*)"]),
    (r"engine/core/file\.c", ["@(file|seen|derived|kills)/*", "@(rad_file|recording)/*"]),
    (r"maps/building/zip\.c", ["@(sh3d|zip)/*"]),
    (r"maps/(building/)?building\w*\.c", ["sums/@(plans|files)", "@(building|plan|prt|quads)/*", "@(curved|sh3d|soup|soup_obj|wad)/!(polygons_*)"]),
    (r"maps/quake/\w+\.c", ["@(quake|quake_faults|prt)/*"]),
    (r"maps/enclose/\w+\.c", ["sums/@(plans|files)", "enclose/!(random_plans)", "@(enclose|enclose_plans)/*"]),
    (r"visibility/pairs/\w+\.c", ["sums/*sight", "@(pairs|witness|seen)/!(sightlines_*)", "pairs/sightlines_*"]),
    (r"visibility/query/\w+\.c", ["sums/sight", "@(query_slot|query_cone|query_eye|query|query_oracle)/*", "@(leaves|layers|walk)/*"]),
    (r"visibility/soup/\w+\.c", ["sums/*sight", "@(soup|soup_doors|soup_merge)/!(polygons_*)", "@(soup|stability)/*"]),
    (r"visibility/(cells/given|cells/contacts|winding|beam|ways)\.c", ["sums/*sight", "@(prt|pairs|witness|cells)/!(sightlines_*)", "@(sightline|query|query_oracle|trees)/!(are_the_same*)"]),
    (r"visibility/cells/leaves\.c", ["sums/walks", "@(leaves|doors)/*"]),
    (r"visibility/vis_file\.c", ["@(vis_file|derived)/*", "agreement/*"]),
    (r"visibility/(trees/\w+|sightline)\.c", ["sums/*sight", "@(forest|sightline|trees)/!(are_the_same*|hold_every_line_of_doom*|hold_every_line_of_portal*)",
                                                           "@(trees|query|query_oracle)/!(are_the_same*)"]),
    (r"visibility/(prepare/build_cells|cells/(cells|convex|convex_sweep|portals|surfaces|squares))\.c",
     ["sums/*sight", "@(cells|convex|squares|layers|solid|fixture|query|leaves)/*", "@(query_oracle|mesh|trees|enclose)/!(random_*|are_the_same*|hold_every_line_of_doom*)"]),
    (r"radiosity/shoot/shoot\w*\.c", ["sums/light", "@(shoot|ambient)/*", "@(bake_probes|rad_file)/!(refuses_what*)"]),
    (r"radiosity/mesh/mesh\w*\.c", ["sums/light", "@(mesh|mesh_contacts|mesh_splits)/*", "@(reconstruct|shoot|cells)/*"]),
    (r"(engine/team/\w+|radiosity/mesh/(parts|borders)|radiosity/show/joined|engine/scene/bake_parts)\.c", ["team/*", "parts/*"]),
    (r"radiosity/shoot/sky\w*\.c", ["sums/light", "sky/!(room_*|box_*)", "sky/*"]),
    (r"radiosity/(show/reconstruct\w*|mesh/nodes)\.c", ["sums/light", "reconstruct/*", "bake_probes/*"]),
    (r"engine/sim/(body|solid|obstacles)\.c",
     ["sums/walks", "@(solid|body|door_frames)/!(apartment|four_bedrooms|home_*|house|office)", "@(body|doors)/!(four_bedrooms|apartment|home_*)"]),
    (r"engine/sim/(doors|door_part|door_states)\.c", ["sums/walks", "@(doors|door_frames|leaves)/*", "wad/*"]),
    (r"engine/lit/exposure\.c", ["exposure/!(tours*)", "exposure/*"]),
]

# Faults that the tests once let pass: name, file, text, what replaces it. The text occurs once in the file.
PLANTED = [
    ("an undecided half counts as excluded", "visibility/pairs/settle.c",
     "if (verdict == OPEN) worst = OPEN;", ";"),
    ("closed doors block no sight in the walk", "visibility/query/query_walk.c",
     "if (!query_door_closed(q, nearest)) look_around", "look_around"),
    ("the wedge's first side is narrowed", "visibility/query/query_cone.c",
     "1 / vec2_length(cone->from)), -1, nearest)", "1 / vec2_length(cone->from)), 1, nearest)"),
    ("the wedge's second side is narrowed", "visibility/query/query_cone.c",
     "1 / vec2_length(cone->to)), 1, nearest)", "1 / vec2_length(cone->to)), -1, nearest)"),
    ("no gap between leaves", "engine/sim/doors.c",
     "if (gap >= CLEAR) return false;", "if (gap >= 0) return false;"),
    ("doors step eight times as far", "engine/sim/doors.c", "return CLEAR / longest;", "return 8 * CLEAR / longest;"),
    ("doors are used through windows", "engine/sim/doors.c",
     "b->openings[region->opening].kind == OPENING_WINDOW) break;",
     "b->openings[region->opening].kind == OPENING_WINDOW && false) break;"),
    ("the open share of the sky is turned over", "radiosity/shoot/sky.c", "0.5 + 0.5 * normal.z", "0.5 - 0.5 * normal.z"),
    ("a patch in half shade stands free", "radiosity/shoot/sky.c", "STANDS_FREE = 0.1;", "STANDS_FREE = 0.6;"),
    ("elements weigh 1/d", "radiosity/show/reconstruct.c", "1 / fmax(square, NEAREST), 0}", "1 / sqrt(fmax(square, NEAREST)), 0}"),
    ("more of the rest is laid on top", "radiosity/show/reconstruct.c", "MOST_REST = 0.2;", "MOST_REST = 0.9;"),
    ("light weighs the exposure without its root", "engine/lit/exposure.c",
     "double weight = angle * sqrt(b);", "double weight = angle * b;"),
    ("light does not weigh the exposure", "engine/lit/exposure.c",
     "double weight = angle * sqrt(b);", "double weight = angle;"),
    ("what triangles have in common is no portal", "visibility/cells/portals.c", "if (count < 3) return;", "if (count <= 3) return;"),
    ("no limit of all entries", "maps/building/zip.c",
     "if (archive->unpacked + unpacked > ARCHIVE_MAX_TOTAL)", "if (archive->unpacked + unpacked > SIZE_MAX)"),
    ("what is unpacked is not counted", "maps/building/zip.c", "archive->unpacked += out->size;", ";"),
]

# ---- what to change

# Name, pattern, replacement. Lines are in the repository's format, so that blanks tell binary operators from others.
OPERATORS = [
    ("comparison", r" < ", " <= "), ("comparison", r" <= ", " < "), ("comparison", r" > ", " >= "),
    ("comparison", r" >= ", " > "), ("comparison", r" < ", " > "), ("comparison", r" > ", " < "),
    ("comparison", r" <= ", " >= "), ("comparison", r" >= ", " <= "), ("comparison", r" == ", " != "),
    ("comparison", r" != ", " == "), ("logic", r" && ", " || "), ("logic", r" \|\| ", " && "),
    ("not", r"(?<![\w)\]])!(?=[\w(])", ""), ("sign", r" \+ ", " - "), ("sign", r" - ", " + "),
    ("sign", r" \+= ", " -= "), ("sign", r" -= ", " += "), ("sign", r"(?<=[(\[,=?:] )-(?=[\w(])|(?<=[(\[{])-(?=[\w(])", ""),
    ("product", r" \* ", " / "), ("product", r" / ", " * "),
    ("constant", r"(?<![\w.])0(?![\w.])", "1"), ("constant", r"(?<![\w.])1(?![\w.])", "2"), ("constant", r"(?<![\w.])1(?![\w.])", "0"),
    ("constant", r"(?<![\w.])[2-9]\d*(?![\w.])", lambda m: str(2 * int(m.group()))),
    ("constant", r"(?<![\w.])\d+\.\d+(?:e-?\d+)?f?(?![\w.])", lambda m: "(2 * %s)" % m.group()),
    ("constant", r"(?<![\w.])\d+e-?\d+f?(?![\w.])", lambda m: "(2 * %s)" % m.group()),
    ("one more", r" \+ 1(?![\w.])", ""), ("one less", r" - 1(?![\w.])", ""),
    ("extreme", r"\bfmin\b", "fmax"), ("extreme", r"\bfmax\b", "fmin"), ("extreme", r"\.min\b", ".max"), ("extreme", r"\.max\b", ".min"),
    ("value", r"\btrue\b", "false"), ("value", r"\bfalse\b", "true"),
    ("axis", r"\.x\b", ".y"), ("axis", r"\.y\b", ".x"), ("axis", r"\.z\b", ".x"),
    ("index", r"\[0\]", "[1]"), ("index", r"\[1\]", "[0]"), ("index", r"\[([ijk])\]", r"[\1 + 1]"),
    ("return", r"(?<=\breturn )(?!0;|true;|false;|-1;)[^;]+(?=;$)", "0"),
    ("deleted", r"^\s+(?:if \(.*\) )?[a-z_][\w.>\[\]()*&-]*(?:\(.*\)| [-+*/|&]?= .*|\+\+|--);$", ";"),
    ("deleted", r"^\s+(?:if \(.*\) )?(?:continue|break|return);$", ";"),
]
# Of these lines none is changed: declarations of compile-time things, checks of our own mistakes, error sentences; and sizes of
# memory, which the sanitizers watch (`make asan`).
PASSED_OVER = re.compile(r"^\s*(#|//|\*|/\*|enum |typedef |static const char)|CORE_ASSERT|static_assert|error_set|__builtin_prefetch"
                         r"|ARENA_ARRAY|arena_alloc|malloc|sizeof|^\s*[A-Z]\w+ [\w, *]*\[[^]]*\](, |;)|zip_error_fini|zip_discard")
DECLARATION = re.compile(r"^\s+(?:static |const |unsigned |long )*[A-Za-z_]\w* [*]?\w+(?: = .*|\[.*)?;$")

Mutant = collections.namedtuple("Mutant", "key file line kind before after")


def blank_out(line):
    """The line with strings, characters and comments overwritten, as long as before."""
    line = re.sub(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'', lambda m: "_" * len(m.group()), line)
    return re.sub(r"(//.*|/\*.*?\*/)", lambda m: " " * len(m.group()), line)


def changes_of(line, previous, following):
    """All changes of one line as (kind, after)."""
    bare = blank_out(line)
    if PASSED_OVER.search(line) or not bare.strip() or not line.startswith((" ", "static const", "#define")):
        return
    for kind, pattern, by in OPERATORS:
        if kind == "deleted":
            ends = previous.rstrip()
            whole = bare.count("(") == bare.count(")") and (ends.endswith((";", "{", "}", ")")) or not ends.strip())
            if not whole or DECLARATION.match(bare) and not bare.lstrip().startswith(("continue", "break", "return")):
                continue
            if following.lstrip().startswith("else") or bare.lstrip().startswith("for "):
                continue
        for match in re.finditer(pattern, bare.rstrip()):
            text = by(match) if callable(by) else match.expand(by) if "\\" in by else by
            if kind == "deleted":
                text = bare[:len(bare) - len(bare.lstrip())] + ";"
            after = line[:match.start()] + text + line[match.end():]
            if after != line:
                yield kind, after


def mutants_of(path, seed):
    """One mutant a line: of all changes of that line the one whose hash is lowest."""
    with open(path) as f:
        lines = f.read().split("\n")
    seen = collections.Counter()
    for i, line in enumerate(lines):
        if not line.strip():
            continue
        seen[line] += 1
        best = None
        for kind, after in changes_of(line, lines[i - 1] if i else "", lines[i + 1] if i + 1 < len(lines) else ""):
            name = "\0".join([str(seed), path, line, str(seen[line]), after])
            key = hashlib.sha1(name.encode()).hexdigest()[:12]
            if best is None or key < best.key:
                best = Mutant(key, path, i + 1, kind, line.strip(), after.strip())
        if best:
            yield best


def planted():
    for name, path, text, by in PLANTED:
        content = open(path).read()
        if content.count(text) != 1:
            sys.exit("%s: the text of '%s' occurs %d times (expected once): %s" % (path, name, content.count(text), text))
        line = content[:content.index(text)].count("\n") + 1
        key = "planted-" + hashlib.sha1((path + text + by).encode()).hexdigest()[:6]
        yield Mutant(key, path, line, "planted: " + name, text, by)


def stages_of(path):
    """The tests that should notice a fault in this file; none where the file is no core logic."""
    return next((stages for pattern, stages in TABLE if re.fullmatch(pattern, path)), None)


def sources():
    return sorted(path for top in ("engine", "maps", "visibility", "radiosity") for path in glob.glob(top + "/**/*.c", recursive=True)
                  if stages_of(path))


# ---- compiling and running

def limits(cpu, sanitized):
    resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu + 5))
    if not sanitized:  # the address sanitizer maps terabytes
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def object_path(mutant):
    return os.path.abspath("%s/objects/%s.o" % (WORK, mutant.key))


def kept(command):
    """The command with copies of the objects, so that the tree may be built while this runs."""
    out = []
    for word in command.split():
        if word.endswith(".o"):
            copy = os.path.join(WORK, "base", word)
            os.makedirs(os.path.dirname(copy), exist_ok=True)
            if not os.path.exists(copy) or os.path.getmtime(copy) != os.path.getmtime(word):
                shutil.copy2(word, copy)
            word = copy
        out.append(word)
    # The sanitizers are at odds with the faster linker.
    fast = shutil.which("ld.gold") and not any(word.startswith("-fsanitize=") for word in out)
    return out + (["-fuse-ld=gold"] if fast else [])


class Bench:
    """What one thread works with: a folder of its own."""

    def __init__(self, options, link, number):
        self.folder = os.path.abspath("%s/%d" % (WORK, number))
        self.compile = options.compile.split()
        self.sanitized = any(word.startswith("-fsanitize=") for word in self.compile)
        self.link = link
        self.base = {}

    def object_of(self, path, content, out):
        """Compiles content as if it were path. False where it does not compile."""
        copy = os.path.join(self.folder, path)
        os.makedirs(os.path.dirname(copy), exist_ok=True)
        with open(copy, "w") as f:
            f.write(content)
        command = self.compile + ["-g0", "-w", "-ffile-prefix-map=%s/=" % self.folder, "-MF", out + ".d", "-c", "-o", out, copy]
        return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def mutate(self, mutant, compare=True):
        """'' and an object, or why there is no fault to notice. Without `compare` the code is known to differ."""
        lines = open(mutant.file).read()
        if mutant.kind.startswith("planted"):
            changed = lines.replace(mutant.before, mutant.after)
        else:
            each = lines.split("\n")
            old = each[mutant.line - 1]
            each[mutant.line - 1] = old[:len(old) - len(old.lstrip())] + mutant.after
            changed = "\n".join(each)
        original, out = self.folder + "/original.o", object_path(mutant)
        if compare and mutant.file not in self.base:
            if not self.object_of(mutant.file, lines, original):
                sys.exit("%s does not compile: %s" % (mutant.file, shlex.join(self.compile)))
            self.base[mutant.file] = open(original, "rb").read()
        if not self.object_of(mutant.file, changed, out):
            return "does not compile"
        return "same code" if compare and open(out, "rb").read() == self.base[mutant.file] else ""

    def binary(self, mutant):
        """The test binary with the mutant's object, or as it is for None."""
        out, command = self.folder + "/all", self.link
        if mutant:
            swapped = "/" + mutant.file[:-2] + ".o"
            command = [object_path(mutant) if a.endswith(swapped) else a for a in self.link]
            assert command != self.link, swapped
        subprocess.run(command + ["-s", "-o", out], check=True, stdout=subprocess.DEVNULL)
        return out

    def run(self, binary, stage, cpu, wall):
        """'' where all pass, else the test that failed, and CPU seconds."""
        scratch = self.folder + "/scratch"
        shutil.rmtree(scratch, ignore_errors=True)
        os.makedirs(scratch)
        environment = dict(os.environ, ENFILADE_BUILD="build/release", XDG_CACHE_HOME=scratch, TMPDIR=scratch, OMP_NUM_THREADS="2")
        log = self.folder + "/log"
        with open(log, "w") as f:
            child = subprocess.Popen([binary, "-j1", "--fail-fast", "--color=never", "--filter", stage], stdout=f, stderr=f,
                                     env=environment, stdin=subprocess.DEVNULL, start_new_session=True,
                                     preexec_fn=lambda: limits(cpu, self.sanitized))
        pid, status, used, end = 0, None, None, time.time() + wall
        while not pid and time.time() < end:
            time.sleep(0.02)
            pid, status, used = os.wait4(child.pid, os.WNOHANG)
        try:
            os.killpg(child.pid, signal.SIGKILL)  # what it left behind too
        except ProcessLookupError:
            pass
        if not pid:
            used = os.wait4(child.pid, 0)[2]
        spent = used.ru_utime + used.ru_stime
        text = open(log, errors="replace").read()
        failed = re.search(r"\[FAIL\] (\S+?::\w+)", text)
        if failed:
            return failed.group(1), spent
        if not pid or status:
            return "status %d" % status if pid else "hangs", spent
        if not re.search(r"Tested: [1-9]", text):
            raise SystemExit("no test matches %s" % stage)
        return "", spent


def baseline(bench, stages, trust):
    """CPU seconds of each stage without a fault, kept as long as the test binary is the same; all must pass."""
    binary = bench.binary(None)
    version = hashlib.sha1(open(binary, "rb").read()).hexdigest()
    kept = json.load(open(BASELINE)) if os.path.exists(BASELINE) else {}
    times = {stage: t for old in kept.values() for stage, t in old.items()} if trust else kept.get(version, {})
    for stage in stages:
        if stage in times:
            continue
        failed, times[stage] = bench.run(binary, stage, 300, 1200)
        if failed:
            sys.exit("without any fault %s fails (%s)" % (failed, stage))
        print("%6.1f CPU s  %s" % (times[stage], stage), flush=True)
        with open(BASELINE, "w") as f:
            json.dump({version: times}, f)
    return times


def judge(bench, mutant, times, stages, quick):
    binary, spent = bench.binary(mutant), 0
    for stage in stages:
        failed, seconds = bench.run(binary, stage, int(20 + 4 * times[stage]), 300 + 20 * times[stage])
        spent += seconds
        if failed:
            return "noticed", failed, spent
    return "passed" if quick else "survived", "", spent


# ---- results

def explained():
    """Keys of survivors that tests/mutants.md explains, and how; `open` is no explanation."""
    out = {}
    if os.path.exists(SURVIVORS):
        for row in re.findall(r"^\| `([\w-]+)` \| (\w+) \|", open(SURVIVORS).read(), re.M):
            if row[1] != "open":
                out[row[0]] = row[1]
    return out


def read_results():
    if not os.path.exists(RESULTS):
        return {}
    with open(RESULTS) as f:
        return {row["key"]: row for row in csv.DictReader(f)}


class Ledger:
    FIELDS = ["key", "file", "line", "kind", "before", "after", "verdict", "by", "seconds"]

    def __init__(self, rows):
        self.rows, self.lock = rows, threading.Lock()

    def add(self, mutant, verdict, by="", seconds=0.0):
        with self.lock:
            self.rows[mutant.key] = dict(mutant._asdict(), verdict=verdict, by=by, seconds="%.1f" % seconds)
            with open(RESULTS + ".new", "w", newline="") as f:
                writer = csv.DictWriter(f, self.FIELDS)
                writer.writeheader()
                writer.writerows(self.rows.values())
            os.replace(RESULTS + ".new", RESULTS)


def summarize(mutants, rows):
    reasons = explained()
    folders = collections.defaultdict(collections.Counter)
    print("%-22s %8s %8s %9s %11s" % ("folder", "mutants", "noticed", "survived", "equivalent"))
    for mutant in mutants:
        row = rows.get(mutant.key)
        if row:
            for name in (os.path.dirname(mutant.file), "all"):
                folders[name]["mutants"] += 1
                folders[name]["noticed" if row["verdict"] == "noticed" else "survived"] += 1
                folders[name]["equivalent"] += row["verdict"] != "noticed" and reasons.get(mutant.key) == "equivalent"
    for name in sorted(folders, key=lambda n: (n == "all", n)):
        c = folders[name]
        print("%-22s %8d %8d %9d %11d" % (name, c["mutants"], c["noticed"], c["survived"], c["equivalent"]))
    c = folders["all"]
    if c["mutants"]:
        print("noticed: %.1f %% of all, %.1f %% of those not proven equivalent" % (
            100 * c["noticed"] / c["mutants"], 100 * c["noticed"] / max(c["mutants"] - c["equivalent"], 1)))
    missing = [m for m in mutants if m.kind.startswith("planted") and rows.get(m.key, {}).get("verdict") != "noticed"]
    for mutant in missing:
        print("not noticed: %s (%s)" % (mutant.kind, mutant.file))
    unexplained = [m for m in mutants if rows.get(m.key, {}).get("verdict") != "noticed" and m.key not in reasons]
    for m in unexplained:
        print("%s %s:%d %s\n    - %s\n    + %s" % (m.key, m.file, m.line, m.kind, m.before, m.after))
    return not missing and not unexplained


def choose(options, benches, ledger):
    """The first mutants by key that change the code, `count` of them, and all planted ones."""
    pool = sorted((m for path in sources() for m in mutants_of(path, options.seed)), key=lambda m: m.key)
    left, found = pool, []
    print("%d lines of %d files could be changed" % (len(pool), len(sources())))

    def sort_out(number, mutant):
        if mutant.key not in ledger.rows:
            why = benches[number].mutate(mutant)
            if why:
                ledger.add(mutant, why)
        return ledger.rows.get(mutant.key, {}).get("verdict") not in ("same code", "does not compile")

    while left and len(found) < options.count:
        part, left = left[:options.count - len(found)], left[options.count - len(found):]
        found += [m for m, good in zip(part, spread(options.jobs, sort_out, part)) if good]
    return [m for m in list(planted()) + found if not options.only or re.search(options.only, "%s:%d" % (m.file, m.line))]


def spread(jobs, work, items):
    """work(number of the thread, item) of each, in order."""
    free = list(range(jobs))
    lock = threading.Lock()

    def one(item):
        with lock:
            number = free.pop()
        try:
            return work(number, item)
        finally:
            with lock:
                free.append(number)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, items))


def main():
    parser = argparse.ArgumentParser(description="plants faults and runs the tests that should notice them")
    parser.add_argument("--compile", required=True, help="command that compiles, without -c and -o (the Makefile gives it)")
    parser.add_argument("--link", required=True, help="command that links the test binary, without -o")
    parser.add_argument("--count", type=int, default=340, help="mutants besides the planted ones")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--only", help="of places as visibility/query/query.c:12 that match this pattern alone")
    parser.add_argument("--again", action="store_true", help="run those that survived anew")
    parser.add_argument("--quick", action="store_true", help="run the first stage of each alone")
    parser.add_argument("--tests", help="run this filter alone")
    parser.add_argument("--trust", action="store_true", help="tests that passed in an earlier build without a fault pass in this one")
    parser.add_argument("--fresh", action="store_true", help="forget earlier results")
    parser.add_argument("--summary", action="store_true", help="run nothing")
    options = parser.parse_args()
    shutil.rmtree(WORK + "/objects", ignore_errors=True)
    os.makedirs(WORK + "/objects")
    if options.fresh and os.path.exists(RESULTS):
        os.remove(RESULTS)
    ledger = Ledger(read_results())
    link = kept(options.link)
    benches = [Bench(options, link, i) for i in range(options.jobs)]
    for bench in benches:
        os.makedirs(bench.folder, exist_ok=True)
    mutants = choose(options, benches, ledger)
    due = [m for m in mutants if ledger.rows.get(m.key, {}).get("verdict") != "noticed"
           and (options.again or ledger.rows.get(m.key, {}).get("verdict") != "survived")]
    if due and not options.summary:
        def stages(mutant):
            return [options.tests] if options.tests else stages_of(mutant.file)[:1 if options.quick else None]
        options.quick = options.quick or bool(options.tests)
        times = baseline(benches[0], sorted({s for m in due for s in stages(m)}), options.trust)
        began = time.time()

        def one(number, mutant):
            why = "" if os.path.exists(object_path(mutant)) else benches[number].mutate(mutant, mutant.key not in ledger.rows)
            verdict, by, spent = (why, "", 0) if why else judge(benches[number], mutant, times, stages(mutant), options.quick)
            if os.path.exists(object_path(mutant)):
                os.remove(object_path(mutant))
            ledger.add(mutant, verdict, by, spent)
            print("%5.0f s  %-9s %s:%d %s" % (time.time() - began, verdict, mutant.file, mutant.line, by), flush=True)
        spread(options.jobs, one, due)
    sys.exit(0 if summarize(mutants, ledger.rows) else 1)


main()
