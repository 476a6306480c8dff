#!/usr/bin/env python3
"""structure.py [BUILD] - how easy the tree is to find one's way in, held to its bounds; part of `make lint`.

  - folders hold about 30 files at most (fixtures, seeds and pictures aside);
  - no circle of files that use each other, by the symbols that the objects in BUILD (build/release) define and want;
  - no static function has a name that occurs in more than three files.

The order of folders is tests/core/test_layers.c's. Prints each fault with its place; `--all` prints what holds, too.
"""
import collections, os, re, subprocess, sys

MOST_FILES = 34      # of a folder: about 30
MOST_NAMED = 3       # files in which a static function of one name stands
FIXTURES = ("tests/support", "tests/references", "tests/seeds", "tests/pictures")
FUNCTION = re.compile(r"^static [^;=\n{]*?\b(\w+)\([^;{]*\)\s*\{", re.M)


def listed():
    text = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True, check=True).stdout
    return [path for path in text.split("\n") if path and os.path.exists(path)]


def crowded(files):
    count = collections.Counter(os.path.dirname(path) for path in files if not path.endswith(".png"))
    for folder, number in sorted(count.items()):
        if number > MOST_FILES and not folder.startswith(FIXTURES):
            yield f"{folder}: holds {number} files (about 30 are allowed)"


def uses(build):
    """File -> files that define a symbol that it wants."""
    defined, wanted = {}, {}
    for folder, _, names in os.walk(build):
        for name in names:
            if not name.endswith(".o") or "/tests" in folder:
                continue
            source = os.path.relpath(os.path.join(folder, name), build)[:-2] + ".c"
            if not os.path.exists(source):
                continue
            for line in subprocess.run(["nm", os.path.join(folder, name)], capture_output=True, text=True).stdout.split("\n"):
                part = line.split()
                if len(part) == 3 and part[1] in "TDBRCV":
                    defined[part[2]] = source
                elif len(part) == 2 and part[0] == "U":
                    wanted.setdefault(source, set()).add(part[1])
    graph = {source: {defined[s] for s in names if s in defined} - {source} for source, names in wanted.items()}
    for source in set(defined.values()):
        graph.setdefault(source, set())
    return graph


def circles(graph):
    """Strongly connected components of more than one file (Tarjan 1972)."""
    index, low, stack, held, found = {}, {}, [], set(), []

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        held.add(v)
        for w in graph[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in held:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            part = []
            while not part or part[-1] != v:
                part.append(stack.pop())
                held.discard(part[-1])
            if len(part) > 1:
                found.append(sorted(part))

    sys.setrecursionlimit(10000)
    for v in sorted(graph):
        if v not in index:
            visit(v)
    return found


def repeated(files):
    where = collections.defaultdict(set)
    for path in files:
        if path.endswith(".c") and not path.startswith("tests/"):
            for match in FUNCTION.finditer(open(path).read()):
                where[match.group(1)].add(path)
    for name, paths in sorted(where.items()):
        if len(paths) > MOST_NAMED:
            yield f"{name}: stands in {len(paths)} files ({', '.join(sorted(paths))})"


def main():
    build = next((a for a in sys.argv[1:] if not a.startswith("-")), "build/release")
    files = listed()
    faults = list(crowded(files)) + list(repeated(files))
    if os.path.isdir(build):
        faults += ["a circle of files: " + ", ".join(part) for part in circles(uses(build))]
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
