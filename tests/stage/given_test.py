"""What was marked or segmented elsewhere: given_test.py BEATLAS WORK_FOLDER NAME

WORK_FOLDER is that of stage_test.py, whose `prepare` empties it; the `prepare` of these tests makes the exam.
"""
import json
import shutil
import sys

import nibabel
import numpy

from stage_test import WORK, beatlas, digest, new_folder

PHANTOM = WORK / "given_phantom"
EXAM, IMPORTED = PHANTOM / "cine.nii.gz", WORK / "given_imported"
RV, MUSCLE, LV, REST = 1, 2, 3, 4


def prepare():
    beatlas("phantom", "-o", new_folder(PHANTOM.name), "--preset", "small", "--without", "all", "--phases", 5,
            "--spacing", "2,2,8", "--format", "nifti")
    beatlas("import", EXAM, "--study", new_folder(IMPORTED.name))


def thin_exam(name, *words):
    """The same heart in slices of 4 mm: the folder of its images, and a study that holds them."""
    exam, imported = new_folder(name), new_folder(f"{name}_imported")
    beatlas("phantom", "-o", exam, "--preset", "small", "--without", "all", "--phases", 5, "--format", "nifti", *words)
    beatlas("import", exam / "cine.nii.gz", "--study", imported)
    return exam, imported


def truth(exam=PHANTOM):
    image = nibabel.load(exam / "truth_labels.nii.gz")
    return image, numpy.asarray(image.dataobj).astype(numpy.uint8)


def save(name, labels, affine):
    file = WORK / name
    nibabel.save(nibabel.Nifti1Image(labels, affine), file)
    return file


def study_of(name, imported=IMPORTED):
    """A study that holds the exam alone."""
    folder = new_folder(name)
    shutil.copytree(imported, folder)
    return folder


def labels_of(folder):
    return numpy.asarray(nibabel.load(folder / "segment" / "labels.nii.gz").dataobj)


def segment(folder, *words, code=0):
    said = beatlas("segment", "--study", folder, *words, code=code).stderr
    return [line for line in said.splitlines() if "warning" not in line][-1] if code else said


def options(folder):
    return json.loads((folder / "study.json").read_text())["stages"]["segment"]["options"]


def dice(a, b):
    return 2 * (a & b).sum() / (a.sum() + b.sum())


def dices(found, true, phases):
    """Of heart, LV blood, RV blood and muscle: mean over the phases."""
    masks = ((lambda l: l > 0), (lambda l: l == LV), (lambda l: l == RV), (lambda l: l == MUSCLE))
    return [numpy.mean([dice(mask(found[..., p]), mask(true[..., p])) for p in phases])
            for mask in masks]


def ends(true):
    volume = (true == LV).sum(axis=(0, 1, 2))
    return int(volume.argmax()), int(volume.argmin())


def marks():
    """Markups of 3D Slicer and a seeds file that says the same give the same labels."""
    image, true = truth()
    middle = true.shape[2] // 2
    inner = {}
    for label in (RV, MUSCLE, LV):
        at = numpy.argwhere(true[:, :, middle, 0] == label)
        column = at[at[:, 0] == int(numpy.median(at[:, 0]))]
        ends_of = [(*column[0], middle), (*column[len(column) // 3], middle)]
        inner[label] = nibabel.affines.apply_affine(image.affine, ends_of)
    ours = {"version": 1, "seeds": []}
    markups = []
    for name, label in (("RV blood", RV), ("Myocardium", MUSCLE), ("LV", LV)):
        lps = (inner[label] * (-1, -1, 1)).tolist()
        ours["seeds"].append({"label": label, "stroke_lps_mm": lps, "radius_mm": 1.5, "phase": 1})
        markups.append({"type": "Line", "name": name, "coordinateSystem": "RAS",
                        "controlPoints": [{"label": f"{name}-{n + 1}", "position": place}
                                          for n, place in enumerate(inner[label].tolist())]})
    seeds, slicer = WORK / "marks.json", WORK / "marks.mrk.json"
    seeds.write_text(json.dumps(ours))
    slicer.write_text(json.dumps({"@schema": "https://x/markups-schema-v1.0.3.json#",
                                  "markups": markups}))
    one, two = study_of("given_seeds"), study_of("given_markups")
    segment(one, "--seeds", seeds)
    segment(two, "--seeds", slicer, "--seeds-phase", "1", "--seeds-radius", "1.5")
    assert digest(one / "segment" / "labels.nii.gz") == digest(two / "segment" / "labels.nii.gz")
    assert "Myocardium" not in (two / "study.json").read_text()
    # The study remembers them; replayed from what it keeps they are the same.
    assert "nothing has changed" in segment(one)
    again = study_of("given_replayed")
    kept = WORK / "kept.json"
    kept.write_text(json.dumps(json.loads((two / "study.json").read_text())["seeds"]))
    segment(again, "--seeds", kept)
    assert digest(again / "segment" / "labels.nii.gz") == digest(one / "segment" / "labels.nii.gz")


def again():
    """After a stroke, and after it was taken back, the result is that of a study of its own."""
    image, true = truth()
    middle = true.shape[2] // 2
    at = numpy.argwhere(true[:, :, middle, 2] == MUSCLE)
    outer = at[at[:, 0].argmax()]
    ends_of = [(outer[0], outer[1] + by, middle) for by in (-4, 4)]
    lps = (nibabel.affines.apply_affine(image.affine, ends_of) * (-1, -1, 1)).tolist()
    seeds = WORK / "stroke.json"
    seeds.write_text(json.dumps({"version": 1, "seeds": [
        {"label": 0, "stroke_lps_mm": lps, "radius_mm": 2, "phase": 2}]}))

    def files(folder):
        return {file.name: digest(file) for file in (folder / "segment").iterdir()}

    folder, fresh = study_of("given_again"), study_of("given_fresh")
    segment(folder)
    automatic = files(folder)
    segment(folder, "--seeds", seeds)
    segment(fresh, "--seeds", seeds)
    assert files(folder) == files(fresh)
    assert files(folder)["labels.nii.gz"] != automatic["labels.nii.gz"]
    segment(folder, "--seeds", "none")
    assert files(folder) == automatic


def painted():
    """A painting on the grid of the images or a finer one, of one phase or of all; it stays drawn."""
    image, true = truth()
    plain = study_of("painted_none")
    segment(plain)
    # Half of the LV's blood painted as RV blood in the middle slices of one phase.
    paint = numpy.zeros(true.shape[:3], numpy.uint8)
    middle = true.shape[2] // 2
    inside = true[..., 0] == LV
    inside[:, :, : middle - 1] = inside[:, :, middle + 2 :] = False
    half = int(numpy.median(numpy.argwhere(inside)[:, 0]))
    inside[half:] = False
    paint[inside] = RV
    folder = study_of("painted")
    segment(folder, "--seeds", save("painted.nii.gz", paint, image.affine))
    found = labels_of(folder)
    assert (found[..., 0][inside] == RV).mean() > 0.99, "what was painted stays as painted"
    assert (labels_of(plain)[..., 0][inside] == RV).mean() < 0.01
    told = options(folder)["painted"]
    assert told["phases"] == [0] and len(told["file_sha256"]) == 64, told
    text = (folder / "study.json").read_text()
    assert "painted.nii" not in text and str(WORK) not in text

    # Other numbers; twice as fine, so that each voxel holds eight of it: the same marks.
    fine = numpy.kron(numpy.where(inside, 7, 0).astype(numpy.uint8), numpy.ones((2, 2, 2), numpy.uint8))
    affine = image.affine.copy()
    affine[:3, :3] /= 2
    affine[:3, 3] -= affine[:3, :3] @ (0.5, 0.5, 0.5)
    other = study_of("painted_fine")
    segment(other, "--seeds", save("fine.nii.gz", fine, affine), "--label-map", "7=rv_blood")
    assert (labels_of(other) == found).all()

    # As 4-D with only that phase painted.
    cycle = numpy.zeros(true.shape, numpy.uint8)
    cycle[..., 0] = paint
    other = study_of("painted_cycle")
    segment(other, "--seeds", save("cycle.nii.gz", cycle, image.affine))
    assert (labels_of(other) == found).all()

    # The study remembers a painting, whatever becomes of the file; none gives it up.
    (WORK / "painted.nii.gz").unlink()
    assert "nothing has changed" in segment(folder)
    segment(folder, "--discard-edits")
    segment(folder, "--seeds", "none")
    assert (labels_of(folder) == labels_of(plain)).all()
    segment(folder)
    assert "given" not in json.loads((folder / "study.json").read_text())
    assert not list((folder / "given").glob("*.nii.gz"))


def labels():
    """A segmentation from elsewhere: whole, or end-diastole and end-systole, on any grid."""
    exam, imported = thin_exam("labels_exam")
    image, true = truth(exam)
    phases = true.shape[3]
    ed, es = ends(true)
    others = [p for p in range(phases) if p not in (ed, es)]
    whole = study_of("labels_whole", imported)
    segment(whole, "--labels", exam / "truth_labels.nii.gz")
    assert (labels_of(whole) == true).all(), "as they are"
    package = WORK / "labels.beatlas"
    said = beatlas("build", "--study", whole, "-o", package).stderr
    assert "edited by hand" not in said, said
    provenance = json.loads(beatlas("info", package, "--json").stdout)["provenance"]
    assert "truth_labels" not in json.dumps(provenance) and "file_sha256" in json.dumps(provenance)

    # Only the two ends, as ACDC gives them: every slice in another order, M&Ms' numbers.
    order = sorted((ed, es))
    mms = numpy.select([true == LV, true == MUSCLE, true == RV], [1, 2, 3]).astype(numpy.uint8)
    affine = image.affine.copy()
    affine[:3, 3] += affine[:3, 2] * (true.shape[2] - 1)
    affine[:3, 2] *= -1
    file = save("mms.nii.gz", mms[:, :, ::-1][..., order], affine)
    led, plain = study_of("labels_ends", imported), study_of("labels_none", imported)
    words = ("--labels", file, "--labels-phases", f"{order[0]},{order[1]}", "--label-map", "mms")
    segment(led, *words)
    segment(plain)
    found = labels_of(led)
    for p in order:
        for label in (LV, MUSCLE, RV):
            assert ((found[..., p] == label) == (true[..., p] == label)).all(), "as given"
    beatlas("report", led)
    assert f'"drawn_phases":[{order[0]},{order[1]}]' in (led / "report.html").read_text()
    automatic = labels_of(plain)
    for name, a, b in zip(("LV", "RV", "muscle"), dices(automatic, true, others)[1:],
                          dices(found, true, others)[1:]):
        print(f"{name}: mean Dice of the other phases {a:.4f} automatic, {b:.4f} with ED and ES")
        # Where both are right but for the voxels of the boundary, none is the better one.
        assert b >= a - 5e-4, (name, a, b)
    # One phase after the other is the same as both at once.
    first, second = (save(f"mms_{p}.nii.gz", mms[:, :, ::-1][..., p], affine) for p in order)
    apart = study_of("labels_apart", imported)
    for p, one in zip(order, (first, second)):
        segment(apart, "--labels", one, "--labels-phases", p, "--label-map", "mms")
    assert (labels_of(apart) == found).all()
    half = save("mms_half.nii.gz", mms[::2, ::2, ::-1, order[0]], affine @ numpy.diag((2, 2, 1, 1)))
    said = segment(apart, "--labels", half, "--labels-phases", order[0], "--label-map", "mms", code=3)
    assert f"other voxels than the labels of phase {order[1]}" in said, said
    # Remembered without the file, and given up.
    file.unlink()
    assert "nothing has changed" in segment(led)
    segment(led, "--labels", "none")
    assert (labels_of(led) == automatic).all()


def coverage():
    """Labels with the exact shares of voxels beside them: the surfaces lie where the shares say."""
    exact, imported = thin_exam("given_exact", "--coverage")
    shares = exact / "truth_coverage"
    names = ("heart", "lv_blood", "lv_myocardium", "rv_blood")
    assert sorted(file.name for file in shares.iterdir()) == [f"coverage_{n}.nii.gz" for n in names]
    labels = ("--labels", exact / "truth_labels.nii.gz")
    package, folder = WORK / "given_coverage.beatlas", new_folder("given_coverage")
    beatlas("build", exact / "cine.nii.gz", "-o", package, "--study", folder, "--no-report",
            "--scene", "palpation", *labels, "--coverage", shares)
    found = json.loads(beatlas("validate", package, "--truth", exact, "--json").stdout)
    heart = [p for s in found["structures"] if s["name"] == "heart" for p in s["phases"]]
    mean, bias = (numpy.mean([p[key] for p in heart]) for key in ("mean_mm", "bias_mm"))
    print(f"heart: mean {mean:.3f} mm, bias {bias:+.3f} mm")
    # Voxels of 2 x 2 x 4 mm; the labels alone give 0.13.
    assert mean < 0.05 and abs(bias) < 0.03, (mean, bias)

    # The study keeps them, tells of them by hash, and reads its own files as well as the phantom's.
    told = options(folder)
    assert all(len(told[f"coverage_{n}"]["sha256"]) == 64 for n in names), told
    assert "truth_coverage" not in (folder / "study.json").read_text()
    before = digest(folder / "segment" / "coverage_heart.nii.gz")
    moved = WORK / "given_moved"
    shutil.rmtree(moved, ignore_errors=True)
    shares.rename(moved)
    assert "nothing has changed" in segment(folder)
    segment(folder, "--discard-edits")
    assert digest(folder / "segment" / "coverage_heart.nii.gz") == before
    other = study_of("given_coverage_again", imported)
    segment(other, *labels, "--coverage", folder / "segment")
    assert digest(other / "segment" / "coverage_heart.nii.gz") == before

    # Slices and columns in another order are the same voxels.
    turned = WORK / "given_turned"
    shutil.rmtree(turned, ignore_errors=True)
    turned.mkdir()
    for name in names:
        own = nibabel.load(moved / f"coverage_{name}.nii.gz")
        affine = own.affine.copy()
        affine[:3, 3] += affine[:3, 1:3] @ (numpy.array(own.shape[1:3]) - 1)
        affine[:3, 1:3] *= -1
        values = numpy.float32(own.dataobj)[:, ::-1, ::-1]
        nibabel.save(nibabel.Nifti1Image(values, affine), turned / f"coverage_{name}.nii.gz")
    again = study_of("given_coverage_turned", imported)
    segment(again, *labels, "--coverage", turned)
    one, two = (nibabel.load(f / "segment" / "coverage_heart.nii.gz").get_fdata()
                for f in (folder, again))
    assert numpy.abs(one - two).max() < 1e-6

    # Each mistake is one sentence.
    def refused(change, *words, code=3):
        bad = WORK / "given_bad"
        shutil.rmtree(bad, ignore_errors=True)
        shutil.copytree(moved, bad)
        change(bad)
        return segment(again, *(words or (*labels, "--coverage", bad)), code=code)

    def saved(name, data, affine=None):
        def change(bad):
            own = nibabel.load(moved / "coverage_heart.nii.gz")
            values = data(numpy.float32(own.dataobj)) if data else numpy.float32(own.dataobj)
            nibabel.save(nibabel.Nifti1Image(values, own.affine if affine is None else affine(own.affine)),
                         bad / name)
        return change

    def shifted(by):
        return lambda affine: affine + numpy.outer(affine[:, 0] * by, (0, 0, 0, 1))

    heart = "coverage_heart.nii.gz"
    for change, told in (
            (saved(heart, lambda v: v * 100), "share of a voxel, 0 to 1"),
            (saved(heart, lambda v: v * 0), "covers nothing"),
            (saved(heart, lambda v: v[..., :3]), "holds 3 images"),
            (saved(heart, None, shifted(0.5)), "between the images' voxels"),
            (saved(heart, None, shifted(80)), "reaches beyond the images"),
            (saved(heart, None, shifted(5)), "tell the opposite of"),
            (saved("coverage_aorta.nii.gz", None), "the labels hold none of it"),
            (saved("coverage_spleen.nii.gz", None), "its name ends with no structure"),
            (lambda bad: (bad / heart).write_text("hello"), "coverage_heart.nii.gz"),
            (lambda bad: [file.unlink() for file in bad.iterdir()], "holds no coverage_")):
        said = refused(change)
        assert said.startswith("beatlas: ") and told in said, (told, said)
    ok = lambda bad: None
    said = refused(ok, *labels, "--coverage", WORK / "no_such_folder")
    assert "no folder that can be read" in said, said
    assert "--labels must name" in refused(ok, "--coverage", moved, code=2)
    said = refused(ok, *labels, "--coverage", moved, "--labels-phases", "0,3", code=2)
    assert "every phase" in said, said
    # Other labels have none of it, and it can be given up alone.
    segment(again, "--coverage", "none")
    assert "coverage_heart" not in options(again) and "labels" in options(again)


def axes():
    """Images turned towards the patient's axes, slices first or second: one stack, one segmentation,
    and labels go by place, whichever of the two is turned."""
    plain = study_of("axes_plain")
    segment(plain)
    image = nibabel.load(plain / "exam" / "stack.nii.gz")
    step_s = image.header.get_zooms()[3]
    label_image, true = truth()

    def turned(name, values, affine, order, flips):
        """Axis n of the file is the axis order[n] of the stack, backwards where flips[n]."""
        at = numpy.eye(4)
        at[:3, :3] = 0
        for n, (axis, flip) in enumerate(zip(order, flips)):
            at[axis, n] = -1 if flip else 1
            at[axis, 3] = values.shape[axis] - 1 if flip else 0
        values = numpy.transpose(values, [*order, 3])
        values = numpy.flip(values, [n for n, flip in enumerate(flips) if flip])
        out = nibabel.Nifti1Image(values, affine @ at)
        out.header.set_zooms([*out.header.get_zooms()[:3], step_s])
        out.header.set_xyzt_units("mm", "sec")
        nibabel.save(out, WORK / name)
        return WORK / name

    def on_stack(folder):
        """Labels of a study, voxel by voxel where those of `image` lie."""
        other = nibabel.load(folder / "segment" / "labels.nii.gz")
        assert other.shape[2] == image.shape[2], other.shape
        at = numpy.linalg.inv(other.affine) @ image.affine
        index = numpy.stack(numpy.meshgrid(*map(numpy.arange, image.shape[:3]), indexing="ij"), -1)
        there = index @ at[:3, :3].T + at[:3, 3]
        assert numpy.abs(there - numpy.rint(there)).max() < 1e-2
        return numpy.asarray(other.dataobj)[tuple(numpy.moveaxis(numpy.rint(there).astype(int), -1, 0))]

    stack = numpy.asarray(image.dataobj)
    automatic = labels_of(plain)
    for order, flips in (((2, 0, 1), (0, 1, 0)), ((0, 2, 1), (1, 0, 1))):
        name = "axes_" + "".join(map(str, order))
        folder = new_folder(name)
        beatlas("import", turned(name + ".nii.gz", stack, image.affine, order, flips), "--study", folder)
        segment(folder)
        found = on_stack(folder)
        for label in (RV, MUSCLE, LV):
            volumes = [(labels == label).sum(axis=(0, 1, 2)) for labels in (found, automatic)]
            off = numpy.abs(volumes[0] / volumes[1] - 1).max()
            print(f"{name}, label {label}: volume off by {100 * off:.2f} % at most, Dice "
                  f"{dice(found == label, automatic == label):.4f}")
            # A network does not see alike what is turned or seen from the other side.
            assert off < 0.1 and dice(found == label, automatic == label) > 0.95
        segment(folder, "--labels", PHANTOM / "truth_labels.nii.gz")
        assert (on_stack(folder) == true).all(), "labels in the scanner's order, images turned"
        segment(plain, "--labels", turned("axes_labels.nii.gz", true, label_image.affine, order, flips))
        assert (labels_of(plain) == true).all(), "labels turned, images in the scanner's order"


def wrong():
    """Each mistake is one sentence that says what to do, and the study stays as it was."""
    image, true = truth()
    phases = true.shape[3]
    folder = study_of("given_wrong")
    segment(folder)
    before = digest(folder / "segment" / "labels.nii.gz")
    file = {name: save(f"wrong_{name}.nii.gz", *content) for name, content in {
        "one": (true[..., 0], image.affine),
        "two": (true[..., :2], image.affine),
        "empty": (numpy.zeros_like(true[..., 0]), image.affine),
        "numbers": (numpy.where(true[..., 0] == LV, 9, 0).astype(numpy.uint8), image.affine),
        "halves": (true[..., 0] * numpy.float32(0.5), image.affine),
        "flipped": (true, numpy.diag((-1, -1, 1, 1)) @ image.affine @ numpy.array(
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 400], [0, 0, 0, 1]])),
        "gap": (numpy.where(numpy.arange(phases) == 3, 0, true).astype(numpy.uint8), image.affine),
    }.items()}
    (WORK / "wrong.nrrd").write_text("NRRD0004\n")
    slicer = WORK / "wrong.mrk.json"
    slicer.write_text(json.dumps({"markups": [{"type": "Fiducial", "controlPoints": [
        {"label": "spleen-1", "position": [0, 0, 0]}]}]}))
    far = WORK / "far.mrk.json"
    far.write_text(json.dumps({"markups": [{"type": "Fiducial", "controlPoints": [
        {"label": "lv-1", "position": [900, 0, 0]}]}]}))
    for words, code, told in (
            (("--labels", file["one"]), 3, f"has {phases} phases"),
            (("--labels", file["one"]), 3, "--labels-phases"),
            (("--labels", file["two"], "--labels-phases", "0"), 3, "2 images"),
            (("--labels", file["two"], "--labels-phases", f"0,{phases}"), 3, "not known"),
            (("--labels", file["two"], "--labels-phases", "5,1"), 2, "ascending"),
            (("--labels", file["empty"], "--labels-phases", "0"), 3, "empty"),
            (("--labels", file["numbers"], "--labels-phases", "0"), 3, "--label-map 9=NAME"),
            (("--labels", file["halves"], "--labels-phases", "0"), 3, "no label image"),
            (("--labels", file["flipped"]), 3, "outside the images"),
            (("--labels", file["gap"]), 3, "no heart in phase 3"),
            (("--labels", WORK / "wrong.nrrd"), 3, "NIfTI"),
            (("--labels", slicer), 3, "NIfTI"),
            (("--labels", WORK / "none.nii.gz"), 3, "none.nii.gz"),
            (("--labels", file["one"], "--label-map", "lge"), 2, "--label-map"),
            (("--labels-phases", "0"), 2, "--labels must name"),
            (("--label-map", "acdc"), 2, "--label-map"),
            (("--seeds-phase", "0"), 2, "--seeds must name"),
            (("--seeds", file["two"]), 3, f"has {phases} phases"),
            (("--seeds", file["one"], "--seeds-phase", str(phases)), 3, "phase"),
            (("--seeds", file["empty"]), 3, "empty"),
            (("--seeds", file["numbers"]), 3, "--label-map 9=NAME"),
            (("--seeds", file["halves"]), 3, "no label image"),
            (("--seeds", file["flipped"]), 3, "outside the images"),
            (("--seeds", slicer), 3, "'spleen-1' is no known label"),
            (("--seeds", far), 3, "outside the images"),
            (("--seeds", far, "--seeds-phase", "-1", "--seeds-radius", "99"), 2, "--seeds-radius")):
        said = segment(folder, *words, code=code)
        assert said.startswith("beatlas: ") and told in said, (words, said)
        assert digest(folder / "segment" / "labels.nii.gz") == before, words
    # A mistake of before does not stay in the study.
    assert "nothing has changed" in segment(folder, "--seeds", "none", "--labels", "none")


if __name__ == "__main__":
    globals()[sys.argv[3]]()
