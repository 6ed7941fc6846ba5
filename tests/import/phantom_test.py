"""The phantom's images in every format are read back to one cine, by the program and by pydicom:
phantom_test.py BEATLAS NAME"""
import json

import nibabel
import numpy as np
import pydicom

from harness import beatlas, case, imported, main

FORMATS = ("dicom", "dicom-volume", "dicom-enhanced", "nifti")
# Exact shares of voxels that lie askew take ten times as long to make, and no format tells them apart.
WORDS = ("--preset", "small", "--matrix", "48,40,11", "--phases", "9", "--rr", "0.81",
         "--oblique", "12,-7,20", "--partial-volume", "supersampled")


def made(folder, form, *words):
    """The folder of a phantom, its images and its truth."""
    out = folder / form
    said = beatlas("phantom", "-o", out, "--format", form, *WORDS, *words).stdout.decode()
    return out, said.strip(), json.loads((out / "truth.json").read_text())


def expected_grid(truth):
    """LPS from index of the truth's spec, turned about its centre: x, then y, then z."""
    spec = truth["spec"]
    lps = np.array(spec["grid"]["lps_from_index"]).reshape(4, 4)
    a, b, c = np.radians(spec["oblique_deg"])
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    turn = np.eye(4)
    turn[:3, :3] = about_z @ about_y @ about_x
    centre = np.eye(4)
    centre[:3, 3] = (lps @ [*(np.array(spec["grid"]["size"]) - 1) / 2, 1])[:3]
    return centre @ turn @ np.linalg.inv(centre) @ lps


@case
def every_format_is_imported_to_the_same_cine(folder):
    cines = {}
    for form in FORMATS:
        _, images, truth = made(folder, form)
        stack = imported(folder / f"study-{form}", images, *(
            ("--rr", "0.81") if form == "nifti" else ())).stack
        assert stack.size == (48, 40, 11) and stack.phases == 9, (form, stack.size, stack.phases)
        far = np.abs(stack.corners(stack.lps) - stack.corners(expected_grid(truth))).max()
        assert far < 1e-3, f"{form}: voxels lie {far} mm from where they were imaged"
        assert abs(stack.rr_s - 0.81) < 1e-6, (form, stack.rr_s)
        times = np.array(truth["times_s"])
        assert np.abs(np.array(stack.times_s) - times).max() < 1e-5, (form, stack.times_s)
        cines[form] = stack.values
    for form in FORMATS[1:]:
        assert np.array_equal(cines[form], cines["dicom"]), f"{form} holds other voxels"
    assert cines["dicom"].std() > 100


@case
def series_are_as_many_as_the_format_says(folder):
    for form, series, files in (("dicom", 11, 99), ("dicom-volume", 1, 99),
                                ("dicom-enhanced", 1, 1)):
        _, images, _ = made(folder, form)
        found = [pydicom.dcmread(file, stop_before_pixels=True)
                 for file in sorted((folder / form / "dicom").rglob("*.dcm"))]
        assert len(found) == files, (form, len(found))
        assert len({d.SeriesInstanceUID for d in found}) == series, form
        assert len({d.SOPInstanceUID for d in found}) == files, form
        assert len({d.StudyInstanceUID for d in found}) == 1, form


@case
def an_enhanced_object_says_what_the_standard_asks_for(folder):
    """Read with pydicom: voxels, times and places of each frame, and the dimensions."""
    out, images, truth = made(folder, "dicom-enhanced", "--slice-thickness", "6")
    made(folder, "nifti", "--slice-thickness", "6")
    values = np.asarray(nibabel.load(folder / "nifti" / "cine.nii.gz").dataobj)
    d = pydicom.dcmread(next((out / "dicom").glob("*.dcm")))
    assert d.SOPClassUID == pydicom.uid.EnhancedMRImageStorage
    assert d.file_meta.MediaStorageSOPClassUID == d.SOPClassUID
    assert d.file_meta.MediaStorageSOPInstanceUID == d.SOPInstanceUID
    assert int(d.NumberOfFrames) == 99 == len(d.PerFrameFunctionalGroupsSequence)
    pixels = d.pixel_array
    shared = d.SharedFunctionalGroupsSequence[0]
    grid = expected_grid(truth)
    spacing = np.linalg.norm(grid[:3, :3], axis=0)
    measures = shared.PixelMeasuresSequence[0]
    assert np.allclose(measures.PixelSpacing, spacing[[1, 0]], atol=1e-6)
    assert abs(measures.SpacingBetweenSlices - spacing[2]) < 1e-6
    assert measures.SliceThickness == 6
    cosines = np.array(shared.PlaneOrientationSequence[0].ImageOrientationPatient, float)
    assert np.allclose(cosines, np.concatenate([grid[:3, 0] / spacing[0], grid[:3, 1] / spacing[1]]))
    assert list(shared.MRImageFrameTypeSequence[0].FrameType) == list(d.ImageType)
    organization = d.DimensionOrganizationSequence[0].DimensionOrganizationUID
    pointers = [(item.DimensionOrganizationUID, item.DimensionIndexPointer,
                 item.FunctionalGroupPointer) for item in d.DimensionIndexSequence]
    content_tag = pydicom.tag.Tag("FrameContentSequence")
    assert pointers == [(organization, pydicom.tag.Tag("InStackPositionNumber"), content_tag),
                        (organization, pydicom.tag.Tag("TemporalPositionIndex"), content_tag)]
    seen = set()
    for n, group in enumerate(d.PerFrameFunctionalGroupsSequence):
        content, beat = group.FrameContentSequence[0], group.CardiacSynchronizationSequence[0]
        k, p = content.InStackPositionNumber - 1, content.TemporalPositionIndex - 1
        assert list(content.DimensionIndexValues) == [k + 1, p + 1]
        seen.add((k, p))
        place = np.array(group.PlanePositionSequence[0].ImagePositionPatient, float)
        assert np.abs(place - (grid @ [0, 0, k, 1])[:3]).max() < 1e-6
        assert abs(beat.NominalCardiacTriggerDelayTime - 1e3 * truth["times_s"][p]) < 1e-9
        assert abs(beat.RRIntervalTimeNominal - 810) < 1e-9
        assert np.array_equal(pixels[n].T, values[:, :, k, p]), (n, k, p)
    assert len(seen) == 99


@case
def trigger_times_are_nominal_whatever_the_faults(folder):
    faults = ("--jitter", "0.03", "--mistriggered", "3", "--shifts", "2")
    out, images, truth = made(folder, "dicom", *faults)
    files = sorted((out / "dicom").rglob("*.dcm"))
    assert len(files) == 99, len(files)
    for file in files:
        d = pydicom.dcmread(file)
        p = int(d.TemporalPositionIdentifier) - 1
        assert abs(float(d.TriggerTime) - 1e3 * truth["times_s"][p]) < 1e-6
        assert int(d.NominalInterval) == 810
    told = truth["acquisition"]["slices"]
    assert len(told) == 11 and sum(s["mistriggered"] for s in told) == 3
    assert len({t for s in told for t in s["offset_s"]}) > 20
    assert len({tuple(s["shift_mm"]) for s in told}) == 11


@case
def a_truths_spec_makes_the_same_phantom_again(folder):
    faults = ("--bias", "0.3", "--arms", "--jitter", "0.01", "--seed", "5", "--signals", "A")
    _, _, truth = made(folder, "nifti", *faults)
    (folder / "spec.json").write_text(json.dumps(truth["spec"]))
    beatlas("phantom", "-o", folder / "again", "--format", "nifti", "--spec", folder / "spec.json")
    first = (folder / "nifti" / "cine.nii.gz").read_bytes()
    assert (folder / "again" / "cine.nii.gz").read_bytes() == first
    assert json.loads((folder / "again" / "truth.json").read_text()) == truth
    # One word overrides what the file says.
    beatlas("phantom", "-o", folder / "other", "--format", "nifti", "--spec", folder / "spec.json",
            "--no-arms")
    other = json.loads((folder / "other" / "truth.json").read_text())
    assert other["spec"]["scanner"]["arms"] is False
    assert (folder / "other" / "cine.nii.gz").read_bytes() != first


if __name__ == "__main__":
    main()
