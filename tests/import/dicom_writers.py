"""DICOM exams of the beating object: classic and Enhanced MR, written with pydicom, turned into
other transfer syntaxes by DCMTK's and GDCM's tools."""
import pathlib
import random
import shutil
import subprocess

import numpy as np
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

MR = "1.2.840.10008.5.1.4.1.1.4"
ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.4.1"
ROOT = "1.2.826.0.1.3680043.8.498.7."

TOOLS = {
    "explicit_little_endian": ["dcmconv", "+te"],
    "implicit_little_endian": ["dcmconv", "+ti"],
    "explicit_big_endian": ["dcmconv", "+tb"],
    "deflated": ["dcmconv", "+td"],
    "rle": ["dcmcrle"],
    "jpeg_lossless": ["dcmcjpeg", "+e1"],
    "jpeg_lossless_14": ["dcmcjpeg", "+el"],
    "jpeg_ls": ["dcmcjpls"],
    "jpeg_2000": ["gdcmconv", "--j2k"],
}


def decimal(value):
    """A DS: at most 16 characters."""
    for digits in range(15, 5, -1):
        text = f"{float(value):.{digits}g}"
        if len(text) <= 16:
            return text
    raise ValueError(value)


def pixel_format(dataset, pixels, bits=16, stored=None, signed=False):
    """Puts an array of whole numbers (frames x) rows x columns into a data set."""
    stored = stored or bits
    whole = np.round(pixels).astype(np.int64)
    low, high = (-(1 << stored - 1), (1 << stored - 1) - 1) if signed else (0, (1 << stored) - 1)
    assert whole.min() >= low and whole.max() <= high, (whole.min(), whole.max())
    d = dataset
    d.Rows, d.Columns = whole.shape[-2:]
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.BitsAllocated, d.BitsStored, d.HighBit = bits, stored, stored - 1
    d.PixelRepresentation = 1 if signed else 0
    kind = ("i" if signed else "u") + str(bits // 8)
    data = whole.astype(f"<{kind}").tobytes()
    d.PixelData = data + b"\0" * (len(data) % 2)
    d["PixelData"].VR = "OB" if bits == 8 else "OW"


def new_dataset(sop_class, number):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = sop_class, ROOT + f"1.{number}"
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID = sop_class, meta.MediaStorageSOPInstanceUID
    d.StudyInstanceUID, d.SeriesInstanceUID = ROOT + "2.1", ROOT + "3.1"
    d.FrameOfReferenceUID = ROOT + "4.1"
    d.Modality, d.SeriesNumber, d.InstanceNumber = "MR", 1, number
    d.PatientName, d.PatientID, d.StudyID = "Nobody^Known", "0001", "1"
    d.StudyDate, d.StudyTime, d.AccessionNumber = "20000101", "120000", ""
    return d


def set_place(d, truth, k):
    d.ImagePositionPatient = [decimal(v) for v in truth.place((0, 0, k))]
    d.ImageOrientationPatient = [decimal(v) for v in (*truth.turn[:, 0], *truth.turn[:, 1])]
    d.PixelSpacing = [decimal(truth.step[1]), decimal(truth.step[0])]
    # Must not be used: slices are thinner than their distance, and the rest is plainly wrong.
    d.SliceThickness, d.SpacingBetweenSlices, d.SliceLocation = "5", "1", decimal(-99 - k)


def classic_image(truth, k, p, number, phase=None, bits=16, stored=None, signed=False, slope=1,
                  intercept=0):
    """One image of slice k; p counts frames, phase (0..1) is what it shows."""
    phase = p / truth.phases if phase is None else phase
    d = new_dataset(MR, number)
    d.ImageType = ["ORIGINAL", "PRIMARY", "M", "RETRO"]
    set_place(d, truth, k)
    d.TriggerTime, d.NominalInterval = decimal(phase * truth.rr_ms), int(round(truth.rr_ms))
    d.CardiacNumberOfImages = truth.phases
    pixels = truth.image(k, phase)
    if (slope, intercept) != (1, 0):
        d.RescaleSlope, d.RescaleIntercept = decimal(slope), decimal(intercept)
        pixels = (pixels - intercept) / slope
    pixel_format(d, pixels, bits, stored, signed)
    return d


def classic_exam(truth, series="slice", change=None, keep=lambda k, p: True, frames=None, **pixels):
    """Data sets of the whole stack.

    @param series "one", "slice" or "phase": what a series holds
    @param change change(k, p, dataset) may alter one image
    @param frames frames(k) -> the phases (0..1) of slice k's images; None: truth.phases even ones
    """
    out = []
    for k in range(truth.size[2]):
        for p, phase in enumerate(frames(k) if frames else [None] * truth.phases):
            if not keep(k, p):
                continue
            d = classic_image(truth, k, p, len(out) + 1, phase, **pixels)
            number = {"one": 1, "slice": k + 1, "phase": p + 1}[series]
            d.SeriesNumber, d.SeriesInstanceUID = number, ROOT + f"3.{number}"
            d.InstanceNumber = {"one": len(out) + 1, "slice": p + 1, "phase": k + 1}[series]
            if change:
                change(k, p, d)
            out.append(d)
    return out


def set_number(d, number):
    """A UID of its own."""
    d.SOPInstanceUID = d.file_meta.MediaStorageSOPInstanceUID = ROOT + f"1.{number}"


def save(dataset, path):
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    dataset.save_as(path, write_like_original=False)
    return path


def save_all(folder, datasets, names="plain", seed=5):
    """@param names "plain": IM000001 and so on in the given order; "random": no order, no
    extension, nested folders"""
    chance = random.Random(seed)
    numbers = list(range(len(datasets)))
    if names == "random":
        chance.shuffle(numbers)
    out = []
    for number, d in zip(numbers, datasets):
        path = pathlib.Path(folder) / f"IM{number + 1:06d}"
        if names == "random":
            path = pathlib.Path(folder) / f"{chance.randrange(3):02x}" / f"{chance.getrandbits(40):010x}"
        out.append(save(d, path))
    return out


def convert(folder, syntax):
    """Every file of a folder into another transfer syntax, in place."""
    for file in sorted(p for p in pathlib.Path(folder).rglob("*") if p.is_file()):
        other = file.with_name(file.name + ".tmp")
        done = subprocess.run([*TOOLS[syntax], str(file), str(other)], capture_output=True, text=True)
        assert done.returncode == 0 and other.exists(), f"{TOOLS[syntax]}: {done.stderr}"
        other.replace(file)


def shuffled(folder, out, seed=11, suffix=""):
    """Copies all files under names and in folders that say nothing."""
    chance = random.Random(seed)
    files = sorted(p for p in pathlib.Path(folder).rglob("*") if p.is_file())
    chance.shuffle(files)
    for file in files:
        to = pathlib.Path(out) / f"{chance.randrange(4):x}" / f"{chance.getrandbits(48):012x}{suffix}"
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, to)
    return pathlib.Path(out)


def cut(file, share):
    """A copy that broke off."""
    content = pathlib.Path(file).read_bytes()
    pathlib.Path(file).write_bytes(content[: int(len(content) * share)])


def item(**values):
    out = Dataset()
    for key, value in values.items():
        setattr(out, key, value)
    return out


def enhanced_image(truth, frames, number=1, shared_plane=True, timing="trigger", slopes=None,
                   sop_class=ENHANCED_MR, bits=16, stored=None, signed=False):
    """A multi-frame object of the given (k, p), in that order.

    @param timing "trigger": trigger delay and R-R; "temporal": temporal position and R-R
    @param slopes slope and intercept of frame n, or None
    """
    d = new_dataset(sop_class, number)
    d.ImageType = ["ORIGINAL", "PRIMARY", "CARDIAC", "NONE"]
    d.ContentDate, d.ContentTime = "20000101", "120000"
    measures = item(PixelSpacing=[decimal(truth.step[1]), decimal(truth.step[0])],
                    SliceThickness="5", SpacingBetweenSlices="1")
    plane = item(ImageOrientationPatient=[decimal(v) for v in (*truth.turn[:, 0],
                                                               *truth.turn[:, 1])])
    shared = item(PixelMeasuresSequence=[measures])
    if shared_plane:
        shared.PlaneOrientationSequence = [plane]
    shared.MRTimingAndRelatedParametersSequence = [item(RepetitionTime=3.0, FlipAngle=50.0)]
    groups, pixels = [], []
    for n, (k, p) in enumerate(frames):
        group = item(
            FrameContentSequence=[item(StackID="1", InStackPositionNumber=k + 1,
                                       TemporalPositionIndex=p + 1,
                                       DimensionIndexValues=[k + 1, p + 1])],
            PlanePositionSequence=[item(
                ImagePositionPatient=[decimal(v) for v in truth.place((0, 0, k))])],
            MRImageFrameTypeSequence=[item(FrameType=["ORIGINAL", "PRIMARY", "CARDIAC", "NONE"],
                                           ComplexImageComponent="MAGNITUDE")])
        if not shared_plane:
            group.PlaneOrientationSequence = [plane]
        beat = item(RRIntervalTimeNominal=truth.rr_ms)
        if timing == "trigger":
            beat.NominalCardiacTriggerDelayTime = p * truth.rr_ms / truth.phases
        group.CardiacSynchronizationSequence = [beat]
        image = truth.image(k, p / truth.phases)
        if slopes:
            slope, intercept = slopes(n)
            image = (image - intercept) / slope
            group.PixelValueTransformationSequence = [item(
                RescaleSlope=decimal(slope), RescaleIntercept=decimal(intercept), RescaleType="US")]
        groups.append(group)
        pixels.append(image)
    d.SharedFunctionalGroupsSequence, d.PerFrameFunctionalGroupsSequence = [shared], groups
    d.NumberOfFrames = len(pixels)
    pixel_format(d, np.stack(pixels), bits, stored, signed)
    return d
