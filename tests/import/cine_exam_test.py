"""Real exams, whole and damaged in every way that copying and archiving do:
cine_exam_test.py BEATLAS NAME

Skipped where the exams are not on the machine."""
import pathlib
import shutil

import numpy as np
import pydicom
from PIL import Image

from dicom_writers import ROOT, convert, cut, save, shuffled
from harness import (Exam, case, expect_same_exam, imported, main, one_sentence, refused, run,
                     shared_data)

# From base to apex; row x column points the other way.
SHORT_AXIS = ["Se5", "Se4", "Se3", "Se2", "Se1", "Se11"]
RR_S = [0.863, 0.860, 0.829, 0.776, 0.814, 0.831]


def exam_copy(folder, name="exam"):
    """The short axis and two of the five views, to be damaged."""
    for series in (*SHORT_AXIS, "Se6", "Se8"):
        shutil.copytree(shared_data("cine-exam") / series, folder / name / series)
    return folder / name


def expect_whole(exam, views=2, slices=6):
    """The short axis of 6 slices and 25 phases, where the files' own positions say."""
    stack = exam.stack
    assert stack.size == (256, 208, slices), (stack.size, exam.decisions)
    assert stack.phases == 25 and len(exam.views) == views, (stack.phases, len(exam.views))
    assert np.allclose(stack.spacing(), (1.40625, 1.40625, 17.70), atol=2e-3), stack.spacing()
    first = pydicom.dcmread(shared_data("cine-exam") / "Se5" / "01.dcm", stop_before_pixels=True)
    last = pydicom.dcmread(shared_data("cine-exam") / "Se11" / "01.dcm", stop_before_pixels=True)
    if slices == 6:
        ends = [np.array(d.ImagePositionPatient, float) for d in (first, last)]
        here = [stack.lps[:3, 3], stack.lps[:3, 3] + 5 * stack.lps[:3, 2]]
        # The exporter's six digits, and slices placed evenly.
        assert max(np.linalg.norm(a - b) for a, b in zip(ends, here)) < 0.02, (ends, here)
        assert abs(stack.rr_s - np.mean(RR_S)) < 1.5e-3, stack.rr_s


def expect_pixels(exam, series, k, exact=True):
    """Frames of one slice, in the order of their trigger times, are the exam's phases."""
    files = [pydicom.dcmread(f) for f in (shared_data("cine-exam") / series).glob("*.dcm")]
    files.sort(key=lambda d: float(d.TriggerTime))
    frames = np.stack([d.pixel_array.T for d in files], axis=-1).astype(float)
    frames = frames * float(files[0].get("RescaleSlope", 1)) + float(files[0].get("RescaleIntercept", 0))
    read = exam.stack.values[:, :, k, :]
    scores = [np.corrcoef(frames[..., 6].ravel(), read[..., p].ravel())[0, 1] for p in range(25)]
    assert int(np.argmax(scores)) in (5, 6, 7), f"frame 6 looks like phase {np.argmax(scores)}"
    assert max(scores) > 0.99, max(scores)
    if exact:
        assert np.abs(frames - read).max() < 0.51


@case
def whole_folder(folder):
    exam = imported(folder / "study", shared_data("cine-exam"))
    expect_whole(exam, views=5)
    for k, series in enumerate(SHORT_AXIS):
        expect_pixels(exam, series, k, exact=False)
    text = "\n".join(exam.decisions) + exam.said
    for word in ("SAMPLE", "cine_trufi", "Siemens", "Vida"):
        assert word not in text, word


@case
def one_series_is_one_slice(folder):
    """One series of this exam is one slice: a sentence that says what is missing."""
    source = exam_copy(folder) / "Se3"
    refused(folder, source, "Se3", r"slice", r"\b(1|one)\b")
    number = pydicom.dcmread(source / "01.dcm", stop_before_pixels=True).SeriesNumber
    refused(folder, folder / "exam", "slice", options=("--series", str(number)))


@case
def some_series(folder):
    """Three neighbouring slices by --series, and by naming their folders."""
    root = shared_data("cine-exam")
    numbers = {name: int(pydicom.dcmread(root / name / "01.dcm", stop_before_pixels=True).SeriesNumber)
               for name in SHORT_AXIS}
    exam = imported(folder / "folders", [root / name for name in ("Se3", "Se1", "Se2")])
    expect_whole(exam, views=0, slices=3)
    chosen = ",".join(str(numbers[name]) for name in ("Se1", "Se2", "Se3"))
    exam2 = imported(folder / "series", root, "--series", chosen)
    assert np.array_equal(exam.stack.values, exam2.stack.values)
    assert np.array_equal(exam.stack.lps, exam2.stack.lps)
    assert not exam2.views


@case
def shuffled_and_renamed_files(folder):
    imported(folder / "plain", shared_data("cine-exam"))
    for seed, suffix in ((1, ""), (2, ".IMA")):
        other = shuffled(shared_data("cine-exam"), folder / f"mixed{seed}", seed, suffix)
        imported(folder / f"study{seed}", other)
        expect_same_exam(folder / "plain", folder / f"study{seed}")


@case
def text_and_pictures_in_it(folder):
    source = exam_copy(folder)
    (source / "report.txt").write_text("findings\n")
    (source / "Se3" / "Thumbs.db").write_bytes(bytes(range(256)) * 20)
    Image.new("RGB", (64, 48), (200, 30, 30)).save(source / "Se1" / "photo.png")
    Image.new("L", (64, 48), 77).save(source / "photo.jpg")
    expect_whole(imported(folder / "study", source))


@case
def images_of_other_kinds_in_it(folder):
    """A computed tomogram, a colour screenshot and a report of the same study."""
    source = exam_copy(folder)
    d = pydicom.dcmread(source / "Se3" / "04.dcm")
    d.Modality, d.SOPClassUID = "CT", "1.2.840.10008.5.1.4.1.1.2"
    d.file_meta.MediaStorageSOPClassUID = d.SOPClassUID
    own(d, 1, series=900)
    d.ImagePositionPatient = ["0", "0", "0"]
    d.ImageOrientationPatient = ["1", "0", "0", "0", "1", "0"]
    save(d, source / "ct")
    d = pydicom.dcmread(source / "Se3" / "04.dcm")
    d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.7"
    d.Modality = "OT"
    own(d, 2, series=901)
    d.SamplesPerPixel, d.PhotometricInterpretation, d.PlanarConfiguration = 3, "RGB", 0
    d.BitsAllocated, d.BitsStored, d.HighBit = 8, 8, 7
    d.PixelData = bytes(3 * d.Rows * d.Columns)
    save(d, source / "screen")
    d = pydicom.dcmread(source / "Se3" / "04.dcm")
    d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.88.11"
    d.Modality = "SR"
    own(d, 3, series=902)
    for key in ("PixelData", "Rows", "Columns", "BitsAllocated", "BitsStored", "HighBit"):
        delattr(d, key)
    save(d, source / "report")
    expect_whole(imported(folder / "study", source))


def own(d, number, series):
    d.SOPInstanceUID = d.file_meta.MediaStorageSOPInstanceUID = ROOT + f"8.{number}"
    d.SeriesInstanceUID, d.SeriesNumber = ROOT + f"9.{series}", series


def foreign(d, number, patient=True):
    own(d, number, series=d.SeriesNumber)
    d.StudyInstanceUID, d.FrameOfReferenceUID = ROOT + "77", ROOT + "78"
    if patient:
        d.PatientID, d.PatientName = "OTHER-77", "Other^Person"


def expect_a_question_or_the_exam(folder, source, never):
    """One stray image of another exam: asked, or left and told; never mixed in."""
    done = run("import", source, "--study", folder / "probe")
    if done.returncode == 3:
        refused(folder, source, "--exam", never=never)
        whole = 0
        for number in (1, 2):
            done = run("import", source, "--study", folder / f"s{number}", "--exam", number)
            if done.returncode == 0:
                expect_whole(Exam(folder / f"s{number}", done.err))
                whole += 1
        assert whole == 1, "one of the two exams is the whole one, the other a single image"
    else:
        exam = imported(folder / "study", source)
        expect_whole(exam)
        exam.expect_told("patient|stud(y|ies)|exams")
        for word in never:
            assert word not in exam.said


@case
def an_image_of_another_patient_in_it(folder):
    source = exam_copy(folder)
    d = pydicom.dcmread(source / "Se3" / "04.dcm")
    foreign(d, 4)
    save(d, source / "Se3" / "stray")
    expect_a_question_or_the_exam(folder, source, ("OTHER", "Person", "SAMPLE"))


@case
def an_image_of_another_study_in_it(folder):
    source = exam_copy(folder)
    d = pydicom.dcmread(source / "Se3" / "04.dcm")
    foreign(d, 5, patient=False)
    save(d, source / "Se3" / "stray")
    expect_a_question_or_the_exam(folder, source, ("SAMPLE",))


@case
def a_file_cut_short(folder):
    """In its pixels, in its header, in the stack and in a view."""
    source = exam_copy(folder)
    for series, share in (("Se3", 0.7), ("Se3", 0.015), ("Se8", 0.999), ("Se1", 0.01)):
        file = source / series / "07.dcm"
        whole = file.read_bytes()
        cut(file, share)
        refused(folder, source, rf"{series}/07\.dcm", "truncated|damaged|cut short|incomplete")
        file.write_bytes(whole)


@case
def a_file_that_broke_off_within_its_first_bytes(folder):
    """Nothing of an image is left to see: left out like a missing one, or refused by name."""
    source = exam_copy(folder)
    cut(source / "Se3" / "07.dcm", 0.001)
    done = run("import", source, "--study", folder / "study")
    if done.returncode == 0:
        exam = Exam(folder / "study", done.err)
        expect_whole(exam)
        exam.expect_told("ignored 1|fewer frames|missing|lacks")
    else:
        one_sentence(done, r"07\.dcm")


@case
def one_file_missing(folder):
    """One frame of 25 is bridged, and said."""
    source = exam_copy(folder)
    (source / "Se3" / "07.dcm").unlink()
    exam = imported(folder / "study", source)
    expect_whole(exam)
    exam.expect_warning("fewer frames|missing|lacks")
    whole = imported(folder / "whole", shared_data("cine-exam"))
    others = [k for k in range(6) if k != 2]
    assert np.array_equal(exam.stack.values[:, :, others], whole.stack.values[:, :, others])
    # What is bridged looks like what was there.
    off = np.abs(exam.stack.values[:, :, 2] - whole.stack.values[:, :, 2]).mean()
    assert off < 0.05 * whole.stack.values[:, :, 2].mean(), off


@case
def a_whole_slice_missing(folder):
    """A hole of 35 mm in the stack is not filled."""
    source = exam_copy(folder)
    shutil.rmtree(source / "Se3")
    refused(folder, source, "slice", "gap|hole|missing|spacing|apart|even")


@case
def a_file_twice_under_another_name(folder):
    source = exam_copy(folder)
    imported(folder / "plain", source)
    shutil.copyfile(source / "Se3" / "07.dcm", source / "Se1" / "copy of 07.dcm")
    exam = imported(folder / "study", source)
    expect_whole(exam)
    exam.expect_told("cop(y|ies)|duplicate|twice")
    for name in ("stack.nii.gz", "view_00.nii.gz", "view_01.nii.gz"):
        a, b = (folder / study / "exam" / name for study in ("plain", "study"))
        assert a.read_bytes() == b.read_bytes(), name


@case
def a_file_twice_with_a_new_uid(folder):
    """An archive that anonymised twice: the same image of another name and UID."""
    source = exam_copy(folder)
    plain = imported(folder / "plain", source)
    d = pydicom.dcmread(source / "Se3" / "07.dcm")
    own(d, 6, series=d.SeriesNumber)
    d.SeriesInstanceUID = pydicom.dcmread(source / "Se3" / "08.dcm").SeriesInstanceUID
    save(d, source / "Se3" / "again.dcm")
    exam = imported(folder / "study", source)
    expect_whole(exam)
    assert np.array_equal(exam.stack.values, plain.stack.values)
    exam.expect_told("cop(y|ies)|duplicate|twice|share|equal")


def changed(folder, change, only=None):
    source = exam_copy(folder)
    for file in source.rglob("*.dcm"):
        if only and file.parent.name not in only:
            continue
        d = pydicom.dcmread(file)
        change(d)
        d.save_as(file)
    return source


def expect_instance_order(folder, change, warning):
    """The frames in the order of their numbers: what the times said too."""
    exam = imported(folder / "study", changed(folder, change))
    expect_whole(exam)
    exam.expect_warning(warning)
    for k, series in ((0, "Se5"), (3, "Se2")):
        expect_pixels(exam, series, k)


@case
def without_trigger_times(folder):
    def drop(d):
        del d.TriggerTime
    expect_instance_order(folder, drop, "trigger time")


@case
def with_constant_trigger_times(folder):
    expect_instance_order(folder, lambda d: setattr(d, "TriggerTime", "431"), "trigger time")


@case
def with_trigger_times_that_hold_scan_time(folder):
    def scan(d):
        d.TriggerTime = str(36000 + 1000 * int(d.SeriesNumber % 100) + 870 * int(d.InstanceNumber))
    expect_instance_order(folder, scan, "trigger time")


@case
def with_trigger_times_in_seconds(folder):
    """The same exam as from milliseconds, with a warning."""
    plain = imported(folder / "plain", shared_data("cine-exam"))

    def seconds(d):
        d.TriggerTime = f"{float(d.TriggerTime) / 1000:.6g}"
    exam = imported(folder / "study", changed(folder, seconds))
    expect_whole(exam)
    exam.expect_warning("trigger time")
    off = np.abs(exam.stack.values - plain.stack.values)
    assert off.mean() < 0.5 and off.max() < 0.02 * plain.stack.values.max(), (off.mean(), off.max())


@case
def with_trigger_times_of_zero_in_one_series(folder):
    """One slice without times among five with: its frames by number, the others by time."""
    plain = imported(folder / "plain", shared_data("cine-exam"))
    source = changed(folder, lambda d: setattr(d, "TriggerTime", "0"), only=("Se2",))
    exam = imported(folder / "study", source)
    expect_whole(exam)
    exam.expect_warning("trigger time")
    others = [k for k in range(6) if k != 3]
    assert np.array_equal(exam.stack.values[:, :, others], plain.stack.values[:, :, others])
    expect_pixels(exam, "Se2", 3)


@case
def without_intervals(folder):
    """No R-R interval recorded: frames x step of the trigger times."""
    def drop(d):
        del d.NominalInterval
    exam = imported(folder / "study", changed(folder, drop))
    expect_whole(exam)
    exam.expect_told("R-R")


@case
def compressed_by_an_archive(folder):
    """JPEG-LS and implicit little endian: the same exam, byte by byte."""
    source = exam_copy(folder)
    imported(folder / "plain", source)
    for series, syntax in (("Se1", "jpeg_ls"), ("Se2", "implicit_little_endian"), ("Se3", "rle"),
                           ("Se8", "jpeg_lossless")):
        convert(source / series, syntax)
    imported(folder / "study", source)
    expect_same_exam(folder / "plain", folder / "study")


@case
def two_phases(folder):
    """An incomplete archive: the four complete positions of six, with a warning."""
    source = shared_data("two-phase-ge")
    exam = imported(folder / "study", source)
    stack = exam.stack
    assert stack.size == (256, 256, 4) and stack.phases == 2, (stack.size, stack.phases)
    assert np.allclose(stack.spacing(), (1.367188, 1.367188, 8.0), atol=2e-3), stack.spacing()
    assert abs(stack.rr_s - 0.967) < 1e-3, stack.rr_s
    assert np.allclose(stack.times_s, (0.348, 0.929), atol=1e-6), stack.times_s
    exam.expect_warning(r"\b2\b.*(left|position|slice)|left")
    # Each image as it is, in its place: 28 and 40 lie together, and so on.
    pairs = {(28, 40), (48, 60), (68, 80), (88, 100)}
    for systole, diastole in pairs:
        images = [pydicom.dcmread(source / "dicom" / f"IM-0009-{n:04d}.dcm")
                  for n in (systole, diastole)]
        at = np.array(images[0].ImagePositionPatient, float)
        k = np.linalg.inv(stack.lps[:3, :3]) @ (at - stack.lps[:3, 3])
        assert np.abs(k[:2]).max() < 0.02 and abs(k[2] - round(k[2])) < 0.01, k
        k = int(round(k[2]))
        # 348 of 967 ms is nearest the middle of the cycle, 929 its end, which is its beginning.
        for image, phase in zip(images, (1, 0)):
            pixels = image.pixel_array.T.astype(float)
            off = [np.abs(pixels - stack.values[:, :, k, p]).max() for p in (phase, 1 - phase)]
            assert off[0] < 0.51 < off[1], (systole, diastole, off)


@case
def two_phases_of_files_named_one_by_one(folder):
    source = shared_data("two-phase-ge")
    imported(folder / "a", source)
    imported(folder / "b", sorted((source / "dicom").iterdir(), reverse=True))
    for name in ("stack.nii.gz",):
        a, b = (folder / study / "exam" / name for study in "ab")
        assert a.read_bytes() == b.read_bytes()


@case
def the_suite_sees_the_whole_exam(folder):
    """Guards the tests: the exam is the one that they were written for."""
    root = shared_data("cine-exam")
    assert len(list(root.rglob("*.dcm"))) == 275
    assert sorted(p.name for p in pathlib.Path(root).iterdir() if p.is_dir()) == sorted(
        f"Se{n}" for n in range(1, 12))


if __name__ == "__main__":
    main()
