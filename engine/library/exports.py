#!/usr/bin/env python3
"""exports.py NAMES BASE LIGHT OUT - the symbols of the two libraries, each of which is one relocatable object.

NAMES is the list that headers.py wrote. Writes OUT.rename, `old new` for every global symbol that either object defines, so that no
name without the prefix is left; OUT.base and OUT.light, the new names that each library gives away: those of the headers, and of the
base also those that the light library uses.
"""
import subprocess, sys


def symbols(path):
    """The global symbols that an object defines, and those that it wants."""
    defined, wanted = set(), set()
    for line in subprocess.run(["nm", "-g", path], capture_output=True, text=True, check=True).stdout.splitlines():
        part = line.split()
        if len(part) == 3:
            defined.add(part[2])
        else:
            wanted.add(part[-1])
    return defined, wanted


def main():
    names, base, light, out = sys.argv[1:5]
    renamed = dict(line.split() for line in open(names))
    base_defines, _ = symbols(base)
    light_defines, light_wants = symbols(light)
    public = set(renamed)
    for name in base_defines | light_defines:
        renamed.setdefault(name, ("ENF_" if name.isupper() else "Enf" if name[0].isupper() else "enf_") + name)
    files = {"rename": [f"{name} {renamed[name]}" for name in base_defines | light_defines],
             "base": [renamed[name] for name in base_defines & (public | light_wants)],
             "light": [renamed[name] for name in light_defines & public]}
    for suffix, lines in files.items():
        with open(f"{out}.{suffix}", "w") as file:
            file.writelines(line + "\n" for line in sorted(lines))


main()
