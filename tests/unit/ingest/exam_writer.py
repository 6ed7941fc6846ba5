"""The object that exams are made of, and how its images are written with pydicom: see make_exam.py."""
import os
import random

import numpy as np
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import UID, ExplicitVRLittleEndian, ImplicitVRLittleEndian, RLELossless

MR = "1.2.840.10008.5.1.4.1.1.4"
ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.4.1"
ROOT = "1.2.826.0.1.3680043.8.498.7."
SECRET = "SECRET^NAME"


def turn():
    """Columns: directions of growing column, row and slice index, in LPS; determinant +1."""
    a, b, c = 0.5, -0.35, 0.8
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return rz @ ry @ rx


class Stack:
    """columns x rows x slices, steps in mm, origin LPS."""

    def __init__(self, size=(96, 80, 24), step=(2.5, 2.2, 5.0), origin=(-100.0, -60.0, 20.0)):
        self.size, self.step = size, step
        self.origin, self.turn = np.array(origin), turn()
        self.blobs = [((60, 45, 30), 5.0, 3000), ((180, 55, 55), 6.0, 2000),
                      ((110, 130, 80), 7.0, 1500)]  # centre [mm from the origin], sigma, height

    def lps(self, local):
        return self.origin + self.turn @ np.asarray(local, dtype=float)

    def slice(self, k):
        """rows x columns, at phase-mean brightness."""
        i, j = np.meshgrid(np.arange(self.size[0]), np.arange(self.size[1]))
        out = np.zeros(i.shape)
        for centre, sigma, height in self.blobs:
            r2 = ((i * self.step[0] - centre[0]) ** 2 + (j * self.step[1] - centre[1]) ** 2 +
                  (k * self.step[2] - centre[2]) ** 2)
            out += height * np.exp(-r2 / (2 * sigma ** 2))
        return out + 100

    def at(self, lps):
        """Phase-mean brightness at places [..., 3]."""
        local = (np.asarray(lps) - self.origin) @ self.turn
        out = np.full(local.shape[:-1], 100.0)
        for centre, sigma, height in self.blobs:
            r2 = np.sum((local - np.array(centre)) ** 2, axis=-1)
            out += height * np.exp(-r2 / (2 * sigma ** 2))
        return out

    def truth(self):
        affine = np.eye(4)
        affine[:3, :3] = self.turn @ np.diag(self.step)
        affine[:3, 3] = self.origin
        return {"size": list(self.size), "lps_from_index": affine.tolist(),
                "blobs": [{"lps": self.lps(c).tolist(), "sigma": s, "height": h}
                          for c, s, h in self.blobs]}


SMALL = dict(size=(20, 16, 6), step=(4.0, 4.5, 8.0))


class Writer:
    def __init__(self, out):
        self.out, self.count = out, 0
        self.random = random.Random(5)
        os.makedirs(out, exist_ok=True)

    def path(self):
        """Names without order or extension, in nested folders."""
        folder = os.path.join(self.out, "%02x" % self.random.randrange(4), "d")
        os.makedirs(folder, exist_ok=True)
        return os.path.join(folder, "%08x" % self.random.getrandbits(32))

    def write(self, pixels, position, orientation, spacing, series, instance, trigger=None, rr=None,
              kind="M", syntax=ExplicitVRLittleEndian, path=None, **extra):
        self.count += 1
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = MR
        meta.MediaStorageSOPInstanceUID = UID(ROOT + "1.%d" % self.count)
        meta.TransferSyntaxUID = syntax
        d = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        d.is_little_endian, d.is_implicit_VR = True, syntax == ImplicitVRLittleEndian
        d.SOPClassUID, d.SOPInstanceUID = MR, meta.MediaStorageSOPInstanceUID
        d.StudyInstanceUID, d.SeriesInstanceUID = ROOT + "2", ROOT + "3.%d" % series
        d.Modality, d.SeriesNumber, d.InstanceNumber = "MR", series, instance
        d.PatientName, d.PatientID, d.SeriesDescription = SECRET, "SECRETID", "SECRETTEXT"
        d.ImageType = ["ORIGINAL", "PRIMARY", kind]
        d.ImagePositionPatient = ["%.10g" % v for v in position]
        d.ImageOrientationPatient = ["%.10g" % v for v in orientation]
        d.PixelSpacing = ["%.10g" % v for v in spacing]
        d.SliceThickness, d.SliceLocation = 3.0, -99.0  # must not be used
        if trigger is not None:
            d.TriggerTime = "%.10g" % trigger
        if rr is not None:
            d.NominalInterval = int(round(rr))
        pixels = np.round(pixels).astype(np.int16)
        d.Rows, d.Columns = pixels.shape
        d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
        d.BitsAllocated, d.BitsStored, d.HighBit, d.PixelRepresentation = 16, 16, 15, 1
        d.PixelData = pixels.tobytes()
        for key, value in extra.items():
            setattr(d, key, value)
        meta.MediaStorageSOPInstanceUID = d.SOPInstanceUID
        if syntax == RLELossless:
            d.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
            d.compress(RLELossless)
        path = path or self.path()
        d.save_as(path, write_like_original=False)
        return path


def orientation_of(matrix):
    return list(matrix[:, 0]) + list(matrix[:, 1])
