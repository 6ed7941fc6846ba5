"""Several stacks, studies or patients in one folder: a ranked choice that is explained and can be
overridden, or one question: choice_test.py BEATLAS NAME"""
import re
import shutil

import numpy as np

import exam_object
from dicom_writers import (ROOT, classic_exam, convert, enhanced_image, new_dataset, save, save_all,
                           set_number)
from exam_object import BeatingObject, expect_object, expect_places
from harness import case, expect_same_exam, imported, main, refused

SAX = dict(size=(28, 24, 8), step=(1.8, 1.8, 8.0))


def series(truth, number, study=1, patient="0001", **how):
    """A stack as one series."""
    out = classic_exam(truth, series="one", **how)
    for d in out:
        d.SeriesNumber, d.SeriesInstanceUID = number, ROOT + f"3.{study}.{number}"
        d.StudyInstanceUID, d.PatientID = ROOT + f"2.{study}", patient
        d.FrameOfReferenceUID = ROOT + f"4.{study}"
    return out


def save_exam(folder, images):
    for n, d in enumerate(images):
        set_number(d, n + 1)
    save_all(folder, images, names="random")
    return folder


def two_exams(folder, same_patient=False):
    """Two short exams of different size; which is which shows in the grid."""
    first = BeatingObject(size=(28, 24, 5))
    second = BeatingObject(size=(24, 30, 6), origin=(10, 20, 30), turn=exam_object.turned(0.2, 1.1))
    images = series(first, 3, study=1, patient="0001")
    others = series(second, 3, study=2, patient="0001" if same_patient else "0002")
    for d in images:
        d.PatientName, d.PatientBirthDate, d.StudyDescription = "Ada^First", "19510203", "Morning"
    for d in others:
        d.PatientName = "Ada^First" if same_patient else "Bert^Second"
        d.PatientBirthDate, d.StudyDescription = "19620304", "Evening"
        d.StudyDate = "20010101"
    return save_exam(folder / "dicom", images + others), first, second


def asks_and_obeys(folder, same_patient):
    source, first, second = two_exams(folder, same_patient)
    said = refused(folder, source, "--exam", r"\b1\b.*\b2\b", never=(
        "Ada", "Bert", "First", "Second", "0001", "0002", "1951", "1962", "Morning", "Evening",
        "20010101", "20000101", ROOT.rstrip(".")))
    assert re.search(r"series|images|slices|phases", said), f"says nothing of what to choose: {said}"
    found = {}
    for number in (1, 2):
        exam = imported(folder / f"study{number}", source, "--exam", number)
        truth = first if exam.stack.size == first.size else second
        expect_object(exam, truth)
        found[number] = truth
        assert not exam.views, "nothing of the other exam lies beside"
    assert found[1] is not found[2], "--exam 1 and 2 gave the same exam"
    refused(folder, source, "exam", r"\b3\b", options=("--exam", "3"))


@case
def two_patients_are_never_mixed(folder):
    asks_and_obeys(folder, same_patient=False)


@case
def two_studies_of_one_patient_are_never_mixed(folder):
    asks_and_obeys(folder, same_patient=True)


@case
def exams_are_numbered_alike_whatever_the_names_of_files(folder):
    source, _, _ = two_exams(folder)
    again, _, _ = two_exams(folder / "again")
    for n, file in enumerate(sorted((f for f in again.rglob("*") if f.is_file()), reverse=True)):
        (folder / "flat").mkdir(exist_ok=True)
        shutil.copyfile(file, folder / "flat" / f"{n:04d}")
    imported(folder / "a", source, "--exam", "1")
    imported(folder / "b", folder / "flat", "--exam", "1")
    expect_same_exam(folder / "a", folder / "b")


@case
def parts_of_one_exam_need_no_choice(folder):
    """Several series, and several frames of reference (a patient who moved), are one exam."""
    truth = BeatingObject(**SAX)
    images = classic_exam(truth)
    for d in images:
        d.FrameOfReferenceUID = ROOT + f"4.{d.SeriesNumber}"
    expect_object(imported(folder / "s", save_exam(folder / "dicom", images)), truth)


@case
def an_exam_of_many_kinds_gives_the_short_axis(folder):
    """Axial cine, long axis, scout, perfusion, flow, stills and a repeat beside the short axis."""
    short = BeatingObject(**SAX)
    images = series(short, 11)
    for n, axes in enumerate(([1, 2, 0], [2, 0, 1])):  # long axes: planes that hold the normal
        turn = exam_object.turned()[:, axes]
        images += series(BeatingObject(size=(28, 24, 1), turn=turn), 21 + n)
    scout = series(BeatingObject(size=(32, 32, 3), turn=np.eye(3), step=(4, 4, 30), phases=1), 1)
    for d in scout:
        del d.TriggerTime, d.NominalInterval
    perfusion = series(BeatingObject(size=(20, 20, 3), step=(3, 3, 16), phases=30), 31)
    for n, d in enumerate(perfusion):
        d.TriggerTime = str(12000 + 900 * (n % 30))
        d.AcquisitionNumber = n % 30 + 1
    flow = series(BeatingObject(size=(22, 22, 1), turn=np.eye(3)), 41)
    for d in flow:
        d.ImageType = ["ORIGINAL", "PRIMARY", "P", "ND"]
    stills = series(BeatingObject(size=(24, 24, 14), step=(2, 2, 5), phases=1), 51)
    source = save_exam(folder / "dicom", images + scout + perfusion + flow + stills)
    exam = imported(folder / "study", source)
    expect_object(exam, short)
    assert len(exam.views) >= 2, exam.decisions
    exam.expect_told(r"series 11\b", r"\b51\b|stills|one phase", r"\b31\b|perfusion|beats")


@case
def several_stacks_are_ranked_and_can_be_overridden(folder):
    """Two cine stacks: both are listed by number, --stack takes the other."""
    short = BeatingObject(**SAX)
    axial = BeatingObject(size=(26, 22, 6), step=(2, 2, 8.5), turn=np.eye(3), origin=(-30, -40, 10))
    source = save_exam(folder / "dicom", series(short, 11) + series(axial, 12))
    exam = imported(folder / "best", source)
    expect_object(exam, short)
    exam.expect_told(r"series 11\b", r"series.* 12\b", r"--stack|stack 2|\b2[.:)]")
    other = imported(folder / "other", source, "--stack", "2")
    expect_object(other, axial)
    same = imported(folder / "one", source, "--stack", "1")
    expect_object(same, short)
    refused(folder, source, "stack", r"\b9\b|\b2\b", options=("--stack", "9"))


@case
def series_can_be_named(folder):
    short = BeatingObject(**SAX)
    axial = BeatingObject(size=(26, 22, 6), step=(2, 2, 8.5), turn=np.eye(3), origin=(-30, -40, 10))
    source = save_exam(folder / "dicom", series(short, 11) + series(axial, 12))
    exam = imported(folder / "named", source, "--series", "12")
    expect_object(exam, axial)
    assert not exam.views
    expect_object(imported(folder / "both", source, "--series", "12,11"), short)
    refused(folder, source, "series", r"\b77\b", options=("--series", "77"))


@case
def a_slice_a_series_can_be_named(folder):
    truth = BeatingObject(size=(28, 24, 6))
    images = classic_exam(truth)
    for d in images:
        d.SeriesNumber += 2
    source = save_exam(folder / "dicom", images)
    exam = imported(folder / "s", source, "--series", "3,4,5,6")
    part = BeatingObject(size=(28, 24, 6))
    assert exam.stack.size == (28, 24, 4), exam.stack.size
    off = np.linalg.norm(exam.stack.lps[:3, 3] - part.place((0, 0, 0)))
    assert off < 0.01, f"first slice {off} mm off"


@case
def a_repeated_stack_is_taken_once(folder):
    """The same slices scanned again: one is taken whole, the other is told as left."""
    truth = BeatingObject(**SAX)
    again = BeatingObject(**SAX, offset=300)
    source = save_exam(folder / "dicom", series(truth, 5) + series(again, 6))
    exam = imported(folder / "study", source)
    level = exam.stack.values.mean() - truth.array().mean()
    expect_object(exam, again if level > 150 else truth)
    exam.expect_told(r"left.*series [56]\b|series [56]\b.*left|--stack")


@case
def slices_of_other_field_of_view_are_another_stack(folder):
    """Parallel slices of other pixels are never put between those of the stack."""
    truth = BeatingObject(**SAX)
    zoomed = BeatingObject(size=(28, 24, 3), step=(0.9, 0.9, 24.0))
    source = save_exam(folder / "dicom", series(truth, 5) + series(zoomed, 6))
    exam = imported(folder / "study", source)
    expect_object(exam, truth)


@case
def a_flow_series_among_the_slices_is_left(folder):
    """Phase contrast of the same plane and matrix: velocity images never enter the stack."""
    truth = BeatingObject(**SAX)
    flow = BeatingObject(size=(28, 24, 1), step=SAX["step"], origin=tuple(truth.place((0, 0, 3))),
                         phases=30, offset=700)
    images = series(truth, 5)
    speed = series(flow, 7)
    for d in speed:
        d.ImageType = ["ORIGINAL", "PRIMARY", "P", "ND"]
    magnitude = series(BeatingObject(size=(28, 24, 1), step=SAX["step"], phases=30,
                                     origin=tuple(truth.place((0, 0, 5)))), 8)
    exam = imported(folder / "study", save_exam(folder / "dicom", images + speed + magnitude))
    expect_object(exam, truth)
    expect_places(exam.stack, truth)


@case
def frames_marked_as_phase_are_no_magnitude(folder):
    """ComplexImageComponent alone marks velocity frames, in an object of their own or among the
    others."""
    truth = BeatingObject(size=(28, 24, 5))
    frames = [(k, p) for k in range(5) for p in range(10)]
    noise = np.random.default_rng(0)

    def velocity(group):
        group.MRImageFrameTypeSequence[0].ComplexImageComponent = "PHASE"
    good, bad = enhanced_image(truth, frames), enhanced_image(truth, frames, number=2)
    bad.SeriesNumber, bad.SeriesInstanceUID = 2, ROOT + "3.2"
    bad.PixelData = noise.integers(0, 4096, len(frames) * 24 * 28).astype("<u2").tobytes()
    for group in bad.PerFrameFunctionalGroupsSequence:
        velocity(group)
    save(good, folder / "two" / "a")
    save(bad, folder / "two" / "b")
    expect_object(imported(folder / "s", folder / "two"), truth)
    save(bad, folder / "alone" / "b")
    refused(folder, folder / "alone", "phase .velocity. images only")
    both = enhanced_image(truth, frames + frames)
    for group in both.PerFrameFunctionalGroupsSequence[len(frames):]:
        velocity(group)
    pixels = np.frombuffer(both.PixelData, "<u2").copy()
    pixels[pixels.size // 2:] = noise.integers(0, 4096, pixels.size // 2)
    both.PixelData = pixels.tobytes()
    save(both, folder / "one" / "x")
    expect_object(imported(folder / "t", folder / "one"), truth)


@case
def spectra_are_no_images(folder):
    """They have rows and columns, and by definition no pixels."""
    truth = BeatingObject(size=(28, 24, 5))
    source = save_exam(folder / "dicom", series(truth, 10))
    spectrum = new_dataset("1.2.840.10008.5.1.4.1.1.4.2", 9999)
    spectrum.SeriesNumber, spectrum.SeriesInstanceUID = 77, ROOT + "3.77"
    spectrum.Rows = spectrum.Columns = spectrum.DataPointRows = 1
    spectrum.DataPointColumns, spectrum.NumberOfFrames = 4, 1
    spectrum.SpectroscopyData = np.zeros(8, "<f4").tobytes()
    save(spectrum, source / "spectrum")
    exam = imported(folder / "s", source)
    expect_object(exam, truth)
    exam.expect_told("ignored 1 DICOM file without an image")
    del spectrum.SpectroscopyData
    spectrum.SOPClassUID = spectrum.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4"
    save(spectrum, source / "spectrum")
    refused(folder, source, "spectrum", "damaged")


@case
def a_series_of_two_kinds_gives_one(folder):
    """Every image with and without a correction, in no fixed order."""
    truth = BeatingObject(**SAX)
    kinds = {name: series(BeatingObject(**SAX, offset=offset), 5)
             for name, offset in (("ND", 0), ("NORM", 800))}
    for name, images in kinds.items():
        for d in images:
            d.ImageType = ["ORIGINAL", "PRIMARY", "M", "RETRO", name]
    images = []
    for n, pair in enumerate(zip(kinds["ND"], kinds["NORM"])):
        images += pair if n % 2 else pair[::-1]
    for n, d in enumerate(images):
        d.InstanceNumber = n + 1
    exam = imported(folder / "s", save_exam(folder / "dicom", images))
    level = exam.stack.values.mean() - truth.array().mean()
    expect_object(exam, BeatingObject(**SAX, offset=800) if level > 400 else truth)
    exam.expect_warning(r"2 kinds .ImageType.")
    assert not exam.told("NORM|RETRO")


@case
def objects_of_a_phase_each_without_times(folder):
    """Every object holds a frame of each slice: the objects' numbers order the frames."""
    truth = BeatingObject(size=(20, 16, 5), phases=12)
    for p in range(12):
        d = enhanced_image(truth, [(k, p) for k in range(5)], number=p + 1, timing="temporal")
        for group in d.PerFrameFunctionalGroupsSequence:
            del group.FrameContentSequence[0].TemporalPositionIndex
        d.InstanceNumber = p + 1
        save(d, folder / "dicom" / f"{(p * 7) % 12}")
    exam = imported(folder / "s", folder / "dicom")
    expect_object(exam, truth)
    exam.expect_warning("ordered by InstanceNumber")


@case
def copies_with_contours_take_no_originals_place(folder):
    """Later, of more frames, marked in one of the ways of the standard; alone they are used."""
    truth = BeatingObject(**SAX)

    def copies(number):
        return series(BeatingObject(**SAX, phases=12, offset=700), number)
    images = series(truth, 5)
    for d in (marked := copies(6)):
        d.ImageType = ["DERIVED", "SECONDARY", "M", "RETRO"]
    images += marked
    for d in (marked := copies(7)):
        d.BurnedInAnnotation = "YES"
    images += marked
    for d in (marked := copies(8)):
        d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.7"
    exam = imported(folder / "s", save_exam(folder / "dicom", images + marked))
    expect_object(exam, truth)
    assert not exam.told("no originals"), exam.decisions
    alone = imported(folder / "t", folder / "dicom", "--series", "7")
    assert alone.stack.phases == 12
    alone.expect_warning("no originals of series 7")


@case
def an_inversion_scout_takes_no_slice_of_the_cine(folder):
    """At a place of the cine, later, of more frames; InversionTime, flip angle or name tells it."""
    truth = BeatingObject(**SAX)
    slice_of = dict(size=(28, 24, 1), step=SAX["step"], phases=20, offset=700)
    images = series(truth, 5)
    for n, k in enumerate((2, 4, 6)):
        scout = series(BeatingObject(**slice_of, origin=tuple(truth.place((0, 0, k)))), 21 + n)
        for d in scout:
            d.FlipAngle, d.SequenceName = "58", "*tfi2d1_10"
            if n == 0:
                d.InversionTime = "82"
            elif n == 1:
                d.FlipAngle = "30"
            else:
                d.SequenceName = "*tfl2d1r_29"
        images += scout
    for d in images[:len(series(truth, 5))]:
        d.FlipAngle, d.SequenceName = "58", "*tfi2d1_10"
    expect_object(imported(folder / "s", save_exam(folder / "dicom", images)), truth)


@case
def packed_objects_of_a_phase_each(folder):
    """Every slice needs all files; also one deflated file."""
    truth = BeatingObject(size=(20, 16, 24), phases=12)
    for p in range(12):
        save(enhanced_image(truth, [(k, p) for k in range(24)], number=p + 1),
             folder / "dicom" / f"{p}")
    convert(folder / "dicom", "jpeg_2000")
    expect_object(imported(folder / "s", folder / "dicom"), truth)
    whole = enhanced_image(truth, [(k, p) for p in range(12) for k in range(24)])
    save(whole, folder / "deflated" / "x")
    convert(folder / "deflated", "deflated")
    expect_object(imported(folder / "t", folder / "deflated"), truth)


if __name__ == "__main__":
    main()
