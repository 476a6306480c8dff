#!/usr/bin/env python3
"""headers.py FOLDER NAMES - the public headers, under one prefix.

Puts enfilade.h, enfilade_light.h and all headers that they include into FOLDER, under their own paths, ready for C11 and C++17. Every
name that they declare gets the prefix of its kind, so that a host program may use the short name for something else: `Mesh` becomes
`EnfMesh`, `mesh_build` becomes `enf_mesh_build`, `VIS_TOUCH` becomes `ENF_VIS_TOUCH`. Includes between the headers become
<enfilade/...>. NAMES gets a line `short prefixed` for each of the names: objcopy renames the library's symbols by it.
"""
import os, re, subprocess, sys

ROOTS = ("engine/library/enfilade.h", "engine/library/enfilade_light.h")
WORD = re.compile(r"[A-Za-z_]\w*")
TOKEN = re.compile(r"[A-Za-z_]\w*|\S")
KEYWORDS = set("""void char short int long float double signed unsigned const volatile static inline extern struct enum union typedef
    bool size_t ptrdiff_t return if else for while do switch case default break continue sizeof __attribute__ format printf noreturn
    _Noreturn restrict""".split())


def headers():
    """All headers, each after those that it includes."""
    listed = []
    for root in ROOTS:
        rule = subprocess.run(["gcc", "-MM", "-I.", "-x", "c", root], capture_output=True, text=True, check=True).stdout
        for path in rule.replace("\\\n", " ").split(":", 1)[1].split():
            if path not in listed:
                listed.append(path)
    return listed


def bare(text):
    """The text without comments and strings."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    text = re.sub(r"//[^\n]*", "", text)
    return re.sub(r'"(\\.|[^"\\\n])*"', '""', text)


def declared(text):
    """The names that a header declares at file scope: macros, types, constants, functions, objects."""
    text = bare(text)
    names = set(re.findall(r"^\s*#\s*define\s+(\w+)", text, re.M))
    text = re.sub(r"^\s*#(?:[^\n]*\\\n)*[^\n]*", "", text, flags=re.M)
    for body in re.findall(r"\benum\b[^{;()]*\{([^}]*)\}", text):
        names.update(re.findall(r"(?:^|,)\s*([A-Za-z_]\w*)", body))
    names.update(re.findall(r"\b(?:struct|enum|union)\s+([A-Za-z_]\w*)", text))
    # What is left once bodies are gone: one declaration between semicolons.
    flat, depth = [], 0
    for token in TOKEN.findall(text):
        depth -= token == "}"
        if depth == 0:
            flat.append(";" if token == "}" and flat and flat[-1] == "{" and "(" in statement(flat) else token)
        depth += token == "{"
    for line in " ".join(flat).split(";"):
        words = WORD.findall(line)
        if not words:
            continue
        called = re.search(r"\(\s*\*\s*(\w+)\s*(?:\[[^\]]*\]\s*)?\)", line) if words[0] == "typedef" else None
        if called:
            names.add(called.group(1))
            continue
        found = [w for w in re.findall(r"([A-Za-z_]\w*)\s*\(", line) if w not in KEYWORDS]
        if found:
            names.add(found[0])
        else:
            head = re.split(r"[=\[]", line)[0]
            last = [w for w in WORD.findall(head) if w not in KEYWORDS]
            names.update(last[-1:])
    return {name for name in names if name not in KEYWORDS}


def statement(tokens):
    """The tokens since the last semicolon, as text."""
    last = len(tokens) - 1 - tokens[::-1].index(";") if ";" in tokens else -1
    return " ".join(tokens[last + 1:])


def prefixed(name):
    if name.isupper() or name.endswith("_H"):
        return "ENF_" + name
    return ("Enf" if name[0].isupper() else "enf_") + name


def public(path, text, renamed):
    """The header as it is installed."""
    text = re.sub(r'^#include "(?:engine/library/)?(.*)"', r"#include <enfilade/\1>", text, flags=re.M)
    # Names, but no members, and no part of an include; of comments those that cannot be ordinary words.
    lines = []
    for line in text.split("\n"):
        if not line.startswith("#include"):
            code, slashes, comment = line.partition("//")
            code = re.sub(r"(?<![\w.])(?<!->)[A-Za-z_]\w*", lambda m: renamed.get(m.group(0), m.group(0)), code)
            comment = re.sub(r"\b[A-Za-z]\w*_\w+", lambda m: renamed.get(m.group(0), m.group(0)), comment)
            line = code + slashes + comment
        lines.append(line)
    # C++ is told that the functions are C, from below the includes to the end.
    last = max((i for i, line in enumerate(lines) if line.startswith("#include")), default=None)
    if last is None:
        last = next(i for i, line in enumerate(lines) if line.startswith("#define"))
    end = max(i for i, line in enumerate(lines) if line.startswith("#endif"))
    opened = ["", "#ifdef __cplusplus", 'extern "C" {', "#endif"]
    closed = ["#ifdef __cplusplus", "}", "#endif", ""]
    return "\n".join(lines[:last + 1] + opened + lines[last + 1:end] + closed + lines[end:])


def main():
    folder, list_of_names = sys.argv[1:3]
    texts = {path: open(path).read() for path in headers()}
    names = set().union(*(declared(text) for text in texts.values()))
    renamed = {name: prefixed(name) for name in names}
    for path, text in texts.items():
        place = os.path.join(folder, path.removeprefix("engine/library/"))
        os.makedirs(os.path.dirname(place), exist_ok=True)
        with open(place, "w") as out:
            out.write(public(path, text, renamed))
        os.chmod(place, 0o644)
    with open(list_of_names, "w") as out:
        out.writelines(f"{name} {renamed[name]}\n" for name in sorted(names))


main()
