"""A study that is left, resumed and built again: study_test.py BEATLAS WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py, whose `prepare` made the phantom.
"""
import json
import pathlib
import random
import re
import shutil
import sys

import jsonschema
import nibabel
import numpy

import stage_test
from stage_test import WORK, beatlas, digest, expect_same, new_folder

# Few phases of slices as thick as patients', and coarse: these tests build dozens of times.
PHANTOM = WORK / "quick_phantom"
EXAM, PACKAGE, RECIPE = PHANTOM / "dicom", WORK / "quick.beatlas", WORK / "quick.json"
COARSE = {"register": {"shape_mm": 2}, "field": {"voxel_mm": 2}, "mesh": {"edge_mm": 5}}
SCHEMAS = pathlib.Path(__file__).parents[2] / "schemas"
MADE = ("import", "segment", "pictures", "register", "field", "mesh", "pack")


def prepare():
    beatlas("phantom", "-o", new_folder(PHANTOM.name), "--preset", "small", "--without", "all", "--phases", 5,
            "--spacing", "2,2,8")
    write_recipe(RECIPE)
    done = beatlas("build", EXAM, "-o", PACKAGE, "--recipe", RECIPE)
    assert done.stdout == "", "build prints no data"
    for line in done.stderr.splitlines():
        assert line.startswith(("beatlas: warning: ", "beatlas: import: ")), (
            f"a pipe stays quiet but for warnings and what import chose: {line}")
    with_study = WORK / "quick_with_study.beatlas"
    beatlas("build", EXAM, "-o", with_study, "--study", new_folder("quick_study"), "--recipe", RECIPE)
    expect_same(PACKAGE, with_study)


def threads():
    """The same bytes for any number of threads."""
    for count in (1, 3):
        package = WORK / f"quick_threads{count}.beatlas"
        beatlas("build", EXAM, "-o", package, "--recipe", RECIPE, "--threads", count)
        expect_same(PACKAGE, package)


def write_recipe(file, **sections):
    content = {name: dict(options) for name, options in COARSE.items()}
    for name, options in sections.items():
        content.setdefault(name, {}).update(options)
    file.write_text(json.dumps(content))


def stages():
    """Stage by stage gives the same bytes as in one go."""
    folder, package = new_folder("stages"), WORK / "stages.beatlas"
    beatlas("import", EXAM, "--study", folder, "--recipe", RECIPE)
    for stage in stage_test.STAGES:
        beatlas(stage, "--study", folder, "--recipe", RECIPE)
    beatlas("pack", "--study", folder, "-o", package, "--recipe", RECIPE)
    expect_same(PACKAGE, package)
    # A stage that gives something else makes the later ones stale.
    recipe = WORK / "stages.json"
    write_recipe(recipe, segment={"outline_sigma_mm": 3})
    beatlas("segment", "--study", folder, "--recipe", recipe)
    said = beatlas("mesh", "--study", folder, "--recipe", recipe, code=3).stderr
    assert "beatlas register --study" in said, said
    # Images of other phases than the labels: neither is shown with the other, and nobody is said to have edited.
    beatlas("import", EXAM, "--study", folder, "--recipe", recipe, "--phases", 3)
    for phase in (1, 2):
        said = beatlas("export", folder, "--to", "slicer", "--phase", phase, "-o", new_folder("stages_out"), code=3).stderr
        assert "segment is stale" in said and f"beatlas segment --study {folder}" in said, said
        assert not list((WORK / "stages_out").glob("*")), "nothing half written"
    said = beatlas("report", folder, code=3).stderr
    assert "segment/labels.nii.gz is stale" in said and "edited" not in said, said
    assert f"beatlas build --study {folder}" in said, said


def built(name):
    """A study of the exam, for this test alone, and its package."""
    folder, package = new_folder(name), WORK / f"{name}.beatlas"
    shutil.copytree(WORK / "quick_study", folder)
    shutil.copyfile(PACKAGE, package)
    return folder, package


def again(folder, package, *words):
    """Builds again; gives the names of the stages that were kept and that were made."""
    said = beatlas("build", EXAM, "-o", package, "--study", folder, *words).stderr
    lines = [line for line in said.splitlines() if line.startswith("beatlas: study: kept ")]
    assert len(lines) == 1, said
    kept, _, made = lines[0].removeprefix("beatlas: study: kept ").partition("; ")
    made = made.removeprefix("made ")
    return kept.split(", "), [] if made == "nothing has changed" else made.split(", "), said


def states(folder):
    told = json.loads(beatlas("status", folder, "--json").stdout)
    jsonschema.validate(told, json.loads((SCHEMAS / "status.schema.json").read_text()))
    text = beatlas("status", folder).stdout
    for stage in told["stages"]:
        assert f"{stage['name']:10}{stage['state']}" in text, text
    return {stage["name"]: stage["state"] for stage in told["stages"]}


def paint(file, change):
    """Changes labels with an independent library, as an editor would save them."""
    image = nibabel.load(file)
    labels = numpy.asarray(image.dataobj).copy()
    before = labels.copy()
    change(labels)
    assert (labels != before).any()
    nibabel.save(nibabel.Nifti1Image(labels, image.affine, image.header), file)
    return before, labels


def add_block(labels):
    """A block of heart beside the heart, in every phase."""
    inside = numpy.argwhere(labels[..., 0] > 0)
    low, middle = inside.min(axis=0), inside.mean(axis=0).astype(int)
    # As far as into the heart, so that it is one piece in every phase; what is heart stays what it is.
    block = labels[low[0] - 6:low[0] + 8, middle[1] - 5:middle[1] + 5, middle[2] - 4:middle[2] + 4, :]
    block[block == 0] = 4


def volume(package, name="heart"):
    told = json.loads(beatlas("info", package, "--json").stdout)
    return next(entry["volume_ml"] for entry in told["structures"] if entry["name"] == name)


def block_at_the_border(labels):
    """A block of heart from the heart to the border of the slices, in one phase."""
    inside = numpy.argwhere(labels[..., 2] > 0)
    low, middle = inside.min(axis=0), inside.mean(axis=0).astype(int)
    labels[:low[0] + 8, middle[1] - 8:middle[1] + 8, middle[2] - 2:middle[2] + 2, 2] = 4


def pictures(folder, pattern):
    found = sorted((folder / "pictures").glob(pattern))
    for file in found:
        assert file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n", file
    return [file.name for file in found]


def leak():
    """A leak is a warning with a picture, or, where the recipe says so, an error that keeps it."""
    folder, package = built("leak")
    assert pictures(folder, "*leak*") == []
    labels = folder / "segment" / "labels.nii.gz"
    paint(labels, block_at_the_border)
    _, _, said = again(folder, package)
    assert "runs along the border of the slices" in said, said
    rang = pictures(folder, "leak_*")
    assert rang and rang[0] == "leak_01.png", rang
    named = re.findall(r"limit 200 mm2.*see pictures/(leak_\d+\.png) in the study", said)
    assert named and set(named) <= set(rang), (named, rang)
    told = json.loads(beatlas("info", package, "--json").stdout)["provenance"]["warnings"]
    assert any("runs along the border" in line for line in told), told

    # As an error, found in what was painted.
    strict = WORK / "leak.json"
    write_recipe(strict, segment={"leak": "error"})
    before = digest(package)
    said = beatlas("build", EXAM, "-o", package, "--study", folder, "--recipe", strict, code=4).stderr
    assert "/segment/leak" in said and "limit 200 mm2" in said, said
    assert digest(package) == before
    assert pictures(folder, "refused_leak_*")[0] == "refused_leak_01.png"

    # As an error, found in what the stage made: nothing of it is kept but the picture.
    painted = digest(labels)
    write_recipe(strict, segment={"leak": "error", "leak_still_mm2": 10})
    said = beatlas("build", EXAM, "-o", package, "--study", folder, "--recipe", strict,
                   "--discard-edits", code=4).stderr
    assert "does not beat" in said and "refused_leak_01.png" in said, said
    assert digest(labels) == painted and digest(package) == before
    assert pictures(folder, "refused_leak_*") == ["refused_leak_01.png"]
    # The study remembers it, without its own place; so does the report, also one written later.
    told = {stage["name"]: stage for stage in json.loads(beatlas("status", folder, "--json").stdout)["stages"]}
    assert told["segment"]["state"] == "refused" and "does not beat" in told["segment"]["refused"], told
    assert states(folder)["pack"] != "done" and str(folder) not in told["segment"]["refused"], told
    beatlas("report", folder)
    report = json.loads((folder / "report.json").read_text())
    assert report["verdict"] == "rejected" and "does not beat" in report["reasons"][0]["sentence"], report
    assert str(folder) not in (folder / "report.html").read_text()

    # Made anew as before: no leak, no picture of one.
    again(folder, package, "--recipe", RECIPE, "--discard-edits")
    assert pictures(folder, "*leak*") == []
    expect_same(PACKAGE, package)
    assert set(states(folder).values()) == {"done"}, states(folder)


def resume():
    """Only what changed runs again: nothing, one stage's options, a missing file, another scene."""
    folder, package = built("resume")
    assert set(states(folder).values()) == {"done"}, states(folder)
    stamp = package.stat().st_mtime_ns
    kept, made, _ = again(folder, package)
    assert made == [] and tuple(kept) == MADE and package.stat().st_mtime_ns == stamp

    # Without naming the source.
    said = beatlas("build", "--study", folder, "-o", package).stderr
    assert "nothing has changed" in said, said

    # Without naming the package: the one it made last, for what it was made for.
    lone = WORK / "resume_lone"
    shutil.rmtree(lone, ignore_errors=True)
    lone.mkdir()
    shutil.copytree(folder, lone / "study")
    beatlas("build", "--study", lone / "study", "-o", lone / "any name.beatlas", "--scene", "palpation")
    small = digest(lone / "any name.beatlas")
    assert "nothing has changed" in beatlas("build", "--study", lone / "study").stderr
    # A copy of the study does not write over the package of the one that it is a copy of.
    shutil.copytree(lone / "study", lone / "twin")
    said = beatlas("build", "--study", lone / "twin", code=2).stderr
    assert "made last, of which one may be a copy" in said and "-o X.beatlas" in said, said
    shutil.rmtree(lone / "twin")
    beatlas("seeds", lone / "study", "add", "--label", "myocardium", "--slice", 20, "--row", 40, "--column", 40)
    said = beatlas("build", "--study", lone / "study").stderr
    assert "pack" in said.split("; made ")[1] and [file.name for file in lone.glob("*.beatlas")] == ["any name.beatlas"]
    info = json.loads(beatlas("info", lone / "any name.beatlas", "--json").stdout)
    assert info["scene"] == "palpation", info["scene"]
    assert digest(lone / "any name.beatlas") != small
    beatlas("seeds", lone / "study", "remove", "all")
    beatlas("build", "--study", lone / "study")
    assert digest(lone / "any name.beatlas") == small
    assert "any name" not in "".join(file.read_text(errors="replace") for file in (lone / "study").glob("*.*"))
    # Copies, none, none yet: it asks.
    shutil.copyfile(lone / "any name.beatlas", lone / "copy.beatlas")
    assert "2 copies" in beatlas("build", "--study", lone / "study", code=2).stderr
    for file in lone.glob("*.beatlas"):
        file.unlink()
    assert "name the package to write with -o" in beatlas("build", "--study", lone / "study", code=2).stderr

    # A copy of the source under other names in another order is the same source.
    moved = new_folder("resume_source")
    files = sorted(file for file in EXAM.rglob("*") if file.is_file())
    random.Random(1).shuffle(files)
    moved.mkdir()
    for at, file in enumerate(files):
        shutil.copyfile(file, moved / f"{at:05d}")
    said = beatlas("build", moved, "--study", folder, "-o", package).stderr
    assert "nothing has changed" in said, said
    # A source that cannot be read is not taken for the one before.
    said = beatlas("build", WORK / "resume_nowhere", "--study", folder, "-o", package, code=3).stderr
    assert "no such file or folder" in said, said

    # Words about the source stay until others are given, and that is said.
    rr = json.loads(beatlas("info", package, "--json").stdout)["rr_interval_s"]
    kept, made, _ = again(folder, package, "--rr", round(1.1 * rr, 3))
    assert "import" in made, made
    kept, made, said = again(folder, package)
    assert made == [] and f"--rr {round(1.1 * rr, 3):g}" in said, said
    kept, made, said = again(folder, package, "--rr", "0")
    assert "import" in made and "last built" not in said, said
    expect_same(PACKAGE, package)

    # Another mesh: the stages before stay. And back again to the same bytes.
    recipe = WORK / "resume.json"
    write_recipe(recipe, mesh={"edge_mm": 6})
    kept, made, _ = again(folder, package, "--recipe", recipe)
    assert made == ["mesh", "pack"], made
    assert digest(package) != digest(PACKAGE)
    kept, made, _ = again(folder, package)
    assert made == [], "the study remembers its recipe"
    write_recipe(recipe)
    kept, made, _ = again(folder, package, "--recipe", recipe)
    assert made == ["mesh", "pack"], made
    expect_same(PACKAGE, package)

    # Another scene is packed from what is there.
    kept, made, _ = again(folder, WORK / "resume_small.beatlas", "--scene", "palpation")
    assert made == ["pack"], made

    # A package is written again as it was asked for, with its own levels of detail.
    scene, levels = WORK / "resume_scene.json", folder / "resume_levels.beatlas"
    scene.write_text(json.dumps({"content": "anatomy", "surface_edges_mm": [5]}))
    kept, made, _ = again(folder, levels, "--scene", scene)
    assert made == ["pack"], made
    before = digest(levels)
    said = beatlas("build", "--study", folder).stderr
    assert "nothing has changed" in said and digest(levels) == before, said

    # A file that is gone is made again; what it gives is what it was, so nothing follows.
    (folder / "field" / "heart.vdb").unlink()
    assert states(folder)["field"] == "stale", states(folder)
    kept, made, _ = again(folder, package)
    assert made == ["field", "pack"], made  # the package was of another scene
    expect_same(PACKAGE, package)
    (folder / "pictures" / "overlay.png").unlink()
    kept, made, _ = again(folder, package)
    assert made == ["pictures"] and (folder / "pictures" / "overlay.png").exists()
    package.unlink()
    kept, made, _ = again(folder, package)
    assert made == ["pack"]
    expect_same(PACKAGE, package)


def foretold():
    """Slices and phases that foretell each other: told, kept for the report, and given up with other labels."""
    folder, package = built("foretold")
    told = json.loads(beatlas("assess", folder, "--json").stdout)
    jsonschema.validate(told, json.loads((SCHEMAS / "assess.schema.json").read_text()))
    assert told["slices_apart_mm"] == 16 and told["phases_apart_s"] == 0, "five phases foretell nothing"
    rows = {row["structure"]: row for row in told["between_slices"]}
    assert {"heart", "lv_blood", "rv_blood", "lv_myocardium"} <= set(rows), rows
    # Of slices of 8 mm, one between two others is foretold to a pixel.
    assert 0.05 < rows["lv_blood"]["mean_mm"] < 2 and rows["lv_blood"]["contours"] > 10, rows
    assert [place["mean_mm"] for place in told["worst"]] == sorted(
        (place["mean_mm"] for place in told["worst"]), reverse=True)
    text = beatlas("assess", folder).stdout
    assert "lv_blood" in text and all(len(line) <= 100 for line in text.splitlines()), text
    assert "Hidden phases" not in text

    def reported(*words):
        summary = json.loads(beatlas("report", folder, "--json", *words).stdout)
        jsonschema.validate(summary, json.loads((SCHEMAS / "report.schema.json").read_text()))
        return summary["self_test"]

    kept = reported()
    assert {key: kept[key] for key in told} == told
    # A page elsewhere comes with the study's figures; the page in the study is not taken for it.
    kept_test = (folder / "self_test.json").read_bytes()
    (folder / "self_test.json").unlink()
    assert reported("-o", WORK / "foretold.html") is None
    again(folder, package)
    made_from = json.loads((folder / "report.json").read_text())["made_from"]
    assert made_from in (folder / "report.html").read_text(), "the page is of before"
    (folder / "self_test.json").write_bytes(kept_test)
    paint(folder / "segment" / "labels.nii.gz", add_block)
    assert reported() is None, "it was of other labels"
    again(folder, package, "--self-test")
    after = json.loads((folder / "report.json").read_text())["self_test"]
    assert after["worst"] != told["worst"] or after["between_slices"] != told["between_slices"]


def axis():
    """The long axis and the boundaries' uncertainty: files that others can read; an edited axis."""
    folder, package = built("axis")
    file = folder / "segment" / "long_axis.json"
    whole = json.loads(file.read_text())
    jsonschema.validate(whole, json.loads((SCHEMAS / "long_axis.schema.json").read_text()))
    lengths = [phase["lv_base_mm"] - phase["apex_mm"] for phase in whole["phases"]]
    # The phantom's: 98 mm at end-diastole, 84 mm at end-systole.
    assert 94 < max(lengths) < 102 and 80 < min(lengths) < 88, lengths
    told = f"LV {round(min(lengths))} to {round(max(lengths))} mm from apex to base"
    assert told in beatlas("status", folder).stdout, told
    assert json.loads(beatlas("status", folder, "--json").stdout)["long_axis"] == whole

    for name in ("heart", "lv_blood", "rv_blood", "lv_myocardium"):
        sigma = nibabel.load(folder / "segment" / f"uncertainty_{name}.nii.gz").get_fdata()
        coverage = nibabel.load(folder / "segment" / f"coverage_{name}.nii.gz").get_fdata()
        assert sigma.shape == coverage.shape and sigma.min() == 0, name
        stated = sigma > 0
        assert stated.sum() > 1000, name
        assert ((coverage[stated] > 0) & (coverage[stated] < 1)).all(), name
        assert 0.05 < numpy.median(sigma[stated]) < 1, name  # voxels of 2 mm

    whole["phases"][0]["apex_mm"] += 1
    file.write_text(json.dumps(whole))
    assert states(folder)["segment"] == "edited"
    kept, made, said = again(folder, package)
    assert "segment/long_axis.json edited by hand and kept" in said, said
    assert "segment" in kept and "register" in made, said
    whole["phases"][0]["apex_mm"] = whole["phases"][0]["lv_base_mm"] + 1
    file.write_text(json.dumps(whole))
    said = beatlas("build", "-o", package, "--study", folder, code=3).stderr
    assert "long_axis.json" in said and "/phases/0" in said, said
    # Without the RV's place no segment can be counted, and that is said.
    whole["phases"][0]["apex_mm"] = whole["phases"][0]["lv_base_mm"] - max(lengths)
    del whole["rv_centre_lps_mm"]
    file.write_text(json.dumps(whole))
    _, made, said = again(folder, package)
    assert "mesh" in made and "rv_centre_lps_mm" in said, said
    items = json.loads(beatlas("info", package, "--json").stdout)["items"]
    assert not any(item["path"].startswith("maps/") for item in items), items
    again(folder, package, "--discard-edits")
    expect_same(PACKAGE, package)


if __name__ == "__main__":
    globals()[sys.argv[3]]()
