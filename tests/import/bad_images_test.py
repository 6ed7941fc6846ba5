"""Images that show no beating heart in space: too few, not of one size, without a place, of no number.
Refused as bad_input_test.py has it, or told: bad_images_test.py BEATLAS NAME"""
import numpy as np
import pydicom

from bad_exams import RR, STEP, TRUTH, damaged, dicom, each_refused, refused_or_told, volumes
from dicom_writers import decimal, pixel_format
from exam_object import BeatingObject, expect_object
from harness import case, imported, main, refused
from volume_writers import metaimage, nifti, nrrd


@case
def missing_phases(folder):
    """A slice amid the stack shows a part of the cycle only: it is left blank, two are too many."""
    exam = imported(folder / "told", dicom(folder, name="amid", keep=lambda k, p: k != 2 or p < 5))
    assert exam.stack.size == (20, 16, 5), exam.stack.size
    exam.expect_warning("slice 2 is missing within the stack")
    source = dicom(folder, keep=lambda k, p: k not in (2, 3) or p < 5)
    refused(folder, source, "dicom", "slice", "cycle|phases|frames|hole|gap")
    # At the end of the stack it is left, with a warning.
    source = dicom(folder, name="end", keep=lambda k, p: k != 4 or p < 5)
    exam = imported(folder / "study", source)
    assert exam.stack.size == (20, 16, 4), exam.stack.size
    exam.expect_warning("slice")
    # All slices stop half-way: no heart beats on without images.
    half = dicom(folder, name="half", frames=lambda k: [p / 20 for p in range(10)])
    refused(folder, half, "half", "cycle|phases|R-R|beat")


@case
def one_phase(folder):
    refused(folder, dicom(folder, keep=lambda k, p: p == 3), "dicom", "phase")
    single = BeatingObject(size=(20, 16, 5), phases=1)
    each_refused(folder, volumes(folder, single.array()), "phase|one image|time", options=RR)
    each_refused(folder, volumes(folder, single.array()[..., 0], name="flat"),
                 "phase|one image|time", options=RR)


@case
def one_slice(folder):
    flat = BeatingObject(size=(20, 16, 1))
    refused(folder, dicom(folder, flat), "dicom", "slice", r"\b(3|three)\b")
    each_refused(folder, volumes(folder, flat.array(), flat.lps), "slice")
    two = BeatingObject(size=(20, 16, 2))
    refused(folder, dicom(folder, two, name="two"), "two", "slice", r"\b(3|three)\b")


@case
def mixed_sizes(folder):
    """One image of another size amid a series: named."""
    def smaller(d):
        pixel_format(d, d.pixel_array[:12, :14])
    said = refused(folder, damaged(folder, 17, smaller), "IM000017", "size|pixels|rows")
    assert "20" in said or "14" in said, f"says no size: {said}"


@case
def zero_or_negative_spacing_of_dicom(folder):
    for n, spacing in enumerate((["0", "2.1"], ["1.7", "-2.1"], ["0", "0"], None)):
        def change(k, p, d):
            d.PixelSpacing = spacing
        source = dicom(folder, name=f"all{n}", change=change)
        refused(folder, source, f"all{n}", "spacing")
    # In one image: that one is named, or its absence is told.
    source = damaged(folder, 17, lambda d: setattr(d, "PixelSpacing", ["0", "2.1"]))
    refused_or_told(folder, source, "IM000017", "spacing")


@case
def zero_or_negative_spacing_of_volumes(folder):
    data = TRUTH.array()
    flat = TRUTH.lps.copy()
    flat[:3, 2] = 0
    for pixdim in ((2.1, 0, 7.3), (2.1, 1.7, -7.3)):
        file = nifti(folder / "q.nii", data, TRUTH.lps, STEP, sform=False, pixdim=pixdim)
        refused(folder, file, r"q\.nii", "spacing|voxel size|pixdim|edge|mm")

    def zero(header):
        header["srow_x"][2] = header["srow_y"][2] = header["srow_z"][2] = 0
    file = nifti(folder / "s.nii", data, TRUTH.lps, STEP, qform=False, pixdim=(2.1, 1.7, 0),
                 change=zero)
    refused(folder, file, r"s\.nii", "spacing|voxel size|sform|pixdim|edge|mm")
    file = nrrd(folder / "z.nrrd", data, flat, list_axis=3)
    refused(folder, file, r"z\.nrrd", "spacing|direction|voxel size|edge", options=RR)
    for step in ("2.1 0 7.3 0.08437", "2.1 1.7 -7.3 0.08437"):
        file = metaimage(folder / "m.mha", data, TRUTH.lps, STEP)
        content = file.read_bytes()
        start = content.index(b"ElementSpacing")
        end = content.index(b"\n", start)
        file.write_bytes(content[:start] + f"ElementSpacing = {step}".encode() + content[end:])
        refused(folder, file, r"m\.mha", "spacing|voxel size|edge")


@case
def voxels_that_are_no_number(folder):
    for value in (np.nan, np.inf):
        data = TRUTH.array()
        data[4, 5, 2, 6] = value
        each_refused(folder, volumes(folder, data, dtype="float32"), "number|NaN|finite|infinite")


@case
def places_that_are_no_number(folder):
    """One image whose position is no number: named, never skipped without a word."""
    source = dicom(folder)
    file = source / "IM000017"
    first = decimal(pydicom.dcmread(file).ImagePositionPatient[0]).encode()
    content = file.read_bytes()
    assert content.count(first) == 1
    file.write_bytes(content.replace(first, b"nan".ljust(len(first))))
    refused_or_told(folder, source, "IM000017", "position")


@case
def all_zero_images(folder):
    def black(k, p, d):
        d.PixelData = bytes(len(d.PixelData))
    refused(folder, dicom(folder, change=black), "dicom", "nothing|zero|one value|empty|black")
    each_refused(folder, volumes(folder, TRUTH.array() * 0), "nothing|zero|one value|empty|black")
    # One phase black in one slice or in all: damaged, not a heart that goes out.
    source = dicom(folder, name="phase", change=lambda k, p, d: black(k, p, d) if p == 4 else None)
    refused(folder, source, "phase", "nothing|zero|one value|empty|black")


@case
def another_modality_than_mr(folder):
    """A gated CT is read, with a warning."""
    for modality, sop in (("CT", "1.2.840.10008.5.1.4.1.1.2"), ("US", "1.2.840.10008.5.1.4.1.1.6.1")):
        def change(k, p, d):
            d.Modality, d.SOPClassUID = modality, sop
            d.file_meta.MediaStorageSOPClassUID = sop
        exam = imported(folder / f"study-{modality}", dicom(folder, name=modality, change=change))
        expect_object(exam, TRUTH)
        exam.expect_warning("MR|modality|magnetic")
    exam = imported(folder / "study-mr", dicom(folder, name="mr"))
    assert not exam.told("modality|no MR"), exam.decisions


@case
def colour_images(folder):
    def colour(k, p, d):
        d.SamplesPerPixel, d.PhotometricInterpretation, d.PlanarConfiguration = 3, "RGB", 0
        d.BitsAllocated, d.BitsStored, d.HighBit = 8, 8, 7
        d.PixelData = bytes(range(240)) * 4
    refused(folder, dicom(folder, change=colour), "dicom", "colou?r")
    # NIfTI RGB24 and RGBA32.
    for code, bytes_each in ((128, 3), (2304, 4)):
        file = nifti(folder / "rgb.nii", TRUTH.array(), TRUTH.lps, STEP, dtype="int16")
        content = bytearray(file.read_bytes())
        content[70:74] = np.array([code, 8 * bytes_each], "<i2").tobytes()
        count = int(np.prod(TRUTH.array().shape))
        file.write_bytes(bytes(content[:352]) + bytes(range(200)) * (count * bytes_each // 200 + 1))
        refused(folder, file, r"rgb\.nii", "colou?r")
    data = TRUTH.array()[..., :3]
    for kind in ("RGB-color", "3-color"):
        file = nrrd(folder / "rgb.nrrd", data, TRUTH.lps, list_axis=0, kind=kind)
        refused(folder, file, r"rgb\.nrrd", "colou?r", options=RR)
    file = metaimage(folder / "rgb.mha", TRUTH.array(), TRUTH.lps, STEP,
                     fields=("ElementNumberOfChannels = 3",))
    content = file.read_bytes()
    at = content.index(b"LOCAL\n") + 6
    file.write_bytes(content[:at] + content[at:] * 3)
    refused(folder, file, r"rgb\.mha", "colou?r|channels|values a voxel|component")


@case
def a_fourth_axis_that_is_not_time(folder):
    why = "time"
    for unit in ("hz", "ppm", "rads"):
        file = nifti(folder / f"{unit}.nii", TRUTH.array(), TRUTH.lps, STEP, unit=unit)
        refused(folder, file, rf"{unit}\.nii", why)
    # A vector field in the fifth dimension, a symmetric matrix in the fourth by intent.
    file = nifti(folder / "matrix.nii", TRUTH.array()[..., :6], TRUTH.lps, STEP, unit="unknown",
                 change=lambda h: h.__setitem__("intent_code", 1005))
    refused(folder, file, r"matrix\.nii", f"{why}|matrix|vector|intent", options=RR)
    for kind in ("3-vector", "vector", "3-gradient", "3D-symmetric-matrix"):
        data = TRUTH.array()[..., :6 if "matrix" in kind else 3]
        file = nrrd(folder / "vector.nrrd", data, TRUTH.lps, list_axis=0, kind=kind)
        refused(folder, file, r"vector\.nrrd", f"{why}|vector|matrix|kind", options=RR)
    keys = [("modality", "DWMRI"), ("DWMRI_b-value", "1000")]
    keys += [(f"DWMRI_gradient_{n:04d}", "0 0 1") for n in range(10)]
    file = nrrd(folder / "diffusion.nrrd", TRUTH.array(), TRUTH.lps, list_axis=3, keys=keys)
    refused(folder, file, r"diffusion\.nrrd", f"{why}|diffusion", options=RR)


@case
def five_dimensions(folder):
    file = nifti(folder / "five.nii", TRUTH.array(), TRUTH.lps, STEP)
    content = bytearray(file.read_bytes())
    content[40:42] = (5).to_bytes(2, "little")
    content[50:52] = (3).to_bytes(2, "little")
    file.write_bytes(bytes(content[:352]) + bytes(content[352:]) * 3)
    refused(folder, file, r"five\.nii", "dimension")


@case
def complex_voxels(folder):
    file = nifti(folder / "complex.nii", TRUTH.array(), TRUTH.lps, STEP)
    content = bytearray(file.read_bytes())
    content[70:74] = np.array([32, 64], "<i2").tobytes()
    file.write_bytes(bytes(content[:352]) + bytes(content[352:]) * 4)
    refused(folder, file, r"complex\.nii", "complex|type")


@case
def sheared_stacks(folder):
    """Slices that slide sideways, or a tilted gantry: never straightened in silence. Slices of DICOM, each of
    which tells its place, are; a volume has one for all."""
    def slide(k, p, d, step=2.4):
        at = TRUTH.place((0, 0, k)) + step * k * TRUTH.turn[:, 0]
        d.ImagePositionPatient = [decimal(v) for v in at]
    imported(folder / "S", dicom(folder, change=slide)).expect_warning("whose middle lies", "resampled")
    far = dicom(folder, name="far", change=lambda k, p, d: slide(k, p, d, 1000))
    refused(folder, far, "far", "no field of view in common")
    lps = TRUTH.lps.copy()
    lps[:3, 2] += 2.4 * TRUTH.turn[:, 0]
    data = TRUTH.array()
    files = [nifti(folder / "tilt.nii", data, lps, STEP, qform=False),
             nrrd(folder / "tilt.nrrd", data, lps, list_axis=3),
             metaimage(folder / "tilt.mha", data, lps, STEP)]
    each_refused(folder, files, "shear|tilt|orthogonal|perpendicular|right angle", options=RR)


@case
def cosines_that_are_none(folder):
    def double(k, p, d):
        d.ImageOrientationPatient = [decimal(2 * float(v)) for v in d.ImageOrientationPatient]
    refused(folder, dicom(folder, change=double), "dicom", "orientation|cosine")
    source = dicom(folder, name="none", change=lambda k, p, d: delattr(d, "ImageOrientationPatient"))
    refused(folder, source, "none", "orientation|position")


@case
def derived_images_without_geometry_are_left(folder):
    """A screenshot that says MR, a map of no spacing: neither costs the exam. An original does."""
    for name, sop_class, kind, wrong in (
            ("capture", "1.2.840.10008.5.1.4.1.1.7", ["ORIGINAL", "PRIMARY"],
             lambda d: setattr(d, "ImageOrientationPatient", [0] * 6)),
            ("map", "1.2.840.10008.5.1.4.1.1.4", ["DERIVED", "SECONDARY", "MPR"],
             lambda d: setattr(d, "PixelSpacing", [0, 0]))):
        source = dicom(folder, name=name)
        odd = pydicom.dcmread(next(f for f in sorted(source.rglob("*")) if f.is_file()))
        odd.SOPClassUID = odd.file_meta.MediaStorageSOPClassUID = sop_class
        odd.SOPInstanceUID = odd.file_meta.MediaStorageSOPInstanceUID = odd.SOPInstanceUID + ".9"
        odd.SeriesNumber, odd.SeriesInstanceUID = 99, odd.SeriesInstanceUID + ".9"
        odd.ImageType = kind
        wrong(odd)
        odd.save_as(source / "odd")
        exam = imported(folder / (name + "_study"), source)
        expect_object(exam, TRUTH)
        exam.expect_told("ignored 1 image without position")
        odd.SOPClassUID = odd.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4"
        odd.ImageType = ["ORIGINAL", "PRIMARY"]
        odd.save_as(source / "odd")
        refused(folder, source, "odd", "cosines|spacing")


@case
def uneven_slices(folder):
    """A hole amid the stack."""
    def hole(k, p, d):
        at = TRUTH.place((0, 0, k if k < 2 else k + 0.6))
        d.ImagePositionPatient = [decimal(v) for v in at]
    refused(folder, dicom(folder, change=hole), "dicom", "gap|uneven|even|spacing|apart")


if __name__ == "__main__":
    main()
