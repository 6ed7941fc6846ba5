"""Bad input: one sentence that names the file and the reason, exit code 3, nothing left behind:
bad_input_test.py BEATLAS NAME"""
import json
import re
import zipfile

import numpy as np
import pydicom

from dicom_writers import (classic_exam, convert, cut, decimal, enhanced_image, pixel_format, save,
                           save_all)
from exam_object import BeatingObject, expect_object
from harness import (Exam, beatlas, case, exam_bytes, imported, main, one_sentence, refused, run)
from volume_writers import metaimage, nifti, nrrd

TRUTH = BeatingObject(size=(20, 16, 5))
STEP = 0.08437
RR = ("--rr", "0.8437")


def dicom(folder, truth=TRUTH, name="dicom", **how):
    save_all(folder / name, classic_exam(truth, **how))
    return folder / name


def damaged(folder, number, change):
    """An exam of which one file is changed: IM000017 is frame 7 of slice 2, say."""
    def one(k, p, d):
        if k * TRUTH.phases + p + 1 == number:
            change(d)
    return dicom(folder, change=one)


def volumes(folder, data=None, lps=None, name="cine", step=STEP, **how):
    """The same voxels in each of the other formats; how goes to all."""
    data = TRUTH.array() if data is None else data
    lps = TRUTH.lps if lps is None else lps
    keys = (("axis 3 index type", "numeric"),
            ("axis 3 index values", " ".join(f"{p * step:.6g}" for p in range(data.shape[-1]))))
    listed = {"list_axis": 3, "keys": keys,
              "fields": ('labels: "" "" "" "time"', 'units: "" "" "" "s"')}
    return [nifti(folder / f"{name}.nii", data, lps, step, **how),
            nifti(folder / f"{name}.nii.gz", data, lps, step, **how),
            nrrd(folder / f"{name}.nrrd", data, lps, **(listed if data.ndim == 4 else {}), **how),
            metaimage(folder / f"{name}.mha", data, lps, step, **how)]


def each_refused(folder, files, *patterns, **how):
    for file in files:
        refused(folder, file, file.name.replace(".", r"\."), *patterns, **how)


def refused_or_told(folder, source, file, reason):
    """One image among many: refused by name, or left, with the reason and what it does."""
    done = run("import", source, "--study", folder / "study")
    if done.returncode != 0:
        one_sentence(done, file, reason)
        return
    exam = Exam(folder / "study", done.err)
    exam.expect_told(rf"ignored 1 image.*{reason}")
    exam.expect_warning("fewer frames|missing|lacks|left")


@case
def not_an_image(folder):
    source = folder / "texts"
    source.mkdir()
    (source / "a.txt").write_text("hello\n")
    (source / "b").write_bytes(bytes(range(256)) * 40)
    refused(folder, source, "texts", "DICOM|image")
    for name in ("a.dcm", "a", "a.nii", "a.nii.gz", "a.nrrd", "a.seq.nrrd", "a.nhdr", "a.mha",
                 "a.mhd", "a.txt"):
        for content in (b"hello, this is no image\n" * 30, b""):
            (folder / name).write_bytes(content)
            refused(folder, folder / name, name.replace(".", r"\."))
        (folder / name).unlink()
    refused(folder, folder / "texts" / "b", r"\bb\b")


@case
def nothing_there(folder):
    refused(folder, folder / "missing_exam", "missing_exam")
    refused(folder, folder / "missing.nii.gz", r"missing\.nii\.gz")
    (folder / "empty").mkdir()
    refused(folder, folder / "empty", "empty")


@case
def words_that_cannot_be(folder):
    """Usage, told by the option and what it takes; no word is repeated, it may be a path."""
    source = dicom(folder)
    for words, patterns in {("--rr", "nan"): ("--rr", "0.2 to 3"),
                            ("--rr", "0.1"): ("--rr", "0.2 to 3"),
                            ("--phases", "1"): ("--phases", "2 to 200", r"\b0\b"),
                            ("--phases", "201"): ("--phases", "2 to 200"),
                            ("--times", ""): ("--times", "empty"),
                            ("--series", "7001-9001"): ("--series", "commas")}.items():
        one_sentence(run("import", source, "--study", folder / "study", *words), *patterns, code=2)
    done = run("build", "-o", folder / "x.beatlas", "--series", "7001", "8001", source)
    said = one_sentence(done, "--series", "commas", code=2)
    assert str(source) not in said, said
    one_sentence(run("import", "", "--study", folder / "study"), "SOURCE", "empty", code=2)
    assert not (folder / "study").exists()
    for words in (("--times", folder / "none.txt"), ("--times", "none.txt"), ("--times", source)):
        one_sentence(run("import", source, "--study", folder / "study", *words), "no such file")


@case
def names_that_break_a_line(folder):
    """Control characters of names neither part a message nor reach a terminal."""
    source = dicom(folder)
    odd = source / "IM\n0 \x1b[31m"
    (source / "IM000003").rename(odd)
    cut(odd, 0.5)
    said = refused(folder, source, r"IM\?0 \?\[31m")
    assert "\x1b" not in said, said
    file = nifti(folder / "a\nb.nii", TRUTH.array()[..., :1], TRUTH.lps, STEP)
    refused(folder, file, r"a\?b\.nii: ")
    refused(folder, folder / "no\nsuch", r"no\?such: no such file")
    one_sentence(run("info", folder / "no\nsuch\x1b[31m.beatlas"), r"no\?such\?\[31m")


@case
def an_archive(folder):
    source = dicom(folder)
    with zipfile.ZipFile(folder / "exam.zip", "w") as archive:
        for file in source.iterdir():
            archive.write(file, file.name)
    refused(folder, folder / "exam.zip", r"exam\.zip", "unpack|archive")


@case
def truncated_dicom(folder):
    for n, (share, syntax) in enumerate(((0.9, None), (0.35, None), (0.6, "rle"), (0.6, "jpeg_ls"),
                                         (0.6, "jpeg_2000"), (0.5, "jpeg_lossless"))):
        source = dicom(folder, name=f"d{n}")
        if syntax:
            convert(source, syntax)
        cut(source / "IM000017", share)
        refused(folder, source, "IM000017", "truncated|damaged|broken|incomplete")
    multi = save(enhanced_image(TRUTH, [(k, p) for k in range(5) for p in range(10)]),
                 folder / "enhanced" / "multi")
    cut(multi, 0.8)
    refused(folder, folder / "enhanced", "multi", "truncated|damaged|broken|incomplete")


@case
def truncated_volumes(folder):
    why = "truncated|damaged|broken|incomplete|short|ends|holds"
    files = volumes(folder)
    files.append(nrrd(folder / "zip.nrrd", TRUTH.array(), TRUTH.lps, list_axis=3, encoding="gzip"))
    files.append(metaimage(folder / "zip.mha", TRUTH.array(), TRUTH.lps, STEP, compressed=True))
    for file in files:
        whole = file.read_bytes()
        for share in (0.98, 0.5):
            file.write_bytes(whole[: int(share * len(whole))])
            refused(folder, file, file.name.replace(".", r"\."), why, options=RR)
        file.write_bytes(whole[:100])
        refused(folder, file, file.name.replace(".", r"\."), options=RR)
    for writer, name, data_file in ((nrrd, "far.nhdr", "far.raw"), (metaimage, "far.mhd", "far.zraw")):
        file = (writer(folder / name, TRUTH.array(), TRUTH.lps, list_axis=3, data_file=data_file)
                if writer is nrrd else
                writer(folder / name, TRUTH.array(), TRUTH.lps, STEP, data_file=data_file))
        cut(folder / data_file, 0.9)
        refused(folder, file, r"far\.", why, options=RR)


@case
def a_damaged_gzip_stream(folder):
    """One byte changed within: the checksum tells."""
    for file in (nifti(folder / "cine.nii.gz", TRUTH.array(), TRUTH.lps, STEP),
                 nrrd(folder / "cine.nrrd", TRUTH.array(), TRUTH.lps, list_axis=3, encoding="gzip"),
                 metaimage(folder / "cine.mha", TRUTH.array(), TRUTH.lps, STEP, compressed=True)):
        content = bytearray(file.read_bytes())
        content[len(content) * 3 // 4] ^= 0x10
        file.write_bytes(content)
        refused(folder, file, file.name.replace(".", r"\."), options=RR)


@case
def missing_phases(folder):
    """A slice amid the stack shows a part of the cycle only: nothing is invented."""
    source = dicom(folder, keep=lambda k, p: k != 2 or p < 5)
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
    """Slices that slide sideways, or a tilted gantry: never straightened in silence."""
    def slide(k, p, d):
        at = TRUTH.place((0, 0, k)) + 2.4 * k * TRUTH.turn[:, 0]
        d.ImagePositionPatient = [decimal(v) for v in at]
    refused(folder, dicom(folder, change=slide), "dicom", "shear|shift|tilt")
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
def uneven_slices(folder):
    """A hole amid the stack."""
    def hole(k, p, d):
        at = TRUTH.place((0, 0, k if k < 2 else k + 0.6))
        d.ImagePositionPatient = [decimal(v) for v in at]
    refused(folder, dicom(folder, change=hole), "dicom", "gap|uneven|even|spacing|apart")


@case
def an_encoding_that_is_not_read(folder):
    file = nrrd(folder / "cine.nrrd", TRUTH.array(), TRUTH.lps, list_axis=3)
    file.write_bytes(file.read_bytes().replace(b"encoding: raw", b"encoding: zstd"))
    refused(folder, file, r"cine\.nrrd", "encoding", options=RR)
    source = dicom(folder)
    for path in source.iterdir():
        content = path.read_bytes()
        # MPEG-4: a transfer syntax that no image reader takes.
        path.write_bytes(content.replace(b"1.2.840.10008.1.2.1\0", b"1.2.840.10008.1.2.9\0"))
    refused(folder, source, "dicom|IM0000")


@case
def seeds_outside_the_volume(folder):
    source = dicom(folder)
    middle = [float(v) for v in TRUTH.place((10, 8, 2))]
    outside = [float(v) for v in TRUTH.place((400, 8, 2))]

    def build(name, seeds, *patterns):
        (folder / name).write_text(json.dumps({"seeds": seeds}))
        done = run("build", source, "-o", folder / "heart.beatlas", "--seeds", folder / name)
        # What import chose is told before; the sentence comes once.
        done.err = "".join(line for line in done.err.splitlines(True)
                           if not line.startswith(("beatlas: import:", "beatlas: warning:")))
        one_sentence(done, name.replace(".", r"\."), *patterns)
        assert not (folder / "heart.beatlas").exists()
        assert not list(folder.rglob("*partial*"))
    build("far.json", [{"label": 3, "lps_mm": middle}, {"label": 2, "lps_mm": outside}], "outside")
    build("late.json", [{"label": 3, "lps_mm": middle, "phase": 500}], "phase")
    build("label.json", [{"label": 9, "lps_mm": middle}], "label")
    build("empty.json", [], "seeds")


@case
def what_was_there_stays(folder):
    """A refusal touches neither an old package nor what a study holds."""
    good, bad = dicom(folder, name="good"), dicom(folder, name="bad", keep=lambda k, p: p == 0)
    imported(folder / "study", good)
    before = exam_bytes(folder / "study")
    record = (folder / "study" / "study.json").read_text()
    one_sentence(run("import", bad, "--study", folder / "study"), "bad")
    assert exam_bytes(folder / "study") == before
    stages = json.loads(record)["stages"]
    assert json.loads((folder / "study" / "study.json").read_text())["stages"] == stages
    (folder / "heart.beatlas").write_text("the old one")
    one_sentence(run("build", bad, "-o", folder / "heart.beatlas"), "bad")
    assert (folder / "heart.beatlas").read_text() == "the old one"
    beatlas("import", good, "--study", folder / "study")
    assert exam_bytes(folder / "study") == before


@case
def two_kinds_of_source_at_once(folder):
    source = dicom(folder)
    file = nifti(folder / "cine.nii", TRUTH.array(), TRUTH.lps, STEP)
    refused(folder, [source, file], r"cine\.nii|dicom")
    refused(folder, [file, metaimage(folder / "cine.mha", TRUTH.array(), TRUTH.lps, STEP)], "cine")


@case
def two_files_of_one_image_that_differ(folder):
    """One UID and header, other pixels: no guess, whatever the names."""
    for name in ("A", "Z"):
        source = dicom(folder, name=f"dicom{name}")
        image = pydicom.dcmread(source / "IM000003")
        image.PixelData = bytes(len(image.PixelData))
        image.save_as(source / name)
        refused(folder, source, "IM000003", rf"{name}\b.*differ in their pixels")


@case
def what_lies_behind_the_last_element_is_no_damage(folder):
    source = dicom(folder)
    file = source / "IM000003"
    file.write_bytes(file.read_bytes() + b"\n")
    expect_object(imported(folder / "study", source), TRUTH)


@case
def packed_pixels_without_their_last_mark(folder):
    for syntax in ("rle", "jpeg_2000"):
        source = dicom(folder, name=syntax)
        convert(source, syntax)
        file = source / "IM000003"
        whole = file.read_bytes()
        file.write_bytes(whole[:-8])
        expect_object(imported(folder / f"study-{syntax}", source), TRUTH)
        file.write_bytes(whole[:-12])
        refused(folder, source, "IM000003", "damaged")


@case
def a_private_encoding_in_a_series_that_is_not_used(folder):
    source = dicom(folder)
    other = classic_exam(TRUTH)[0]
    other.SOPInstanceUID = other.file_meta.MediaStorageSOPInstanceUID = "1.2.3.4"
    other.SeriesInstanceUID, other.SeriesNumber = "1.2.3.5", 99
    other.file_meta.TransferSyntaxUID = "1.2.3.4.5.6"
    other.save_as(source / "other")
    expect_object(imported(folder / "study", source), TRUTH)


@case
def bits_at_the_top_of_packed_words(folder):
    """Right if they are plain; no decoder gets them right if they are packed: refused."""
    def left(k, p, d):
        d.PixelData = (np.frombuffer(d.PixelData, "<u2") << 4).astype("<u2").tobytes()
        d.HighBit = 15
    source = dicom(folder, stored=12, change=left)
    expect_object(imported(folder / "study", source), TRUTH)
    convert(source, "rle")
    refused(folder, source, "IM000001", "not supported")


@case
def an_empty_file_is_named(folder):
    source = dicom(folder)
    (source / "IM999999").write_bytes(b"")
    exam = imported(folder / "study", source)
    expect_object(exam, TRUTH)
    exam.expect_warning("1 file is empty")
    assert re.search(r"file 51 of 51 by name\] is empty", exam.said), exam.said


if __name__ == "__main__":
    main()
