"""Labels on the slices as acquired, where import moved some in place or time: acquired_test.py BEATLAS WORK_FOLDER"""
import json

import nibabel
import numpy

from stage_test import WORK, beatlas, new_folder

SOURCE = "segment/labels_source.nii.gz"


def values(file):
    return numpy.asarray(nibabel.load(file).dataobj)


def nearest(labels, slices_mm, spacing):
    """Each slice of [i, j, k, phase] read at x - shift, in whole voxels; background beyond the rim."""
    out = numpy.zeros_like(labels)
    size = labels.shape[:2]
    for k, shift in enumerate(slices_mm):
        i, j = (numpy.rint(numpy.arange(size[a]) - shift[a] / spacing[a]).astype(int) for a in (0, 1))
        fits_i, fits_j = ((at >= 0) & (at < n) for at, n in zip((i, j), size))
        to = numpy.ix_(numpy.flatnonzero(fits_i), numpy.flatnonzero(fits_j))
        out[:, :, k][to] = labels[:, :, k][numpy.ix_(i[fits_i], j[fits_j])]
    return out


def main():
    exam, folder = new_folder("acquired_exam"), new_folder("acquired")
    beatlas("phantom", "-o", exam, "--preset", "small", "--without", "all", "--phases", "4", "--format",
            "nifti", "--shifts", "2", "--matrix", "128", "128", "18", "--spacing", "1.8", "1.8", "8",
            "--noise-seed", "3")
    beatlas("import", exam / "cine.nii.gz", "--study", folder)
    shifts = json.loads((folder / "exam" / "exam.json").read_text())["slice_shifts_mm"]
    assert len(shifts) == 18 and numpy.abs(shifts).max() > 1, shifts

    # Labels drawn on the images as they came, given back as drawn: nearest voxels there and back.
    drawn = exam / "truth_labels.nii.gz"
    beatlas("segment", "--study", folder, "--labels", drawn)
    image = nibabel.load(folder / "segment" / "labels.nii.gz")
    as_acquired = nibabel.load(folder / SOURCE)
    assert as_acquired.shape == image.shape and as_acquired.get_data_dtype() == image.get_data_dtype()
    assert numpy.array_equal(as_acquired.affine, image.affine)
    assert as_acquired.header.get_zooms() == image.header.get_zooms()
    labels, source = numpy.asarray(image.dataobj), numpy.asarray(as_acquired.dataobj)
    assert (source == nearest(labels, shifts, image.header.get_zooms())).all()
    assert (source == values(drawn)).all() and (labels != source).any()

    # A phase that goes out to an editor and comes back as it was is as it was.
    beatlas("export", folder, "--to", "slicer", "--phase", "1", "-o", new_folder("acquired_slicer"))
    exported = WORK / "acquired_slicer" / "labels_01.nii.gz"
    assert (values(exported) == labels[..., 1]).all()
    beatlas("segment", "--study", folder, "--labels", exported, "--labels-phases", "1", "--labels-aligned")
    assert (values(folder / "segment" / "labels.nii.gz") == labels).all()

    # It is an output of the stage as the others are, and nobody's input.
    record = json.loads((folder / "study.json").read_text())["stages"]
    assert SOURCE in record["segment"]["outputs"] and SOURCE not in record["pictures"]["inputs"]
    (folder / SOURCE).unlink()
    states = {s["name"]: s["state"] for s in json.loads(beatlas("status", folder, "--json").stdout)["stages"]}
    assert states["segment"] == "stale", states

    # Slices that stay where they are have no labels elsewhere.
    recipe = WORK / "acquired.json"
    recipe.write_text(json.dumps({"import": {"align_slices": "off"}}))
    beatlas("import", exam / "cine.nii.gz", "--study", folder, "--recipe", recipe)
    beatlas("segment", "--study", folder, "--recipe", recipe, "--labels", drawn)
    assert not (folder / SOURCE).exists() and (values(folder / "segment/labels.nii.gz") == values(drawn)).all()
    record = json.loads((folder / "study.json").read_text())["stages"]
    assert SOURCE not in record["segment"]["outputs"]


def turned(values, lags):
    """Each slice of [i, j, k, phase] shown so many phases later, round the beat."""
    return numpy.stack([numpy.roll(values[:, :, k], lag, axis=-1) for k, lag in enumerate(lags)], axis=2)


def out_of_step():
    exam, folder = new_folder("late_exam"), new_folder("late")
    beatlas("phantom", "-o", exam, "--preset", "small", "--without", "all", "--phases", "10", "--format",
            "nifti", "--matrix", "96", "96", "12", "--spacing", "2.4", "2.4", "10", "--noise-seed", "3")
    lags = [0] * 12
    lags[6], lags[8] = 2, -2
    late = {}
    for name in ("cine", "truth_labels"):
        image = nibabel.load(exam / f"{name}.nii.gz")
        late[name] = exam / f"late_{name}.nii.gz"
        nibabel.save(nibabel.Nifti1Image(turned(numpy.asarray(image.dataobj), lags), image.affine, image.header),
                     late[name])
    told = beatlas("import", late["cine"], "--study", folder).stderr
    assert "2 of 12 slices show the beat out of step" in told, told
    assert json.loads((folder / "exam" / "exam.json").read_text())["slice_lags"] == lags

    # Labels drawn on the images as they came are put in step with them, and out again.
    beatlas("segment", "--study", folder, "--labels", late["truth_labels"])
    labels = values(folder / "segment" / "labels.nii.gz")
    assert (labels == values(exam / "truth_labels.nii.gz")).all()
    assert (values(folder / SOURCE) == values(late["truth_labels"])).all()

    # A phase of the study's images that comes back as it went out changes nothing, in no phase.
    beatlas("export", folder, "--to", "slicer", "--phase", "1", "-o", new_folder("late_slicer"))
    beatlas("segment", "--study", folder, "--labels", WORK / "late_slicer" / "labels_01.nii.gz", "--labels-phases",
            "1", "--labels-aligned")
    assert (values(folder / "segment" / "labels.nii.gz") == labels).all()

    # What is painted in it is in that phase, and in no other.
    file = WORK / "late_slicer" / "labels_01.nii.gz"
    image = nibabel.load(file)
    painted = numpy.asarray(image.dataobj).copy()
    painted[:, :, 6][painted[:, :, 6] == 3] = 2
    assert (painted != labels[..., 1]).any()
    nibabel.save(nibabel.Nifti1Image(painted, image.affine, image.header), file)
    beatlas("segment", "--study", folder, "--labels", file, "--labels-phases", "1", "--labels-aligned")
    labels[..., 1] = painted
    assert (values(folder / "segment" / "labels.nii.gz") == labels).all()

    # A phase beyond the beat is none of those before it.
    told = beatlas("segment", "--study", folder, "--labels", file, "--labels-phases", "11", "--labels-aligned",
                   code=3)
    assert "phase 11 is not known" in told.stderr, told.stderr

    # Slices that stay when they were imaged have no lags.
    recipe = WORK / "late.json"
    recipe.write_text(json.dumps({"import": {"align_slices": "off"}}))
    beatlas("import", late["cine"], "--study", folder, "--recipe", recipe)
    assert "slice_lags" not in json.loads((folder / "exam" / "exam.json").read_text())


main()
out_of_step()
