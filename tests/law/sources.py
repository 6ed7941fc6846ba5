"""The laws that the text of the sources shows: arrows, libraries, public headers, order, scratch."""

import re
from pathlib import Path

import rules

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
# Comments and literals, so that a comment's word or a string's text is no finding.
_NO_CODE = re.compile(r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])'""", re.DOTALL)

_LITERAL = re.compile(r'"(?:\\.|[^"\\\n])*"')


def without_comments(text):
    def blank(match):
        found = match.group(0)
        return "\n" * found.count("\n") if found.startswith("/") else found

    return _NO_CODE.sub(blank, text)


def includes(text):
    """(line, path, quoted) of every #include outside comments."""
    code = without_comments(text)
    for match in _INCLUDE.finditer(code):
        line = code.count("\n", 0, match.start(0)) + 1
        yield line, match.group(1) or match.group(2), match.group(1) is not None


def room_of(path):
    """'pipeline/core/grid.h' -> 'pipeline/core'; None outside the rooms."""
    parts = path.split("/")
    return "/".join(parts[:2]) if len(parts) > 2 and parts[0] in ("pipeline", "runtime") else None


def source_files(root, folders, suffixes=(".h", ".cpp")):
    for folder in folders:
        for path in sorted(Path(root, folder).rglob("*")):
            if path.is_file() and path.suffix in suffixes and "__pycache__" not in path.parts:
                yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")


def rooms(root):
    """The rooms that exist: every folder of pipeline/ and runtime/ that holds a file."""
    for house in ("pipeline", "runtime"):
        for path in sorted(Path(root, house).glob("*/")):
            if any(child.is_file() for child in path.rglob("*")):
                yield f"{house}/{path.name}"


def check_arrows(root):
    """A room includes only from itself and the rooms that rules.ROOMS names for it."""
    for room in rooms(root):
        if room not in rules.ROOMS:
            yield f"{room}: the room is not in rules.ROOMS; say there what it may reach"
    for path, text in source_files(root, ("pipeline", "runtime")):
        room = room_of(path)
        for line, target, quoted in includes(text):
            where = f"{path}:{line}"
            if quoted and room_of(target) is None:
                yield f'{where}: "{target}" is not written from the repository root'
                continue
            other = room_of(target)
            if other is None or other == room:
                continue
            if other not in rules.ROOMS.get(room, ()):
                yield f"{where}: {room} may not include from {other}"
            if not quoted:
                yield f"{where}: write our own header <{target}> in quotes"


def check_libraries(root):
    """A library is included only in the rooms that rules.LIBRARIES names for it."""
    for path, text in source_files(root, ("pipeline", "runtime")):
        for line, target, _ in includes(text):
            for name, library in rules.LIBRARIES.items():
                if library.include.search(target) and room_of(path) not in library.rooms:
                    yield f"{path}:{line}: {name} ({target}) belongs to {', '.join(library.rooms)}"


def public_headers(root):
    """Headers that anyone outside their room reads, directly or through others.

    Those of the runtime's core all are, because trainers outside this repository include them. A
    header that stays within its room is the room's own affair.
    """
    reads = {path: {target for _, target, _ in includes(text)}
             for path, text in source_files(root, ("pipeline", "runtime"))}
    found = {path for path in reads if path.startswith("runtime/") and path.endswith(".h")
             and room_of(path) not in rules.OUTSIDE_THE_CORE}
    todo = [target for path, targets in reads.items() for target in targets
            if target in reads and room_of(target) != room_of(path)]
    while todo:
        header = todo.pop()
        if header not in found:
            found.add(header)
            todo.extend(target for target in reads[header] if target in reads)
    return found


def check_public_headers(root):
    """No header that is read outside its room includes or names the types of a library."""
    for path in sorted(public_headers(root)):
        text = Path(root, path).read_text(encoding="utf-8")
        for line, target, _ in includes(text):
            for name, library in rules.LIBRARIES.items():
                if library.include.search(target):
                    yield f"{path}:{line}: public header includes {name} ({target})"
        code = without_comments(text)
        for name, library in rules.LIBRARIES.items():
            found = library.types.search(code)
            if found:
                line = code.count("\n", 0, found.start()) + 1
                yield f"{path}:{line}: public header names {name}'s {found.group(0)}"


def check_order(root):
    """Every room has a README; no source file is too long to be read in one go."""
    for room in rooms(root):
        readme = Path(root, room, "README.md")
        if not readme.is_file() or len(readme.read_text(encoding="utf-8").split()) < 10:
            yield f"{room}: has no README.md that says what the room is for"
    for path, text in source_files(root, rules.SOURCE_FOLDERS, (".h", ".cpp", ".py", ".cmake")):
        lines = text.count("\n")
        if lines > rules.MAX_LINES:
            yield f"{path}: {lines} lines, more than {rules.MAX_LINES}; one concept a file"


_TEST_NAME = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)", re.MULTILINE)


def check_test_names(root):
    """Suites and tests are named alike: words that begin with capitals."""
    for path, text in source_files(root, ("tests",), (".cpp",)):
        for found in _TEST_NAME.finditer(text):
            for name in found.groups():
                if not name[0].isupper() or "_" in name:
                    line = text.count("\n", 0, found.start()) + 1
                    yield f"{path}:{line}: {name}: name it in CamelCase, as the others are"


_MACHINE_PATH = re.compile(r'"/(?:tmp|home|root|work|mnt|media|Users)/')
_SAYS = re.compile(r"\bgetenv\b|\bv?f?printf\s*\(|\bf?puts\s*\(|\bstd::c(?:out|err|log)\b")


def check_scratch(root):
    """No room but those that speak to a person prints or reads the environment; no path of one
    machine stands in a source."""
    for path, text in source_files(root, ("pipeline", "runtime")):
        for number, line in enumerate(without_comments(text).split("\n"), 1):
            machine = _MACHINE_PATH.search(line)
            if machine:
                yield f"{path}:{number}: a path of one machine: {machine.group(0)[1:]}"
            says = None if room_of(path) in rules.SPEAKS else _SAYS.search(_LITERAL.sub('""', line))
            if says:
                yield (f"{path}:{number}: {says.group(0)} belongs to {', '.join(rules.SPEAKS)}; "
                       "left from a search for a mistake?")
