"""The law of what is written: pages name files, tests, commands and options that there are."""

import os
import re
from pathlib import Path

import sources

ROOT_FOLDERS = ("pipeline", "runtime", "schemas", "samples", "scripts", "tests", "docs")
# A room's README names its own files without a folder.
OWN_FILES = (".h", ".cpp", ".py", ".cmake", ".md")
# Program -> the rooms whose literals are its options and subcommands. beatlas-play becomes beatlas-view
# where its words ask for a picture, so it takes the words of both.
PROGRAMS = {"beatlas": ("pipeline/cli",),
            "beatlas-play": ("runtime/app", "runtime/viewer"),
            "beatlas-view": ("runtime/viewer",)}

_CODE_SPAN = re.compile(r"`([^`\n]+)`")
_BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\]\(([^)\s#]+)")
_GTEST = re.compile(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)", re.MULTILINE)
_CASE = re.compile(r"^@case\ndef (\w+)", re.MULTILINE)
_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
_LITERAL = re.compile(r'"((?:\\.|[^"\\\n])*)"')
_SUBCOMMAND = re.compile(r'add_(?:sub)?command\(\s*(?:\w+,\s*)?"([a-z-]+)"')
_PLACE_HOLDER = re.compile(r"[A-Z]{3,}|[<>{}$]|\.\.\.|\bNN")


def pages(root):
    """Everything that tells how things are. Logs tell how they were and are left out."""
    for path in sorted(Path(root).rglob("*.md")):
        name = path.relative_to(root).as_posix()
        if not name.startswith(("build/", ".")) and not name.endswith(("CHANGELOG.md", "CHANGES.md")):
            yield name, path.read_text(encoding="utf-8")


def tests_by_name(root):
    for _, text in sources.source_files(root, ("tests",), (".cpp",)):
        for suite, name in _GTEST.findall(text):
            yield f"{suite}.{name}"
    for path, text in sources.source_files(root, ("tests/import",), (".py",)):
        for name in _CASE.findall(text):
            yield f"import.{Path(path).stem.removesuffix('_test')}.{name}"


def _program_words(root, rooms):
    """(options, subcommands) that the literals of rooms hold."""
    options, subcommands = {"--help", "--version"}, set()
    for _, text in sources.source_files(root, rooms):
        code = sources.without_comments(text)
        subcommands |= set(_SUBCOMMAND.findall(code))
        for literal in _LITERAL.findall(code):
            # As CLI11 has them: "-o,--output", "!--no-caption"; a sentence that names one is none.
            if re.fullmatch(r"!?-[\w,!-]+", literal):
                options |= set(_OPTION.findall(literal.replace(",", " ").replace("!", " ")))
    return options, subcommands


def _script_options(path):
    return set(_OPTION.findall(path.read_text(encoding="utf-8"))) | {"--help"}


def _missing_path(root, page, word):
    """The path that a word means and that is not there; None where it is there or is no path."""
    word = word.rstrip("/.,:;")
    if _PLACE_HOLDER.search(word):
        return None
    first = word.split("/")[0]
    if first in ROOT_FOLDERS and "/" in word:
        return None if any(Path(root).glob(word)) else word
    if Path(page).parts[0] in ROOT_FOLDERS and Path(word).suffix in OWN_FILES \
            and re.fullmatch(r"[\w/.-]+", word):
        here = Path(root, page).parent
        there = [here / word, Path(root) / word, *here.rglob(word)]
        return None if any(path.exists() for path in there) else word
    return None


def _commands(line):
    """The commands of a line of shell, each as its words, without comments and variables set before it."""
    line = re.sub(r"(^|\s)#.*", "", line)
    for part in re.split(r"&&|\|\||[|;]", line):
        words = part.split()
        while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]):
            words.pop(0)
        if words:
            yield words


class _House:
    def __init__(self, root):
        self.root = Path(root)
        self.tests = set(tests_by_name(root))
        self.suites = {test.rsplit(".", 1)[0] for test in self.tests}
        self.programs = {name: _program_words(root, rooms) for name, rooms in PROGRAMS.items()}
        self.programs["beatlas-play"][1].add("PACKAGE")
        self.options = set().union(*(options for options, _ in self.programs.values()))
        for path in sorted(self.root.glob("scripts/*")):
            if path.is_file() and path.suffix != ".md":
                self.options |= _script_options(path)

    def command(self, words, called):
        """@param called: it stands in a block that a reader copies, not in a sentence"""
        name = words[0]
        options = {found for word in words[1:] for found in _OPTION.findall(word.split("=")[0])}
        if name in self.programs:
            known, subcommands = self.programs[name]
            if name == "beatlas" and len(words) > 1 and re.fullmatch(r"[a-z]+", words[1]) \
                    and words[1] not in subcommands:
                yield f"beatlas has no command {words[1]}"
            for option in sorted(options - known):
                yield f"{name} has no option {option}"
        elif re.match(r"(scripts|samples)/[\w/]+(\.py)?$", name):
            path = self.root / name
            if not path.exists():
                yield f"there is no {name}"
            elif path.is_file() and (called or options):
                if called and not os.access(path, os.X_OK):
                    yield f"{name} cannot be called: it is not executable"
                if len(words) > 1 and words[-1] != "--":
                    for option in sorted(options - _script_options(path)):
                        yield f"{name} has no option {option}"

    def options_of_page(self, page, text):
        """Those of our programs; of what lies in the page's own folder; of others' programs in its blocks."""
        options = set(self.options)
        folder = Path(self.root, page).parent
        if folder != self.root:
            for path in sorted(folder.rglob("*")):
                if path.suffix in (".py", ".cpp") and path.is_file():
                    options |= set(_OPTION.findall(path.read_text(encoding="utf-8")))
        for block in _BLOCK.finditer(text):
            for _, line in _shell_lines(block.group(1)):
                for words in _commands(line):
                    if words[0] not in self.programs and "/" not in words[0]:
                        options |= {found for word in words for found in _OPTION.findall(word)}
        return options

    def span(self, page, span, options):
        first = span.split()[0] if span.split() else ""
        missing = _missing_path(self.root, page, first)
        if missing:
            yield f"there is no {missing}"
            return
        if first in self.programs or (" " in span and re.match(r"(scripts|samples)/", first)):
            for words in _commands(span):
                yield from self.command(words, called=False)
        elif span.startswith("--"):
            for option in sorted(set(_OPTION.findall(span)) - options):
                yield f"no program of ours has an option {option}"
        elif re.fullmatch(r"\w+(\.\w+)+", span) and span.rsplit(".", 1)[0] in self.suites:
            if span not in self.tests:
                yield f"there is no test {span}"
        elif re.fullmatch(r"[A-Z]\w+\.[A-Z]\w+", span):
            yield f"there is no test {span}"


def _line(text, at):
    return text.count("\n", 0, at) + 1


def check_documents(root):
    """What pages name in code spans, links and blocks of shell is there: files, tests, commands, options."""
    house = _House(root)
    for page, text in pages(root):
        prose = re.sub(r"^```.*?^```", lambda block: "\n" * block.group(0).count("\n"), text,
                       flags=re.MULTILINE | re.DOTALL)
        options = house.options_of_page(page, text)
        for found in _CODE_SPAN.finditer(prose):
            for broken in house.span(page, found.group(1), options):
                yield f"{page}:{_line(prose, found.start())}: {broken}"
        for found in _LINK.finditer(prose):
            target = found.group(1)
            if "://" not in target and not Path(root, page).parent.joinpath(target).exists():
                yield f"{page}:{_line(prose, found.start())}: there is no {target}"
        for block in _BLOCK.finditer(text):
            # A line that ends with a backslash goes on in the next.
            for at, line in _shell_lines(block.group(1)):
                for words in _commands(line):
                    for broken in house.command(words, called=True):
                        yield f"{page}:{_line(text, block.start(1)) + at}: {broken}"


def _shell_lines(block):
    begun, whole = 0, ""
    for number, line in enumerate(block.split("\n")):
        if not whole:
            begun = number
        if line.endswith("\\"):
            whole += line[:-1] + " "
            continue
        yield begun, whole + line
        whole = ""
