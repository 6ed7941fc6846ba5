"""Holds the schemas against the program: schemas_test.py BEATLAS SOURCE_FOLDER

Whatever the schema of recipes accepts or refuses, the program must accept or refuse, at the ends of
every range, for unknown keys and for wrong types; every option is in both.
"""
import copy
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import jsonschema

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SCHEMAS = {name: json.loads((SOURCE / "schemas" / f"{name}.schema.json").read_text())
           for name in ("recipe", "scene", "seeds", "palpation", "exercise", "fingers", "case")}
problems = []


def without_comments(text):
    """Of lines that hold nothing else, as ours are; what is left is strict JSON."""
    return json.loads("\n".join("" if line.lstrip().startswith("//") else line
                                for line in text.splitlines()))


def schema_accepts(name, value):
    return jsonschema.Draft202012Validator(SCHEMAS[name]).is_valid(value)


def program_accepts_file(file):
    done = subprocess.run([PROGRAM, "defaults", "--recipe", str(file)], capture_output=True)
    if done.returncode not in (0, 3):
        problems.append(f"exit code {done.returncode} for {file}")
    return done.returncode == 0


def program_accepts_recipe(value):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(value, file)
        file.flush()
        return program_accepts_file(file.name)


def expect(recipe, accepted):
    for who, answer in (("schema", schema_accepts("recipe", recipe)),
                        ("program", program_accepts_recipe(recipe))):
        if answer != accepted:
            problems.append(f"{who} {'accepts' if answer else 'refuses'} {json.dumps(recipe)}")


def options_of(content):
    """The options that an object may have, those of what it refers to included."""
    found = SCHEMAS["recipe"] if "$ref" in content else {}
    for step in content.get("$ref", "#").split("/")[1:]:
        found = found[step]
    return {**found.get("properties", {}), **content.get("properties", {})}


def try_structures(section, key, rule, own):
    """Options of single structures: the same as the section's own, in both."""
    expect({section: {key: {}}}, True)
    expect({section: {key: {"spleen": {}}}}, False)
    for structure, content in options_of(rule).items():
        if options_of(content) != own:
            problems.append(f"options of {section}/{key}/{structure} are others than the section's")
        expect({section: {key: {structure: {"frobnicate": 1}}}}, False)
        name, limit = next(iter(own.items()))
        expect({section: {key: {structure: {name: limit["maximum"]}}}}, True)
        expect({section: {key: {structure: {name: limit["maximum"] + 1}}}}, False)


def told_of_defaults(*words):
    return subprocess.run([PROGRAM, "defaults", *words], capture_output=True, check=True,
                          text=True).stdout


def numbers_of(text):
    return {float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text)}


defaults = json.loads(told_of_defaults("--json"))
commented = told_of_defaults()
if without_comments(commented) != defaults:
    problems.append("`defaults` prints other values with comments than without")
expect(defaults, True)
expect({}, True)
expect({"frobnicate": 1}, False)
expect([], False)



def comment_above(section, key):
    """What stands above an option in the commented recipe."""
    lines = commented.splitlines()
    at = lines.index(f'  "{section}": {{')
    at = next(n for n in range(at, len(lines)) if lines[n].startswith(f'    "{key}": '))
    first = at
    while lines[first - 1].startswith("    //"):
        first -= 1
    return " ".join(line.strip("/ ") for line in lines[first:at])


sections = SCHEMAS["recipe"]["properties"]
if set(sections) != set(defaults):
    problems.append(f"sections differ: {set(sections) ^ set(defaults)}")
tried = 0
ends = [{}, {}]  # every option at the lower and at the upper end of its range
for section, content in sections.items():
    options = options_of(content)
    if set(options) != set(defaults.get(section, {})):
        problems.append(f"options of {section} differ: {set(options) ^ set(defaults[section])}")
    expect({section: {}}, True)
    expect({section: 1}, False)
    expect({section: {"frobnicate": 1}}, False)
    for key, rule in options.items():
        if rule["type"] == "object":
            try_structures(section, key, rule, {k: r for k, r in options.items() if k != key})
            continue
        comment = comment_above(section, key)
        wanted = rule.get("items", rule)
        if not {wanted[end] for end in ("minimum", "maximum") if end in wanted} <= numbers_of(comment):
            problems.append(f"`defaults` tells no range of {section}/{key}: {comment}")
        if any(word not in comment for word in rule.get("enum", [])):
            problems.append(f"`defaults` tells not what {section}/{key} may be: {comment}")
        unit = re.search(r"_(mm2|mm|s|percent|ml|deg|n|mm_s)$", key)
        if unit and not re.search(r"\[|%", comment):
            problems.append(f"`defaults` tells no unit of {section}/{key}: {comment}")
        if rule["type"] == "array":
            entry = rule["items"]
            low, high = entry["minimum"], entry["maximum"]
            for value, accepted in (([], True), ([low, high], True), ([low] * rule["maxItems"], True),
                                    ([low] * (rule["maxItems"] + 1), False), ([low - 1], False),
                                    ([high + 1], False), (["1"], False), ([[low]], False),
                                    (low, False), (None, False), ({}, False)):
                expect({section: {key: value}}, accepted)
                tried += 1
            continue
        if rule["type"] == "boolean":
            for value, accepted in ((True, True), (False, True), (1, False), ("true", False)):
                expect({section: {key: value}}, accepted)
            tried += 1
            continue
        if rule["type"] == "string":
            for value in rule.get("enum", ["", "none", "a model.onnx"]):
                expect({section: {key: value}}, True)
            if "enum" in rule:
                expect({section: {key: "frobnicate"}}, False)
            expect({section: {key: 1}}, False)
            tried += 1
            continue
        low, high = rule["minimum"], rule["maximum"]
        whole = rule["type"] == "integer"
        beyond = 1 if whole else 1e-6 * max(1, abs(high))
        wrong = [("1", False), (None, "null" in rule["type"]), (True, False), ([low], False)]
        # Starting the program takes a quarter of a second: each option gets one of the wrong types.
        for value, accepted in ((low - beyond, False), (high + beyond, False), wrong[tried % 4]):
            expect({section: {key: value}}, accepted)
        ends[0].setdefault(section, {})[key] = low
        ends[1].setdefault(section, {})[key] = high
        tried += 1
        if whole:
            expect({section: {key: low + 0.5}}, False)

for recipe in ends:
    expect(recipe, True)

for file in sorted((SOURCE / "samples").rglob("*.json")):
    name = ("exercise" if file.parent.name == "exercises" else
            "case" if file.parent.name == "cases" else
            next(name for name in SCHEMAS if file.name.startswith(name)))
    text = file.read_text()
    if not schema_accepts(name, without_comments(text)):
        problems.append(f"{file.name} does not follow its schema")
    if not text.startswith("//"):
        problems.append(f"{file.name} does not begin by saying what it is")
    if name == "recipe" and not program_accepts_file(file):
        problems.append(f"the program refuses {file.name}")

if tried < 40:
    problems.append("fewer options were tried than there are")
if problems:
    sys.exit("\n".join(problems))
