"""NIfTI, NRRD and MetaImage files of the beating object. NIfTI by nibabel, the others by hand from
their specifications, so that no line is shared with the reader."""
import gzip
import pathlib
import zlib

import nibabel
import numpy as np

RAS_FROM_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])


def nifti(path, data, lps, step_s, sform=True, qform=True, unit="sec", dtype=np.int16, slope=None,
          pixdim=None, big_endian=False, change=None):
    """data[i, j, k, phase] (or [i, j, k]) with its map to LPS.

    @param slope (scl_slope, scl_inter): stored = (value - inter) / slope
    @param pixdim three edge lengths to write instead of the right ones
    @param change change(header) may alter what is written
    """
    affine = RAS_FROM_LPS @ lps
    dtype = np.dtype(dtype)
    stored = data if slope is None else (data - slope[1]) / slope[0]
    if dtype.kind in "iu":
        stored = np.round(stored)
        assert stored.min() >= np.iinfo(dtype).min and stored.max() <= np.iinfo(dtype).max
    order = ">" if big_endian else "<"
    header = nibabel.Nifti1Header(endianness=order)
    header.set_data_dtype(dtype)
    header.set_data_shape(data.shape)
    if qform:
        header.set_qform(affine, 1)
    if sform:
        header.set_sform(affine, 1)
    header["pixdim"][1:4] = pixdim or np.linalg.norm(affine[:3, :3], axis=0)
    if data.ndim == 4:
        header["pixdim"][4] = step_s * {"sec": 1, "msec": 1e3, "usec": 1e6}.get(unit, 1)
    header.set_xyzt_units("mm", unit)
    header["magic"], header["vox_offset"] = b"n+1", 352
    header["scl_slope"], header["scl_inter"] = slope or (1, 0)
    if change:
        change(header)
    # Bytes by hand: nibabel's own writing would mend what a test breaks.
    voxels = stored.astype(dtype.newbyteorder(order)).tobytes(order="F")
    write(path, header.binaryblock + bytes(4) + voxels)
    return pathlib.Path(path)


def write(path, content):
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.name.endswith(".gz"):
        content = gzip.compress(content, 6, mtime=0)
    path.write_bytes(content)


NRRD_TYPES = {"int16": "short", "uint16": "unsigned short", "uint8": "unsigned char",
              "int32": "int", "float32": "float", "float64": "double"}
SPACES = {"left-posterior-superior": np.diag([1.0, 1, 1]), "LPS": np.diag([1.0, 1, 1]),
          "right-anterior-superior": np.diag([-1.0, -1, 1]), "RAS": np.diag([-1.0, -1, 1]),
          "left-anterior-superior": np.diag([1.0, -1, 1])}


def nrrd_vector(values):
    return "(" + ",".join(f"{v:.17g}" for v in values) + ")"


def nrrd(path, data, lps, list_axis=None, space="left-posterior-superior", encoding="raw",
         dtype="int16", big_endian=False, kind="list", fields=(), keys=(), data_file=None,
         version=4, time_in_space=None):
    """data[i, j, k, phase] or [i, j, k].

    @param list_axis 0 or 3: where the phases stand in the file; None: three axes
    @param data_file name of a detached file of the voxels (.nhdr)
    @param time_in_space seconds between phases, written as a fourth axis of space
    """
    path = pathlib.Path(path)
    turn = SPACES[space]
    directions = [nrrd_vector(turn @ lps[:3, axis]) for axis in range(3)]
    origin = turn @ lps[:3, 3]
    kinds = ["domain"] * 3
    stored = data
    if time_in_space is not None:
        directions = [nrrd_vector([*(turn @ lps[:3, axis]), 0]) for axis in range(3)]
        directions.append(nrrd_vector([0, 0, 0, time_in_space]))
        kinds.append("domain")
        origin = [*origin, 0]
        space += "-time"
    elif list_axis is not None:
        directions.insert(list_axis, "none")
        kinds.insert(list_axis, kind)
        if list_axis == 0:
            stored = np.moveaxis(data, 3, 0)
    dtype = np.dtype(dtype)
    if dtype.kind in "iu":
        stored = np.round(stored)
        assert stored.min() >= np.iinfo(dtype).min and stored.max() <= np.iinfo(dtype).max
    raw = stored.astype(dtype.newbyteorder(">" if big_endian else "<")).tobytes(order="F")
    lines = [f"NRRD000{version}", "# a comment", f"type: {NRRD_TYPES[dtype.name]}",
             f"dimension: {stored.ndim}", f"space: {space}",
             "sizes: " + " ".join(map(str, stored.shape)),
             "space directions: " + " ".join(directions), "kinds: " + " ".join(kinds)]
    if dtype.itemsize > 1:
        lines.append(f"endian: {'big' if big_endian else 'little'}")
    lines += [f"encoding: {encoding}", "space origin: " + nrrd_vector(origin), *fields]
    content = {"raw": lambda: raw, "gzip": lambda: gzip.compress(raw, 6, mtime=0),
               "ascii": lambda: " ".join(map(str, stored.astype(dtype).ravel("F"))).encode()}
    content = content[encoding]()
    if data_file:
        lines.append(f"data file: {data_file}")
    lines += [f"{key}:={value}" for key, value in keys]
    header = "\n".join(lines).encode()
    path.parent.mkdir(parents=True, exist_ok=True)
    if data_file:
        path.write_bytes(header + b"\n")
        (path.parent / data_file).write_bytes(content)
    else:
        path.write_bytes(header + b"\n\n" + content)
    return path


META_TYPES = {"int16": "MET_SHORT", "uint16": "MET_USHORT", "uint8": "MET_UCHAR",
              "int32": "MET_INT", "float32": "MET_FLOAT", "float64": "MET_DOUBLE"}


def metaimage(path, data, lps, step=None, dtype="int16", big_endian=False, compressed=False,
              data_file="LOCAL", fields=()):
    """data[i, j, k, phase] with `step`, the spacing of the fourth axis, or data[i, j, k]."""
    path = pathlib.Path(path)
    count = data.ndim
    spacing = np.linalg.norm(lps[:3, :3], axis=0)
    matrix, offset = np.eye(count), np.zeros(count)
    matrix[:3, :3] = (lps[:3, :3] / spacing).T  # one row an axis of the image
    offset[:3] = lps[:3, 3]
    steps = [*spacing, step][:count]
    dtype = np.dtype(dtype)
    stored = np.round(data) if dtype.kind in "iu" else data
    content = stored.astype(dtype.newbyteorder(">" if big_endian else "<")).tobytes(order="F")

    def text(values):
        return " ".join(f"{v:.17g}" for v in np.ravel(values))

    lines = ["ObjectType = Image", f"NDims = {count}", "BinaryData = True",
             f"BinaryDataByteOrderMSB = {big_endian}", f"CompressedData = {bool(compressed)}"]
    if compressed:
        content = zlib.compress(content)
        lines.append(f"CompressedDataSize = {len(content)}")
    lines += [f"TransformMatrix = {text(matrix)}", f"Offset = {text(offset)}",
              f"CenterOfRotation = {text(np.zeros(count))}", *fields,
              f"ElementSpacing = {text(steps)}", f"DimSize = {' '.join(map(str, data.shape))}",
              f"ElementType = {META_TYPES[dtype.name]}", f"ElementDataFile = {data_file}"]
    path.parent.mkdir(parents=True, exist_ok=True)
    header = ("\n".join(lines) + "\n").encode()
    if data_file == "LOCAL":
        path.write_bytes(header + content)
    else:
        path.write_bytes(header)
        (path.parent / data_file).write_bytes(content)
    return path
