"""Exams to be refused: a sound one, in every format, to be damaged; and how a refusal is looked at."""
from dicom_writers import classic_exam, save_all
from exam_object import BeatingObject
from harness import Exam, one_sentence, refused, run
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
