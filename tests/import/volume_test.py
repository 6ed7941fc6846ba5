"""NIfTI, NRRD and MetaImage of one object are read back to the same Exam: volume_test.py BEATLAS NAME"""
import itertools

import nibabel
import numpy as np

from dicom_writers import classic_exam, save_all
from exam_object import BeatingObject, expect_object, turned
from harness import Exam, beatlas, case, imported, main, one_sentence, refused, run
from volume_writers import metaimage, nifti, nrrd

COUNT = itertools.count()
AXES = list(itertools.permutations(range(3)))
FLIPS = list(itertools.product((False, True), repeat=3))
ORDERS = list(itertools.product(AXES, FLIPS))
# Every order of axes twice, every set of flips at least once.
SOME_ORDERS = [(axes, FLIPS[(3 * n + 5 * turn) % 8])
               for n, axes in enumerate(AXES) for turn in (0, 1)]


def step_s(truth):
    return truth.rr_ms / truth.phases / 1e3


def check(folder, source, truth, *options, rr_error_s=1e-5, **expected):
    exam = imported(folder / f"study{next(COUNT)}", source, *options)
    expect_object(exam, truth, rr_error_s=rr_error_s, **expected)
    return exam


def check_order(folder, source, truth, lps, *options):
    """The slices follow one another along the third axis, wherever the file has them (`lps` is its
    map); a mirrored grid stays one."""
    exam = check(folder, source, truth, *options)
    assert exam.stack.size[2] == truth.size[2], exam.stack.size
    assert np.allclose(exam.stack.spacing()[2], truth.step[2], atol=1e-4), exam.stack.spacing()
    assert np.linalg.det(exam.stack.lps) * np.linalg.det(lps) > 0, exam.stack.lps
    axis = int(np.argmax(np.linalg.norm(lps[:3, :3], axis=0)))
    exam.expect_told(["lie 7.3 mm apart along the file's first axis",
                      "lie 7.3 mm apart along the file's second axis",
                      "the order of its voxels is the file's"][axis])


def written(folder, name, truth, **how):
    return nifti(folder / name, truth.array(), truth.lps, step_s(truth), **how)


# NIfTI

@case
def nifti_plain_and_compressed(folder):
    truth = BeatingObject()
    for name in ("cine.nii", "cine.nii.gz", "CINE.NII"):
        exam = check(folder, written(folder, name, truth), truth)
        assert exam.format == "nifti" and not exam.views


@case
def nifti_every_order_and_direction_of_axes(folder):
    """48 ways to store the same voxels, told by sform and qform."""
    truth = BeatingObject(size=(12, 9, 5))
    for axes, flips in ORDERS:
        data, lps = truth.reordered(axes, flips)
        file = nifti(folder / "cine.nii", data, lps, step_s(truth))
        check_order(folder, file, truth, lps)


@case
def nifti_sform_alone_and_qform_alone(folder):
    truth = BeatingObject(size=(20, 16, 5))
    for axes, flips in ((AXES[0], FLIPS[0]), (AXES[3], FLIPS[5]), (AXES[1], FLIPS[4])):
        data, lps = truth.reordered(axes, flips)
        for how in ({"sform": False}, {"qform": False}):
            check(folder, nifti(folder / "cine.nii", data, lps, step_s(truth), **how), truth)


@case
def nifti_sform_of_1_mm_beside_a_right_pixdim(folder):
    """As public cine files carry it: the edge lengths are pixdim's, and it is said."""
    def unit(header):
        for row in ("srow_x", "srow_y", "srow_z"):
            header[row][:3] /= truth.step
    truth = BeatingObject()
    for qform in (True, False):
        exam = check(folder, written(folder, "cine.nii.gz", truth, qform=qform, change=unit), truth)
        exam.expect_warning("sform|pixdim")
    # The same with axes that are the patient's, as the files of public challenges.
    truth = BeatingObject(turn=np.diag([1.0, 1, 1]))
    exam = check(folder, written(folder, "cine.nii.gz", truth, qform=False, change=unit), truth)
    exam.expect_warning("sform|pixdim")


@case
def nifti_pixdim_of_1_mm_beside_a_right_sform(folder):
    truth = BeatingObject()
    file = written(folder, "cine.nii", truth, qform=False, pixdim=(1, 1, 1))
    exam = check(folder, file, truth)
    exam.expect_warning("sform|pixdim")


@case
def nifti_types_of_voxels(folder):
    truth = BeatingObject(size=(20, 16, 5))
    for dtype, error in (("int16", .51), ("uint16", .51), ("int32", .51), ("float32", .01),
                         ("float64", .01)):
        for big in (False, True):
            check(folder, written(folder, "cine.nii", truth, dtype=dtype, big_endian=big), truth,
                  error=error)
    dim = BeatingObject(size=(20, 16, 5), gain=0.09)
    check(folder, written(folder, "cine.nii", dim, dtype="uint8"), dim)


@case
def nifti_scaled_values(folder):
    truth = BeatingObject(size=(20, 16, 5), offset=-700)
    for big in (False, True):
        file = written(folder, "cine.nii", truth, slope=(0.25, -300.0), big_endian=big)
        check(folder, file, truth, error=0.13)


@case
def nifti_units_of_time(folder):
    truth = BeatingObject(size=(20, 16, 5))
    for unit in ("sec", "msec", "usec"):
        check(folder, written(folder, "cine.nii", truth, unit=unit), truth)


@case
def nifti_milliseconds_that_claim_to_be_seconds(folder):
    truth = BeatingObject(size=(20, 16, 5))
    file = nifti(folder / "cine.nii", truth.array(), truth.lps, 84.37)
    exam = check(folder, file, truth)
    exam.expect_warning("ms|millisecond")


@case
def nifti_without_a_frame_interval(folder):
    """1 or 0 without a unit is what tools write where they know no time."""
    truth = BeatingObject(size=(20, 16, 5))
    for step in (0.0, 1.0):
        file = nifti(folder / f"cine{step:.0f}.nii", truth.array(), truth.lps, step, unit="unknown")
        refused(folder, file, f"cine{step:.0f}", "--rr")
        check(folder, file, truth, "--rr", "0.8437", rr_error_s=1e-6)


@case
def nifti_rr_times_and_phases(folder):
    truth = BeatingObject(size=(20, 16, 5))
    file = nifti(folder / "cine.nii", truth.array(), truth.lps, 0.03)
    exam = check(folder, file, truth, "--rr", "0.8437", times=False)
    exam.expect_told("given")
    uneven = np.array([0, .05, .12, .2, .3, .42, .5, .61, .7, .77])
    places = truth.place(np.stack(np.meshgrid(*map(np.arange, truth.size), indexing="ij"), axis=-1))
    frames = np.stack([truth.value(places, t / 0.8437) for t in uneven], axis=-1)
    file = nifti(folder / "uneven.nii", frames, truth.lps, 0.08437)
    words = ("--times", ",".join(map(str, uneven)), "--rr", "0.8437")
    exam = imported(folder / "uneven", file, *words)
    assert np.allclose(exam.stack.times_s, uneven, atol=1e-6), exam.stack.times_s
    # Ten frames, uneven: the blend is coarse, the wrong phase is much farther off.
    expect_object(exam, truth, error=60, times=False)
    truth25 = BeatingObject(size=(20, 16, 5), phases=25)
    check(folder, written(folder, "c25.nii", truth25), truth25, "--phases", "30", error=8,
          times=False, phases=30)


@case
def nifti_list_of_volumes(folder):
    """A file a phase; 10 comes after 9, whatever the shell's order."""
    truth = BeatingObject()
    data = truth.array()
    files = [nifti(folder / "list" / f"phase_{p + 1}.nii.gz", data[..., p], truth.lps, 0)
             for p in range(10)]
    refused(folder, files, "--rr")
    by_shell = sorted(files)  # phase_1, phase_10, phase_2, ...
    assert by_shell != files
    for order in (files, by_shell):
        check(folder, order, truth, "--rr", "0.8437")
    check(folder, folder / "list", truth, "--rr", "0.8437")


@case
def nifti_list_that_is_no_cycle(folder):
    """Volumes of another size or place are no phases of one cine."""
    truth = BeatingObject()
    data = truth.array()
    files = [nifti(folder / "list" / f"p{p:02d}.nii.gz", data[..., p], truth.lps, 0)
             for p in range(10)]
    nifti(files[6], data[:-1, :, :, 6], truth.lps, 0)
    refused(folder, files, r"p06\.nii\.gz", "size|voxels|matrix|36|35", options=("--rr", "0.8437"))
    moved = truth.lps.copy()
    moved[0, 3] += 3
    nifti(files[6], data[..., 6], moved, 0)
    refused(folder, files, r"p06\.nii\.gz", "place|grid|position|geometry|lie",
            options=("--rr", "0.8437"))


@case
def nifti_with_extensions_and_a_fifth_dimension_of_one(folder):
    truth = BeatingObject(size=(20, 16, 5))
    image = nibabel.load(written(folder, "plain.nii", truth))
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension("comment", b"a comment " * 40))
    nibabel.save(image, folder / "extended.nii.gz")
    check(folder, folder / "extended.nii.gz", truth)
    content = bytearray((folder / "plain.nii").read_bytes())
    content[40:42], content[50:52] = (5).to_bytes(2, "little"), (1).to_bytes(2, "little")
    (folder / "five.nii").write_bytes(content)
    check(folder, folder / "five.nii", truth)


@case
def nifti_alone_in_a_folder(folder):
    truth = BeatingObject(size=(20, 16, 5))
    written(folder, "exam/cine.nii.gz", truth)
    (folder / "exam" / "readme.txt").write_text("hello\n")
    done = run("import", folder / "exam", "--study", folder / "study")
    if done.returncode == 0:
        check(folder, folder / "exam", truth)
    else:
        one_sentence(done, r"cine\.nii\.gz|name the")


@case
def nifti_interval_of_exactly_one_second(folder):
    """What ITK writes for a cine whose spacing nobody set; 2 and 3 of them would be an R-R."""
    truth = BeatingObject(size=(20, 16, 5))
    for count in (2, 3, 10):
        file = nifti(folder / "one.nii", truth.array()[..., :count], truth.lps, 1.0)
        refused(folder, file, r"one\.nii", "--rr")
    exam = check(folder, nifti(folder / "one.nii", truth.array(), truth.lps, 1.0), truth, "--rr",
                 "0.8437")
    exam.expect_told("given R-R interval; the R-R interval is 844 ms")
    assert not exam.told("warning"), exam.decisions
    exam = check(folder, written(folder, "cine.nii", truth), truth)
    exam.expect_told("frame interval.*R-R interval is 844 ms.*taken as even")


@case
def a_study_within_the_source(folder):
    """Its images are no part of the exam, and the source stays the same by it."""
    truth = BeatingObject(size=(20, 16, 5))
    for name, write in (("volume", lambda to: written(to, "cine.nii.gz", truth)),
                        ("dicom", lambda to: save_all(to, classic_exam(truth)))):
        write(folder / name)
        first = beatlas("import", ".", "--study", "exam.study", cwd=folder / name)
        record = (folder / name / "exam.study" / "exam" / "exam.json").stat().st_mtime_ns
        again = beatlas("import", ".", "--study", "exam.study", cwd=folder / name)
        assert "R-R interval" in first.err and "R-R interval" not in again.err, again.err
        assert (folder / name / "exam.study" / "exam" / "exam.json").stat().st_mtime_ns == record
        expect_object(Exam(folder / name / "exam.study"), truth, rr_error_s=1e-3)
        exam = check(folder, folder / name, truth, rr_error_s=1e-3)
        exam.expect_told("1 study in the folder was left")


@case
def hidden_files_beside_the_image(folder):
    """What macOS leaves on foreign disks is no second image."""
    truth = BeatingObject(size=(20, 16, 5))
    written(folder / "mac", "cine.nii.gz", truth)
    (folder / "mac" / "._cine.nii.gz").write_bytes(b"\0\5\x16\7\0\2\0\0Mac OS X" + bytes(4000))
    (folder / "mac" / ".old.nii").write_bytes(b"x" * 400)
    check(folder, folder / "mac", truth)


# NRRD

def slicer(truth, axis, unit="s"):
    """What Slicer writes of a sequence's times."""
    labels, units = ['""'] * 3, ['""'] * 3
    labels.insert(axis, '"time"')
    units.insert(axis, f'"{unit}"')
    factor = {"s": 1, "ms": 1000}[unit]
    values = " ".join(f"{t * factor:.9g}" for t in truth.times_s())
    return {"fields": ("labels: " + " ".join(labels), "units: " + " ".join(units),
                       'space units: "mm" "mm" "mm"', "measurement frame: (1,0,0) (0,1,0) (0,0,1)"),
            "keys": (("DataNodeClassName", "vtkMRMLScalarVolumeNode"),
                     (f"axis {axis} index type", "numeric"),
                     (f"axis {axis} index values", values))}


@case
def nrrd_slicer_sequences(folder):
    """.seq.nrrd: the list axis first or last, times in s or ms."""
    truth = BeatingObject()
    for axis, encoding, unit in itertools.product((0, 3), ("raw", "gzip"), ("s", "ms")):
        for space in ("right-anterior-superior", "left-posterior-superior"):
            file = nrrd(folder / "cine.seq.nrrd", truth.array(), truth.lps, list_axis=axis,
                        encoding=encoding, space=space, version=5, **slicer(truth, axis, unit))
            exam = check(folder, file, truth)
            assert exam.format == "nrrd", exam.format


@case
def nrrd_slicer_sequence_that_only_counts(folder):
    """Index values 0 1 2 ...: frames, no seconds."""
    truth = BeatingObject()
    keys = (("axis 0 index type", "numeric"), ("axis 0 index values", " ".join(map(str, range(10)))))
    file = nrrd(folder / "cine.seq.nrrd", truth.array(), truth.lps, list_axis=0, keys=keys,
                fields=('labels: "frame" "" "" ""',))
    refused(folder, file, r"cine\.seq\.nrrd", "--rr")
    check(folder, file, truth, "--rr", "0.8437")


@case
def nrrd_slicer_multivolume(folder):
    """What Slicer's MultiVolume wrote: trigger times as labels of the frames."""
    truth = BeatingObject()
    labels = ",".join(f"{1e3 * t:.6g}" for t in truth.times_s())
    file = nrrd(folder / "multi.nrrd", truth.array(), truth.lps, list_axis=0, encoding="gzip",
                keys=(("MultiVolume.FrameIdentifyingDICOMTagName", "TriggerTime"),
                      ("MultiVolume.FrameIdentifyingDICOMTagUnits", "ms"),
                      ("MultiVolume.NumberOfFrames", "10"), ("MultiVolume.FrameLabels", labels)))
    done = run("import", file, "--study", folder / "probe")
    if done.returncode == 0:
        check(folder, file, truth)
    else:
        one_sentence(done, r"multi\.nrrd", "--rr")
        check(folder, file, truth, "--rr", "0.8437")


@case
def nrrd_axes_spaces_and_encodings(folder):
    truth = BeatingObject(size=(20, 16, 5))
    rr = ("--rr", "0.8437")
    for axis, kind in itertools.product((0, 3), ("list", "time")):
        for space in ("left-posterior-superior", "LPS", "right-anterior-superior", "RAS",
                      "left-anterior-superior"):
            file = nrrd(folder / "cine.nrrd", truth.array(), truth.lps, list_axis=axis, space=space,
                        kind=kind)
            check(folder, file, truth, *rr)
    for encoding in ("raw", "gzip", "ascii"):
        file = nrrd(folder / "cine.nrrd", truth.array(), truth.lps, list_axis=3, encoding=encoding)
        check(folder, file, truth, *rr)


@case
def nrrd_every_order_and_direction_of_axes(folder):
    truth = BeatingObject(size=(12, 9, 5))
    for axes, flips in SOME_ORDERS:
        data, lps = truth.reordered(axes, flips)
        file = nrrd(folder / "cine.nrrd", data, lps, list_axis=0)
        check_order(folder, file, truth, lps, "--rr", "0.8437")


@case
def nrrd_types_of_voxels(folder):
    truth = BeatingObject(size=(20, 16, 5))
    for dtype, big in itertools.product(("int16", "uint16", "int32", "float32", "float64"),
                                        (False, True)):
        file = nrrd(folder / "cine.nrrd", truth.array(), truth.lps, list_axis=3, dtype=dtype,
                    big_endian=big)
        check(folder, file, truth, "--rr", "0.8437")
    dim = BeatingObject(size=(20, 16, 5), gain=0.09)
    check(folder, nrrd(folder / "cine.nrrd", dim.array(), dim.lps, list_axis=0, dtype="uint8"), dim,
          "--rr", "0.8437")


@case
def nrrd_time_as_an_axis_of_space(folder):
    """As ITK writes four dimensions."""
    truth = BeatingObject(size=(20, 16, 5))
    for space in ("left-posterior-superior", "right-anterior-superior"):
        file = nrrd(folder / "cine.nrrd", truth.array(), truth.lps, space=space,
                    time_in_space=0.08437)
        check(folder, file, truth)


@case
def nrrd_with_the_voxels_in_another_file(folder):
    truth = BeatingObject()
    for encoding, name in (("raw", "cine.raw"), ("gzip", "cine.raw.gz")):
        file = nrrd(folder / "cine.nhdr", truth.array(), truth.lps, list_axis=3, encoding=encoding,
                    data_file=name, **slicer(truth, 3))
        check(folder, file, truth)
    (folder / "cine.raw.gz").unlink()
    refused(folder, file, r"cine\.(nhdr|raw\.gz)")


@case
def nrrd_list_of_volumes(folder):
    truth = BeatingObject()
    data = truth.array()
    files = [nrrd(folder / "list" / f"phase_{p + 1}.nrrd", data[..., p], truth.lps)
             for p in range(10)]
    for order in (files, sorted(files)):
        check(folder, order, truth, "--rr", "0.8437")


# MetaImage

@case
def metaimage_in_one_file_and_in_two(folder):
    truth = BeatingObject()
    for compressed in (False, True):
        for name, data_file in (("cine.mha", "LOCAL"), ("cine.mhd", "cine.raw")):
            file = metaimage(folder / name, truth.array(), truth.lps, step_s(truth),
                             compressed=compressed, data_file=data_file)
            exam = check(folder, file, truth)
            assert exam.format == "metaimage", exam.format
    (folder / "cine.raw").unlink()
    refused(folder, folder / "cine.mhd", r"cine\.(mhd|raw)")


@case
def metaimage_every_order_and_direction_of_axes(folder):
    truth = BeatingObject(size=(12, 9, 5))
    for axes, flips in SOME_ORDERS:
        data, lps = truth.reordered(axes, flips)
        file = metaimage(folder / "cine.mha", data, lps, step_s(truth))
        check_order(folder, file, truth, lps)


@case
def metaimage_types_of_voxels(folder):
    truth = BeatingObject(size=(20, 16, 5))
    for dtype, big in itertools.product(("int16", "uint16", "int32", "float32", "float64"),
                                        (False, True)):
        check(folder, metaimage(folder / "cine.mha", truth.array(), truth.lps, step_s(truth),
                                dtype=dtype, big_endian=big), truth)
    dim = BeatingObject(size=(20, 16, 5), gain=0.09)
    check(folder, metaimage(folder / "cine.mha", dim.array(), dim.lps, step_s(dim), dtype="uint8"),
          dim)


@case
def metaimage_times(folder):
    """Steps of the fourth axis in s or ms; 1 says nothing."""
    truth = BeatingObject(size=(20, 16, 5))
    check(folder, metaimage(folder / "ms.mha", truth.array(), truth.lps, 84.37), truth)
    file = metaimage(folder / "one.mha", truth.array(), truth.lps, 1.0)
    refused(folder, file, r"one\.mha", "--rr")
    check(folder, file, truth, "--rr", "0.8437")


def in_parts(folder, truth, names, contents):
    """A NRRD and a MetaImage header that list these files beside them."""
    for name, content in zip(names, contents):
        (folder / name).write_bytes(content)
    files = [nrrd(folder / "cine.nhdr", truth.array(), truth.lps, list_axis=3, data_file="LIST",
                  **slicer(truth, 3)),
             metaimage(folder / "cine.mhd", truth.array(), truth.lps, step_s(truth),
                       data_file="LIST")]
    for file in files:
        lines = [line for line in file.read_text().splitlines() if "LIST" not in line]
        lines += [line for line in file.read_text().splitlines() if "LIST" in line]
        file.write_text("\n".join([*lines, *names]) + "\n")
    return files


@case
def lists_of_data_files(folder):
    """Each part has its own size; one that is short shifts no other, a stray one is told."""
    truth = BeatingObject(size=(20, 16, 5))
    parts = [np.round(truth.array()[..., p]).astype("<i2").tobytes(order="F") for p in range(10)]
    names = [f"part{p}.raw" for p in range(10)]
    for file in in_parts(folder, truth, names, parts):
        check(folder, file, truth)
    shifted = [*parts[:3], parts[3][:-200], parts[4] + bytes(200), *parts[5:]]
    for file in in_parts(folder, truth, names, shifted):
        refused(folder, file, file.name.replace(".", r"\."), "data file 4 of the 10.*shorter")
    for file in in_parts(folder, truth, ["stray.raw", *names], [parts[9], *parts]):
        refused(folder, file, file.name.replace(".", r"\."), "11 data files for 10 images")


@case
def metaimage_list_of_volumes(folder):
    truth = BeatingObject()
    data = truth.array()
    files = [metaimage(folder / "list" / f"phase_{p + 1}.mha", data[..., p], truth.lps)
             for p in range(10)]
    for order in (files, sorted(files)):
        check(folder, order, truth, "--rr", "0.8437")


# All

@case
def formats_give_one_exam(folder):
    """The same voxels from every format: the same images, grid and times, whatever the file."""
    truth = BeatingObject(turn=turned(-2.6, 0.7, 1.9), step=(1.4063, 2.3, 8.85))
    data = truth.array()
    files = [written(folder, "a.nii.gz", truth, dtype="float32"),
             nrrd(folder / "a.nrrd", data, truth.lps, list_axis=0, dtype="float32",
                  **slicer(truth, 0)),
             metaimage(folder / "a.mha", data, truth.lps, step_s(truth), dtype="float32")]
    exams = [check(folder, file, truth) for file in files]
    for exam in exams[1:]:
        assert np.array_equal(exam.stack.values, exams[0].stack.values)
        assert np.allclose(exam.stack.lps, exams[0].stack.lps, atol=1e-4)
        assert abs(exam.stack.rr_s - exams[0].stack.rr_s) < 1e-6


if __name__ == "__main__":
    main()
