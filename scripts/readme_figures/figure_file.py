"""docs/figures.json, and the parts of pages that are written from it.

Every set has the commands that were run and the values that they gave, as numbers; its text is made of the values by
the set's own `text`, here as in a check, so a page and the file cannot differ unnoticed.
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


def _marks_are_paired(page):
    marks = _MARK.findall(page)
    return all(mark != "end" for mark in marks[::2]) and all(mark == "end" for mark in marks[1::2]) \
        and len(marks) % 2 == 0


def text_of(name, kept, sets):
    return sets[name].text(kept[name]["values"])


def _part_differs(wanted, stated):
    """The first pair of lines (wanted, stated) that differ; None where none does."""
    wanted, stated = wanted.splitlines(), stated.splitlines()
    pairs = zip(wanted + [""] * len(stated), stated + [""] * len(wanted))
    return next(((a, b) for a, b in pairs if a != b), None)


def differences(pages, kept, sets):
    """Sentences; none where the pages state what the file holds, all of it and nothing else.

    @param pages: name of each page -> its text; a set may stand on several
    """
    wrong, found = [], set()
    for page, text in pages.items():
        if not _marks_are_paired(text):
            wrong.append(f"the marks of {page} are not in pairs, <!-- figures: NAME --> and <!-- figures: end -->")
            continue
        for name, stated in _PART.findall(text):
            found.add(name)
            if name not in sets:
                wrong.append(f"{page} has a part {name} that no set makes")
            elif name in kept:
                differs = _part_differs(text_of(name, kept, sets), stated)
                if differs:
                    wrong.append(f"{page} states of {name} {differs[1]!r}, the file {differs[0]!r}")
    wrong += [f"the file has no set {name}" for name in sets if name not in kept]
    wrong += [f"no page has a part for the set {name}" for name in sets if name not in found]
    wrong += [f"the file has a set {name} that is none" for name in kept if name not in sets]
    return wrong


def written(page, kept, sets):
    """A page with the text of every set that the file holds; what stands outside of the marks stays."""
    def fill(found):
        name = found.group(1)
        if name not in kept or name not in sets:
            return found.group(0)
        return f"{BEGIN.format(name)}\n{text_of(name, kept, sets)}\n{END}"
    return _PART.sub(fill, page)
