#!/usr/bin/env python3
"""check_words.py - the words that people read first, held to their bounds; part of `make lint`.

  - README.md has at most MOST_WORDS words, code blocks and targets of links aside;
  - no sentence of a .md file has more than LONGEST_SENTENCE words; code blocks, tables and targets of links aside;
  - at most MOST_HEADLESS comments of .c and .h files begin with one of HEADLESS: they lack a subject;
  - at most MOST_LONG_LINES lines of .c and .h files have more than LONGEST_LINE columns;
  - every function in a header that the library installs, but MOST_UNDOCUMENTED, has a comment above it (engine/library/headers.py says
    which headers);
  - comments and .md files name only source files that are there, but for those of ELSEWHERE;
  - the first line of a source file names the file.

Prints each fault with its place, and exits with 1 if there is any. `--all` lists those that are still allowed, too.
"""
import os, re, subprocess, sys

MOST_WORDS = 1200
LONGEST_SENTENCE = 35
HEADLESS = ("What", "Of")
LONGEST_LINE = 140
NAMED = re.compile(r"(?<![\w/.*-])((?:[\w-]+/)*[a-z_0-9]+\.(?:c|h|md))\b")
ELSEWHERE = {"stdio.h", "example.c", "enfilade/enfilade.h"}
# Faults that the tree still has. These may only fall, and end at 0.
MOST_HEADLESS = 0
MOST_LONG_LINES = 0
MOST_UNDOCUMENTED = 0
FENCE = re.compile(r"^( {0,3})(```|~~~)")
ITEM = re.compile(r"^\s*([-*+]|\d+\.)\s+")
# The end of a sentence: a full stop, unless an abbreviation, before a blank and the beginning of the next one.
END = re.compile(r"(?<!\bet al)(?<!\be\.g)(?<!\bi\.e)(?<!\bvs)(?<!\b[A-Z])[.!?][)*_\"']*\s+(?=[A-Z0-9`*_(\[\"'.])")


def listed(*endings):
    text = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True, check=True).stdout
    return [path for path in text.split("\n") if path.endswith(endings) and os.path.exists(path)]


def paragraphs(text):
    """(line number, words) of each paragraph, item, heading and row of a table; a row begins with `|`. Code blocks are left out."""
    at, kept, fenced = 0, "", False
    for number, line in enumerate(text.split("\n") + [""], 1):
        bare = line.strip()
        if FENCE.match(line):
            fenced = not fenced
            bare = ""
        elif fenced or (not kept and line.startswith("    ") and not ITEM.match(line)):
            bare = ""
        if not bare or bare[0] in "#|" or ITEM.match(line) or kept[:1] in ("#", "|"):
            if kept:
                yield at, kept
            at, kept = number, ""
        if bare:
            kept = f"{kept} {bare}" if kept else bare
            at = at if kept != bare else number
    if kept:
        yield at, kept


def readable(text):
    """The words that a reader sees: pictures and links by their texts, code in a line as one word."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"^\s*([-*+]|\d+\.|#+)\s+", "", text)


def words(text):
    return [word for word in text.split() if re.search(r"\w", word)]


def long_sentences(path, text):
    for line, paragraph in paragraphs(text):
        if paragraph.startswith("|"):
            continue
        prose = re.sub(r"`[^`]*`", lambda code: "`" + re.sub(r"[^\w]", "_", code.group()[1:-1]) + "`", readable(paragraph))
        for sentence in END.split(prose):
            if len(words(sentence)) > LONGEST_SENTENCE:
                yield f"{path}:{line}: a sentence has {len(words(sentence))} words (at most {LONGEST_SENTENCE}): {sentence[:60]}..."


def too_many_words(path, text):
    count = sum(len(words(readable(paragraph))) for _, paragraph in paragraphs(text))
    if count > MOST_WORDS:
        yield f"{path}: has {count} words (at most {MOST_WORDS})"


def headless(files):
    """The comments of .c and .h files whose first word is one of HEADLESS."""
    first = re.compile(r"//+\s*(%s)\b" % "|".join(HEADLESS))
    for path in files:
        before = ""
        for number, line in enumerate(open(path, errors="replace"), 1):
            found = first.search(line)
            # A comment that goes on from the line above begins no sentence here.
            if found and not (line.lstrip().startswith("//") and before.startswith("//") and not before.rstrip().endswith((".", ":"))):
                yield f"{path}:{number}: {line.strip()[:90]}"
            before = line.lstrip()


def long_lines(files):
    for path in files:
        for number, line in enumerate(open(path, errors="replace"), 1):
            if len(line.rstrip("\n")) > LONGEST_LINE:
                yield f"{path}:{number}: has {len(line) - 1} columns (at most {LONGEST_LINE})"


def gone(path, names):
    """Source files that a comment, or the text of a .md file, names and that are not there."""
    for number, line in enumerate(open(path, errors="replace"), 1):
        words = line if path.endswith(".md") else line[line.find("//"):] if "//" in line else ""
        for name in NAMED.findall(words):
            if (name if "/" in name else os.path.basename(name)) not in names:
                yield f"{path}:{number}: names {name}, which is not there"


def unnamed(files):
    for path in files:
        if not open(path, errors="replace").readline().startswith(f"// {os.path.basename(path)} - "):
            yield f"{path}:1: does not begin with `// {os.path.basename(path)} - `"


def installed_headers():
    """The project's headers that engine/library/headers.py installs, by the same question to the compiler."""
    text = subprocess.run(["gcc", "-MM", "-I.", "-x", "c", "engine/library/enfilade_light.h"], capture_output=True, text=True, check=True).stdout
    return [path for path in text.replace("\\\n", " ").split(":", 1)[1].split() if not path.startswith("engine/library/")]


def undocumented(path):
    """Functions of a header without a comment above them. A comment stands for all that follow it without a blank line."""
    text = open(path).read()
    commented, depth, statement = False, 0, ""
    for number, line in enumerate(text.split("\n"), 1):
        bare = line.strip()
        code = re.sub(r"//.*", "", bare).strip()
        if not bare:
            commented = False
        if bare.startswith("//") and depth == 0 and not statement:
            commented = True
        if bare.startswith("#") or not code:
            continue
        before = depth
        depth += code.count("{") - code.count("}")
        if before or (depth and not code.endswith("{")):
            continue
        statement = f"{statement} {code}".strip()
        if not statement.endswith((";", "{", "}")):
            continue
        found = re.match(r"^(?!typedef\b|struct\b\s+\w+\s*\{|enum\b|extern\b|_Static_assert|return\b)[\w\s*]*?\b(\w+)\s*\(", statement)
        if found and not commented and "//" not in bare:
            yield f"{path}:{number}: {found.group(1)} has no comment above it"
        statement = ""


def main():
    faults = []
    for path in listed(".md"):
        text = open(path).read()
        faults += long_sentences(path, text)
        if path == "README.md":
            faults += too_many_words(path, text)
    sources = listed(".c", ".h")
    names = {part for path in listed("") for part in (path, os.path.basename(path))} | ELSEWHERE
    names |= {"/".join(path.split("/")[at:]) for path in listed(".c", ".h", ".md") for at in range(1, path.count("/") + 1)}
    faults += [fault for path in listed(".c", ".h", ".md") for fault in gone(path, names)]
    faults += unnamed(sources)
    bare = [fault for path in installed_headers() for fault in undocumented(path)]
    counted = (list(headless(sources)), MOST_HEADLESS, f"comments begin with {' or '.join(HEADLESS)}"), \
              (list(long_lines(sources)), MOST_LONG_LINES, "lines are too long"), \
              (bare, MOST_UNDOCUMENTED, "public functions have no comment")
    for found, most, sentence in counted:
        if len(found) > most or "--all" in sys.argv[1:]:
            print("\n".join(found))
        if len(found) > most:
            faults.append(f"{len(found)} {sentence} (at most {most})")
    print("\n".join(faults) if faults else "check_words: no fault")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
