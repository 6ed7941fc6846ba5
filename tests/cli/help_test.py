"""The --help of every command: synopsis, an example that the program takes as it stands, and the
paper behind the method: help_test.py BEATLAS SOURCE_FOLDER"""
import pathlib
import re
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
# What these do is said in full by their help; no one's method is behind it.
WITHOUT_A_METHOD = {"info", "status", "defaults"}
problems = []


def help_of(*words):
    done = subprocess.run([PROGRAM, *words, "--help"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def part(text, head):
    """The indented lines below a head."""
    found = re.search(rf"^{head}:\n((?:  .*\n?)+)", text, re.MULTILINE)
    return found.group(1) if found else ""


def usage_error(line, folder):
    """What is said if the words of a command are wrong; what it would do is another matter."""
    for name in ("p", "bench", "out"):  # where a folder would be filled: nothing long begins
        (pathlib.Path(folder) / name).touch()
    (pathlib.Path(folder) / "samples").symlink_to(SOURCE / "samples")
    done = subprocess.run([PROGRAM, *line.split()[1:]], cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 2, 3, 5), (line, done)
    return done.stderr if done.returncode == 2 else ""


commands = re.findall(r"^  ([a-z]+) ", help_of().split("Subcommands:")[1], re.MULTILINE)
assert {"build", "segment", "seeds", "defaults"} <= set(commands), commands
for command in commands:
    text = help_of(command)
    synopsis = re.search(rf"^Usage: beatlas {command} (.*)", text, re.MULTILINE)
    if not synopsis:
        problems.append(f"{command}: no synopsis")
        continue
    for required in re.findall(r"^  (--?[a-z-]+).*REQUIRED", text, re.MULTILINE):
        if required not in synopsis.group(1):
            problems.append(f"{command}: {required} is required and not in the synopsis")
    examples = [line.strip() for line in part(text, "Example").splitlines()]
    if not examples:
        problems.append(f"{command}: no example")
    for line in examples:
        if not line.startswith(f"beatlas {command}"):
            problems.append(f"{command}: its example is of another command: {line}")
        with tempfile.TemporaryDirectory(prefix="beatlas-help-") as folder:
            said = usage_error(line, folder)
        if said:
            problems.append(f"{line}\n{said}")
    method = part(text, "Method")
    if command not in WITHOUT_A_METHOD and not re.search(r"\b(19|20)\d\d\b", method):
        problems.append(f"{command}: no paper behind its method")
# The check of examples can fail.
with tempfile.TemporaryDirectory(prefix="beatlas-help-") as folder:
    assert usage_error("beatlas build exam/ --fast", folder)
# The runtime's program, whose options are its command and two others.
PROGRAM = str(pathlib.Path(PROGRAM).parent / "beatlas-play")
for words in ([], ["probe"], ["replay-ticks"], ["sensitivity"]):
    text = help_of(*words)
    synopsis, examples = re.search(r"^Usage: .+", text, re.MULTILINE), part(text, "Example")
    if not synopsis or not examples:
        problems.append(f"beatlas-play {words}: no synopsis or no example")
    for line in examples.splitlines():
        with tempfile.TemporaryDirectory(prefix="beatlas-help-") as folder:
            problems += filter(None, [usage_error(line.strip(), folder)])
if problems:
    sys.exit("\n".join(problems))
