"""Plays exercises as a trainee would, on a package that is made for it:
exercise_test.py BEATLAS_PLAY MAKE_SAMPLE_PACKAGE SOURCE_FOLDER [FAKE_DEVICE_LIBRARY]

What is found, scored, lost, resumed, played again and refused, and that simulated trainees of two skills
are told apart.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import jsonschema

sys.dont_write_bytecode = True
from checks import check, refused, run as run_words  # noqa: E402

PLAY, MAKE, SOURCE = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
DEVICE = sys.argv[4] if len(sys.argv) > 4 else None
SAMPLES = SOURCE / "samples" / "exercises"
RUNS = 14  # of each skill


def schema(name):
    return json.loads((SOURCE / "schemas" / f"{name}.schema.json").read_text())


def play(*words, **environment):
    return run_words(PLAY, *words, environment={**os.environ, **environment})


def trained(package, exercise, session, *more):
    return play(package, "--exercise", exercise, "--session", session, "--device", "trainee", "--fast", *more)


def scored(session, package):
    kept = json.loads((session / "session.json").read_text())
    jsonschema.validate(kept, schema("exercise_session"))
    jsonschema.validate(kept["exercise"], schema("exercise"))
    score = json.loads((session / "score.json").read_text())
    jsonschema.validate(score, schema("exercise_score"))
    check(kept["package"] == package.name, "the session names another package")
    return score


def auc(better, worse):
    """How often one of the better has more points than one of the worse."""
    pairs = [(a > b) + 0.5 * (a == b) for a in better for b in worse]
    return sum(pairs) / len(pairs)


def one_that_is_found(folder, package):
    session = folder / "found"
    run = trained(package, SAMPLES / "01_soft_large.json", session, "--seed", 4)
    check(run.returncode == 0, run.stderr)
    score = scored(session, package)
    lesion = score["find"]["lesions"][0]
    check(lesion["found"] and lesion["named"] and lesion["kind"] == "soft", f"not found: {score}")
    check(score["palpation"]["share"] > 0.5 and score["find"]["points"] > 80, f"{score}")
    check("found, marked" in run.stdout and "of 100 points" in run.stdout, run.stdout)
    page = (session / "report.html").read_text()
    for word in ("of 100 points", "soft muscle", "<svg", "hidden and palpated", package.name):
        check(word in page, f"the report lacks '{word}'")
    return session


def the_same_once_more(session, package):
    files = {name: (session / name).read_bytes() for name in ("score.json", "report.html")}
    run = play("replay-exercise", package, session)
    check(run.returncode == 0 and "ticks came out the same to the bit" in run.stdout, run.stderr)
    for name, bytes_before in files.items():
        check((session / name).read_bytes() == bytes_before, f"{name} is another after the replay")


def a_changed_trace_is_refused(session, package):
    trace = session / "trial_001_1.csv"
    whole = trace.read_text()
    lines = whole.splitlines()
    forces = [n for n, line in enumerate(lines[1:], 1) if float(line.split(",")[4]) > 1]
    middle = lines[forces[len(forces) // 2]].split(",")
    middle[1] = str(float(middle[1]) + 0.5)
    lines[forces[len(forces) // 2]] = ",".join(middle)
    trace.write_text("\n".join(lines) + "\n")
    refused(play("replay-exercise", package, session), 3, "came out otherwise")
    trace.write_text(whole)
    kept = json.loads((session / "session.json").read_text())
    twice = dict(kept, trials=[dict(kept["trials"][0], done=False), kept["trials"][0]])
    (session / "session.json").write_text(json.dumps(twice))
    refused(play("replay-exercise", package, session), 3, "/trials must be a list of at most 1")
    kept["trials"][0]["parts"] = ["../../etc/passwd"]
    (session / "session.json").write_text(json.dumps(kept))
    refused(play("replay-exercise", package, session), 3, "/trials/0/parts/0 must be trial_001_1.csv")


def a_lost_device_is_kept(folder, package):
    session = folder / "lost"
    exercise = SAMPLES / "01_soft_large.json"
    run = play(package, "--exercise", exercise, "--session", session, "--seed", 4, "--device", "dhd",
               "--device-library", DEVICE, FAKE_DHD="lost")
    refused(run, 5, "trial 1 is kept and goes on with the same command")
    kept = json.loads((session / "session.json").read_text())
    check(kept["trials"][0]["parts"] == ["trial_001_1.csv"] and not kept["trials"][0]["done"], f"{kept}")
    refused(play("replay-exercise", package, session), 3, "was broken off")
    refused(trained(package, SAMPLES / "02_soft.json", session), 3, "holds another session")
    refused(trained(package, exercise, session, "--seed", 5), 3, "holds another session")
    run = trained(package, exercise, session)
    check(run.returncode == 0, run.stderr)
    score = scored(session, package)
    kept = json.loads((session / "session.json").read_text())
    check(len(kept["trials"][0]["parts"]) == 2 and score["seed"] == 4, f"{kept}")
    rows = sum(len((session / part).read_text().splitlines()) - 1 for part in kept["trials"][0]["parts"])
    check(score["ticks"] == rows, f"{score['ticks']} ticks of {rows} rows")
    check(score["find"]["lesions"][0]["found"], f"{score}")
    refused(trained(package, exercise, session), 3, "is finished")


def presses(session):
    count, before = 0, "0"
    for trace in sorted(session.glob("trial_001_*.csv")):
        for line in trace.read_text().splitlines()[1:]:
            button = line.split(",")[8]
            count += before == "0" != button
            before = button
    return count


def what_was_marked_before_counts(folder, package):
    exercise, session = SAMPLES / "07_two.json", folder / "two"
    check(trained(package, exercise, session, "--seed", 2).returncode == 0, "two lesions are not played")
    check(presses(session) == 2, f"{presses(session)} marks of two lesions")
    trace = session / "trial_001_1.csv"
    lines = trace.read_text().splitlines()
    first = next(n for n, line in enumerate(lines[1:], 1) if line.split(",")[8] != "0")
    trace.write_text("\n".join(lines[:first + 50]) + "\n")
    kept = json.loads((session / "session.json").read_text())
    kept["trials"][0].update(done=False, played_s=float(lines[first + 49].split(",")[0]))
    (session / "session.json").write_text(json.dumps(kept))
    run = trained(package, exercise, session)
    check(run.returncode == 0, run.stderr)
    check(presses(session) == 2, f"{presses(session)} marks where the first was made before")


def a_threshold(folder, package):
    exercise = folder / "threshold.json"
    exercise.write_text(json.dumps({"version": 1, "task": "threshold", "trials": 12, "places": 4,
                                    "radius_mm": [10, 10], "seconds": 60}))
    session = folder / "threshold"
    run = trained(package, exercise, session, "--seed", 1)
    check(run.returncode == 0, run.stderr)
    score = scored(session, package)["staircase"]
    check(len(score["trials"]) == 12 and 0.02 < score["threshold"] < 0.25, f"{score}")
    check(score["low"] < score["threshold"] < score["high"], f"{score}")
    check(all(trial["right"] == (trial["marked"] == trial["segment"]) or not trial["right"]
              for trial in score["trials"]), f"{score}")
    check(len(re.findall(r"^trial \d+ of 12: (?:right|wrong)$", run.stdout, re.M)) == 12, run.stdout)
    the_same_once_more(session, package)


def one_that_is_interrupted_says_so(folder, package):
    exercise = folder / "long.json"
    exercise.write_text(json.dumps({"version": 1, "task": "threshold", "trials": 60, "places": 4,
                                    "radius_mm": [10, 10], "seconds": 60}))
    for played in range(1, 5):
        # Between two trials or within one, as the threads have it.
        words = [PLAY, package, "--exercise", exercise, "--session", folder / f"cut_{played}", "--device", "trainee",
                 "--fast", "--seed", "1"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
            for _ in range(played):
                run.stdout.readline()
            run.terminate()
            message = run.communicate()[1]
        check(run.returncode == 5, f"{run.returncode}: {message}")


def a_device_without_buttons_is_refused(folder, package):
    controller, line = os.openpty()
    run = play(package, "--exercise", SAMPLES / "06_any.json", "--session", folder / "lever", "--device", "lever",
               "--lever-line", os.ttyname(line))
    refused(run, 2, "4 buttons, and lever has 0")
    os.close(controller)
    os.close(line)


def skills_are_told_apart(folder, package):
    points = {}
    for skill in ("skilled", "unskilled"):
        points[skill] = []
        for seed in range(RUNS):
            session = folder / f"{skill}_{seed}"
            run = trained(package, SAMPLES / "06_any.json", session, "--trainee", skill, "--seed", seed)
            check(run.returncode == 0, run.stderr)
            points[skill].append(scored(session, package)["find"]["points"])
    told = auc(points["skilled"], points["unskilled"])
    run = trained(package, SAMPLES / "06_any.json", folder / "json", "--seed", 0, "--json")
    check(json.loads(run.stdout) == scored(folder / "json", package), "--json is another than score.json")
    print(f"area under the curve {told:.3f}: {points}")
    check(told >= 0.95, "the score does not tell the skilled from the unskilled")


def bad_calls(folder, package):
    exercise, session = SAMPLES / "02_soft.json", folder / "bad"
    refused(play(package, "--exercise", exercise), 2, "name one with --session")
    refused(play(package, "--headless", "--seed", 3), 2, "name one by --exercise")
    refused(play(package, "--headless", "--device", "trainee"), 2, "name one by --exercise")
    refused(trained(package, exercise, session, "--preset", "low_pressure"), 2, "tells its own preset")
    refused(trained(package, exercise, session, "--trace", folder / "t.csv"), 2, "keeps every tick")
    refused(trained(package, exercise, session, "--seed", "1.5"), 2, "--seed")
    refused(trained(package, folder / "none.json", session), 3, "none.json cannot be read")
    broken = folder / "broken.json"
    for text, words in (("{", "is not valid JSON"), ('{"version": 2}', "/version"),
                        ('{"version": 1, "lesion": 2}', "/lesion")):
        broken.write_text(text)
        refused(trained(package, broken, session), 3, words)
    golden = SOURCE / "tests" / "package" / "golden" / "v3.beatlas"
    refused(trained(golden, exercise, session), 3, "has no map of the LV's wall")
    broken.write_text(json.dumps({"version": 1, "lesions": 3, "radius_mm": [40, 40]}))
    refused(trained(package, broken, session), 3, "no room for 3 such lesions")
    check(not session.exists(), "a session that never began left a folder")


with tempfile.TemporaryDirectory() as place:
    here = pathlib.Path(place)
    heart = here / "heart.beatlas"
    subprocess.run([MAKE, heart, "palpation"], check=True)
    played = one_that_is_found(here, heart)
    the_same_once_more(played, heart)
    a_changed_trace_is_refused(played, heart)
    if DEVICE:
        a_lost_device_is_kept(here, heart)
    what_was_marked_before_counts(here, heart)
    a_threshold(here, heart)
    one_that_is_interrupted_says_so(here, heart)
    a_device_without_buttons_is_refused(here, heart)
    bad_calls(here, heart)
    skills_are_told_apart(here, heart)
