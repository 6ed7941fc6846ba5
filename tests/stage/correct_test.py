"""From what is wrong to an atlas that is right: correct_test.py BEATLAS WORK_FOLDER NAME [ITK_PAINT]

WORK_FOLDER is that of stage_test.py; the exam is that of study_test.py's `prepare`. ITK_PAINT is
itk_paint.cpp, where ITK is: the library with which 3D Slicer and ITK-SNAP read and write images. Where
it is not, what needs it is skipped.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import jsonschema
import nibabel
import numpy
import scipy.ndimage
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from given_test import LV, MUSCLE, PHANTOM, RV, labels_of, study_of
from stage_test import PROGRAM, WORK, beatlas, digest, expect_same, new_folder
from study_test import PACKAGE, SCHEMAS, again, built, states, write_recipe


def seeds_of(folder):
    told = json.loads(beatlas("seeds", folder, "list", "--json").stdout)
    if told["seeds"]:
        jsonschema.validate(told, json.loads((SCHEMAS / "seeds.schema.json").read_text()))
    return told["seeds"]


def edge_of_heart(folder, phase):
    """A voxel just outside the heart, in the middle slice: column, row, slice."""
    labels = labels_of(folder)[..., phase]
    middle = labels.shape[2] // 2
    inside = numpy.argwhere(labels[:, :, middle] > 0)
    column, row = inside[inside[:, 0].argmin()]
    return int(column) - 2, int(row), middle


def seeds():
    """Added from the command line by voxel, LPS or RAS, a seed has only the needed stages run and is in
    the labels; removed, the bytes are as before."""
    folder, package = built("seeds")
    column, row, k = edge_of_heart(folder, 2)
    labels = labels_of(folder)
    assert labels[column, row, k, 2] == 0
    said = beatlas("seeds", folder, "add", "--label", "myocardium", "--slice", k, "--row", row,
                   "--column", column, "--phase", 2, "--radius", "3").stdout
    assert "added seed 1, lv_myocardium, phase 2, radius 3.0 mm" in said, said
    assert f"({'slice, row, column'} {k}, {row}, {column})" in said, said
    assert f"beatlas build --study {folder}" in said, said
    told = states(folder)
    assert told["import"] == "done" and told["segment"] == "stale", told
    kept, made, _ = again(folder, package)
    assert kept == ["import"] and made == ["segment", "pictures", "register", "field", "mesh", "pack"], (kept, made)
    found = labels_of(folder)
    assert found[column, row, k, 2] == MUSCLE, "what was marked stays as marked"
    assert digest(package) != digest(PACKAGE)
    kept, made, _ = again(folder, package)
    assert made == [], made

    # Its place in the patient is that of the voxel in the file: the same seed in LPS and in RAS.
    image = nibabel.load(folder / "exam" / "stack.nii.gz")
    ras = nibabel.affines.apply_affine(image.affine, (column, row, k))
    lps = ras * (-1, -1, 1)
    word = lambda place: ",".join(f"{number:.6f}" for number in place)  # noqa: E731
    beatlas("seeds", folder, "add", "--label", "2", "--lps", word(lps), "--phase", 2, "--radius", "3")
    beatlas("seeds", folder, "add", "--label", "lv_myocardium", "--ras", word(ras), "--phase", 2,
            "--radius", "3")
    one, two, three = seeds_of(folder)
    # The file's own map is kept in single precision.
    assert numpy.allclose(one["lps_mm"], two["lps_mm"], atol=1e-4), (one, two)
    assert two == three, (two, three)
    # A stroke, and one of every phase.
    beatlas("seeds", folder, "add", "--label", "background", "--lps", word(lps), "--lps",
            word(lps + (8, 0, 0)), "--phase", -1)
    stroke = seeds_of(folder)[3]
    assert numpy.allclose(stroke["stroke_lps_mm"], [lps, lps + (8, 0, 0)], atol=1e-5), stroke
    assert (stroke["label"], stroke["phase"], stroke["radius_mm"]) == (0, -1, 2.0), stroke
    listed = beatlas("seeds", folder, "list").stdout.splitlines()
    assert [line.split()[0] for line in listed] == ["1", "2", "3", "4"], listed
    assert "every phase" in listed[3] and "stroke" in listed[3], listed

    # Mistakes: one sentence, and the seeds stay.
    before = seeds_of(folder)
    size = image.shape
    beside = nibabel.affines.apply_affine(image.affine, (-2, row, k))
    for words, code, told in (
            (("add", "--label", "spleen", "--lps", "0,0,0"), 2, "'spleen' is no known label; call it one of background"),
            (("add", "--label", "lv"), 2, "--lps, --ras"),
            (("add", "--label", "lv", "--lps", "1,2"), 2, "three numbers"),
            (("add", "--label", "lv", "--slice", "3", "--row", "4"), 2, "all three"),
            (("add", "--label", "lv", "--slice", size[2], "--row", 4, "--column", 4), 3,
             f"slices 0 to {size[2] - 1}, rows 0 to {size[1] - 1}"),
            (("add", "--label", "lv", "--lps", "900,0,0"), 3, "outside the images"),
            (("add", "--label", "lv", "--ras", word(beside), "--radius", "20"), 3,
             f"mm RAS lies outside the images, in slice, row, column {k}, {row}, -2; they have slices 0 to"),
            (("add", "--label", "lv", "--lps", word(lps), "--phase", size[3]), 3, "phase"),
            (("remove", "5"), 3, "no seed 5"), (("remove", "last"), 2, "list")):
        error = beatlas("seeds", folder, *words, code=code).stderr
        assert error.startswith("beatlas: ") and told in error and len(error.splitlines()) == 1, error
        assert seeds_of(folder) == before, words

    beatlas("seeds", folder, "remove", "2", "4")
    assert seeds_of(folder) == [one, three]
    beatlas("seeds", folder, "remove", "all")
    assert "no seeds" in beatlas("seeds", folder, "list").stdout
    again(folder, package)
    expect_same(PACKAGE, package)


def slip():
    """A seed of the heart in the lung, and one of muscle in blood: said, with seed and place, and in the report."""
    folder, package = built("slip")
    labels, image = labels_of(folder), numpy.asarray(nibabel.load(folder / "exam" / "stack.nii.gz").dataobj)
    k = labels.shape[2] // 2
    inside = numpy.argwhere(labels[:, :, k, 0] > 0)
    box = [slice(low, high) for low, high in zip(inside.min(axis=0), inside.max(axis=0))]
    # Away from the heart, or the mark would lie beside what it says and be no slip.
    apart = ~scipy.ndimage.binary_dilation(labels[:, :, k, 0] > 0, iterations=2)[box[0], box[1]]
    dark = numpy.where(apart, image[box[0], box[1], k, 0], numpy.inf)
    lung = numpy.unravel_index(dark.argmin(), dark.shape) + inside.min(axis=0)
    middle = numpy.argwhere(labels[:, :, k, 0] == LV).mean(axis=0).astype(int)
    for label, (column, row) in (("rest_of_heart", lung), ("lv_myocardium", middle), ("lv_blood", middle)):
        beatlas("seeds", folder, "add", "--label", label, "--slice", k, "--row", row, "--column", column)
    said = beatlas("build", "--study", folder, "-o", package).stderr
    warned = [line for line in said.splitlines() if ": warning: seed " in line]
    told = [line for line in warned if "if that is a slip" in line]
    assert [line.split("seed ")[1][0] for line in told] == ["1", "2"], told
    alone = [line for line in warned if line not in told]
    assert len(alone) == 1 and "seed 1, " in alone[0] and "stays alone" in alone[0], alone
    assert "as dark as lung" in told[0] and "as bright as blood" in told[1], told
    assert all(" at (" in line and "mm LPS, phase 0" in line and "seeds STUDY remove " in line for line in told)
    report = json.loads((folder / "report.json").read_text())
    assert any("seed 1, rest_of_heart" in reason["sentence"] for reason in report["reasons"]), report["reasons"]


def heart_in_touch(file, phases=6):
    """A beating LV in its wall and an RV beside it, all of them tubes, and a still body as bright as blood, on
    which the RV lies without a wall, in noise of a tenth of blood. Gives where the heart is, from closed form, and a
    ball of each structure in three slices, which tell it without a prior."""
    size, step = (84, 60, 30), numpy.array((2.0, 2, 3))
    x, y, z = numpy.moveaxis(numpy.moveaxis(numpy.indices(size), 0, -1) * step - (108, 59, 0), -1, 0)
    chance = numpy.random.default_rng(6)
    from_lv, from_rv = numpy.hypot(x, y), numpy.hypot(x + 40, y)
    within = (z > 10) & (z < 77)
    images, inside = [], []
    for phase in range(phases):
        beat = 0.5 * (1 - numpy.cos(2 * numpy.pi * phase / phases))
        image = numpy.where(x < -52, 400.0, 20.0)
        rv = within & (from_rv < 24 * (1 - 0.15 * beat))
        wall = within & (from_lv < 30 - 1.5 * beat)
        image[rv], image[wall] = 400, 200
        image[within & (from_lv < 20 * (1 - 0.25 * beat))] = 400
        images.append(numpy.hypot(image + chance.normal(0, 40, size), chance.normal(0, 40, size)))
        inside.append(rv | wall)
    stack = nibabel.Nifti1Image(numpy.stack(images, -1).astype(numpy.int16), numpy.diag((-2.0, -2, 3, 1)))
    stack.header.set_zooms((*step, 0.8 / phases))
    stack.header.set_xyzt_units("mm", "sec")
    nibabel.save(stack, file)
    seeds = [{"label": label, "lps_mm": [108 + across, 59 + down, 3 * k], "radius_mm": radius, "phase": 0}
             for k in (4, 14, 25)
             for label, across, down, radius in ((LV, 2, -2, 5), (MUSCLE, 0, 25, 2), (RV, -42, 0, 5), (0, 0, 44, 4))]
    return numpy.stack(inside, -1), {"version": 1, "seeds": seeds}


def elsewhere_ml(before, after, balls, voxel_ml):
    """The largest change of a label in a phase, outside of what hangs together with a change in a ball."""
    differs = before != after
    inside = numpy.zeros(differs.shape, bool)
    place = numpy.moveaxis(numpy.indices(differs.shape[:3]), 0, -1) * numpy.array((2.0, 2, 3))
    for lps, radius, phase in balls:
        ball = (numpy.abs(place - lps) <= radius + 1.5).all(axis=-1)
        inside[..., slice(None) if phase < 0 else slice(phase, phase + 1)] |= ball[..., None]
    # Twice around the beat, which has no first phase.
    lumps, _ = scipy.ndimage.label(numpy.concatenate((differs, differs), axis=3))
    within = numpy.isin(lumps, numpy.unique(lumps[numpy.concatenate((inside & differs,) * 2, axis=3)]))
    count = differs.shape[3]
    differs &= ~(within[..., :count] | within[..., count:])
    gained = [numpy.where(differs, (after == label) * 1 - (before == label), 0).sum(axis=(0, 1, 2))
              for label in range(8)]
    return voxel_ml * numpy.abs(gained).max()


def offered():
    """What the report offers for a leak, run as it stands, halves its alarm and changes nothing else."""
    images, folder, package = WORK / "offered.nii.gz", new_folder("offered"), WORK / "offered.beatlas"
    truth, seeds = heart_in_touch(images)
    # Where the tubes end the image has no edge: what lies beyond is marked, too.
    seeds["seeds"] += [{"label": 0, "lps_mm": [108 + across, 59, 3 * k], "radius_mm": 4, "phase": -1}
                       for k in (0, 1, 28, 29) for across in (0, -40)]
    marks = WORK / "offered_seeds.json"
    marks.write_text(json.dumps(seeds))
    package.unlink(missing_ok=True)
    # Slices stay where the closed form has them.
    recipe = WORK / "offered.json"
    write_recipe(recipe, **{"import": {"align_slices": "off"}})
    beatlas("build", images, "-o", package, "--study", folder, "--recipe", recipe, "--prior", "none", "--seeds", marks)
    told = json.loads((folder / "report.json").read_text())
    assert told["intervals_90"] == told["surfaces_90"] == {}, "no prior foretells them"
    voxel_ml = 0.012

    def seen():
        """Report, ml that leaked, ml that were lost, alarms' sizes by kind."""
        told = json.loads((folder / "report.json").read_text())
        heart = labels_of(folder) > 0
        leaks = [place for place in told["places"] if place["kind"] == "leak"]
        sizes = {place["alarm"]: place["figure"] for place in leaks if place["structure"] == "heart"}
        return (leaks, voxel_ml * (heart & ~truth).sum(axis=(0, 1, 2)).max(),
                voxel_ml * (truth & ~heart).sum(axis=(0, 1, 2)).max(), sizes)

    leaks, leaked_ml, lost_ml, sizes = seen()
    assert leaked_ml > 20, leaked_ml
    lost_at_first = lost_ml
    paths = os.pathsep.join((str(pathlib.Path(PROGRAM).parent), os.environ["PATH"]))
    tried = [place for place in leaks if place["commands"][0].startswith("beatlas seeds")
             and "LABEL" not in place["commands"][0]]
    assert tried, [place["commands"] for place in leaks]
    offer = tried[0]
    before, labels = sizes[offer["alarm"]], labels_of(folder)
    balls = []
    for words in offer["commands"]:
        subprocess.run(words, shell=True, check=True, cwd=folder, env=dict(os.environ, PATH=paths),
                       capture_output=True)
        if "--lps=" in words:
            place, radius, phase = (re.search(rf"--{name}[= ](\S+)", words)[1] for name in ("lps", "radius", "phase"))
            balls.append((numpy.array(place.split(","), float), float(radius), int(phase)))
    leaks, left_ml, lost_ml, sizes = seen()
    changed_ml = elsewhere_ml(labels, labels_of(folder), balls, voxel_ml)
    after = sizes.get(offer["alarm"], 0)
    print(f"{offer['alarm']}, {len(balls)} seeds: {before} mm2, {leaked_ml:.1f} ml leaked; then {after} mm2, "
          f"{left_ml:.1f} ml; {lost_ml:.1f} ml lost ({lost_at_first:.1f}), {changed_ml:.2f} ml changed elsewhere")
    assert after <= 0.5 * before and changed_ml <= 1 and left_ml <= leaked_ml
    assert lost_ml < lost_at_first + 2, "seeds in what leaked, not in the heart"
    told = json.loads((folder / "report.json").read_text())
    assert any(place["kind"] == "leak" for place in told["before"]["places"])

    # Where labels were given they stay, whatever a seed says: none is offered.
    given = WORK / "offered_labels.nii.gz"
    shutil.copyfile(folder / "segment" / "labels.nii.gz", given)
    beatlas("segment", "--study", folder, "--labels", given)
    told = json.loads(beatlas("report", folder, "--json").stdout)
    leaks = [place for place in told["places"] if place["kind"] == "leak"]
    assert leaks and all(place["commands"] == ["beatlas build --study ."] for place in leaks), leaks


def slicer():
    """Seeds as markups of 3D Slicer, and back: the same seeds, whatever the program added."""
    folder = study_of("slicer")
    affine = nibabel.load(folder / "exam" / "stack.nii.gz").affine
    place = lambda *voxel: ",".join(  # noqa: E731
        map(str, nibabel.affines.apply_affine(affine, voxel) * (-1, -1, 1)))
    for words in (("lv_blood", "--lps", place(40, 40, 20), "--phase", "3", "--radius", "5.5"),
                  ("background", "--lps", place(2, 2, 2), "--phase", "-1"),
                  ("lv_blood", "--lps", place(42, 40, 20), "--phase", "3"),
                  ("rv_blood", "--lps", place(20, 30, 20), "--lps", place(24, 30, 20), "--lps",
                   place(26, 33, 20), "--phase", "0", "--radius", "1.25"),
                  ("rest_of_heart", "--lps", place(20, 30, 15), "--lps", place(24, 30, 15))):
        beatlas("seeds", folder, "add", "--label", *words)
    seeds = seeds_of(folder)
    markups = json.loads(beatlas("seeds", folder, "list", "--slicer").stdout)
    assert [(m["type"], m["name"]) for m in markups["markups"]] == [
        ("Fiducial", "lv_blood@3"), ("Fiducial", "background@all"), ("Curve", "rv_blood@0"),
        ("Line", "rest_of_heart@0")]
    # As Slicer 5 saves them again: in RAS if so asked, measurements and colours beside them.
    for markup in markups["markups"]:
        markup["coordinateSystem"] = "RAS"
        markup["measurements"] = [{"name": "length", "enabled": False, "units": "mm"}]
        markup["display"] = {"visibility": True, "color": [1.0, 0.5, 0.5]}
        for point in markup["controlPoints"]:
            x, y, z = point["position"]
            point["position"], point["orientation"] = [-x, -y, z], [-1, 0, 0, 0, -1, 0, 0, 0, 1]
    file = WORK / "slicer.mrk.json"
    file.write_text(json.dumps(markups))
    other = study_of("slicer_back")
    beatlas("segment", "--study", other, "--seeds", file)
    order = [0, 2, 1, 3, 4]  # those of a list come together
    assert seeds_of(other) == [seeds[at] for at in order], seeds_of(other)


def geometry(file):
    """Of the first three axes: size, and the map from voxels to LPS, by nibabel and by VTK."""
    image = nibabel.load(file)
    lps = numpy.diag((-1, -1, 1, 1)) @ image.affine
    reader = vtk.vtkNIFTIImageReader()
    reader.SetFileName(str(file))
    reader.TimeAsVectorOn()
    reader.Update()
    matrix = reader.GetSFormMatrix() or reader.GetQFormMatrix()
    form = numpy.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    # VTK's is of points in mm along the axes from their origin, without the voxels' edges; and its
    # reader turns the slices around where that makes the axes right-handed.
    spacing = numpy.diag((*reader.GetOutput().GetSpacing(), 1))
    assert numpy.allclose(numpy.abs(numpy.diag((-1, -1, 1, 1)) @ form @ spacing)[:3, :3],
                          numpy.abs(lps[:3, :3]), atol=1e-4), (form, lps)
    assert reader.GetOutput().GetDimensions() == image.shape[:3]
    return image.shape[:3], lps, vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())


def editors_itk():
    """The same, painted by ITK."""
    if len(sys.argv) < 5:
        print("skipped: ITK is not here; scripts/setup --bench installs it")
        sys.exit(77)
    editors(sys.argv[4])


def editors(paint=None):
    """One phase for an editor: where it is in the patient for every reader; painted there and given
    back, or painted in the study's own file, it is in the labels."""
    folder = study_of("editors")
    beatlas("segment", "--study", folder)
    beatlas("seeds", folder, "add", "--label", "lv", "--slice", 10, "--row", 40, "--column", 40,
            "--phase", 3)
    out = new_folder("editors_out")
    beatlas("export", folder, "--to", "slicer", "--phase", 3, "-o", out)
    assert sorted(file.name for file in out.iterdir()) == [
        "image_03.nii.gz", "labels.ctbl", "labels.txt", "labels_03.nii.gz", "seeds_03.mrk.json"]
    beatlas("seeds", folder, "remove", "all")
    stack = nibabel.load(folder / "exam" / "stack.nii.gz")
    truth = nibabel.load(PHANTOM / "truth_labels.nii.gz")
    size, lps, _ = geometry(out / "image_03.nii.gz")
    assert size == stack.shape[:3]
    # An independent statement of where the images lie: the phantom's own.
    assert numpy.allclose(lps, numpy.diag((-1, -1, 1, 1)) @ truth.affine, atol=1e-3), lps
    assert numpy.allclose(geometry(out / "labels_03.nii.gz")[1], lps, atol=1e-5)
    image = numpy.asarray(nibabel.load(out / "image_03.nii.gz").dataobj)
    assert (image == numpy.asarray(stack.dataobj)[..., 3]).all()
    before = labels_of(folder)
    drawn = nibabel.load(out / "labels_03.nii.gz")
    assert (numpy.asarray(drawn.dataobj) == before[..., 3]).all()
    beatlas("export", folder, "--to", "slicer", "--phase", before.shape[3], "-o", out, code=3)

    # A ball of 8 mm of RV blood in the LV's middle, painted by ITK or by nibabel.
    middle = numpy.argwhere(before[..., 3] == LV).mean(axis=0)
    place = nibabel.affines.apply_affine(lps, middle.round())
    voxels = numpy.moveaxis(numpy.indices(size), 0, -1)
    ball = numpy.linalg.norm(nibabel.affines.apply_affine(lps, voxels) - place, axis=-1) <= 8

    def painted(source, target, *phase):
        if paint:
            said = subprocess.run([paint, str(source), str(target), *map(str, place), "8", str(RV),
                                   *map(str, phase)], capture_output=True, text=True, check=True).stdout
            told = numpy.array(said.split(), float)
            assert numpy.allclose(told[:3], lps[:3, 3], atol=1e-3), "ITK's origin"
            assert numpy.allclose(told[6:].reshape(3, 3).T * told[3:6], lps[:3, :3], atol=1e-4), told
            return
        labels = nibabel.load(source)
        values = numpy.asarray(labels.dataobj).copy()
        (values[..., phase[0]] if phase else values)[ball] = RV
        nibabel.save(nibabel.Nifti1Image(values, labels.affine), target)

    given = WORK / "editors_painted.nii.gz"
    painted(out / "labels_03.nii.gz", given)
    other = study_of("editors_given")
    beatlas("segment", "--study", other, "--labels", given, "--labels-phases", 3)
    found = labels_of(other)[..., 3]
    assert (found[ball] == RV).all() and (found[~ball] == before[..., 3][~ball]).all()

    # Painted over the export: another one does not take its place, nor writes anything beside it.
    painted(out / "labels_03.nii.gz", out / "labels_03.nii.gz")
    files = {file.name: digest(file) for file in out.iterdir()}
    said = beatlas("export", folder, "--to", "slicer", "--phase", 3, "-o", out, code=2).stderr
    assert "labels_03.nii.gz is there and would be lost" in said, said
    assert files == {file.name: digest(file) for file in out.iterdir()}

    # In the study's 4-D file, as ITK-SNAP saves it over.
    file = folder / "segment" / "labels.nii.gz"
    painted(file, given, 3)
    shutil.copyfile(given, file)
    assert states(folder)["segment"] == "edited"
    beatlas("register", "--study", folder)
    after = labels_of(folder)
    changed = numpy.zeros(before.shape, bool)
    changed[..., 3] = ball & (before[..., 3] != RV)
    assert ((after != before) == changed).all()


if __name__ == "__main__":
    globals()[sys.argv[3]]()
