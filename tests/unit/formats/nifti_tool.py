"""Reads and writes NIfTI with nibabel, independently of the code under test.

describe FILE            what nibabel sees, as JSON
write OUT VARIANT        a file of the named kind; JSON of what it holds
"""
import gzip
import json
import sys

import nibabel
import numpy as np


def oblique_ras():
    """index -> RAS, asymmetric: three angles, three spacings."""
    a, b, c = 0.3, -0.5, 0.7
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    out = np.eye(4)
    out[:3, :3] = rx @ ry @ rz @ np.diag([1.25, 1.5, 6.0])
    out[:3, 3] = [-40.5, 31.25, 12.0]
    return out


def describe(path):
    image = nibabel.load(path)
    header = image.header
    data = np.asarray(image.dataobj, dtype=np.float64)
    flat = data.flatten(order="F")
    return {
        "shape": list(data.shape),
        "affine": image.affine.tolist(),
        "qform": header.get_qform().tolist(),
        "sform_code": int(header["sform_code"]),
        "qform_code": int(header["qform_code"]),
        "zooms": [float(z) for z in header.get_zooms()],
        "units": list(header.get_xyzt_units()),
        "dtype": str(header.get_data_dtype()),
        "values": [float(v) for v in flat],
    }


def write(path, variant):
    rng = np.random.default_rng(7)
    data = rng.integers(-300, 3000, size=(5, 4, 3, 6)).astype(np.int16)
    affine = oblique_ras()
    image = nibabel.Nifti1Image(data, affine)
    header = image.header
    header.set_xyzt_units("mm", "sec")
    header["pixdim"][4] = 0.15
    if variant == "plain":
        image.set_qform(affine, 1)
        image.set_sform(affine, 1)
    elif variant == "qform_only":
        image.set_qform(affine, 1)
        image.set_sform(None, 0)
    elif variant == "none":
        image.set_qform(None, 0)
        image.set_sform(None, 0)
        header["pixdim"][1:4] = [1.25, 1.5, 6.0]
    elif variant == "sform_of_1mm":
        image.set_qform(None, 0)
        unit = np.eye(4)
        unit[:3, :3] = affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0)
        unit[:3, 3] = affine[:3, 3]
        image.set_sform(unit, 1)
        header["pixdim"][1:4] = [1.25, 1.5, 6.0]
    elif variant == "sform_of_1mm_with_qform":
        image.set_qform(affine, 1)
        unit = np.eye(4)
        image.set_sform(unit, 1)
        header["pixdim"][1:4] = [1.25, 1.5, 6.0]
    elif variant == "pixdim_of_1mm":
        image.set_qform(None, 0)
        image.set_sform(affine, 1)
        header["pixdim"][1:4] = 1
    elif variant == "msec":
        header.set_xyzt_units("mm", "msec")
        header["pixdim"][4] = 150
    elif variant == "no_unit":
        image = nibabel.Nifti1Image(data, affine)
    elif variant == "three_d":
        image = nibabel.Nifti1Image(data[..., 0], affine)
    elif variant == "two_slices":
        image = nibabel.Nifti1Image(data[:, :, :2], affine)
    elif variant == "zero":
        image = nibabel.Nifti1Image(data * 0, affine, header)
    elif variant == "slope":
        header["scl_slope"], header["scl_inter"] = 0.5, -10
        image = nibabel.Nifti1Image(data, affine, header)
        image.header.set_slope_inter(0.5, -10)
    elif variant in ("float32", "float64", "uint8", "int32", "big_endian"):
        kind = {"big_endian": ">i2"}.get(variant, variant)
        if variant == "uint8":
            data = np.abs(data) % 256
        image = nibabel.Nifti1Image(data.astype(kind), affine)
        if variant == "big_endian":
            big = nibabel.Nifti1Header(endianness=">")
            image = nibabel.Nifti1Image(data.astype(kind), affine, header=big)
        image.header.set_xyzt_units("mm", "sec")
        image.header["pixdim"][4] = 0.15
    elif variant == "nan":
        data = data.astype(np.float32)
        data[2, 1, 1, 3] = np.nan
        image = nibabel.Nifti1Image(data, affine)
    elif variant == "rgb":
        rgb = np.zeros((5, 4, 3), dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
        image = nibabel.Nifti1Image(rgb, affine)
    elif variant == "five_d":
        image = nibabel.Nifti1Image(np.zeros((5, 4, 3, 2, 2), np.int16), affine)
    elif variant == "sheared":
        affine[:3, 1] += 0.2 * affine[:3, 0]
        image = nibabel.Nifti1Image(data, affine)
        image.set_sform(affine, 1)
    elif variant == "text":
        with open(path, "w") as out:
            out.write("this is no image\n" * 100)
        return {}
    elif variant == "truncated":
        nibabel.save(image, path)
        opener = gzip.open if path.endswith(".gz") else open
        with opener(path, "rb") as whole:
            content = whole.read()
        with opener(path, "wb") as cut:
            cut.write(content[: len(content) - 37])
        return {}
    else:
        raise SystemExit("unknown variant " + variant)
    nibabel.save(image, path)
    values = np.asarray(nibabel.load(path).dataobj, dtype=np.float64) if variant != "rgb" else np.zeros(1)
    return {"true_affine": affine.tolist(), "values": [float(v) for v in np.nan_to_num(values.flatten(order="F"))]}


if sys.argv[1] == "describe":
    json.dump(describe(sys.argv[2]), sys.stdout)
else:
    json.dump(write(sys.argv[2], sys.argv[3]), sys.stdout)
