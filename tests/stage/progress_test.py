"""What a long command shows of itself, and that the interrupt key stops it: progress_test.py BEATLAS
WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py; the exam and package are those of study_test.py's `prepare`.
"""
import fcntl
import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
import time

import jsonschema

from stage_test import PROGRAM, WORK, beatlas, expect_same, new_folder
from study_stops_test import no_half_files
from study_test import EXAM, PACKAGE, RECIPE, SCHEMAS

STAGES = ("import", "segment", "pictures", "register", "field", "mesh", "pack")
# Of processor time, that a busy machine does not lengthen: what stops cleanly within a second.
SECOND = 1.0


def paused(process, seconds):
    process.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    process.send_signal(signal.SIGCONT)


def on_a_terminal(words, columns):
    """What a command writes to a terminal of that width, and its exit code. Every stage is held up
    for longer than it may be silent and than a guess of the time left needs, so that what is shown
    does not depend on the machine's speed."""
    main, other = pty.openpty()
    fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen([PROGRAM, *map(str, words)], stdin=other, stdout=subprocess.DEVNULL,
                               stderr=other)
    os.close(other)
    said, lines_of = b"", {}
    while True:
        try:
            piece = os.read(main, 65536)
        except OSError:  # the other side is closed
            break
        if not piece:
            break
        said += piece
        for stage in re.findall(rb"\x1b\[K(\w+) \d+ %", piece):
            lines_of[stage] = lines_of.get(stage, 0) + 1
            if lines_of[stage] <= 4:
                paused(process, 1.1 if lines_of[stage] == 1 else 0.15)
    os.close(main)
    return process.wait(), said.decode()


def shown():
    """On a terminal a line that is written over: stage, percent, what it works on; it fits."""
    code, said = on_a_terminal(("build", EXAM, "-o", WORK / "shown.beatlas", "--recipe", RECIPE), 60)
    assert code == 0, said
    lines = [line for line in re.split(r"\r\x1b\[K|\r?\n", said) if line]
    for stage in ("segment", "register", "field", "mesh", "pack"):
        mine = [line for line in lines if re.match(rf"{stage} \d+ %", line)]
        percents = [int(re.match(r"\w+ (\d+)", line).group(1)) for line in mine]
        assert percents and percents == sorted(percents), (stage, percents)
    progress = [line for line in lines if re.match(r"\w+ \d+ %", line)]
    assert all(len(line) < 60 for line in progress), progress
    assert any(re.search(r"\(.*phase \d+ of \d+", line) for line in progress), progress
    assert any(re.search(r"\d+ s left", line) for line in progress), progress
    # What stays behind is the log alone: the last of the line is wiped.
    after = said.rsplit("\x1b[K", 1)[1]
    assert not re.search(r"\d %", after), after


def lines():
    """For other programs: JSON lines that follow their schema, shares that never fall; else quiet."""
    schema = jsonschema.Draft202012Validator(
        json.loads((SCHEMAS / "progress.schema.json").read_text()))
    words = ("build", EXAM, "-o", WORK / "lines.beatlas", "--recipe", RECIPE)
    done = beatlas(*words, "--json")
    assert done.stdout == ""
    expect_same(PACKAGE, WORK / "lines.beatlas")
    events = [json.loads(line) for line in done.stderr.splitlines()]
    for event in events:
        schema.validate(event)
    assert [e["stage"] for e in events if e["event"] == "begin"] == [
        stage for stage in STAGES if stage != "pictures"]
    assert [e["stage"] for e in events if e["event"] == "done"] == [
        stage for stage in STAGES if stage != "pictures"]
    assert events[-1] == {"event": "end", "exit_code": 0, "text": ""}, events[-1]
    stage, share = None, 0
    for event in events:
        if event["event"] == "begin":
            assert stage is None
            stage, share, steps = event["stage"], 0, 0
        elif event["event"] == "progress":
            assert event["stage"] == stage and event["share"] >= share, event
            share, steps = event["share"], steps + 1
        elif event["event"] == "done":
            assert event["stage"] == stage
            # A stage that takes a while tells often how far it is, to beyond its middle.
            assert stage == "import" or (steps >= 5 and share > 0.5), (stage, steps, share)
            stage = None
    assert {e["event"] for e in events} >= {"begin", "progress", "done", "note", "end"}

    quiet = beatlas(*words).stderr
    assert all(line.startswith(("beatlas: warning: ", "beatlas: import: "))
               for line in quiet.splitlines()), quiet

    # Figures on stdout, progress on stderr, of a command whose figures are JSON, too.
    done = beatlas("validate", WORK / "lines.beatlas", "--json")
    assert json.loads(done.stdout)["passed"]
    for line in done.stderr.splitlines():
        schema.validate(json.loads(line))


def begun(process, stage, share):
    """Reads the JSON lines of a command until it is that far in the stage."""
    for line in process.stderr:
        event = json.loads(line)
        assert event["event"] != "end", event
        if (event["event"] in ("begin", "progress") and event["stage"] == stage
                and event.get("share", 0) >= share):
            return
    raise AssertionError(f"it ended before {share} of {stage}")


def cpu_s(pid):
    fields = open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def interrupt():
    """The interrupt key in the middle of any stage: it stops soon, and the same command goes on to the
    bytes of an undisturbed build."""
    # A folder of its own: other tests write packages beside each other at the same time.
    folder, package = new_folder("interrupt"), new_folder("interrupt_package") / "interrupt.beatlas"
    package.parent.mkdir()
    words = [PROGRAM, "build", str(EXAM), "-o", str(package), "--study", str(folder),
             "--recipe", str(RECIPE), "--json", "--threads", "1"]
    for stage, share in (("segment", 0.3), ("field", 0), ("field", 0.5), ("mesh", 0.1), ("mesh", 0.6),
                         ("pack", 0), ("pack", 0.8)):  # before it is written, and while it is checked
        process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        begun(process, stage, share)
        before = cpu_s(process.pid)
        process.send_signal(signal.SIGINT)
        events = [json.loads(line) for line in process.stderr]
        _, status, usage = os.wait4(process.pid, 0)
        spent = usage.ru_utime + usage.ru_stime - before
        print(f"{stage} at {share}: {spent:.2f} s")
        assert os.waitstatus_to_exitcode(status) == 5, events
        assert events[-1]["exit_code"] == 5 and "stopped on request" in events[-1]["text"], events
        assert spent < SECOND, (stage, share, spent)
        assert not package.exists()
        for place in (folder, package.parent):
            assert not list(place.rglob(".partial*")), "half written"
        no_half_files(folder, package)
    done = beatlas(*words[1:])
    expect_same(PACKAGE, package)
    kept = next(json.loads(line)["text"] for line in done.stderr.splitlines() if "study: kept" in line)
    assert "kept import, segment, pictures, register, field, mesh" in kept, kept


if __name__ == "__main__":
    globals()[sys.argv[3]]()
