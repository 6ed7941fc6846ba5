"""Bad input: one sentence that names the file and the reason, exit code 3, nothing left behind:
bad_input_test.py BEATLAS NAME"""
import json
import pathlib
import re
import zipfile

import numpy as np
import pydicom

from bad_exams import RR, STEP, TRUTH, dicom, volumes
from dicom_writers import classic_exam, convert, cut, enhanced_image, save
from exam_object import expect_object
from harness import beatlas, case, exam_bytes, imported, main, one_sentence, refused, run
from volume_writers import metaimage, nifti, nrrd


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
def the_index_of_a_folder(folder):
    """Named instead of the folder it lies in."""
    source = dicom(folder)
    index = pydicom.dcmread(next(f for f in sorted(source.rglob("*")) if f.is_file()))
    index.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.1.3.10"
    index.save_as(source / "DICOMDIR")
    refused(folder, source / "DICOMDIR", "DICOMDIR", "name the folder")


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
    old = (pathlib.Path(__file__).resolve().parents[1] / "package" / "golden" / "v3.beatlas").read_bytes()
    (folder / "heart.beatlas").write_bytes(old)
    one_sentence(run("build", bad, "-o", folder / "heart.beatlas"), "bad")
    assert (folder / "heart.beatlas").read_bytes() == old
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
