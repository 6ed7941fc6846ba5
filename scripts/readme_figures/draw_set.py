"""Drawn hearts, by scripts/score_draws."""
import csv

import draws

FIRST, COUNT = 10000, 8
CALLED = {"lv_ed": "LV, end-diastole", "lv_es": "LV, end-systole", "muscle_ed": "muscle, end-diastole",
          "muscle_es": "muscle, end-systole", "rv_ed": "RV, end-diastole", "rv_es": "RV, end-systole",
          "heart_ed": "whole heart, end-diastole"}
STRUCTURES = {"lv": "LV", "rv": "RV", "muscle": "LV muscle", "heart": "heart"}


def measure(tools):
    words = ["scripts/score_draws", "--first", FIRST, "--count", COUNT, "--surfaces"]
    tools.run(*words, "--out", "draws", "--beatlas", tools.programs / "beatlas", told=False)
    tools.note(" ".join(map(str, words)))
    with open(tools.folder / "draws" / "draws.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {row["seed"]: {"outcome": row["outcome"], "beats": draws.counts(row),
                          "distance_mm": float(row["distance_mm"]),
                          **{figure: float(row.get(figure) or 0) for figure in CALLED},
                          "surfaces": {figure: float(row[figure]) for figure in draws.SURFACES if row.get(figure)}}
            for row in rows}


def text(values):
    hearts = [row for row in values.values() if row["beats"]]
    lines = [f"| {len(hearts)} of {len(values)} draws with a beating heart: Dice | mean | least |", "|---|---|---|"]
    for figure, called in CALLED.items():
        dice = [row[figure] for row in hearts]
        lines.append(f"| {called} | {sum(dice) / len(dice):.2f} | {min(dice):.2f} |")
    with_surfaces = [row for row in hearts if row.get("surfaces")]
    if not with_surfaces:
        return "\n".join(lines)
    apart = [row["distance_mm"] for row in with_surfaces]
    lines += ["", f"| surfaces of {len(with_surfaces)}, slices {min(apart):.0f} to {max(apart):.0f} mm apart | "
                  "mean mm | of the worst draw | 95th percentile mm | bias mm |", "|---|---|---|---|---|"]
    for name, called in STRUCTURES.items():
        mean, far, bias = ([row["surfaces"][f"{name}_{what}"] for row in with_surfaces]
                           for what in ("mm", "p95_mm", "bias_mm"))
        lines.append(f"| {called} | {sum(mean) / len(mean):.1f} | {max(mean):.1f} | {sum(far) / len(far):.1f} | "
                     f"{sum(bias) / len(bias):+.1f} |")
    return "\n".join(lines)
