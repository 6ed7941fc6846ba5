"""Rows and pictures of draws: how far labels agree with the truth of an exam of a random heart.

What `beatlas phantom --draw` writes is compared: truth_labels_source.nii.gz, labels of the slices as acquired.
"""
import json
import pathlib

import nibabel
import numpy

import intervals
from measures import LABELS, Labels, dice, ejection_fraction, nearest_voxels, voxel_ml

SHORT = {"lv_blood": "lv", "lv_myocardium": "muscle", "rv_blood": "rv"}
ENDS = ("ed", "es")
FIGURES = [f"{name}_{end}" for end in ENDS for name in (*SHORT.values(), "heart")]
VOLUMES = [f"{name}_{end}_ml{whose}" for end in ENDS for name in SHORT.values() for whose in ("", "_truth")]
EXPECTED = [f"{name}_{end}_expected" for end in ENDS for name in SHORT.values()]
# Of surfaces, over the phases: the mean distance, the mean of the 95th percentiles, the mean signed distance; and the
# share of them that lies within their bands.
SURFACES = [f"{name}_{what}" for name in (*SHORT.values(), "heart")
            for what in ("mm", "p95_mm", "bias_mm", "band_percent")]
COLUMNS = ["seed", "outcome", *FIGURES, *EXPECTED, "ef", "ef_truth", *VOLUMES, *SURFACES, "surfaces_told",
           *intervals.COLUMNS, "reported", "reasons", "exit", "told", "seconds", "rendering", "plane", "slices",
           "distance_mm", "thickness_mm", "pixel_mm", "columns", "phases", "has_heart", "attempt", "in_view", "wall_mm",
           "contrast_to_noise", "picture", "complete"]
GOOD = {"lv_ed": 0.85, "lv_es": 0.8, "rv_ed": 0.75, "rv_es": 0.65}  # Dice; of others 0.75
FAILURES = ("lost", "refused", "below the gate", "a heart where there is none", "no draw", "not refused")


def row_of(seed, truth, code, told, gate):
    """What is known before labels are compared."""
    stack, measured = truth["stack"], truth.get("measured", {})
    row = {"seed": seed, "exit": code, "told": told if code else "", "rendering": truth["rendering"],
           "plane": stack["plane"], "slices": stack["slices"], "distance_mm": round(stack["distance_mm"], 2),
           "thickness_mm": round(stack["thickness_mm"], 2), "pixel_mm": round(stack["pixel_mm"], 2),
           "columns": stack["columns"], "phases": len(truth["times_s"]),
           "has_heart": "yes" if truth["has_heart"] else "no", "attempt": truth["attempt"]}
    if measured:
        row.update({"in_view": round(measured["in_view"], 2), "wall_mm": round(measured["wall"], 1),
                    "contrast_to_noise": round(measured["blood_over_muscle_in_noise"], 1)})
    if code:
        row["outcome"] = outcome_of(row, gate)
    return row


def outcome_of(row, gate):
    """In words; FAILURES lists those that are failures."""
    refused = row["exit"] != 0
    if row["has_heart"] == "no":
        right = row["exit"] == 3 and "no heart found" in row["told"]
        return "refused, no heart" if right else "not refused" if refused else "a heart where there is none"
    if row["phases"] == 1:
        said = "one image only" in row["told"] or "one phase" in row["told"]
        return "refused, one phase" if row["exit"] == 3 and said else "not refused"
    if refused:
        return "refused"
    if row["lv_ed_ml"] == 0:
        return "lost"
    return "found" if row["lv_ed"] >= gate else "below the gate"


def failed(row):
    return row["outcome"] in FAILURES


def counts(row):
    """Whether there was a beating heart to be found."""
    return row.get("has_heart") == "yes" and int(row["phases"]) > 1


def _truth(drawn, name="truth_labels_source.nii.gz"):
    image = nibabel.load(pathlib.Path(drawn) / name)
    values = numpy.asarray(image.dataobj)
    return (values if values.ndim == 4 else values[..., None]), image.affine


def _ends(truth):
    """The phases in which the true LV is fullest and emptiest."""
    curve = next(s["volume_ml"] for s in truth["structures"] if s["name"] == "lv_blood")
    return {"ed": int(numpy.argmax(curve)), "es": int(numpy.argmin(curve))}


def _expected_dice(belief, phase):
    """The Dice that the prior expects of labels: pipeline/report/doubt.h."""
    labelled, expected, agreed = intervals.about_labels(belief, phase)
    both = labelled + expected
    return round(float(2 * agreed / both), 4) if both > 0 else ""


def compared(study, drawn, truth, report):
    """@param report what `beatlas report --json` prints of the study; None: it ended badly"""
    labels = Labels(study)
    told = json.loads((pathlib.Path(study) / "segment" / "segment.json").read_text())
    belief = {entry["structure"]: entry for entry in told["belief"]}
    true, affine = _truth(drawn)
    each_ml = voxel_ml(affine)
    row = {}
    for end, phase in _ends(truth).items():
        ours = nearest_voxels(labels.values[..., phase], labels.affine, true.shape[:3], affine)
        theirs = true[..., phase]
        for name, label in LABELS.items():
            key = f"{SHORT[name]}_{end}"
            row[key] = round(dice(ours == label, theirs == label), 4)
            row[f"{key}_ml"] = round(float((ours == label).sum() * each_ml), 2)
            row[f"{key}_expected"] = _expected_dice(belief[name], phase) if name in belief else ""
            row[f"{key}_ml_truth"] = round(float((theirs == label).sum() * each_ml), 2)
        row[f"heart_{end}"] = round(dice(ours > 0, theirs > 0), 4)
    for whose, key in (("", "ef"), ("_truth", "ef_truth")):
        ef = ejection_fraction(row[f"lv_ed_ml{whose}"], row[f"lv_es_ml{whose}"])
        row[key] = "" if ef is None else round(ef, 1)
    volumes = {name: (true == label).sum(axis=(0, 1, 2)) * each_ml for name, label in LABELS.items()}
    distance_mm = numpy.linalg.norm(labels.affine[:3, 2])
    if report is not None:
        row.update(intervals.columns(report, belief, distance_mm, volumes))
        row["reported"] = "yes"
        row["reasons"] = " ".join(reason["id"] for reason in report["reasons"] if reason["id"] != "package")
    return row


def is_right(row):
    """Whether all Dice are good and the LV's EDV is within 10 %."""
    figures = (figure for figure in FIGURES if figure not in ("heart_ed", "heart_es", "muscle_es"))
    case = intervals.case_of(row, "lv_edv_ml")
    return (case is not None and abs(case[0] - case[1]) <= 0.1 * case[1]
            and all(float(row[figure]) >= GOOD.get(figure, 0.75) for figure in figures))


def surface_errors(report):
    """Of what `beatlas validate --json` says of a drawn exam."""
    row = {}
    for entry in report["drawn"]:
        name = SHORT.get(entry["name"], entry["name"])
        for figure, what in (("mean_mm", "mm"), ("p95_mm", "p95_mm"), ("bias_mm", "bias_mm")):
            if f"{name}_{what}" in SURFACES and entry["phases"]:
                row[f"{name}_{what}"] = round(float(numpy.mean([phase[figure] for phase in entry["phases"]])), 3)
        if f"{name}_band_percent" in SURFACES and "band_percent" in entry:
            row[f"{name}_band_percent"] = round(entry["band_percent"], 1)
    return row


def beyond(rows, gates):
    """Which of the gates, "STRUCTURE=MM" each, the mean distance of surfaces breaks: a sentence each. A structure of
    which nothing was measured breaks its gate."""
    out = []
    for gate in gates:
        name, most = gate.split("=")
        values = [float(row[f"{name}_mm"]) for row in rows if row.get(f"{name}_mm") not in (None, "")]
        if not values:
            out.append(f"no surface of {name} was compared")
        elif numpy.mean(values) > float(most):
            out.append(f"surfaces of {name} lie {numpy.mean(values):.2f} mm off in the mean of {len(values)} draws, "
                       f"{float(most):g} may")
    return out


def line_of(row):
    """One draw in a line."""
    said = f"draw {row['seed']}: {row['outcome']}"
    if row.get("lv_ed") not in (None, ""):
        said += ", Dice " + ", ".join(f"{name} {float(row[f'{name}_ed']):.2f} {float(row[f'{name}_es']):.2f}"
                                      for name in SHORT.values())
        said += f", EF {row['ef']} for {row['ef_truth']}"
    if row.get("heart_mm") not in (None, ""):
        said += ", mm " + ", ".join(f"{name} {float(row[f'{name}_mm']):.2f}" for name in (*SHORT.values(), "heart")
                                    if row.get(f"{name}_mm") not in (None, ""))
    if row.get("plane"):
        said += (f" ({row['plane'].replace('_', ' ')}, {row['rendering']}, {row['slices']} slices {row['distance_mm']} "
                 f"mm apart, {row['phases']} phases)")
    return said + (f": {row['told']}" if row.get("told") else "")


def summary_of_intervals(hearts):
    lines = []
    for key in intervals.KEYS:
        held = intervals.coverage(hearts, key)
        if held:
            count, inside, below, above, half = held
            lines.append(f"  {key:13s} {count} {100 * inside:.0f} % ({100 * below:.0f} below, {100 * above:.0f} "
                         f"above), +-{half:.1f}")
    return ["  true figures in their 90 % intervals: draws, share, median of half the width", *lines] if lines else []


def summary_of_reasons(hearts):
    told = [row for row in hearts if row.get("reported") == "yes"]
    right = [row["reasons"].split() for row in told if is_right(row)]
    wrong = [row["reasons"].split() for row in told if not is_right(row)]
    if not told:
        return []
    lines = ["  reasons to look, of draws that are right (all Dice good, EDV of the LV within 10 %) and of others"]
    for reason in sorted({reason for reasons in right + wrong for reason in reasons}):
        lines.append(f"  {reason:25s} {sum(reason in reasons for reasons in right)} of {len(right)} right, "
                     f"{sum(reason in reasons for reasons in wrong)} of {len(wrong)} wrong")
    lines.append(f"  {'none':25s} {right.count([])} of {len(right)} right, {wrong.count([])} of {len(wrong)} wrong")
    return lines


def summary(rows, gate):
    """Least and mean Dice by structure of the hearts that were there, lost ones counting 0."""
    hearts = [row for row in rows if counts(row)]
    passed = sum(not failed(row) for row in hearts)
    lines = [f"{len(rows)} draws, {len(hearts)} with a beating heart; LV at ED >= {gate:g} in {passed} of them"]
    for outcome in sorted({row["outcome"] for row in rows}):
        lines.append(f"  {outcome}: {sum(row['outcome'] == outcome for row in rows)}")
    lines.append("  Dice: least, median, mean")
    for figure in FIGURES:
        values = [float(row.get(figure) or 0) for row in hearts]
        if values:
            lines.append(f"  {figure:10s} {min(values):.3f} {numpy.median(values):.3f} {numpy.mean(values):.3f}")
    measured = [row for row in hearts if row.get("heart_mm") not in (None, "")]
    if measured:
        lines.append(f"  surfaces of {len(measured)} [mm], and [%] of them in their bands: median, mean, most")
        for figure in SURFACES:
            values = [float(row[figure]) for row in measured if row.get(figure) not in (None, "")]
            if values:
                lines.append(f"  {figure:19s} {numpy.median(values):.2f} {numpy.mean(values):.2f} "
                             f"{max(values, key=abs):.2f}")
    lines.append("  expected Dice with the true one, r; quantile .05 of those whose Dice is good; how many of "
                 "the others lie below")
    for figure in EXPECTED:
        true = figure.removesuffix("_expected")
        pairs = numpy.array([(float(row[figure]), float(row[true])) for row in hearts
                             if row.get(figure) not in (None, "")])
        good = pairs[:, 1] >= GOOD.get(true, 0.75) if len(pairs) else numpy.zeros(0, bool)
        if good.sum() < 3:
            continue
        limit = numpy.quantile(pairs[good, 0], 0.05)
        lines.append(f"  {true:10s} {numpy.corrcoef(pairs.T)[0, 1]:.2f} {limit:.3f} "
                     f"{(pairs[~good, 0] < limit).sum()} of {(~good).sum()}")
    lines += summary_of_intervals(hearts) + summary_of_reasons(hearts)
    for rendering in ("box", "profile"):
        values = [float(row.get("lv_ed") or 0) for row in hearts if row["rendering"] == rendering]
        if values:
            lines.append(f"  lv_ed of {len(values)} {rendering}: {min(values):.3f} {numpy.median(values):.3f} "
                         f"{numpy.mean(values):.3f}")
    return "\n".join(lines)


def write_picture(study, drawn, truth, row, file):
    """Every slice at ED and ES with our outlines and, dotted, the truth's. @param study None: it has no labels"""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from sheets import COLOURS
    images, affine = _truth(drawn, "cine.nii.gz")
    true, _ = _truth(drawn)
    labels = Labels(study) if study else None
    slices, columns = images.shape[2], 8
    chosen = range(slices) if slices <= 24 else numpy.linspace(0, slices - 1, 24).round().astype(int)
    lines = -(-len(chosen) // columns)
    figure, grid = plt.subplots(2 * lines, columns, squeeze=False, dpi=70, figsize=(2.2 * columns, 4.5 * lines + 0.4))
    for axes in grid.ravel():
        axes.set_axis_off()
    for n, (end, phase) in enumerate(_ends(truth).items()):
        ours = numpy.zeros(true.shape[:3], numpy.uint8)
        if labels:
            ours = nearest_voxels(labels.values[..., phase], labels.affine, true.shape[:3], affine)
        brightest = numpy.percentile(images[..., phase], 99.5) or 1
        for m, k in enumerate(chosen):
            axes = grid[n * lines + m // columns, m % columns]
            axes.imshow(images[..., k, phase].T, cmap="gray", vmin=0, vmax=brightest)
            for name, label in LABELS.items():
                for mask, style in ((ours[..., k] == label, "solid"), (true[..., k, phase] == label, "dotted")):
                    if mask.any() and not mask.all():
                        colour = COLOURS[name] if style == "solid" else "#ffff60"
                        axes.contour(mask.T.astype(float), levels=[0.5], colors=colour, linestyles=style,
                                     linewidths=1)
            axes.set_title(f"{end.upper()} slice {k}", fontsize=7, pad=2)
    figure.suptitle(line_of(row) + "\nlines ours (LV red, muscle green, RV blue), dots the truth", fontsize=9)
    figure.tight_layout(pad=0.3, rect=(0, 0, 1, 1 - 0.5 / figure.get_figheight()))
    figure.savefig(file)
    plt.close(figure)
