"""Words, dates and numbers that name nobody and occur nowhere by chance; planted in a source, then
searched for in all that a program left and said."""
import base64
import copy
import ctypes
import ctypes.util
import gzip
import io
import pathlib
import re
import zipfile
import zlib

import pydicom
from pydicom.datadict import DicomDictionary
from pydicom.dataset import Dataset
from pydicom.sequence import Sequence

PERSON, GIVEN = "MKQ90001ZX", "MKQ90002ZX"  # in PatientName, and in names of files
ID_DIGITS = "77703339"  # in every UID and number of a patient
BIRTH, CLOCK, AGE, WEIGHT = "19170923", "031741.591827", "097Y", "83.719246"
NUMBER = "5550666777123"  # a long run of digits in a file's name
# In lower case; a literal beginning each, which is quick to search for. The clock's fraction counts
# behind its own minutes or by itself: coordinates of a mesh hold any six digits behind others.
WORDS = [re.compile(pattern) for pattern in (
    rb"mkq\d{5}zx", rb"77703339\d*", rb"19170923", rb"1741\.591827", rb"(?<![.\d])591827",
    rb"83\.719246", rb"5550666777123")]
WIDE_WORDS = [re.compile(pattern) for pattern in (
    rb"m\0k\0q\0(?:\d\0){5}z\0x", rb"7\x007\x007\x000\x003\x003\x003\x009(?:\0\d)*",
    rb"1\x009\x001\x007\x000\x009\x002\x003", rb"5\x009\x001\x008\x002\x007",
    rb"8\x003\0\.\x007\x001\x009\x002\x004\x006",
    rb"5\x005\x005\x000\x006\x006\x006\x007\x007\x007\x001\x002\x003")]

PRINTABLE = bytes(range(32, 127)) + b"\n\r\t"

# What an image is read by, or what has no room for a word.
NEEDED = {
    "SpecificCharacterSet", "ImageType", "SOPClassUID", "SOPInstanceUID", "StudyInstanceUID",
    "SeriesInstanceUID", "FrameOfReferenceUID", "Modality", "PhotometricInterpretation",
    "FrameType", "ComplexImageComponent", "InstanceCreatorUID", "PatientName", "TriggerTime",
    "PixelPresentation", "VolumetricProperties", "TimezoneOffsetFromUTC",
    "PixelDataProviderURL"}
TEXTS = {"AE": 16, "CS": 16, "LO": 64, "LT": 1000, "SH": 16, "ST": 1000, "UC": 1000, "UT": 1000}


def word(number):
    return f"MKQ{number:05d}ZX"


def value_of(vr, number):
    if vr in TEXTS:
        return word(number)
    return {"PN": f"{word(number)}^{GIVEN}", "DA": BIRTH, "TM": CLOCK, "DT": BIRTH + CLOCK,
            "AS": AGE, "UI": f"1.2.826.0.1.3680043.8.498.{ID_DIGITS}{number:05d}",
            "UR": f"http://{word(number)}.example/"}[vr]


def planted_texts():
    """Every element of the standard whose value is text, and private ones beside; a word each."""
    out = Dataset()
    number = 0
    for tag, (vr, _, _, _, keyword) in DicomDictionary.items():
        group = tag >> 16
        number += 1
        if (group <= 4 or group in (0x7FE0, 0xFFFA, 0xFFFC, 0xFFFE) or not keyword
                or keyword in NEEDED or vr not in (*TEXTS, "PN", "DA", "TM", "DT", "AS", "UI", "UR")):
            continue
        out.add_new(tag, vr, value_of(vr, number))
    out.PatientName = f"{PERSON}^{GIVEN}^{word(90003)}^Dr"
    out.PatientID = ID_DIGITS + "0000123"
    out.AccessionNumber, out.StudyID = ID_DIGITS + "55", ID_DIGITS[:8]
    out.PatientWeight, out.PatientSize = WEIGHT, "1.719246"
    inner = Dataset()
    inner.PatientName, inner.PatientID = f"{word(90010)}^{GIVEN}", ID_DIGITS + "77"
    inner.TextValue, inner.PersonName = word(90011), f"{word(90012)}^X"
    inner.Date = BIRTH
    deep = Dataset()
    deep.ReferringPhysicianName, deep.ImageComments = f"{word(90013)}^X", word(90014)
    inner.ReferencedImageSequence = Sequence([deep])
    for keyword in ("OtherPatientIDsSequence", "RequestAttributesSequence", "ContentSequence",
                    "ReferencedStudySequence", "OriginalAttributesSequence", "SourceImageSequence",
                    "PerformedProtocolCodeSequence", "AcquisitionContextSequence"):
        setattr(out, keyword, Sequence([inner, inner]))
    for group in (0x0009, 0x0019, 0x0029, 0x0051, 0x2001):
        block = out.private_block(group, f"{word(90020 + group % 100)} HEADER", create=True)
        block.add_new(0x10, "LO", word(90030))
        block.add_new(0x11, "UN", b"name=" + word(90031).encode() + b" ")
        block.add_new(0x12, "OB", word(90032).encode("utf-16-le") + word(90033).encode())
        block.add_new(0x13, "SQ", Sequence([inner]))
    out.add_new(0xFFFCFFFC, "OB", (word(90040) * 4).encode())  # padding at the end
    return out


def plant_header(dataset):
    """Where no element stands: the preamble, the meta header, the UIDs."""
    dataset.preamble = (word(90050) + " " + word(90051)).encode().ljust(128, b"\0")
    meta = dataset.file_meta
    meta.SourceApplicationEntityTitle = word(90052)
    meta.ImplementationVersionName = word(90053)
    meta.PrivateInformationCreatorUID = f"1.2.3.{ID_DIGITS}"
    meta.PrivateInformation = word(90054).encode()
    for keyword in ("SOPInstanceUID", "StudyInstanceUID", "SeriesInstanceUID",
                    "FrameOfReferenceUID"):
        old = dataset[keyword].value.split(".")
        dataset[keyword].value = ".".join([*old[:-2], ID_DIGITS + old[-2], old[-1]])
    meta.MediaStorageSOPInstanceUID = dataset.SOPInstanceUID


def encoded(dataset):
    """The bytes of each element, explicit little endian."""
    out = {}
    for element in dataset:
        buffer = pydicom.filebase.DicomBytesIO()
        buffer.is_little_endian, buffer.is_implicit_VR = True, False
        pydicom.filewriter.write_data_element(buffer, element, ["iso8859"])
        out[int(element.tag)] = buffer.getvalue()
    return out


class Texts:
    """The planted elements, made and encoded once: exams of many files are written quickly."""

    def __init__(self):
        self.dataset = planted_texts()
        self.encoded = encoded(self.dataset)

    def plant(self, dataset):
        """What an image needs stays, what names somebody is replaced; the rest comes on saving."""
        for keyword in ("PatientName", "PatientID", "StudyID", "StudyDate", "StudyTime",
                        "AccessionNumber", "ContentDate", "ContentTime"):
            dataset[keyword] = copy.copy(self.dataset[keyword])
        plant_header(dataset)
        dataset._texts = self
        return dataset


def save_planted(dataset, path):
    """A data set whose texts lie beside its own elements, in the order of tags."""
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    head = Dataset()
    head.file_meta, head.preamble = dataset.file_meta, dataset.preamble
    head.is_little_endian, head.is_implicit_VR = True, False
    buffer = io.BytesIO()
    pydicom.dcmwrite(buffer, head, write_like_original=False)
    elements = {**dataset._texts.encoded, **encoded(dataset)}
    path.write_bytes(buffer.getvalue() + b"".join(elements[tag] for tag in sorted(elements)))
    return path


def text_count(dataset):
    """How many values of a data set hold a planted word, those of sequences counted too."""
    return sum(1 for element in dataset.iterall()
               if plain_words(str(element.value).encode("utf-8", "replace")))


def unzstd(content):
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_getFrameContentSize.restype = ctypes.c_ulonglong
    library.ZSTD_decompress.restype = ctypes.c_size_t
    size = library.ZSTD_getFrameContentSize(content, ctypes.c_size_t(len(content)))
    assert size < 1 << 33, "no zstd frame of known size"
    out = ctypes.create_string_buffer(size)
    got = library.ZSTD_decompress(out, ctypes.c_size_t(size), content, ctypes.c_size_t(len(content)))
    assert got == size, "a zstd frame that cannot be unpacked"
    return out.raw[:size]


def layers(name, content):
    """A file and all that is packed in it."""
    yield name, content
    if content[:2] == b"\x1f\x8b":
        yield from layers(name + "|gunzip", gzip.decompress(content))
    elif content[:4] == b"PK\x03\x04":
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            yield name + "|names", " ".join(archive.namelist()).encode() + archive.comment
            for entry in archive.infolist():
                yield f"{name}|{entry.filename}|extra", entry.extra + entry.comment
                yield from layers(f"{name}|{entry.filename}", archive.read(entry))
    elif content[:15] == b"<!DOCTYPE html>":
        for n, packed in enumerate(re.findall(rb"[A-Za-z0-9+/]{64,}={0,2}", content)):
            if len(packed) % 4 == 0:
                yield f"{name}|base64 {n}", base64.b64decode(packed)
    elif content[:4] == b"\x28\xb5\x2f\xfd":
        yield from layers(name + "|unzstd", unzstd(content))
    elif content[:8] == b"\x89PNG\r\n\x1a\n":
        at = 8
        while at + 8 <= len(content):
            size, kind = int.from_bytes(content[at:at + 4], "big"), content[at + 4:at + 8]
            if kind in (b"zTXt", b"iCCP") and b"\0" in content[at + 8:at + 8 + size]:
                packed = content[at + 8:at + 8 + size].split(b"\0", 1)[1][1:]
                yield name + "|" + kind.decode(), zlib.decompress(packed)
            at += size + 12


def plain_words(content):
    """Planted words as they are and in UTF-16."""
    low = content.lower()
    seen = {hit for pattern in WORDS for hit in pattern.findall(low)}
    wide = {hit for pattern in WIDE_WORDS for hit in pattern.findall(low)}
    return seen | {hit.replace(b"\0", b"") for hit in wide}


def found_in(content):
    """Planted words in bytes: as they are, in UTF-16, in base64, in hexadecimal digits."""
    seen = plain_words(content)
    printable = len(content) - len(content.translate(None, PRINTABLE))
    if printable > 0.9 * len(content):  # codes of letters stand in texts
        for run in re.findall(rb"[A-Za-z0-9+/_-]{12,}", content):
            run = run.replace(b"-", b"+").replace(b"_", b"/")
            for start in range(4):
                part = run[start:]
                part = part[: len(part) - (len(part) % 4 == 1)]
                seen |= plain_words(base64.b64decode(part + b"=" * (-len(part) % 4)))
        for run in re.findall(rb"[0-9A-Fa-f]{16,}", content):
            for start in range(2):
                part = run[start:]
                seen |= plain_words(bytes.fromhex(part[: len(part) // 2 * 2].decode()))
    return seen


def explain(seen):
    names = {}
    for number, (tag, entry) in enumerate(DicomDictionary.items(), 1):
        names[word(number).lower()] = entry[4]
    return ", ".join(sorted(f"{s.decode()} ({names.get(s.decode().lower(), 'not of the standard')})"
                            for s in seen))


def expect_clean(what, content):
    if isinstance(content, str):
        content = content.encode("utf-8", "replace")
    for name, part in layers(what, content):
        seen = found_in(part)
        assert not seen, f"{name} holds {explain(seen)}\n" + (
            part.decode("utf-8", "replace")[:2000] if len(part) < 1 << 16 else "")


def expect_clean_files(*roots, at_least=1):
    """Every file below the roots, and every name of a file or folder; how many files there were.

    `at_least` so many, for of a folder that holds none nothing was shown: 0 after a refusal alone."""
    count = 0
    for root in map(pathlib.Path, roots):
        for path in [root, *sorted(root.rglob("*"))] if root.is_dir() else [root]:
            expect_clean(f"the name {path.name}", path.name)
            if path.is_file():
                expect_clean(str(path), path.read_bytes())
                count += 1
    assert count >= at_least, f"{count} files below {', '.join(map(str, roots))}"
    return count
