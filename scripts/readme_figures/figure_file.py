"""docs/figures.json, and the parts of README.md that are written from it.

Every set has the commands that were run and the values that they gave, as numbers; its text is made of the values by
the set's own `text`, here as in a check, so README.md and the file cannot differ unnoticed.
"""
import json
import re

BEGIN, END = "<!-- figures: {} -->", "<!-- figures: end -->"
_PART = re.compile(r"<!-- figures: (?!end)([a-z_]+) -->\n(.*?)<!-- figures: end -->", re.DOTALL)
_MARK = re.compile(r"<!-- figures: ([a-z_]+) -->")


def read(file):
    return json.loads(file.read_text()) if file.exists() else {}


def keep(file, name, made):
    """Puts one set into the file and leaves the others."""
    sets = read(file)
    sets[name] = made
    file.write_text(json.dumps(dict(sorted(sets.items())), indent=1) + "\n")


def _parts(readme):
    return {name: text for name, text in _PART.findall(readme)}


def _marks_are_paired(readme):
    marks = _MARK.findall(readme)
    return all(mark != "end" for mark in marks[::2]) and all(mark == "end" for mark in marks[1::2]) \
        and len(marks) % 2 == 0


def text_of(name, kept, sets):
    return sets[name].text(kept[name]["values"])


def differences(readme, kept, sets):
    """Sentences; none where README.md states what the file holds, all of it and nothing else."""
    if not _marks_are_paired(readme):
        return ["the marks of README.md are not in pairs, <!-- figures: NAME --> and <!-- figures: end -->"]
    parts, wrong = _parts(readme), []
    for name in sets:
        if name not in kept:
            wrong.append(f"the file has no set {name}")
        elif name not in parts:
            wrong.append(f"README.md has no part for the set {name}")
        else:
            wanted = text_of(name, kept, sets).splitlines()
            stated = parts[name].splitlines()
            if wanted != stated:
                pairs = zip(wanted + [""] * len(stated), stated + [""] * len(wanted))
                first = next((a, b) for a, b in pairs if a != b)
                wrong.append(f"README.md states of {name} {first[1]!r}, the file {first[0]!r}")
    wrong += [f"README.md has a part {name} that no set makes" for name in parts if name not in sets]
    wrong += [f"the file has a set {name} that is none" for name in kept if name not in sets]
    return wrong


def written(readme, kept, sets):
    """README.md with the text of every set that the file holds; what stands outside of the marks stays."""
    def fill(found):
        name = found.group(1)
        if name not in kept or name not in sets:
            return found.group(0)
        return f"{BEGIN.format(name)}\n{text_of(name, kept, sets)}\n{END}"
    return _PART.sub(fill, readme)
