"""The laws that only a build shows: what the compiler read, and what a program loads."""

import json
import re
import shlex
import subprocess
from pathlib import Path

import rules
from sources import room_of


def parse_dependency_log(text):
    """The output of `ninja -t deps` -> {object: [header, ...]}; outdated entries are left out."""
    objects = {}
    current = None
    for line in text.splitlines():
        if line.startswith("    "):
            if current is not None:
                current.append(line.strip())
            continue
        entry = re.match(r"^(\S.*?): #deps \d+, .*\((VALID|STALE)\)$", line)
        current = objects.setdefault(entry.group(1), []) if entry and entry.group(2) == "VALID" \
            else None
    return objects


def wanted_objects(commands, root):
    """compile_commands.json -> {object: source from the repository root} of the rooms."""
    wanted = {}
    for command in commands:
        source = Path(command["file"])
        if not source.is_absolute():
            source = Path(command["directory"]) / source
        try:
            source = source.relative_to(root).as_posix()
        except ValueError:
            continue
        if room_of(source):
            wanted[_output(command)] = source
    return wanted


def _output(command):
    """The object as the build tool names it; CMake before 3.27 says so in the command only."""
    if "output" in command:
        return command["output"]
    words = command.get("arguments") or shlex.split(command["command"])
    return words[words.index("-o") + 1]


def check_seen(wanted, log, root):
    """@param wanted, log  as the two functions above return them

    A room's object saw no header of a room out of its reach (through others too), and of the
    libraries only those given to its room or to a room it may reach.
    """
    if not any(source.startswith("runtime/") for source in wanted.values()):
        yield "the build compiles nothing in runtime/: nothing could be checked"
    for output, source in sorted(wanted.items()):
        if output not in log:
            yield f"{source}: not compiled, or older than its headers; build everything first"
            continue
        room = room_of(source)
        reach = reachable(room)
        told = set()
        for header in log[output]:
            inside = relative(header, root)
            other = room_of(inside) if inside else None
            if other and other not in reach and other not in told:
                told.add(other)
                yield f"{source}: the compiler read {inside}, and {room} cannot reach {other}"
            for name, library in rules.LIBRARIES.items():
                if inside is None and name not in told and library.header.search(header) \
                        and room not in library.rooms:
                    told.add(name)
                    yield f"{source}: the compiler read {header} of {name}"


def reachable(room):
    """The room, what it may include and what these may: all that can lie under its includes."""
    found = set()
    todo = [room]
    while todo:
        one = todo.pop()
        if one not in found:
            found.add(one)
            todo.extend(rules.ROOMS.get(one, ()))
    return found


def relative(header, root):
    path = Path(header)
    if not path.is_absolute():
        return None  # ninja prints what lies outside the build folder with an absolute path
    try:
        return path.relative_to(root).as_posix()
    except ValueError:
        return None


def check_compiled(root, build):
    """check_seen on a build folder that Ninja has brought up to date."""
    root = Path(root).resolve()
    commands = json.loads(Path(build, "compile_commands.json").read_text(encoding="utf-8"))
    log = subprocess.run(["ninja", "-C", str(build), "-t", "deps"], check=True,
                         capture_output=True, text=True).stdout
    yield from check_seen(wanted_objects(commands, root), parse_dependency_log(log), root)


def parse_ldd(text):
    """The output of ldd -> (names of all libraries, those that were not found)."""
    names, missing = [], []
    for line in text.splitlines():
        found = re.match(r"^\s+(\S+)(?: => (.*?))?(?: \(0x[0-9a-f]+\))?$", line)
        if not found:
            continue
        names.append(Path(found.group(1)).name)
        if found.group(2) == "not found":
            missing.append(found.group(1))
    return names, missing


def check_loaded(program, ldd_output):
    names, missing = parse_ldd(ldd_output)
    if not any(name.startswith("libc.so") for name in names):
        yield f"{program}: ldd lists no C library: nothing could be checked"
    for name in missing:
        yield f"{program}: needs {name}, which is not installed"
    for heavy in rules.HEAVY:
        for name in names:
            if rules.LIBRARIES[heavy].loaded.search(name):
                yield f"{program}: loads {name} of {heavy}"


def check_programs(programs):
    """What a program or library needs at load time, directly or through others."""
    for program in programs:
        listed = subprocess.run(["ldd", program], check=False, capture_output=True, text=True)
        if listed.returncode != 0:
            yield f"{program}: ldd cannot read it: {listed.stderr.strip()}"
            continue
        yield from check_loaded(program, listed.stdout)
