"""One object written as DICOM in every way that scanners and archives do is read back to the same
Exam: round_trip_test.py BEATLAS NAME"""
import itertools
import json
import random
import shutil
import subprocess

import numpy as np

import exam_object
from dicom_writers import (ROOT, classic_exam, convert, enhanced_image, save, save_all,
                           set_number, shuffled)
from exam_object import BeatingObject, expect_object, expect_places, expect_tellable
from harness import beatlas, case, expect_same_exam, imported, main

COUNT = itertools.count()


def check(folder, source, truth, *options, **expected):
    exam = imported(folder / f"study{next(COUNT)}", source, *options)
    expect_object(exam, truth, **expected)
    return exam


def classic(folder, truth=None, syntax=None, names="plain", name="dicom", **how):
    """Writes a classic exam and reads it back."""
    if truth is None:  # a tool runs once a file: fewer of them
        truth = BeatingObject(size=(36, 28, 4), phases=8) if syntax else BeatingObject()
    save_all(folder / name, classic_exam(truth, **how), names)
    if syntax:
        convert(folder / name, syntax)
    return truth


@case
def the_object_tells_every_flip_and_order(folder):
    expect_tellable(BeatingObject())


@case
def explicit_little_endian(folder):
    check(folder, folder / "dicom", classic(folder))


@case
def implicit_little_endian(folder):
    check(folder, folder / "dicom", classic(folder, syntax="implicit_little_endian"))


@case
def explicit_big_endian(folder):
    check(folder, folder / "dicom", classic(folder, syntax="explicit_big_endian"))


@case
def deflated(folder):
    check(folder, folder / "dicom", classic(folder, syntax="deflated"))


@case
def rle(folder):
    check(folder, folder / "dicom", classic(folder, syntax="rle"))


@case
def jpeg_lossless(folder):
    check(folder, folder / "dicom", classic(folder, syntax="jpeg_lossless"))
    check(folder, folder / "other", classic(folder, syntax="jpeg_lossless_14", name="other"))


@case
def jpeg_ls(folder):
    check(folder, folder / "dicom", classic(folder, syntax="jpeg_ls"))


@case
def jpeg_2000(folder):
    check(folder, folder / "dicom", classic(folder, syntax="jpeg_2000"))


@case
def mixed_transfer_syntaxes(folder):
    """An archive that compressed a part of the exam."""
    truth = BeatingObject()
    images = classic_exam(truth)
    parts = (None, "jpeg_ls", "implicit_little_endian", "rle", "jpeg_2000")
    for part, syntax in enumerate(parts):
        save_all(folder / "dicom" / str(part), images[part::len(parts)])
        if syntax:
            convert(folder / "dicom" / str(part), syntax)
    check(folder, folder / "dicom", truth)


@case
def stored_bits(folder):
    for name, how in {
            "unsigned16": {}, "signed16": {"signed": True, "offset": -1300},
            "unsigned12": {"stored": 12}, "signed12": {"stored": 12, "signed": True,
                                                       "offset": -1300},
            "unsigned8": {"bits": 8, "gain": 0.09}}.items():
        truth = BeatingObject(offset=how.pop("offset", 0), gain=how.pop("gain", 1))
        check(folder, folder / name, classic(folder, truth, name=name, **how))


@case
def high_bits_of_signed_12_are_no_value(folder):
    """Of 12 stored bits of 16 the upper four may hold anything; the sign is bit 11."""
    truth = BeatingObject(offset=-1300)

    def clear(k, p, d):
        values = np.frombuffer(d.PixelData, "<u2") & 0x0FFF
        d.PixelData = values.astype("<u2").tobytes()
    check(folder, folder / "dicom", classic(folder, truth, stored=12, signed=True, change=clear))


@case
def rescale(folder):
    truth = BeatingObject(offset=-500)
    how = {"slope": 0.25, "intercept": -800}
    check(folder, folder / "dicom", classic(folder, truth, **how), error=0.13)
    # Every image may have its own.
    images = classic_exam(truth)
    for n, d in enumerate(images):
        slope, intercept = 0.25 + 0.01 * (n % 7), -900 + n % 13
        k, p = n // truth.phases, n % truth.phases
        d.RescaleSlope, d.RescaleIntercept = str(slope)[:16], str(intercept)
        pixels = (truth.image(k, p / truth.phases) - intercept) / slope
        d.PixelData = np.round(pixels).astype("<u2").tobytes()
    save_all(folder / "own", images)
    check(folder, folder / "own", truth, error=0.17)


@case
def one_series_one_per_slice_one_per_phase(folder):
    for series in ("one", "slice", "phase"):
        check(folder, folder / series, classic(folder, series=series, name=series))


@case
def any_order_of_instances_files_and_series(folder):
    """Nothing but positions and times says which image is which."""
    truth = BeatingObject()
    for series in ("one", "slice"):
        images = classic_exam(truth, series=series)
        numbers = list(range(1, len(images) + 1))
        random.Random(3).shuffle(numbers)
        slices = [4, 2, 5, 1, 3]
        for n, d in zip(numbers, images):
            d.InstanceNumber = n
            if series == "slice":
                d.SeriesNumber = 7 * slices[d.SeriesNumber - 1]
        save_all(folder / series, images, names="random")
        check(folder, folder / series, truth)
    # The same exam, byte by byte, from files of other names in other folders.
    for seed in (1, 2):
        shuffled(folder / "slice", folder / f"again{seed}", seed)
        imported(folder / f"study-again{seed}", folder / f"again{seed}")
    expect_same_exam(folder / "study-again1", folder / "study-again2")


@case
def files_named_one_by_one(folder):
    truth = BeatingObject()
    files = save_all(folder / "dicom", classic_exam(truth))
    random.Random(4).shuffle(files)
    check(folder, files, truth)


@case
def several_folders(folder):
    truth = BeatingObject()
    images = classic_exam(truth)
    save_all(folder / "a", images[:23])
    save_all(folder / "b", images[23:])
    check(folder, [folder / "b", folder / "a"], truth)


@case
def dicomdir_beside(folder):
    truth = classic(folder)
    done = subprocess.run(["dcmmkdir", "+r", "+I", "+id", str(folder / "dicom"), "+D",
                           str(folder / "dicom" / "DICOMDIR"), "-Pgp"],
                          capture_output=True, text=True)
    if not (folder / "dicom" / "DICOMDIR").exists():
        raise AssertionError(f"dcmmkdir: {done.stderr}")
    check(folder, folder / "dicom", truth)


@case
def text_pictures_and_empty_files_beside(folder):
    truth = classic(folder)
    (folder / "dicom" / "README.txt").write_text("A CD of images\n")
    (folder / "dicom" / "empty").write_bytes(b"")
    (folder / "dicom" / "AUTORUN.INF").write_bytes(b"[autorun]\r\nopen=viewer.exe\r\n")
    (folder / "dicom" / "logo.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(2000))
    exam = check(folder, folder / "dicom", truth)
    exam.expect_told(r"ignored 3\b.*ignored 1 empty file")


@case
def every_orientation(folder):
    """Axial, coronal, sagittal, and obliques that turn every axis against every other."""
    turns = [exam_object.AXIAL, exam_object.CORONAL, exam_object.SAGITTAL]
    turns += [exam_object.turned(a, b, c) for a, b, c in
              ((0.1, 2.2, -0.4), (-2.6, 0.7, 1.9), (1.4, -1.2, 3.0), (3.1, 0.02, -0.01))]
    for n, turn in enumerate(turns):
        truth = BeatingObject(size=(20, 17, 4), turn=turn, step=(1.4063, 2.3, 8.85))
        check(folder, folder / f"turn{n}", classic(folder, truth, name=f"turn{n}"))


@case
def far_from_the_centre(folder):
    """Long coordinates: 16 characters a number."""
    truth = BeatingObject(origin=(-1234.56789, 987.654321, -1765.4321), step=(0.9765625, 1.1, 6.37))
    check(folder, folder / "dicom", classic(folder, truth))


@case
def cosines_a_little_off_are_repaired(folder):
    """Six digits or a rounding exporter: repaired, and said."""
    truth = BeatingObject()

    def skew(k, p, d):
        row = truth.turn[:, 0] * 1.002
        column = truth.turn[:, 1] + 0.002 * truth.turn[:, 0]
        d.ImageOrientationPatient = [f"{v:.6f}" for v in (*row, *column)]
    classic(folder, truth, change=skew)
    exam = imported(folder / "study", folder / "dicom")
    exam.expect_warning("cosine|orthonormal")
    matrix = exam.stack.lps[:3, :3] / exam.stack.spacing()
    assert np.allclose(matrix.T @ matrix, np.eye(3), atol=1e-9), matrix
    assert abs(np.linalg.det(matrix) - 1) < 1e-9
    # No axis turns by more than the skew itself; the far corner moves by less than its share.
    assert np.abs(matrix - truth.turn).max() < 0.003
    plain = BeatingObject()
    classic(folder, plain, name="plain", change=lambda k, p, d: setattr(
        d, "ImageOrientationPatient",
        [f"{v:.6f}" for v in (*truth.turn[:, 0], *truth.turn[:, 1])]))
    exam = check(folder, folder / "plain", plain)
    assert not exam.told("warning.*cosine"), "six digits are no fault"


@case
def enhanced_frame_orders(folder):
    """One multi-frame object: by slice, by phase, at random."""
    truth = BeatingObject()
    by_slice = [(k, p) for k in range(5) for p in range(10)]
    by_phase = [(k, p) for p in range(10) for k in reversed(range(5))]
    mixed = by_slice[:]
    random.Random(8).shuffle(mixed)
    for n, frames in enumerate((by_slice, by_phase, mixed)):
        save(enhanced_image(truth, frames, shared_plane=n != 1), folder / f"e{n}" / "multi")
        check(folder, folder / f"e{n}", truth, rr_error_s=1e-6)
        check(folder, folder / f"e{n}" / "multi", truth, rr_error_s=1e-6)  # the file by name


@case
def enhanced_objects_per_slice_and_per_phase(folder):
    truth = BeatingObject()
    for k in range(5):
        d = enhanced_image(truth, [(k, p) for p in range(10)], number=k + 1)
        d.SeriesNumber, d.SeriesInstanceUID = k + 1, ROOT + f"3.{k + 1}"
        save(d, folder / "slice" / f"{k}")
    for p in range(10):
        save(enhanced_image(truth, [(k, p) for k in range(5)], number=20 + p),
             folder / "phase" / f"{p}")
    check(folder, folder / "slice", truth, rr_error_s=1e-6)
    check(folder, folder / "phase", truth, rr_error_s=1e-6)


@case
def enhanced_transfer_syntaxes(folder):
    truth = BeatingObject()
    frames = [(k, p) for p in range(10) for k in range(5)]
    for syntax in ("implicit_little_endian", "deflated", "rle", "jpeg_lossless", "jpeg_ls",
                   "jpeg_2000"):
        save(enhanced_image(truth, frames), folder / syntax / "multi")
        convert(folder / syntax, syntax)
        check(folder, folder / syntax, truth, rr_error_s=1e-6)


@case
def enhanced_rescale_per_frame(folder):
    truth = BeatingObject(offset=-500)
    frames = [(k, p) for p in range(10) for k in range(5)]
    save(enhanced_image(truth, frames, slopes=lambda n: (0.25 + 0.01 * (n % 5), -900 - n)),
         folder / "dicom" / "multi")
    check(folder, folder / "dicom", truth, error=0.16)


@case
def enhanced_temporal_positions(folder):
    """No trigger delays: the order of temporal positions in the R-R interval that is recorded."""
    truth = BeatingObject()
    frames = [(k, p) for k in range(5) for p in reversed(range(10))]
    save(enhanced_image(truth, frames, timing="temporal"), folder / "dicom" / "multi")
    check(folder, folder / "dicom", truth)


@case
def legacy_converted_enhanced(folder):
    """What archives make of classic objects."""
    truth = BeatingObject()
    frames = [(k, p) for k in range(5) for p in range(10)]
    save(enhanced_image(truth, frames, sop_class="1.2.840.10008.5.1.4.1.1.4.4"),
         folder / "dicom" / "multi")
    check(folder, folder / "dicom", truth, rr_error_s=1e-6)


@case
def views_lie_beside_the_stack(folder):
    """Long-axis cines become views, exact in place; scouts and reports are left."""
    truth = BeatingObject()
    images = classic_exam(truth)
    views = []
    for n, axes in enumerate(([1, 2, 0], [2, 0, 1])):
        view = BeatingObject(size=(32, 24, 1), step=(1.9, 1.6, 6.0), turn=exam_object.turned()[:, axes],
                             origin=(-20.5 - n, 15.25, -33.125))
        views.append(view)
        for d in classic_exam(view, series="one"):
            d.SeriesNumber, d.SeriesInstanceUID = 40 + n, ROOT + f"3.{40 + n}"
            images.append(d)
    for k in range(3):
        d = classic_exam(BeatingObject(size=(32, 32, 1), turn=np.eye(3), origin=(0, 0, 20.0 * k)),
                         keep=lambda k, p: p == 0)[0]
        d.SeriesNumber, d.SeriesInstanceUID = 90, ROOT + "3.90"
        del d.TriggerTime, d.NominalInterval
        images.append(d)
    for n, d in enumerate(images):
        set_number(d, n + 1)
    save_all(folder / "dicom", images, names="random")
    exam = check(folder, folder / "dicom", truth)
    assert len(exam.views) == 2, len(exam.views)
    for view, cine in zip(views, exam.views):
        expect_places(cine, view)
        places = cine.places()
        for p in range(10):
            off = np.abs(cine.values[..., p] - view.value(places, p / 10)).max()
            assert off < 0.51, (p, off)


@case
def memory_stays_within_twice_the_series(folder):
    """Peak memory beyond that of a tiny exam is at most twice the decoded series."""
    def peak_mb(truth, name):
        images = [enhanced_image(truth, [(k, p) for p in range(truth.phases)], number=k + 1)
                  for k in range(truth.size[2])]
        save_all(folder / name, images)
        beatlas("import", folder / name, "--study", folder / f"study-{name}", "--timing",
                folder / f"{name}.json")
        return json.loads((folder / f"{name}.json").read_text())["peak_memory_mb"]
    base = peak_mb(BeatingObject(), "tiny")
    large = BeatingObject(size=(320, 320, 12), step=(0.9, 0.9, 8.0), phases=16)
    decoded_mb = np.prod(large.size) * large.phases * 4 / 2**20  # as the Exam holds it
    peak = peak_mb(large, "large")
    print(f"peak {peak:.0f} MB, {base:.0f} MB of it the program's, series {decoded_mb:.0f} MB")
    assert peak - base <= 2 * decoded_mb, (peak, base, decoded_mb)


@case
def sizes_at_both_ends(folder):
    # The object's three parts beat at times of their own, so its slices are not in step; where they are wide enough
    # to be looked at for that, import is told to leave them.
    recipe = folder / "as_they_are.json"
    recipe.write_text(json.dumps({"import": {"align_slices": "off"}}))
    for name, truth in {
            "many_slices": BeatingObject(size=(64, 64, 300), step=(2, 2, 1.1), phases=2),
            "many_phases": BeatingObject(size=(64, 64, 4), phases=100),
            "large_pixels": BeatingObject(size=(1024, 1024, 4), step=(0.31, 0.33, 8), phases=2)
    }.items():
        frames = [(k, p) for k in range(truth.size[2]) for p in range(truth.phases)]
        save(enhanced_image(truth, frames), folder / name / "multi")
        check(folder, folder / name, truth, "--recipe", recipe)
        shutil.rmtree(folder / name)


if __name__ == "__main__":
    main()
