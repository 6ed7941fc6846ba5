"""Three phantoms and a broken exam through scripts/cohort: cohort_test.py BEATLAS SNAKEMAKE SOURCE_FOLDER

The folders and every text of one exam name a person who may be found in none of the cohort's files.
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import nibabel
import numpy

PROGRAM, SNAKEMAKE, SOURCE = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
SKIPPED = 77  # the exit code that ctest takes for "skipped"
if not pathlib.Path(SNAKEMAKE).exists():
    print(f"skipped: there is no {SNAKEMAKE}; scripts/setup installs it")
    sys.exit(SKIPPED)
sys.path.insert(0, str(SOURCE / "tests" / "import"))
from dicom_writers import classic_exam, pixel_format  # noqa: E402
from exam_object import BeatingObject  # noqa: E402
from markers import GIVEN, NUMBER, PERSON, Texts, expect_clean, expect_clean_files, save_planted  # noqa: E402

COARSE = {"field": {"voxel_mm": 4, "inner_mm": 8, "outer_mm": 8}, "mesh": {"edge_mm": 5},
          "register": {"shape_mm": 2}, "quality": {"max_volume_gap_percent": 100}}


def run(*words, **how):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, **how)


def phantom(folder, *words):
    done = run(PROGRAM, "phantom", "-o", folder, "--preset", "small", "--phases", "4", "--without", "all",
               "--format", "nifti", *words)
    assert done.returncode == 0, done.stderr
    return folder / "cine.nii.gz"


def planted(folder, cine):
    """The same images as DICOM whose every text names a person, as do folder and files."""
    image = nibabel.load(cine)
    data = numpy.asarray(image.dataobj)[:, :, ::2]
    affine = numpy.diag([-1.0, -1, 1, 1]) @ image.affine
    step = numpy.linalg.norm(affine[:3, :3], axis=0)
    truth = BeatingObject(size=data.shape[:3], step=step * (1, 1, 2), phases=data.shape[3],
                          turn=affine[:3, :3] / step, origin=affine[:3, 3], rr_ms=750)
    texts = Texts()
    for n, d in enumerate(classic_exam(truth)):
        k, p = divmod(n, truth.phases)
        pixel_format(d, data[:, :, k, p].T)
        save_planted(texts.plant(d), folder / f"{PERSON}_{NUMBER}.{n + 1:04d}")
    return folder


def table(cohort):
    with open(cohort / "summary.csv", newline="") as file:
        return {row["exam"]: row for row in csv.DictReader(file)}


with tempfile.TemporaryDirectory(prefix="beatlas-cohort-") as work:
    work = pathlib.Path(work)
    cohort = work / "cohort"
    exams = work / "exams"
    cine = phantom(work / "a")
    broken = exams / f"{PERSON}_{GIVEN}_broken" / f"{GIVEN}.nii.gz"
    broken.parent.mkdir(parents=True)
    broken.write_bytes(cine.read_bytes()[:5000])
    person = planted(exams / f"{PERSON}_{GIVEN}", cine)
    sources = [cine, broken, phantom(work / "b", "--seed", "5"), person]
    listed = exams / "list.txt"
    listed.write_text("# a comment\n" + "".join(f"{source}\n" for source in sources))
    recipe = work / "recipe.json"
    recipe.write_text(json.dumps(COARSE))
    environment = dict(os.environ, XDG_CACHE_HOME=str(work / "cache"), HOME=str(work),
                       MPLCONFIGDIR=str(work / "cache"))

    def workflow(*words):
        done = run(SNAKEMAKE, "--snakefile", SOURCE / "scripts" / "cohort" / "Snakefile", "--directory",
                   cohort, "--cores", "2", "--keep-going", "--config", f"exams={listed}",
                   f"recipe={recipe}", f"beatlas={PROGRAM}", "threads=1", *words, env=environment)
        return done

    # As if it had been stopped on the way: what is done then is not done again.
    done = workflow("--until", "segment")
    stamps = {file: file.stat().st_mtime_ns for file in cohort.glob("*/segment.json")}
    assert len(stamps) == 3, done.stderr
    done = workflow()
    assert done.returncode == 1, done.stderr
    assert {file: file.stat().st_mtime_ns for file in stamps} == stamps
    rows = table(cohort)
    assert list(rows) == [f"exam_{n:03d}" for n in (1, 2, 3, 4)], rows
    failed = rows["exam_002"]
    assert (failed["state"], failed["stage"]) == ("failed", "import") and failed["reason"], failed
    assert "exam_002: failed import" in done.stderr, done.stderr
    assert "3 of 4 exams have an atlas" in done.stderr, done.stderr
    for name in ("exam_001", "exam_003", "exam_004"):
        row = rows[name]
        # One verdict, with its reasons: the report's own, which stands beside the package.
        summary = json.loads((cohort / name / "study" / "report.json").read_text())
        assert row["state"] == summary["verdict"] and row["stage"] == "", row
        assert row["reason"] == "; ".join(reason["sentence"] for reason in summary["reasons"]), row
        assert bool(row["reason"]) == (row["state"] != "good"), row
        assert "<html" in (cohort / name / "report.html").read_text(), name
        info = json.loads(run(PROGRAM, "info", cohort / name / "heart.beatlas", "--json").stdout)
        lv = next(entry["volume_ml"] for entry in info["structures"] if entry["name"] == "lv_blood")
        assert abs(float(row["lv_edv_ml"]) - max(lv)) < 0.051, row
        assert abs(float(row["lv_ef_percent"]) - 100 * (1 - min(lv) / max(lv))) < 0.051, row
        # The muscle of the phantom: 100 ml and more, of 1.05 g each.
        assert 50 < float(row["lv_mass_g"]) < 250 and row["phases"] == "4", row
    for plot in ("volumes.svg", "ejection_fraction.svg"):
        text = (cohort / plot).read_text()
        assert xml.etree.ElementTree.fromstring(text).tag.endswith("svg")
        assert all(name in text for name in ("exam_001", "exam_003", "exam_004")), plot
        assert "exam_002" not in text, plot

    # The same package as of one command, and the person is nowhere, in what was said neither.
    alone = run(PROGRAM, "build", cine, "-o", work / "alone.beatlas", "--recipe", recipe)
    assert alone.returncode == 0, alone.stderr
    assert (work / "alone.beatlas").read_bytes() == (cohort / "exam_001" / "heart.beatlas").read_bytes()
    expect_clean("stdout", done.stdout)
    expect_clean("stderr", done.stderr)
    assert expect_clean_files(cohort) > 60
    assert PERSON not in "".join(str(file) for file in cohort.rglob("*"))

    # Mended, the one that failed is made, and no other.
    broken.write_bytes(cine.read_bytes())
    done = workflow()
    assert done.returncode == 0, done.stderr
    assert table(cohort)["exam_002"]["state"] in ("good", "check")
    assert {file: file.stat().st_mtime_ns for file in stamps} == stamps
    assert (cohort / "exam_002" / "heart.beatlas").read_bytes() == (
        cohort / "exam_001" / "heart.beatlas").read_bytes()
