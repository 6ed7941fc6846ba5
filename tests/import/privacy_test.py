"""Nothing that names a person leaves ingest: words planted in every text of a source, and in the
names of its files and folders, are searched for in all that the program leaves and says:
privacy_test.py BEATLAS NAME"""
import base64
import gzip
import json
import pathlib
import re
import shutil
import subprocess
import zipfile

import nibabel
import numpy as np
import pydicom

from dicom_writers import (ROOT, classic_exam, convert, cut, enhanced_image, pixel_format, save)
from exam_object import BeatingObject, expect_object
from harness import Exam, beatlas, case, main, one_sentence, run
from markers import (BIRTH, GIVEN, ID_DIGITS, NUMBER, PERSON, Texts, expect_clean,
                     expect_clean_files, found_in, layers, save_planted, text_count, word)
from volume_writers import metaimage, nifti, nrrd

TRUTH = BeatingObject(size=(20, 16, 4), phases=10)
COARSE = {"field": {"voxel_mm": 4, "inner_mm": 8, "outer_mm": 8}, "mesh": {"edge_mm": 5},
          "register": {"shape_mm": 2}, "quality": {"max_volume_gap_percent": 100}}
# A part of a path that shows a person: a word of the source's texts, '^', a long run of digits.
NAMES = (f"{PERSON}_{GIVEN}", f"{PERSON.lower()} cine", f"Doe^Jane {NUMBER}", NUMBER,
         ID_DIGITS + "0000123", f"study {BIRTH}", f"SA-{word(90003)}-1")


def planted(images, texts=None):
    texts = texts or Texts()
    return [texts.plant(d) for d in images]


def named(folder, images, seed=0):
    """Files of names that show the person, all in one folder of such a name."""
    source = pathlib.Path(folder) / NAMES[seed % len(NAMES)]
    for n, d in enumerate(images):
        save_planted(d, source / f"{NAMES[n % len(NAMES)]}.{n + 1:04d}")
    return source


def silent(done):
    """All that was said is clean, but that messages repeat the paths that were typed as they were."""
    said = done.err
    for word in sorted(done.args[1:], key=len, reverse=True):
        said = said.replace(word, "TYPED") if "/" in word else said
    expect_clean("stdout of " + done.command[:60], done.out)
    expect_clean("stderr of " + done.command[:60], said)
    return done


@case
def the_search_finds_what_is_planted(folder):
    """Guards the tests: as it is, in UTF-16, base64 and hexadecimal, packed and packed again."""
    for text in (word(90001), "x" + word(123).lower(), ID_DIGITS + "1", BIRTH, "83.719246"):
        raw = text.encode()
        for content in (raw, text.encode("utf-16-le"), text.encode("utf-16-be"),
                        *(base64.b64encode(b"abc"[:n] + raw + b"de") for n in range(3)),
                        *(base64.b64encode(b"a" * n + text.encode("utf-16-le")) for n in range(3)),
                        b"ab" + raw.hex().encode(), raw.hex().upper().encode()):
            assert found_in(b"before " + content + b" after"), content
    with zipfile.ZipFile(folder / "a.zip", "w") as archive:
        (folder / "a.txt").write_text(word(5))
        subprocess.run(["zstd", "-q", str(folder / "a.txt")], check=True)
        archive.write(folder / "a.txt.zst", "a.zst")
        archive.writestr("b.gz", gzip.compress(word(6).encode()))
    parts = dict(layers("a.zip", (folder / "a.zip").read_bytes()))
    assert found_in(parts["a.zip|a.zst|unzstd"]) and found_in(parts["a.zip|b.gz|gunzip"]), parts
    assert not found_in(b"nothing of it 12345 MKQ ZX 1917")


@case
def the_texts_are_planted(folder):
    """Guards the tests: the words are in the files, and the files are sound."""
    source = named(folder, planted(classic_exam(TRUTH)[:3]))
    files = list(source.iterdir())
    assert len(files) == 3, files
    for file in files:
        d = pydicom.dcmread(file)
        assert text_count(d) > 1500, text_count(d)
        for keyword in ("PatientName", "InstitutionName", "DeviceSerialNumber", "ImageComments",
                        "SeriesDescription", "ProtocolName", "PatientBirthDate", "StudyDate",
                        "OperatorsName", "Manufacturer", "SequenceName", "StationName"):
            assert found_in(str(d[keyword].value).encode()), keyword
        assert np.array_equal(d.pixel_array.shape, (16, 20))
        assert found_in(file.read_bytes()[:128])


@case
def a_whole_build(folder):
    """Study, pictures, package, its manifest, exports, times, logs: all of a planted exam."""
    beatlas("phantom", "-o", folder / "phantom", "--preset", "small", "--format", "nifti", "--phases", "4")
    image = nibabel.load(folder / "phantom" / "cine.nii.gz")
    data = np.asarray(image.dataobj)[:, :, ::2]
    affine = np.diag([-1.0, -1, 1, 1]) @ image.affine
    step = np.linalg.norm(affine[:3, :3], axis=0)
    truth = BeatingObject(size=data.shape[:3], step=step * (1, 1, 2), phases=data.shape[3],
                          turn=affine[:3, :3] / step, origin=affine[:3, 3], rr_ms=750)
    texts = Texts()
    images = classic_exam(truth)
    for n, d in enumerate(images):
        k, p = divmod(n, truth.phases)
        pixel_format(d, data[:, :, k, p].T)
    source = named(folder / "source", planted(images, texts))
    (folder / "coarse.json").write_text(json.dumps(COARSE))
    out = folder / "out"
    out.mkdir()
    done = silent(beatlas("build", source, "-o", out / "heart.beatlas", "--study", out / "study",
                          "--recipe", folder / "coarse.json", "--timing", out / "timing.json", "-v"))
    assert "import" in done.err
    (out / "info.json").write_text(silent(beatlas("info", out / "heart.beatlas", "--json")).out)
    silent(beatlas("info", out / "heart.beatlas"))
    silent(run("validate", out / "heart.beatlas", "--json"))
    silent(run("status", out / "study"))
    silent(run("status", out / "study", "--json"))
    for kind in ("nifti", "obj"):
        silent(beatlas("export", out / "heart.beatlas", "--to", kind, "-o", out / f"export-{kind}"))
    silent(beatlas("export", out / "study", "--to", "nifti", "-o", out / "export-study"))
    silent(beatlas("export", out / "study", "--to", "slicer", "--phase", "0", "-o", out / "editor"))
    silent(beatlas("pack", "--study", out / "study", "-o", out / "again.beatlas", "-v"))
    silent(beatlas("build", source, "-o", out / "heart.beatlas", "--study", out / "study",
                   "--recipe", folder / "coarse.json", "-v", "--json"))
    silent(beatlas("import", source, "--study", out / "lines", "--json", "-v"))
    silent(beatlas("report", out / "study", "-o", out / "report.html", "--json", "-v"))
    parts = dict(layers("report.html", (out / "study" / "report.html").read_bytes()))
    pictures = [part for part in parts.values() if part[:3] == b"\xff\xd8\xff"]
    assert len(pictures) == truth.size[2], "the search looks into the report's pictures"
    files = expect_clean_files(out)
    assert files > 30, files


@case
def classic_and_enhanced_imports(folder):
    """Every way to import says and leaves nothing, verbose too."""
    texts = Texts()
    sources = [named(folder / "classic", planted(classic_exam(TRUTH), texts), 1)]
    frames = [(k, p) for k in range(4) for p in range(10)]
    multi = planted([enhanced_image(TRUTH, frames)], texts)[0]
    for group in multi.PerFrameFunctionalGroupsSequence:
        group.FrameContentSequence[0].FrameComments = word(90060)
        group.FrameContentSequence[0].StackID = word(90061)
        group.FrameContentSequence[0].FrameAcquisitionDateTime = BIRTH + "031741.591827"
    sources.append(named(folder / "enhanced", [multi], 2))
    sources.append(next(sources[1].iterdir()))  # the file by its name
    sources.append(named(folder / "implicit", planted(classic_exam(TRUTH), texts), 3))
    convert(sources[-1], "implicit_little_endian")
    out = folder / "out"
    for n, source in enumerate(sources):
        done = silent(beatlas("import", source, "--study", out / f"study{n}", "-v", "--timing",
                              folder / "timing.json"))
        expect_object(Exam(out / f"study{n}", done.err), TRUTH)
        expect_clean_files(out, folder / "timing.json")


def trouble(folder, source, out, *words, code=3):
    """A refusal that shows no person; its sentence."""
    for command in ("import", "build"):
        package = ["-o", out / "heart.beatlas"] if command == "build" else []
        words_of_it = [command, source, "--study", out / f"study-{command}", *package, *words]
        silent(run(*words_of_it, "-v"))
        done = silent(run(*words_of_it))
        done.err = "".join(line for line in done.err.splitlines(True)
                           if not re.match(r"beatlas: (import|warning): ", line))
        said = one_sentence(done, code=code)
        if out.exists():
            expect_clean_files(out, at_least=0)
    return said


@case
def a_truncated_file_is_named_without_its_name(folder):
    """The place of the file in the order of names replaces what shows the person."""
    source = named(folder, planted(classic_exam(TRUTH)), 0)
    files = sorted(source.iterdir())
    for share in (0.995, 0.6, 0.02):
        shutil.copyfile(files[11], folder / "kept")
        cut(files[11], share)
        said = trouble(folder, source, folder / "out")
        assert re.search(rf"\bfile 12 of {len(files)}\b", said), said
        shutil.copyfile(folder / "kept", files[11])


@case
def names_in_another_form_are_hidden(folder):
    """The header's birth date, ID or name, written otherwise in the name of the folder."""
    for n, (name, patient, number) in enumerate((
            ("born 1980-01-02", "Miller^Jane", "123456"), ("02.01.80", "Miller^Jane", "123456"),
            ("12-34-56", "Miller^Jane", "123456"), ("AB 12 CD", "Miller^Jane", "AB12CD"),
            ("AB12CD", "Miller^Jane", "AB 12 CD"), ("Wu Li", "Wu^Li", "123456"),
            ("of 42", "Miller^Jane", "42"))):
        images = classic_exam(TRUTH)
        for d in images:
            d.PatientName, d.PatientID, d.PatientBirthDate = patient, number, "19800102"
        for k, d in enumerate(images):
            save(d, folder / str(n) / name / f"IM{k}.dcm")
        cut(folder / str(n) / name / "IM7.dcm", 0.9)
        said = one_sentence(run("import", folder / str(n), "--study", folder / "study"))
        assert name not in said and "[folder 1 of 1 by name]/IM7.dcm" in said, said


@case
def harmless_names_are_shown(folder):
    """A name that shows no one stays readable, so that the file can be found."""
    source = folder / "cine exam" / "Se3"
    for n, d in enumerate(planted(classic_exam(TRUTH))):
        save_planted(d, source / f"IM{n:04d}.dcm")
    cut(source / "IM0007.dcm", 0.9)
    said = trouble(folder, folder / "cine exam", folder / "out")
    assert "Se3/IM0007.dcm" in said and "cine exam" in said, said


@case
def refusals_show_no_person(folder):
    texts = Texts()

    def exam(**how):
        return planted(classic_exam(TRUTH, **how), texts)

    def small(d):
        pixel_format(d, TRUTH.image(0, 0)[:10, :12])
        return d
    kinds = {
        "one phase": exam(keep=lambda k, p: p == 0),
        "missing phases": exam(keep=lambda k, p: k not in (1, 2) or p < 4),
        "two slices": exam(keep=lambda k, p: k < 2),
        "a hole": exam(keep=lambda k, p: k not in (1, 2)),
        "mixed sizes": [small(d) if n == 14 else d for n, d in enumerate(exam())],
        "no spacing": exam(change=lambda k, p, d: setattr(d, "PixelSpacing", ["0", "0"])),
        "no place": exam(change=lambda k, p, d: delattr(d, "ImagePositionPatient")),
        "no times": exam(change=lambda k, p, d: [delattr(d, "TriggerTime"),
                                                 delattr(d, "NominalInterval")]),
        "black": exam(change=lambda k, p, d: setattr(d, "PixelData", bytes(len(d.PixelData)))),
    }
    for n, (kind, images) in enumerate(kinds.items()):
        source = named(folder / f"in{n}", images, n)
        trouble(folder, source, folder / f"out{n}")
    whole = named(folder / "whole", exam(), 4)
    for words in (("--series", "999"), ("--exam", "7"), ("--stack", "99"), ("--times", "0,0.1")):
        trouble(folder, whole, folder / "out", *words)


@case
def several_patients_are_listed_by_number(folder):
    texts = Texts()
    images = planted(classic_exam(TRUTH), texts)
    for n, d in enumerate(planted(classic_exam(TRUTH), texts)):
        d.StudyInstanceUID += ".9"
        d.SeriesInstanceUID += ".9"
        d.SOPInstanceUID = d.file_meta.MediaStorageSOPInstanceUID = ROOT + f"5.{ID_DIGITS}{n}"
        d.PatientID, d.PatientName = ID_DIGITS + "999", f"{word(90070)}^{word(90071)}"
        images.append(d)
    source = named(folder / "in", images, 2)
    said = trouble(folder, source, folder / "out")
    assert "--exam" in said and re.search(r"\b1\b.*\b2\b", said), said
    done = silent(beatlas("import", source, "--study", folder / "out" / "s", "--exam", "2", "-v"))
    expect_object(Exam(folder / "out" / "s", done.err), TRUTH)
    expect_clean_files(folder / "out")


def nifti_texts(header):
    header["descrip"] = f"{PERSON}^{GIVEN} {BIRTH}".encode()
    header["aux_file"] = f"{PERSON}.aux".encode()
    header["intent_name"] = word(90080).encode()
    header["db_name"] = word(90081).encode()
    header["data_type"] = word(90082)[:10].encode()


def write_planted(folder, data):
    """The same voxels in each format with words in all its texts; names that show the person."""
    step = TRUTH.rr_ms / TRUTH.phases / 1e3
    folder.mkdir(parents=True, exist_ok=True)
    plain = nifti(folder / "plain.nii", data, TRUTH.lps, step, change=nifti_texts, dtype="float32")
    image = nibabel.load(plain)
    for code in (4, 6, 44):  # AFNI, comment, unknown
        image.header.extensions.append(nibabel.nifti1.Nifti1Extension(
            code, f"<patient>{word(90083)} {BIRTH}</patient>".encode()))
    compressed = folder / f"{PERSON}_{GIVEN}.nii.gz"
    nibabel.save(image, compressed)
    whole = folder / f"{ID_DIGITS}0000123.nii"
    plain.replace(whole)
    times = " ".join(f"{p * step:.6g}" for p in range(data.shape[3]))
    keys = (("axis 3 index type", "numeric"), ("axis 3 index values", times),
            ("PatientName", f"{PERSON}^{GIVEN}"), ("0010|0030", BIRTH), (word(90084), "1"),
            ("PatientID", ID_DIGITS + "0000123"))
    fields = (f"content: {PERSON} {word(90085)}", f"# {word(90086)}",
              f'labels: "{word(90087)}" "" "" "time"', 'units: "" "" "" "s"')
    listed = {"list_axis": 3, "keys": keys, "fields": fields, "dtype": "float32"}
    comment = (f"Comment = {PERSON} {word(90088)}", f"PatientName = {PERSON}^{GIVEN}",
               f"PatientID = {ID_DIGITS}0000123", "ID = 1", f"Name = {word(90089)}",
               f"AcquisitionDate = {BIRTH}")
    listed_meta = {"fields": comment, "dtype": "float32"}
    return [compressed, whole,
            nrrd(folder / f"{PERSON}.seq.nrrd", data, TRUTH.lps, **listed),
            nrrd(folder / f"{word(90085)}.nhdr", data, TRUTH.lps, **listed,
                 data_file=f"{PERSON}_{NUMBER}.raw"),
            metaimage(folder / f"{PERSON}.mha", data, TRUTH.lps, step, **listed_meta),
            metaimage(folder / f"{word(90088)}.mhd", data, TRUTH.lps, step, **listed_meta,
                      data_file=f"{PERSON} {NUMBER}.zraw")]


@case
def volumes_show_no_person(folder):
    """NIfTI's texts and extensions, NRRD's keys and comments, MetaImage's fields; good and bad."""
    files = write_planted(folder / f"{PERSON}_exam", TRUTH.array())
    for n, file in enumerate(files):
        assert found_in(file.read_bytes() if file.suffix != ".gz" else
                        gzip.decompress(file.read_bytes()))
        done = silent(beatlas("import", file, "--study", folder / "out" / f"study{n}", "-v"))
        expect_object(Exam(folder / "out" / f"study{n}", done.err), TRUTH)
    expect_clean_files(folder / "out")


@case
def refused_volumes_show_no_person(folder):
    data = TRUTH.array()
    data[3, 4, 1, 5] = np.nan
    bad = {"nan": data, "black": data * 0 + 5, "one_slice": data[:, :, :1] * 0 + np.arange(20).reshape(
        20, 1, 1, 1), "one_phase": TRUTH.array()[..., :1]}
    for kind, voxels in bad.items():
        for file in write_planted(folder / kind / f"{PERSON}_exam", voxels):
            done = silent(run("import", file, "--study", folder / "out" / "study", "-v"))
            one_sentence(done)
            if (folder / "out").exists():
                expect_clean_files(folder / "out", at_least=0)
    files = write_planted(folder / "cut" / f"{PERSON}_exam", TRUTH.array())
    for file in files:
        cut(file, 0.7)
        one_sentence(silent(run("import", file, "--study", folder / "out" / "study")))
    for far in files[0].parent.glob("*raw"):
        far.unlink()
    for file in (files[3], files[5]):
        one_sentence(silent(run("import", file, "--study", folder / "out" / "study")))


@case
def a_list_of_volumes_shows_no_person(folder):
    """Named one by one and as a folder, whole and with one of another size."""
    data = TRUTH.array()
    source = folder / f"{PERSON}^{GIVEN}"
    files = [nifti(source / f"{PERSON}_{p:02d}.nii.gz", data[..., p], TRUTH.lps, 0,
                   change=nifti_texts) for p in range(10)]
    out = folder / "out"
    silent(beatlas("import", *files, "--study", out / "a", "--rr", "0.8437", "-v"))
    silent(beatlas("import", source, "--study", out / "b", "--rr", "0.8437", "-v"))
    nifti(files[4], data[:-2, :, :, 4], TRUTH.lps, 0, change=nifti_texts)
    done = silent(run("import", *files, "--study", out / "c", "--rr", "0.8437"))
    one_sentence(done)
    done = silent(run("import", source, "--study", out / "c", "--rr", "0.8437"))
    one_sentence(done)
    expect_clean_files(out)


@case
def names_alone_are_hidden_too(folder):
    """An exam without any text, whose files' names show a person by their form."""
    images = classic_exam(TRUTH)
    for d in images:
        d.PatientName, d.PatientID, d.StudyID = "", "", ""
    source = folder / "in" / f"Doe^Jane_{NUMBER}"
    for n, d in enumerate(images):
        save(d, source / f"Doe^Jane {NUMBER}.{n:04d}")
    cut(sorted(source.iterdir())[4], 0.8)
    said = trouble(folder, folder / "in", folder / "out")
    assert "Jane" not in said and "Doe" not in said, said
    assert re.search(r"\bfile 5 of 40\b", said), said


@case
def what_was_typed_is_said_as_typed_and_kept_nowhere(folder):
    """The user knows his own words; what is found below them, and what stays in the study, shows none."""
    source = folder / f"Doe^Jane {BIRTH}"
    for n, d in enumerate(planted(classic_exam(TRUTH))):
        save_planted(d, source / f"{PERSON}_{n:04d}.dcm")
    whole = sorted(source.iterdir())[4].read_bytes()
    cut(sorted(source.iterdir())[4], 0.8)
    said = one_sentence(silent(run("import", source, "--study", folder / "out" / "study")))
    assert f"{source}/[file 5 of 40 by name].dcm: " in said, said
    sorted(source.iterdir())[4].write_bytes(whole)
    for words in (("--series", "999"), ("--times", str(folder / "Doe^Jane.txt"))):
        said = one_sentence(silent(run("import", source, "--study", folder / "out" / "study", *words)))
        assert (str(source) if words[0] == "--series" else words[1]) + ": " in said, said
    # A file without a byte is a warning, which the study keeps.
    (source / f"{PERSON}_empty.dcm").touch()
    done = silent(beatlas("import", source, "--study", folder / "out" / "study"))
    assert "[file 41 of 41 by name].dcm is empty" in done.err, done.err
    expect_clean_files(folder / "out")
    for file in (folder / "out").rglob("*.json"):
        assert str(folder) not in file.read_text() and "Doe" not in file.read_text(), file


if __name__ == "__main__":
    main()
