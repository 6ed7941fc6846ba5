"""How large and how tangled a room is: modules, knots of includes, named constants, long functions."""

import re
from collections import defaultdict

import rules
import sources

_CONSTANT = re.compile(r"\bconst(?:expr|init)\s+(?:[\w:<>,*& ]+\s)?k[A-Z]\w*\s*[={(\[]")
_BLANKED = re.compile(r'R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^[ \t]*#(?:\\\n|[^\n])*',
                      re.DOTALL | re.MULTILINE)
_BEFORE = re.compile(r"^\s*(?:(?:public|private|protected)\s*:)?\s*(?:template\s*<(?:[^<>]|<[^<>]*>)*>)?")
_SPACE = re.compile(r"\b(?:namespace|struct|class|enum|union|extern)\b")


def functions(text):
    """(first line, lines) of each function's definition."""
    code = _BLANKED.sub(lambda found: "\n" * found.group(0).count("\n"), sources.without_comments(text))
    blocks = []  # (line on which it begins, whether it is a function, whether functions may stand in it)
    since = 0    # where the statement begins
    for found in re.finditer(r"[{};]", code):
        at, sign = found.span()[0], found.group(0)
        statement = code[since:at]
        if sign == "{":
            head = _BEFORE.sub("", statement).strip()
            spaced = statement[-1:].isspace()  # braces of an initializer stand at the word
            place = not blocks or blocks[-1][2]
            space = bool(_SPACE.search(head.split("(")[0])) and "=" not in head
            function = place and spaced and not space and "(" in head and not head.endswith(("=", ",", "("))
            if place and (not spaced or head.endswith("=") and "(" in head):
                blocks.append((0, False, False))
                continue  # the statement goes on behind it
            line = code.count("\n", 0, since + len(statement) - len(statement.lstrip())) + 1
            blocks.append((line, function, place and space))
        elif sign == "}" and blocks:
            line, function, _ = blocks.pop()
            if line == 0:
                continue
            if function:
                yield line, code.count("\n", 0, at) + 2 - line
        since = at + 1


def knots(room, files):
    """Sets of modules of a room (a .h with its .cpp) that include each other round a circle."""
    arrows = defaultdict(set)
    for path, text in files:
        module = path.rsplit(".", 1)[0]
        arrows[module] |= {name.rsplit(".", 1)[0] for _, name, _ in sources.includes(text)
                           if name.startswith(f"{room}/")} - {module}
    index, low, stack, found = {}, {}, [], []

    def visit(module):
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(arrows.get(module, ())):
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            knot = set()
            while not knot or module not in knot:
                knot.add(stack.pop())
            if len(knot) > 1:
                found.append(knot)

    for module in sorted(arrows):
        if module not in index:
            visit(module)
    return found


def counted(root):
    """Room -> its figures."""
    by_room = defaultdict(list)
    for path, text in sources.source_files(root, ("pipeline", "runtime")):
        by_room[sources.room_of(path)].append((path, text))
    for room in sorted(by_room):
        files = by_room[room]
        lines = sum(text.count("\n") for _, text in files)
        constants = sum(len(_CONSTANT.findall(sources.without_comments(text))) for _, text in files)
        lengths = [(length, f"{path}:{first}") for path, text in files for first, length in functions(text)]
        longest, place = max(lengths, default=(0, ""))
        yield room, {"modules": len({path.rsplit(".", 1)[0] for path, _ in files}), "lines": lines,
                     "constants": constants, "constants a 1000 lines": round(1000 * constants / max(lines, 1), 1),
                     "knot": max((len(knot) for knot in knots(room, files)), default=1),
                     "functions over 60 lines": sum(length > 60 for length, _ in lengths),
                     "longest function": longest, "where": place}


def check_counts(root):
    """Prints the figures of each room; none may be over what rules.MOST allows."""
    print("room modules lines constants /1000 knot >60 longest")
    for room, figures in counted(root):
        print(room, *figures.values())
        for name, most in rules.MOST.items():
            allowed = most.get(room, most[""]) if isinstance(most, dict) else most
            if figures[name] > allowed:
                yield f"{room}: {name}: {figures[name]}, more than {allowed}"
