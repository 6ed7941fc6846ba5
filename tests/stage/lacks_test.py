"""No wrong heart passes for one, and build and validate agree: lacks_test.py BEATLAS WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py, whose `prepare` made the phantom, with the exam of study_test.py.
"""
import json
import pathlib
import shlex
import sys

import jsonschema
import nibabel
import numpy

from stage_test import WORK, beatlas, new_folder
from study_test import RECIPE, built, paint

SCHEMAS = pathlib.Path(__file__).parents[2] / "schemas"
RV, MUSCLE, LV, REST = 1, 2, 3, 4


def report_of(folder):
    told = json.loads((folder / "report.json").read_text())
    jsonschema.validate(told, json.loads((SCHEMAS / "report.schema.json").read_text()))
    return told


def findings(folder):
    text = (folder / "report.html").read_text()
    text = text.split('<script id="data" type="application/json">')[1].split("</script>")[0]
    return json.loads(text)["findings"]


def rejected(folder, package, *words):
    """The build is refused: no package, the study and its report stay, `status` tells it. The reasons."""
    package.unlink(missing_ok=True)
    done = beatlas("build", "--study", folder, "-o", package, *words, code=4)
    assert not package.exists() and not list(package.parent.glob(f".{package.name}*"))
    told = report_of(folder)
    assert told["verdict"] == "rejected" and told["package"] is None, told["reasons"]
    assert "verdict: rejected" in done.stderr and "no package was written" in done.stderr.splitlines()[-1], done.stderr
    pack = json.loads(beatlas("status", folder, "--json").stdout)["stages"][-1]
    assert pack["name"] == "pack" and pack["state"] == "refused" and str(folder) not in pack["refused"], pack
    # Nothing has changed: it is refused again, and so is the stage alone.
    assert beatlas("build", "--study", folder, "-o", package, *words, code=4).stderr.splitlines()[-1] \
        == done.stderr.splitlines()[-1]
    return told["reasons"], done.stderr.splitlines()[-1]


def agree(folder, package):
    """What build ended with and what validate says of its package."""
    told = report_of(folder)
    done = beatlas("validate", package, "--json", code=None)
    checked = json.loads(done.stdout)
    assert done.returncode == (0 if checked["passed"] else 4)
    said = next((r["sentence"] for r in told["reasons"] if r["id"] == "checks"), "")
    assert told["verdict"] in ("good", "check") and (checked["passed"] or told["verdict"] == "check")
    assert bool(said) == (not checked["passed"]) and all(line in said for line in checked["failures"]), said
    return told, checked


def structure():
    """A heart without an RV is no heart for a scene that needs one, and one for a scene that does not."""
    folder, package = built("lacks")
    file = folder / "segment" / "labels.nii.gz"
    whole = file.read_bytes()

    def without_rv(labels):
        labels[labels == RV] = REST
    paint(file, without_rv)
    reasons, last = rejected(folder, package, "--recipe", RECIPE)
    assert reasons[0]["id"] == "structures" and reasons[0]["level"] == "rejected", reasons
    assert reasons[0]["sentence"].endswith(": rv_blood"), reasons[0]
    assert "labels.nii.gz" in reasons[0]["how"] and "rv_blood" in last and "labels.nii.gz" in last, last
    assert [words.startswith("beatlas build --study .") for words in reasons[0]["commands"]] == [True], reasons[0]
    first = findings(folder)[0]
    assert first["id"] == "structures" and first["how"] and first["commands"] == reasons[0]["commands"], first
    beatlas("pack", "--study", folder, "-o", package, code=3)  # the stages before it must run again

    # The scene says what it does without.
    file.write_bytes(whole)
    paint(file, without_rv)
    scene = WORK / "lacks_scene.json"
    scene.write_text(json.dumps({"structures": ["heart", "lv_blood", "lv_myocardium"]}))
    beatlas("build", "--study", folder, "-o", package, "--recipe", RECIPE, "--scene", scene)
    told, _ = agree(folder, package)
    assert [r["level"] for r in told["reasons"] if r["id"] == "structures"] == ["check"], told["reasons"]
    # Without -o the package is written again, for the scene that it was for.
    beatlas("build", "--study", folder, "--recipe", RECIPE)
    rejected(folder, package, "--recipe", RECIPE, "--scene", "palpation")
    # And whole again: good as it was.
    file.write_bytes(whole)
    beatlas("build", "--study", folder, "-o", package, "--recipe", RECIPE)
    told, checked = agree(folder, package)
    assert checked["passed"] and "structures" not in {r["id"] for r in told["reasons"]}
    # What nobody drew is to be marked, by a command that a shell takes whatever the study is called.
    spaced, package = built("lacks an atrium")
    scene.write_text(json.dumps({"structures": ["la_blood"]}))
    said = beatlas("build", "--study", spaced, "-o", package, "--recipe", RECIPE, "--scene", scene, code=4).stderr
    words = shlex.split(said.split("mark it: ")[1].splitlines()[0])
    assert words[:4] == ["beatlas", "seeds", str(spaced), "add"], words


def never_disagree():
    """What the report calls rejected is no package: labels that do not beat, a surface with a hole."""
    folder, package = built("lacks_beat")
    file = folder / "segment" / "labels.nii.gz"
    whole = file.read_bytes()

    def still(labels):
        labels[...] = labels[..., :1]
    paint(file, still)
    reasons, _ = rejected(folder, package, "--recipe", RECIPE)
    assert [r["id"] for r in reasons if r["level"] == "rejected"] == ["package", "ef_possible"], reasons
    file.write_bytes(whole)
    beatlas("build", "--study", folder, "-o", package, "--recipe", RECIPE)
    agree(folder, package)

    # One triangle less in every phase of the LV's surface, as an editor could leave it.
    for ply in sorted((folder / "mesh").glob("lv_blood_*.ply")):
        head, body = ply.read_bytes().split(b"end_header\n", 1)
        lines = head.decode().splitlines()
        at = next(n for n, line in enumerate(lines) if line.startswith("element face "))
        count = int(lines[at].split()[-1])
        lines[at] = f"element face {count - 1}"
        each = 13 if "property list uchar" in head.decode() else 16
        ply.write_bytes("\n".join(lines).encode() + b"\nend_header\n" + body[:len(body) - each])
    reasons, last = rejected(folder, package, "--recipe", RECIPE)
    assert "surfaces" in [r["id"] for r in reasons if r["level"] == "rejected"], reasons
    assert "open edges" in last, last


def given():
    """Labels of every phase that hold the LV alone are what was meant; an RV is asked for where the scene
    names one."""
    image = nibabel.load(WORK / "phantom" / "truth_labels.nii.gz")
    labels = numpy.asarray(image.dataobj).astype(numpy.uint8)
    labels[(labels != LV) & (labels != MUSCLE)] = 0
    file = WORK / "lacks_lv.nii.gz"
    nibabel.save(nibabel.Nifti1Image(labels, image.affine), file)
    folder, package = new_folder("lacks_given"), WORK / "lacks_given.beatlas"
    beatlas("build", WORK / "phantom" / "dicom", "-o", package, "--study", folder, "--labels", file, "--recipe",
            RECIPE, "--scene", "palpation")
    told, checked = agree(folder, package)
    assert checked["passed"], checked["failures"]
    assert [r["level"] for r in told["reasons"] if r["id"] == "structures"] == ["check"], told["reasons"]
    scene = WORK / "lacks_rv.json"
    scene.write_text(json.dumps({"content": "palpation", "structures": ["rv_blood"]}))
    reasons, last = rejected(folder, package, "--recipe", RECIPE, "--scene", scene)
    assert reasons[0]["sentence"].endswith(": rv_blood"), reasons


globals()[sys.argv[3]]()
