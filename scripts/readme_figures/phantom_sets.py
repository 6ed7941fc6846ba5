"""Phantoms whose truth is known in closed form, built from their images like any exam."""
import json

import nibabel
import numpy

from measures import dice

STRUCTURES = {"heart": lambda labels: labels > 0, "lv": lambda labels: labels == 3, "rv": lambda labels: labels == 1,
              "muscle": lambda labels: labels == 2}
# Preset, ventricles alone, as README.md calls it. A heart as patients have it comes first.
ADULT = [("adult", False, "`adult`, whole (256 x 256 x 64, 1 x 1 x 3 mm)"),
         ("adult", True, "`adult`, ventricles alone")]
SMALLER = [("small", False, "`small`, whole (2 x 2 x 4 mm)"), ("small", True, "`small`, ventricles alone"),
           ("clinical", False, "`clinical`, whole (short-axis slices 10 mm apart)")]
FIELDS = {"heart": "heart, outside", "lv_blood": "LV blood", "rv_blood": "RV blood",
          "lv_myocardium": "LV myocardium"}


def _key(preset, alone):
    return f"{preset}, {'ventricles alone' if alone else 'whole'}"


def _dice_by_phase(tools, preset, alone):
    phantom, study, _ = tools.phantom(preset, alone)
    ours, truth = (numpy.asarray(nibabel.load(file).dataobj) for file in
                   (study / "segment" / "labels.nii.gz", phantom / "truth_labels.nii.gz"))
    assert ours.shape == truth.shape, (ours.shape, truth.shape)
    return {name: [round(dice(of(ours[..., n]), of(truth[..., n])), 7) for n in range(truth.shape[3])]
            for name, of in STRUCTURES.items()}


def _dice_table(values, phantoms):
    lines = ["| phantom | heart | LV | RV | LV muscle |", "|---|---|---|---|---|"]
    for preset, alone, called in phantoms:
        cells = [f"{min(phases):.3f} ({sum(phases) / len(phases):.3f})"
                 for phases in values[_key(preset, alone)].values()]
        lines.append(f"| {called} | {' | '.join(cells)} |")
    return lines


def measure_smaller(tools):
    return {_key(preset, alone): _dice_by_phase(tools, preset, alone) for preset, alone, _ in SMALLER}


def smaller_text(values):
    return "\n".join(_dice_table(values, SMALLER))


def _volumes(curve):
    return {"edv_ml": max(curve), "ef": 100 * (1 - min(curve) / max(curve))}


def _field_errors(told):
    """Of `beatlas validate --json`: means over the phases, and the worst phase's 95th percentile."""
    return {structure["name"]: {
        "mean_mm": sum(phase["mean_mm"] for phase in structure["phases"]) / len(structure["phases"]),
        "bias_mm": sum(phase["bias_mm"] for phase in structure["phases"]) / len(structure["phases"]),
        "worst_p95_mm": max(phase["p95_mm"] for phase in structure["phases"])}
        for structure in told["structures"] if structure["name"] in FIELDS}


def _fields(tools, alone):
    phantom, _, package = tools.phantom("adult", alone)
    told = tools.validated("adult", alone)
    made = {"force_mean_n": told["force"]["mean_n"], "palpations": told["force"]["trajectories"]}
    made.update(_field_errors(told))
    info = json.loads(tools.run("beatlas", "info", package.name, "--json"))
    truth = json.loads((phantom / "truth.json").read_text())
    for whose, document in (("ours", info), ("true", truth)):
        curve = next(each["volume_ml"] for each in document["structures"] if each["name"] == "lv_blood")
        made[whose] = _volumes(curve)
    return made


def measure_adult(tools):
    return {"labels": {_key(preset, alone): _dice_by_phase(tools, preset, alone) for preset, alone, _ in ADULT},
            "fields": {_key("adult", alone): _fields(tools, alone) for alone in (False, True)}}


def adult_text(values):
    lines = _dice_table(values["labels"], ADULT)
    whole, alone = (values["fields"][_key("adult", each)] for each in (False, True))
    lines += ["", "| `adult`, fields | whole: mean mm | bias | 95th percentile | ventricles alone: mean mm | bias | "
              "95th percentile |", "|---|---|---|---|---|---|---|"]
    for name, called in FIELDS.items():
        cells = [f"{made[name]['mean_mm']:.2f} | {made[name]['bias_mm']:.2f} | {made[name]['worst_p95_mm']:.1f}"
                 for made in (whole, alone)]
        lines.append(f"| {called} | {' | '.join(cells)} |".replace("-0.00", "0.00"))
    lines.append("")
    for made, called in ((whole, "Whole heart"), (alone, "Ventricles alone")):
        lines.append(f"{called}: EDV {made['ours']['edv_ml']:.1f} ml for {made['true']['edv_ml']:.1f}, EF "
                     f"{made['ours']['ef']:.1f} % for {made['true']['ef']:.1f}; the force of {made['palpations']} "
                     f"palpations is off by {made['force_mean_n']:.2f} N in the mean.")
    return "\n".join(lines)


# What is given of the truth -> how README.md calls it.
GIVEN = {"coverage": "labels and coverage", "labels": "labels alone"}


def measure_given(tools):
    values = {}
    for given in GIVEN:
        told = tools.given(given == "coverage")
        values[given] = _field_errors(told)
    return values


def given_text(values):
    lines = ["| fields of `small`, ventricles alone, mm | " + " | ".join(
        f"{called}: mean | bias | 95th percentile" for called in GIVEN.values()) + " |", "|---" * 7 + "|"]
    for name, called in FIELDS.items():
        cells = [f"{values[given][name]['mean_mm']:.3f} | {values[given][name]['bias_mm']:.3f} | "
                 f"{values[given][name]['worst_p95_mm']:.2f}" for given in GIVEN]
        lines.append(f"| {called} | {' | '.join(cells)} |".replace("-0.000", "0.000"))
    return "\n".join(lines)
