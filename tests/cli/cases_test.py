"""Searches a folder of cases, and touches one: cases_test.py BEATLAS_PLAY MAKE_SAMPLE_PACKAGE SOURCE_FOLDER

The schema of a case and the program take and refuse the same; what is listed follows its schema; a case is
touched by a device, a press and several fingers, and what cannot be is told by its exit status.
"""
import hashlib
import json
import pathlib
import sys
import tempfile

import jsonschema

sys.dont_write_bytecode = True
from checks import check, refused, run  # noqa: E402

PLAY, MAKE, SOURCE = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
SAMPLES = SOURCE / "samples" / "cases"
SCHEMAS = {name: json.loads((SOURCE / "schemas" / f"{name}.schema.json").read_text())
           for name in ("case", "cases")}
FELT = {"when": "systole", "words": "hard"}
PLAIN = {"version": 1, "title": "A heart", "felt": [FELT]}


def follows(name, value):
    return jsonschema.Draft202012Validator(SCHEMAS[name]).is_valid(value)


def documents():
    """(a case, whether it is one): the ends of every range, wrong types, unknown and missing keys."""
    yield PLAIN, True
    yield [], False
    for key in SCHEMAS["case"]["required"]:
        yield {name: value for name, value in PLAIN.items() if name != key}, False
    for key in SCHEMAS["case"]["properties"]:
        yield PLAIN | {key: None}, False
        yield PLAIN | {key: {}}, False
    for key in ("patient_name", "date", "Title"):
        yield PLAIN | {key: "none"}, False
    for key in ("title", "diagnosis"):
        for words, sound in (("Ünruhe", True), ("", False), ("two\nlines", False), (3, False)):
            yield PLAIN | {key: words}, sound
    for tags, sound in (([], True), (["a", "b"], True), ([""], False), ([1], False), ("a", False)):
        yield PLAIN | {"tags": tags}, sound
    sha = "0123456789abcdef" * 4
    for atlas, sound in (("a.beatlas", True), ("../b/a.beatlas", True), ("a.zip", False), ("/a.beatlas", False)):
        yield PLAIN | {"atlas": atlas}, sound
        yield PLAIN | {"atlas": atlas, "atlas_sha256": sha}, sound
    for wrong in (sha[1:], sha + "0", sha.upper(), ""):
        yield PLAIN | {"atlas": "a.beatlas", "atlas_sha256": wrong}, False
    yield PLAIN | {"atlas_sha256": sha}, False
    for preset in SCHEMAS["case"]["properties"]["preset"]["enum"]:
        yield PLAIN | {"preset": preset}, True
    yield PLAIN | {"preset": "fever"}, False
    for parameters, sound in (("p.json", True), ("../p.json", True), ("/p.json", False), ("", False)):
        yield PLAIN | {"parameters": parameters}, sound
    yield PLAIN | {"preset": "healthy", "parameters": "p.json"}, False
    for rate, sound in ((30, True), (220, True), (29.9, False), (220.1, False), ("60", False), (True, False)):
        yield PLAIN | {"heart_rate_per_min": rate}, sound
    yield PLAIN | {"felt": []}, True
    of_felt = SCHEMAS["case"]["properties"]["felt"]["items"]["properties"]
    for key in ("segment", "when"):
        for word in of_felt[key]["enum"]:
            yield PLAIN | {"felt": [FELT | {key: word}]}, True
        yield PLAIN | {"felt": [FELT | {key: "left"}]}, False
    for key in ("force_n", "depth_mm"):
        low, high = of_felt[key]["minimum"], of_felt[key]["maximum"]
        for number, sound in ((low, True), (high, True), (low - 0.1, False), (high + 0.1, False), ("1", False)):
            yield PLAIN | {"felt": [FELT, FELT | {key: number}]}, sound
    yield PLAIN | {"felt": [FELT | {"finger": "left"}]}, False
    for key in FELT:
        yield PLAIN | {"felt": [{name: value for name, value in FELT.items() if name != key}]}, False


def schema_and_program_agree(folder):
    file = folder / "one.case.json"
    for document, sound in documents():
        file.write_text(json.dumps(document))
        done = run(PLAY, "cases", folder)
        check(done.returncode in (0, 3), f"exit {done.returncode} for {document}")
        for who, takes in (("schema", follows("case", document)), ("program", done.returncode == 0)):
            check(takes == sound, f"the {who} {'takes' if takes else 'refuses'} {document}: {done.stderr}")
        if not sound:
            refused(done, 3, f"{file}: /")
    file.unlink()


def lists(folder, heart):
    done = run(PLAY, "cases", SAMPLES, "made-up", "--json")
    check(done.returncode == 0, done.stderr)
    told = json.loads(done.stdout)
    check(follows("cases", told) and len(told["cases"]) == 3, told)
    for entry in told["cases"]:
        check(follows("case", entry["case"]) and pathlib.Path(entry["file"]).exists(), entry)
    for document, state in ((PLAIN, "none"), (PLAIN | {"atlas": "none.beatlas"}, "missing"),
                            (PLAIN | {"atlas": heart.name}, "there"),
                            (PLAIN | {"atlas": heart.name, "atlas_sha256": "0" * 64}, "other")):
        (folder / "one.case.json").write_text(json.dumps(document))
        told = json.loads(run(PLAY, "cases", folder, "--json").stdout)
        check(follows("cases", told) and told["cases"][0]["atlas_state"] == state, f"{state}: {told}")
    (folder / "broken.case.json").write_text("{")
    done = run(PLAY, "cases", folder, "heart")
    refused(done, 3, "broken.case.json is not valid JSON")
    check(done.stdout.startswith("one.case.json: A heart; "), done.stdout)
    (folder / "broken.case.json").unlink()
    (folder / "one.case.json").unlink()
    done = run(PLAY, "cases", folder)
    check(done.returncode == 0 and "holds no case" in done.stdout, done)
    refused(run(PLAY, "cases"), 2, "FOLDER is required")
    refused(run(PLAY, "cases", folder / "none"), 3, "is no folder that can be read")


def is_touched(folder, heart):
    case = folder / "infarct.case.json"
    case.write_text(json.dumps(PLAIN | {"atlas": heart.name, "preset": "anterior_infarct", "heart_rate_per_min": 90,
                                        "atlas_sha256": hashlib.sha256(heart.read_bytes()).hexdigest()}))
    words = (PLAY, "--case", case, "--headless", "--fast", "--seconds", "0.5", "--json")
    done = run(*words)
    check(done.returncode == 0, done.stderr)
    report = json.loads(done.stdout)
    check((report["heart_rate_per_min"], report["model"]) == (90, "patch"), report)
    done = run(*words, "--fingers", SOURCE / "samples" / "fingers.json")
    check(done.returncode == 0 and len(json.loads(done.stdout)["fingers"]) == 3, done)
    # The infarct is pressed where the map has it, and not beside it.
    scars = []
    for segment in ("mid_anterior", "mid_inferolateral"):
        done = run(PLAY, "--case", case, "--headless", "--press", folder / "press", "--press-segment", segment, "--json")
        check(done.returncode == 0, done.stderr)
        scars.append(json.loads(done.stdout)["atlas"]["wall"]["scar"])
    check(scars == [0.8, 0], scars)
    # Without an atlas, paper B's ventricle is pressed.
    done = run(PLAY, "--case", SAMPLES / "low_pressure.case.json", "--headless", "--press", folder / "press", "--json")
    check(done.returncode == 0 and "atlas" not in json.loads(done.stdout), done)

    refused(run(*words, "--model", "patch"), 2, "leave --model out")
    refused(run(PLAY, "--case", SAMPLES / "healthy.case.json", "--headless"), 2, "names no atlas")
    heart.write_bytes(heart.read_bytes() + b"\n")
    refused(run(*words), 3, "/atlas_sha256 is not that of")
    heart.unlink()
    refused(run(*words), 3, "cannot be read; put it there")


with tempfile.TemporaryDirectory() as name:
    place = pathlib.Path(name)
    package = place / "heart.beatlas"
    check(run(MAKE, package, "palpation").returncode == 0, "no package")
    schema_and_program_agree(place)
    lists(place, package)
    is_touched(place, package)
