"""Writes exams with pydicom or nibabel, independently of the code under test.

make_exam.py VARIANT OUT     writes OUT (a folder, or a .nii.gz file); JSON of the truth to stdout

The object: three Gaussian spheres of different size at places that no flip or swap of axes maps
onto each other, in an oblique stack, brightness 1 + 0.3 cos(2 pi phase).
"""
import json
import os
import subprocess
import sys

import nibabel
import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, ImplicitVRLittleEndian, RLELossless

from exam_writer import ENHANCED_MR, MR, ROOT, SECRET, SMALL, Stack, Writer, orientation_of, turn


def put_stack(w, stack, frames=lambda k: 10, rr=lambda k: 900.0, start=lambda k: 0.0,
              series=lambda k: k + 1, change=None, keep=lambda k, p: True, where=None, **common):
    """change(k, p, keywords) may alter what is written of one image."""
    for k in range(stack.size[2]):
        mean = stack.slice(k)
        for p in range(frames(k)):
            if not keep(k, p):
                continue
            trigger = start(k) + p * rr(k) / frames(k)
            phase = trigger / rr(k)
            words = dict(pixels=mean * (1 + 0.3 * np.cos(2 * np.pi * phase)),
                         position=where(k) if where else stack.lps((0, 0, k * stack.step[2])),
                         orientation=orientation_of(stack.turn),
                         spacing=(stack.step[1], stack.step[0]), series=series(k),
                         instance=1000 - p - 50 * k if k % 2 else p + 1 + 50 * k, trigger=trigger,
                         rr=rr(k), **common)
            if change:
                change(k, p, words)
            w.write(**words)


def put_views(w):
    """Two cine views of other orientations, ten phases."""
    for n, swap in ((0, [1, 2, 0]), (1, [2, 0, 1])):
        matrix = turn()[:, swap]
        for p in range(10):
            w.write(np.full((12, 14), 100.0 + n) + p + np.arange(14)[None, :], (5.0 + n, 6.0, 7.0),
                    orientation_of(matrix), (2.0, 3.0), 201 + n, p + 1, p * 80.0, 800.0)


def put_others(w):
    """What else a whole exam holds."""
    open(os.path.join(w.out, "README.txt"), "w").write("no DICOM")
    open(os.path.join(w.out, "empty"), "w").close()
    # Stills of many more parallel slices than the cine has.
    for k in range(40):
        w.write(np.full((10, 10), 7.0) + k, turn() @ np.array([0, 0, 4.0 * k]),
                orientation_of(turn()), (3.0, 3.0), 301, k + 1, 600.0, 900.0)
    # A localiser and a colour screenshot.
    for k in range(3):
        w.write(np.full((10, 10), 7.0) + k, (k, 0, 0), [1, 0, 0, 0, 1, 0], (3.0, 3.0), 302, k + 1)
    colour = np.zeros((10, 30))
    w.write(colour, (0, 0, 0), [1, 0, 0, 0, 1, 0], (3.0, 3.0), 303, 1, Columns=10,
            SamplesPerPixel=3, PhotometricInterpretation="RGB", PlanarConfiguration=0,
            BitsAllocated=16)
    # A report: DICOM without an image.
    path = w.write(np.zeros((2, 2)), (0, 0, 0), [1, 0, 0, 0, 1, 0], (3.0, 3.0), 304, 1)
    report = pydicom.dcmread(path)
    for key in ("PixelData", "Rows", "Columns", "BitsAllocated"):
        delattr(report, key)
    report.Modality, report.SOPClassUID = "SR", "1.2.840.10008.5.1.4.1.1.88.11"
    report.save_as(path)
    # The exporter's directory.
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = "1.2.840.10008.1.3.10", ROOT + "8"
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    directory = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    directory.is_little_endian, directory.is_implicit_VR = True, False
    record = Dataset()
    record.DirectoryRecordType, record.PatientName = "PATIENT", SECRET
    directory.FileSetID, directory.DirectoryRecordSequence = "SECRETSET", [record]
    directory.save_as(os.path.join(w.out, "DICOMDIR"), write_like_original=False)
    # A perfusion-like series: three slices, many images, trigger times over many beats.
    for k in range(3):
        for p in range(40):
            w.write(np.full((10, 10), 50.0) + p, (30.0, 0, 10.0 * k), [1, 0, 0, 0, 1, 0],
                    (3.0, 3.0), 305, 100 * k + p, p * 900.0, 900.0)


def put_enhanced(out, stack, frames):
    """All slices and phases in one multi-frame object."""
    os.makedirs(out, exist_ok=True)
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = ENHANCED_MR, ROOT + "9"
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID, d.Modality = ENHANCED_MR, ROOT + "9", "MR"
    d.StudyInstanceUID, d.SeriesInstanceUID, d.SeriesNumber = ROOT + "2", ROOT + "3.1", 1
    d.PatientName = SECRET
    shared = Dataset()
    measures = Dataset()
    measures.PixelSpacing, measures.SliceThickness = [stack.step[1], stack.step[0]], 3.0
    shared.PixelMeasuresSequence = [measures]
    plane = Dataset()
    plane.ImageOrientationPatient = ["%.10g" % v for v in orientation_of(stack.turn)]
    shared.PlaneOrientationSequence = [plane]
    d.SharedFunctionalGroupsSequence = [shared]
    groups, pixels = [], []
    for p in range(frames):
        for k in reversed(range(stack.size[2])):
            group, place, time = Dataset(), Dataset(), Dataset()
            place.ImagePositionPatient = ["%.10g" % v for v in stack.lps((0, 0, k * stack.step[2]))]
            group.PlanePositionSequence = [place]
            time.NominalCardiacTriggerDelayTime = p * 900.0 / frames
            time.RRIntervalTimeNominal = 900.0
            group.CardiacSynchronizationSequence = [time]
            groups.append(group)
            pixels.append(np.round(stack.slice(k) * (1 + 0.3 * np.cos(2 * np.pi * p / frames))))
    d.PerFrameFunctionalGroupsSequence = groups
    d.NumberOfFrames = len(pixels)
    d.Rows, d.Columns = pixels[0].shape
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.BitsAllocated, d.BitsStored, d.HighBit, d.PixelRepresentation = 16, 16, 15, 0
    d.PixelData = np.stack(pixels).astype(np.uint16).tobytes()
    d.save_as(os.path.join(out, "multi.dcm"), write_like_original=False)


def cut(path, share):
    content = open(path, "rb").read()
    open(path, "wb").write(content[: int(len(content) * share)])


def nifti(out, stack, frames, **pixdim):
    data = np.stack([stack.slice(k).T for k in range(stack.size[2])], axis=2)
    data = np.stack([data * (1 + 0.3 * np.cos(2 * np.pi * p / frames)) for p in range(frames)], axis=3)
    affine = np.diag([-1.0, -1, 1, 1]) @ np.array(stack.truth()["lps_from_index"])
    image = nibabel.Nifti1Image(np.round(data).astype(np.int16), affine)
    image.set_qform(affine, 1)
    image.header.set_xyzt_units("mm", pixdim.get("unit", "sec"))
    image.header["pixdim"][4] = pixdim.get("step", 0.09)
    nibabel.save(image, out)


def make(variant, out):
    w = None
    small = Stack(**SMALL)
    if variant not in ("nifti", "enhanced") and not variant.startswith("nifti"):
        w = Writer(out)
    if variant == "mixed":
        stack = Stack()
        put_stack(w, stack)
        put_views(w)
        put_others(w)
        return stack.truth()
    if variant in ("implicit", "rle"):
        put_stack(w, small, syntax=ImplicitVRLittleEndian if variant == "implicit" else RLELossless)
        return small.truth()
    if variant in ("deflated", "big_endian", "jpeg_lossless", "jpeg_ls", "jpeg_2000",
                   "jpeg_lossless_cut", "multi_jpeg_ls"):
        kind = variant.removesuffix("_cut")
        if kind == "multi_jpeg_ls":
            put_enhanced(out, small, 10)
        else:
            put_stack(w, small)
        command = {"deflated": ["dcmconv", "--write-xfer-deflated"],
                   "big_endian": ["dcmconv", "--write-xfer-big"],
                   "jpeg_lossless": ["dcmcjpeg"], "jpeg_ls": ["dcmcjpls"],
                   "multi_jpeg_ls": ["dcmcjpls"], "jpeg_2000": ["gdcmconv", "--j2k"]}[kind]
        files = [os.path.join(f, n) for f, _, names in os.walk(out) for n in names]
        for path in files:
            subprocess.run(command + [path, path + ".new"], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            os.replace(path + ".new", path)
        if variant.endswith("_cut"):
            path = os.path.join(out, "the_bad_one")
            os.replace(files[7], path)
            cut(path, 0.95)
        return small.truth()
    if variant == "inverted":
        def invert(k, p, d):
            d["pixels"] = 4095 - np.round(d["pixels"])
            d.update(PhotometricInterpretation="MONOCHROME1", BitsStored=12, HighBit=11,
                     PixelRepresentation=0)
        put_stack(w, small, change=invert)
        return small.truth()
    if variant == "twelve_bits":
        # Signed 12 bit in the upper part of the word, rubbish in the bits below it.
        def shift(k, p, d):
            stored = np.round(d["pixels"] / 4).astype(int) - 500
            d["pixels"] = ((stored & 0xFFF) << 4 | 0xB).astype(np.uint16).view(np.int16)
            d.update(BitsStored=12, HighBit=15, PixelRepresentation=1, RescaleSlope="4",
                     RescaleIntercept="2000")
        put_stack(w, small, change=shift)
        return small.truth()
    if variant in ("float", "float_nan", "double"):
        put_stack(w, small)
        kind = np.float64 if variant == "double" else np.float32
        files = sorted(os.path.join(f, n) for f, _, names in os.walk(out) for n in names)
        for n, path in enumerate(files):
            d = pydicom.dcmread(path)
            values = d.pixel_array.astype(kind)
            if variant == "float_nan" and n in (11, 17):
                values[3, 4] = np.nan
            for key in ("PixelData", "BitsStored", "HighBit", "PixelRepresentation"):
                delattr(d, key)
            d.BitsAllocated = 8 * values.itemsize
            if variant == "double":
                d.DoubleFloatPixelData = values.tobytes()
            else:
                d.FloatPixelData = values.tobytes()
            d.save_as(path)
        return small.truth()
    if variant.startswith("spacing_") or variant == "position_nan":
        put_stack(w, small)
        path = w.write(small.slice(0), small.lps((0, 0, 0)), orientation_of(small.turn),
                       (4.5, 4.0), 1, 99, 1.0, 900.0, path=os.path.join(out, "the_bad_one"))
        content = open(path, "rb").read()
        here = content.index(b"4.5\\4")
        value = {"spacing_zero": b"0.0\\4", "spacing_negative": b"-45\\4",
                 "spacing_nan": b"nan\\4", "spacing_one_value": b"4.500"}.get(variant)
        if variant == "position_nan":
            here, value = content.index(b"-100\\-60"), b"nan "
        open(path, "wb").write(content[:here] + value + content[here + len(value):])
        return small.truth()
    if variant in ("ct", "unknown_modality"):
        put_stack(w, small, Modality="CT" if variant == "ct" else "SECRET")
        return small.truth()
    if variant == "same_uids":
        put_stack(w, small, SOPInstanceUID=ROOT + "77")
        return small.truth()
    if variant == "doubled":
        # Every image stored twice under UIDs of its own, without times.
        def bogus(k, p, d):
            d.update(trigger=None, instance=p + 1)
        put_stack(w, small, change=bogus)
        put_stack(w, small, change=bogus)
        return small.truth()
    if variant == "two_patients":
        put_stack(w, small)
        put_stack(w, small, frames=lambda k: 12, series=lambda k: 50 + k, PatientID="SECRETID2",
                  StudyInstanceUID=ROOT + "4", SeriesInstanceUID=ROOT + "5")
        return small.truth()
    if variant in ("damaged_by_name", "damaged_several"):
        put_stack(w, small)
        folder = os.path.join(out, "SECRETTEXT scan")
        os.makedirs(folder)
        for n in range(3 if variant == "damaged_several" else 1):
            path = w.write(small.slice(0), small.lps((0, 0, 0)), orientation_of(small.turn),
                           (4.5, 4.0), 1, 99 + n, 1.0, 900.0,
                           path=os.path.join(folder, "secret^name %d.dcm" % n))
            cut(path, 0.9)
        open(os.path.join(folder, "a"), "w").close()
        return {}
    if variant == "one_series":
        put_stack(w, small, series=lambda k: 5)
        return small.truth()
    if variant == "series_per_phase":
        put_stack(w, small, change=lambda k, p, d: d.update(series=p + 1))
        return small.truth()
    if variant == "enhanced":
        put_enhanced(out, small, 10)
        return small.truth()
    if variant == "rescaled":
        def rescale(k, p, d):
            d["pixels"] = d["pixels"] * 2 + 20
            d.update(RescaleSlope="0.5", RescaleIntercept="-10")
        put_stack(w, small, change=rescale)
        return small.truth()
    if variant == "timing":
        rr = lambda k: 700.0 + 45 * k
        put_stack(w, small, frames=lambda k: [25, 24, 26, 25, 25, 23][k], rr=rr,
                  start=lambda k: [0, 11.5, 23.7, 60.1, 0, 250.0][k])
        return dict(small.truth(), rr_ms=[rr(k) for k in range(6)])
    if variant == "prospective":
        # Frames reach 85 % of the R-R interval.
        def squeeze(k, p, d):
            d["trigger"] *= 0.85
            d["pixels"] = small.slice(k) * (1 + 0.3 * np.cos(2 * np.pi * d["trigger"] / 900.0))
        put_stack(w, small, frames=lambda k: 22, change=squeeze)
        return small.truth()
    if variant in ("constant_trigger", "no_trigger", "scan_time_trigger"):
        def bogus(k, p, d):
            d["instance"] = p + 1
            d["trigger"] = {"constant_trigger": 500.0, "no_trigger": None,
                            "scan_time_trigger": 12345.0 + 900.0 * p}[variant]
        put_stack(w, small, change=bogus)
        return small.truth()
    if variant == "temporal_position":
        put_stack(w, small, change=lambda k, p, d: d.update(
            instance=77, trigger=0.0, rr=None, FrameTime="90", TemporalPositionIdentifier=p + 1))
        return small.truth()
    if variant == "no_rr":
        put_stack(w, small, change=lambda k, p, d: d.update(trigger=None, rr=None, instance=p + 1))
        return small.truth()
    if variant == "skewed":
        def skew(k, p, d):
            rows = np.array(d["orientation"][:3]) * 1.003
            d["orientation"] = list(rows) + list(np.array(d["orientation"][3:]) + 0.004 * rows)
        put_stack(w, small, change=skew)
        return small.truth()
    if variant == "velocity":
        put_stack(w, small)
        for kind in ("P", "M"):  # a flow series: phase images and magnitudes, one slice
            put_stack(w, Stack(size=(20, 16, 1), step=SMALL["step"], origin=(0, 0, 0)), kind=kind,
                      series=lambda k: 70, frames=lambda k: 30)
        return small.truth()
    if variant == "repeated":
        put_stack(w, small)
        put_stack(w, small, series=lambda k: 50 + k,
                  change=lambda k, p, d: d.update(pixels=d["pixels"] + 500))
        return small.truth()
    if variant == "copies":
        put_stack(w, small)
        w.count = 0
        put_stack(w, small)
        return small.truth()
    if variant == "frame_missing":
        put_stack(w, small, frames=lambda k: 25, keep=lambda k, p: (k, p) != (2, 7))
        return small.truth()
    if variant == "end_slice_incomplete":
        put_stack(w, small, keep=lambda k, p: k > 0 or p < 4)
        return small.truth()
    if variant in ("middle_slice_stops_early", "end_slice_stops_early"):
        short = 3 if variant.startswith("middle") else 0
        put_stack(w, small, keep=lambda k, p: k != short or p < 8)
        return small.truth()
    if variant == "middle_slice_incomplete":
        put_stack(w, small, keep=lambda k, p: k != 3 or p < 4)
        return small.truth()
    if variant == "middle_slice_missing":
        put_stack(w, small, keep=lambda k, p: k != 3)
        return small.truth()
    if variant in ("slightly_uneven", "hole"):
        # Slice positions off by up to 0.3 of 8 mm, or by 5 mm from the middle on.
        off = {"slightly_uneven": [0, 0.3, -0.2, 0.1, 0, 0.2], "hole": [0, 0, 0, 5, 5, 5]}[variant]
        put_stack(w, small, where=lambda k: small.lps((0, 0, 8 * k + off[k])))
        return dict(small.truth(), along_mm=[8 * k + off[k] for k in range(6)])
    if variant == "parallel_stray":
        put_stack(w, small)
        for p in range(10):
            w.write(small.slice(0), small.lps((0, 0, 21.3)), orientation_of(small.turn),
                    (4.5, 4.0), 88, p + 1, p * 90.0, 900.0)
        return small.truth()
    if variant == "fields_of_view":
        # Two slices were planned again: one turned within the plane and moved, one of smaller pixels.
        # Each place is written once.
        whole = Stack(size=(96, 80, 12))
        planned = {3: (np.deg2rad(5), (96, 80), (2.5, 2.2), (-9.0, 6.0)),
                   11: (0.0, (140, 110), (1.9, 1.9), (-12.0, -10.0))}

        def other(k, p, d):
            if k not in planned:
                return
            angle, size, step, first = planned[k]
            row = whole.turn @ [np.cos(angle), np.sin(angle), 0]
            column = whole.turn @ [-np.sin(angle), np.cos(angle), 0]
            corner = whole.lps((*first, k * whole.step[2]))
            i, j = np.meshgrid(np.arange(size[0]) * step[0], np.arange(size[1]) * step[1])
            mean = whole.at(corner + i[..., None] * row + j[..., None] * column)
            beat = 1 + 0.3 * np.cos(2 * np.pi * p / 10)
            d.update(pixels=mean * beat, position=corner, orientation=[*row, *column],
                     spacing=(step[1], step[0]))
        put_stack(w, whole, change=other)
        return whole.truth()
    if variant in ("sheared", "hardly_sheared"):
        shift = 1.5 if variant == "sheared" else 0.05
        put_stack(w, small, where=lambda k: small.lps((shift * k, 0, 8 * k)))
        return small.truth()
    if variant == "one_phase":
        put_stack(w, small, frames=lambda k: 1)
        return small.truth()
    if variant == "two_slices":
        put_stack(w, Stack(size=(20, 16, 2), step=SMALL["step"]))
        put_views(w)
        return {}
    if variant == "zero":
        put_stack(w, small, change=lambda k, p, d: d.update(pixels=d["pixels"] * 0))
        return {}
    if variant == "one_zero_phase":
        put_stack(w, small, change=lambda k, p, d: d.update(pixels=d["pixels"] * (p != 4)))
        return {}
    if variant == "colour":
        put_stack(w, small, change=lambda k, p, d: d.update(
            pixels=np.zeros((16, 60)), Columns=20, SamplesPerPixel=3,
            PhotometricInterpretation="RGB", PlanarConfiguration=0))
        return {}
    if variant == "no_position":
        put_stack(w, small, ImagePositionPatient=None)
        return {}
    if variant == "wild_cosines":
        put_stack(w, small, change=lambda k, p, d: d.update(
            orientation=list(2 * np.array(d["orientation"]))))
        return {}
    if variant == "mixed_size":
        def resize(k, p, d):
            if (k, p) == (2, 4):
                d["pixels"] = d["pixels"][:8, :10]
        put_stack(w, small, change=resize)
        return {}
    if variant in ("truncated_pixels", "truncated_header"):
        put_stack(w, small)
        path = w.write(small.slice(0), small.lps((0, 0, 0)), orientation_of(small.turn), (4.5, 4.0),
                       1, 99, 1.0, 900.0, path=os.path.join(out, "the_bad_one"))
        cut(path, 0.9 if variant == "truncated_pixels" else 0.35)
        return {}
    if variant == "nothing":
        open(os.path.join(out, "notes.txt"), "w").write("no image here")
        return {}
    if variant == "empty":
        return {}
    stack = Stack(size=(48, 40, 24), step=(5.0, 4.4, 5.0))
    if variant == "nifti":
        nifti(out, stack, 10)
        return stack.truth()
    if variant == "nifti_ms_as_s":
        nifti(out, small, 10, step=90.0)
        return small.truth()
    if variant == "nifti_ms":
        nifti(out, small, 10, step=90.0, unit="msec")
        return small.truth()
    if variant == "nifti_no_unit":
        nifti(out, small, 10, step=1.0, unit="unknown")
        return small.truth()
    if variant == "nifti_long":
        nifti(out, small, 10, step=1.0)
        return small.truth()
    if variant == "nifti_one_image":
        nifti(out, small, 1)
        return small.truth()
    if variant == "nifti_two_slices":
        nifti(out, Stack(size=(20, 16, 2), step=SMALL["step"]), 10)
        return {}
    if variant == "nifti_zero_phase":
        nifti(out, small, 10)
        image = nibabel.load(out)
        data = np.array(image.dataobj)
        data[..., 3] = 0
        nibabel.save(nibabel.Nifti1Image(data, image.affine, image.header), out)
        return {}
    raise SystemExit("unknown variant " + variant)


json.dump(make(sys.argv[1], sys.argv[2]), sys.stdout)
