"""How far labels agree with what an expert drew: Dice, volumes, ejection fraction.

Grids need not be the same: labels are taken at the centres of the expert's voxels, from the nearest
voxel. Affines map voxel indices to mm (RAS, as NIfTI has them), arrays are indexed [i, j, k] or
[i, j, k, phase].
"""
import pathlib

import nibabel
import numpy

LABELS = {"lv_blood": 3, "lv_myocardium": 2, "rv_blood": 1}
ENDS = ("ed", "es")


def voxel_ml(affine):
    return abs(numpy.linalg.det(numpy.asarray(affine)[:3, :3])) / 1000


def dice(a, b):
    """Of two masks; nothing in both agrees with nothing, but is no overlap: 0."""
    both = int(a.sum()) + int(b.sum())
    return 2 * int((a & b).sum()) / both if both else 0.0


def nearest_voxels(labels, affine, shape, onto):
    """`labels` at the centres of a grid of `shape` and affine `onto`; 0 beyond their own grid."""
    centres = numpy.indices(shape).reshape(3, -1).astype(float)
    step = numpy.linalg.inv(affine) @ numpy.asarray(onto, float)
    at = numpy.rint(step[:3, :3] @ centres + step[:3, 3:]).astype(int)
    inside = numpy.all((at >= 0) & (at < numpy.array(labels.shape)[:, None]), axis=0)
    out = numpy.zeros(centres.shape[1], labels.dtype)
    out[inside] = labels[tuple(at[:, inside])]
    return out.reshape(shape)


def ejection_fraction(ed_ml, es_ml):
    """[%]; None where nothing was full."""
    return 100 * (1 - es_ml / ed_ml) if ed_ml > 0 else None


def phase_of(told, phases, source_phases, lv_ml):
    """The phase that an exam's list names: an index of the source's, or where the LV is `largest` or
    `smallest`."""
    if told == "largest":
        return int(numpy.argmax(lv_ml))
    if told == "smallest":
        return int(numpy.argmin(lv_ml))
    return int(round(told * phases / source_phases)) % phases


def compared(ours, drawn, drawn_voxel_ml):
    """Per structure that was drawn at all, over the slices in which it was: agreement and volumes.

    @param ours labels on the expert's grid"""
    out = {}
    for name, label in LABELS.items():
        slices = numpy.flatnonzero((drawn == label).any(axis=(0, 1)))
        if len(slices) == 0:
            continue
        a, b = ours[..., slices] == label, drawn[..., slices] == label
        out[name] = {"dice": dice(a, b),
                     "slices": {int(k): dice(a[..., n], b[..., n]) for n, k in enumerate(slices)},
                     "ml": float(a.sum() * drawn_voxel_ml),
                     "expert_ml": float(b.sum() * drawn_voxel_ml)}
    return out


class Labels:
    """What a study says: [i, j, k, phase] on the slices as they were acquired, where it has that."""

    def __init__(self, study):
        folder = pathlib.Path(study) / "segment"
        source = folder / "labels_source.nii.gz"
        self.as_acquired = source.exists()
        image = nibabel.load(source if self.as_acquired else folder / "labels.nii.gz")
        values = numpy.asarray(image.dataobj)
        self.values = values if values.ndim == 4 else values[..., None]
        self.affine = image.affine
        each_ml = voxel_ml(self.affine)
        self.curves_ml = {
            name: (self.values == label).sum(axis=(0, 1, 2)) * each_ml for name, label in LABELS.items()}

    @property
    def phases(self):
        return self.values.shape[3]

    def phase_at(self, exam, end):
        """That which the exam's list names for `end`; where it names none, our own."""
        told = exam[end]["phase"] if end in exam else {"ed": "largest", "es": "smallest"}[end]
        return phase_of(told, self.phases, exam.get("phases_in_source", self.phases),
                        self.curves_ml["lv_blood"])


def drawn_labels(exam, end, data):
    """The expert's labels and their affine; None where none were drawn."""
    if end not in exam:
        return None
    image = nibabel.load(pathlib.Path(data) / exam[end]["labels"])
    return numpy.asarray(image.dataobj), image.affine


def score(study, exam, data):
    """All that is measured of one exam; see compared(). Volumes of `curves_ml` are of all slices."""
    labels = Labels(study)
    row = {"as_acquired": labels.as_acquired,
           "found": bool(labels.curves_ml["lv_blood"].max() > 0),
           "largest_ml": {n: float(c.max()) for n, c in labels.curves_ml.items()},
           "smallest_ml": {n: float(c.min()) for n, c in labels.curves_ml.items()},
           "ef": ejection_fraction(labels.curves_ml["lv_blood"].max(), labels.curves_ml["lv_blood"].min())}
    for end in ENDS:
        drawn = drawn_labels(exam, end, data)
        if drawn is None:
            continue
        values, affine = drawn
        phase = labels.phase_at(exam, end)
        ours = nearest_voxels(labels.values[..., phase], labels.affine, values.shape, affine)
        row[end] = compared(ours, values, voxel_ml(affine))
        row[f"{end}_phase"] = phase
    lv = [row.get(end, {}).get("lv_blood") for end in ENDS]
    if all(lv):
        # The expert leaves slices out by habit: ours of the same slices is what compares.
        row["ef_same_slices"] = ejection_fraction(lv[0]["ml"], lv[1]["ml"])
        row["expert_ef"] = ejection_fraction(lv[0]["expert_ml"], lv[1]["expert_ml"])
    if "reference_ml" in exam:
        row["reference_ml"] = exam["reference_ml"]
    return row
