"""Runs one line of cases.txt: run_case.py BEATLAS SOURCE_FOLDER NAME"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def find_case(name):
    for line in (pathlib.Path(__file__).parent / "cases.txt").read_text().splitlines():
        if re.match(rf"{name} *\|", line):
            _, code, command, wanted = (part.strip() for part in line.split(" |", 3))
            return int(code.strip("| ")), command.strip("| "), wanted.strip("| ")
    sys.exit(f"no case {name}")


def main():
    program, source, name = sys.argv[1:4]
    code, command, wanted = find_case(name)
    environment = dict(os.environ, SAMPLES=f"{source}/samples", LC_ALL="C",
                       MODELS=f"{source}/tests/unit/prior/models",
                       PATH=f"{pathlib.Path(program).parent}:{os.environ['PATH']}")
    with tempfile.TemporaryDirectory(prefix="beatlas-cli-") as folder:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment,
                              capture_output=True, text=True, timeout=50)
        packages = list(pathlib.Path(folder).rglob("*.beatlas"))
        leftovers = [p for p in pathlib.Path(folder).rglob("*") if "partial" in p.name]
    problems = []
    if done.returncode != code:
        problems.append(f"exit code {done.returncode}, expected {code}")
    if not wanted:
        problems.append("the case wants nothing: whatever went wrong would pass")
    for want in filter(None, re.split(r"  +", wanted)):
        stream, pattern = want.split(":", 1)
        text = {"out": done.stdout, "err": done.stderr}[stream]
        if not re.search(pattern, text, re.MULTILINE):
            problems.append(f"{stream} lacks {pattern}")
    if leftovers:
        problems.append(f"left behind: {leftovers}")
    if code != 0:
        if done.stdout:
            problems.append("data was printed")
        if packages:
            problems.append("a package was left")
        if not done.stderr.strip():
            problems.append("nothing was said")
    if code in (2, 3, 4, 5):
        said = [line for line in done.stderr.splitlines() if line.startswith("beatlas: ")]
        if len(said) != 1 or "unexpected trouble" in said[0]:
            problems.append("not one sentence after 'beatlas: '")
    if problems:
        sys.exit("\n".join([f"$ {command}", *problems, "--- stdout", done.stdout,
                            "--- stderr", done.stderr]))


main()
