"""What a study holds by hand, labels that were painted over and seeds, when it is built again:
study_edits_test.py BEATLAS WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py; the exam and package are those of study_test.py's `prepare`.
"""
import json
import shutil
import sys

import nibabel
import numpy

from stage_test import WORK, beatlas, digest, expect_same, new_folder
from study_test import EXAM, MADE, PACKAGE, add_block, again, built, paint, states, volume, write_recipe


def edit():
    """A painted label: only later stages run, the package shows it, a further build does nothing."""
    folder, package = built("edit")
    file = folder / "segment" / "labels.nii.gz"
    before, after = paint(file, add_block)
    told = states(folder)
    assert told["segment"] == "edited" and told["register"] == "stale", told
    kept, made, said = again(folder, package)
    assert kept == ["import", "segment"] and made == ["pictures", "register", "field", "mesh", "pack"], said
    assert "segment/labels.nii.gz edited by hand and kept" in said, said
    told = states(folder)
    assert told["segment"] == "edited", told
    assert all(state == "done" for name, state in told.items() if name != "segment"), told

    # The package shows it: the heart gained the painted voxels, and they are labelled.
    header = nibabel.load(file).header
    voxel_ml = float(numpy.prod(header.get_zooms()[:3])) / 1000
    gained = [((after > 0) & (before == 0))[..., p].sum() * voxel_ml for p in range(after.shape[3])]
    for p, (was, now) in enumerate(zip(volume(PACKAGE), volume(package))):
        # The corners of a block of 12 x 10 x 8 voxels of 2 x 2 x 8 mm are rounded off.
        assert abs(now - was - gained[p]) < 0.1 * gained[p], (p, now - was, gained[p])
    out = new_folder("edit_export")
    beatlas("export", package, "--to", "nifti", "-o", out)
    shown = numpy.asarray(nibabel.load(out / "labels.nii.gz").dataobj)
    share = (shown[after != before] > 0).mean()
    assert share > 0.85, share
    everything = json.loads(beatlas("info", package, "--json").stdout)["provenance"]["warnings"]
    assert any("edited by hand" in warning for warning in everything), everything

    kept, made, _ = again(folder, package)
    assert made == [] and tuple(kept) == MADE, made
    edited = digest(package)

    # Options of the edited stage, and seeds, change nothing as long as the edit is kept, and are remembered.
    recipe, seeds = WORK / "edit.json", WORK / "edit_seeds.json"
    write_recipe(recipe, segment={"outline_sigma_mm": 3})
    seeds.write_text(json.dumps({"seeds": [{"label": 3, "lps_mm": [0, 0, 0], "radius_mm": 1, "phase": 0}]}))
    kept, made, said = again(folder, package, "--recipe", recipe, "--seeds", seeds)
    assert tuple(kept) == MADE and "its options changed since" in said, said
    assert digest(package) == edited
    assert json.loads((folder / "study.json").read_text())["recipe"]["segment"]["outline_sigma_mm"] == 3
    assert "lv_blood" in beatlas("seeds", folder, "list").stdout

    # Given up: as it was made.
    beatlas("seeds", folder, "remove", "all")
    write_recipe(recipe)
    kept, made, said = again(folder, package, "--recipe", recipe, "--discard-edits")
    assert made == list(MADE[1:]), made
    expect_same(PACKAGE, package)
    assert set(states(folder).values()) == {"done"}

    # Stage by stage the same: each names what has to run before it.
    paint(file, add_block)
    said = beatlas("field", "--study", folder, code=3).stderr
    assert "beatlas register --study" in said, said
    for stage in ("register", "field", "mesh"):
        beatlas(stage, "--study", folder)
    beatlas("pack", "--study", folder, "-o", package)
    assert digest(package) == edited


def edit_of_another():
    """Edits are not overwritten by another patient's exam, nor taken for what they are not."""
    folder, package = built("edit_of_another")
    paint(folder / "segment" / "labels.nii.gz", add_block)
    drawn = digest(folder / "segment" / "labels.nii.gz")
    other = new_folder("edit_of_another_exam")
    beatlas("phantom", "-o", other, "--preset", "small", "--without", "all", "--snr", "15")
    said = beatlas("build", other / "dicom", "-o", package, "--study", folder, code=3).stderr
    assert "another source" in said and "--discard-edits" in said, said
    assert digest(folder / "segment" / "labels.nii.gz") == drawn
    expect_same(PACKAGE, package)
    # The same images with a copy of one beside them are no other source, and what an exam's folder also holds is
    # none at all.
    copied = new_folder("edit_of_another_copied")
    shutil.copytree(EXAM, copied)
    (copied / "notes.txt").write_text("what the technician said")
    assert "nothing has changed" in beatlas("import", copied, "--study", folder).stderr
    shutil.copyfile(next(file for file in EXAM.rglob("*") if file.is_file()), copied / "twin")
    assert "nothing has changed" not in beatlas("import", copied, "--study", folder).stderr
    assert digest(folder / "segment" / "labels.nii.gz") == drawn and states(folder)["segment"] == "edited"
    beatlas("import", EXAM, "--study", folder)
    # Nor is the import of the same images replaced by one that the edits do not fit, and what was refused is
    # not remembered. Seeds change nothing in labels that are kept, and adding one says so.
    before = (folder / "study.json").read_bytes()
    said = beatlas("build", EXAM, "-o", package, "--study", folder, "--phases", "2", code=3).stderr
    assert "segment/labels.nii.gz, edited by hand, is of other slices or phases" in said, said
    assert (folder / "study.json").read_bytes() == before
    said = beatlas("seeds", folder, "add", "--label", "lv_blood", "--slice", "20", "--row", "30", "--column", "30").stderr
    assert "segment/labels.nii.gz was edited by hand, and all of segment is kept" in said, said
    beatlas("seeds", folder, "remove", "all")
    # Files for the eye: said to be without effect, and put aside rather than lost.
    eye = folder / "register" / "labels.nii.gz"
    paint(eye, lambda labels: labels.fill(0))
    kept, made, said = again(folder, package)
    assert (folder / "register" / "labels.nii.gz.edited").exists()
    paint(eye, lambda labels: labels.fill(0))
    kept, made, said = again(folder, package)
    assert made == [] and "nothing is made from it" in said, said
    told = json.loads(beatlas("status", folder, "--json").stdout)["stages"]
    assert ["register/labels.nii.gz"] in [stage["unused_edits"] for stage in told], told


def seeds_of_another():
    """Seeds are places in a patient, and would mark any other heart as well: they stay with their own."""
    other = new_folder("seeds_of_another_exam")
    beatlas("phantom", "-o", other, "--preset", "small", "--without", "all", "--snr", "15")
    seeded = new_folder("seeds_of_another")
    beatlas("import", EXAM, "--study", seeded)
    beatlas("seeds", seeded, "add", "--label", "lv_blood", "--slice", "20", "--row", "30", "--column", "30")
    said = beatlas("import", other / "dicom", "--study", seeded, code=3).stderr
    assert "holds seeds for other images than these" in said, said
    # Of the same files they stay, whatever the options, but for which exam among them is meant.
    beatlas("import", EXAM, "--study", seeded, "--rr", "0.8")
    assert "lv_blood" in beatlas("seeds", seeded, "list").stdout
    both = new_folder("exams_of_two")
    for number, exam in enumerate((other, WORK / "seeds_of_another_third")):
        if number:
            beatlas("phantom", "-o", exam, "--preset", "small", "--without", "all", "--snr", "12", "--seed", "3")
        shutil.copytree(exam / "dicom", both / str(number))
    of_two = new_folder("study_of_two")
    beatlas("import", both, "--study", of_two, "--exam", "1")
    beatlas("seeds", of_two, "add", "--label", "lv_blood", "--slice", "20", "--row", "30", "--column", "30")
    beatlas("import", both, "--study", of_two, "--exam", "2", code=3)
    assert "lv_blood" in beatlas("seeds", of_two, "list").stdout
    said = beatlas("import", other / "dicom", "--study", seeded, "--discard-edits").stderr
    assert "given up with the images before: seeds" in said, said
    assert "no seeds" in beatlas("seeds", seeded, "list").stdout


def edit_goes_wrong():
    """Labels that no editor should have left; files that are gone; all of it can be given up."""
    folder, package = built("edit_goes_wrong")
    file = folder / "segment" / "labels.nii.gz"
    whole = file.read_bytes()

    def refused(*words, source=(EXAM,), code=3):
        said = beatlas("build", *source, "-o", package, "--study", folder, *words, code=code).stderr
        expect_same(PACKAGE, package)
        return [line for line in said.splitlines() if "warning" not in line][-1]

    for value, word in ((9, "value 9"), (0, "no heart")):
        paint(file, lambda labels: labels.fill(value))
        said = refused()
        assert word in said and "labels.nii.gz" in said, said
    file.write_bytes(whole)
    image = nibabel.load(file)
    labels = numpy.asarray(image.dataobj)
    shifted = image.affine.copy()
    shifted[:3, 3] += 3
    for edited in (nibabel.Nifti1Image(labels[:-1], image.affine),
                   nibabel.Nifti1Image(labels, shifted),
                   nibabel.Nifti1Image(labels + numpy.float32(0.5), image.affine)):
        nibabel.save(edited, file)
        said = refused()
        assert said.startswith(f"beatlas: {file}") and "save it again" in said, said
    for size in (0, len(whole) // 2):
        file.write_bytes(whole[:size])
        said = refused()
        assert said.startswith(f"beatlas: {file}") and "save it again" in said, said
    # Without what tells how they were made no edit can be told.
    file.write_bytes(whole)
    paint(file, add_block)
    (folder / "segment" / "labels_as_made.nii.gz").unlink()
    said = refused()
    assert "labels_as_made.nii.gz is gone" in said and "--discard-edits" in said, said
    paint(folder / "register" / "labels.nii.gz", lambda labels: labels.fill(0))
    again(folder, package, "--discard-edits")
    expect_same(PACKAGE, package)
    assert set(states(folder).values()) == {"done"}, states(folder)
    told = json.loads(beatlas("status", folder, "--json").stdout)["stages"]
    assert not any(stage["unused_edits"] for stage in told), told

    # Images that were changed or lost come back from the source alone.
    stack = folder / "exam" / "stack.nii.gz"
    paint(stack, lambda values: values[:2].fill(0))
    said = refused("--discard-edits", source=())
    assert "exam/stack.nii.gz was edited by hand" in said and "SOURCE" in said, said
    again(folder, package, "--discard-edits")
    expect_same(PACKAGE, package)
    stack.unlink()
    said = refused(source=())
    assert "exam/stack.nii.gz is gone" in said and "SOURCE" in said, said
    kept, made, said = again(folder, package)
    assert made == ["import"], said
    # The index is lost: what to do is said.
    index = folder / "study.json"
    index.write_bytes(index.read_bytes()[:500])
    said = refused()
    assert "study.json" in said and "new folder" in said, said


if __name__ == "__main__":
    globals()[sys.argv[3]]()
