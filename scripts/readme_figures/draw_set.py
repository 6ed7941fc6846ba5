"""Drawn hearts, by scripts/score_draws."""
import csv

import draws

FIRST, COUNT = 10000, 8
CALLED = {"lv_ed": "LV, end-diastole", "lv_es": "LV, end-systole", "muscle_ed": "muscle, end-diastole",
          "muscle_es": "muscle, end-systole", "rv_ed": "RV, end-diastole", "rv_es": "RV, end-systole",
          "heart_ed": "whole heart, end-diastole"}


def measure(tools):
    words = ["scripts/score_draws", "--first", FIRST, "--count", COUNT]
    tools.run(*words, "--out", "draws", "--beatlas", tools.programs / "beatlas", told=False)
    tools.note(" ".join(map(str, words)))
    with open(tools.folder / "draws" / "draws.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {row["seed"]: {"outcome": row["outcome"], "beats": draws.counts(row),
                          **{figure: float(row.get(figure) or 0) for figure in CALLED}} for row in rows}


def text(values):
    hearts = [row for row in values.values() if row["beats"]]
    lines = [f"| {len(hearts)} of {len(values)} draws with a beating heart: Dice | mean | least |", "|---|---|---|"]
    for figure, called in CALLED.items():
        dice = [row[figure] for row in hearts]
        lines.append(f"| {called} | {sum(dice) / len(dice):.2f} | {min(dice):.2f} |")
    return "\n".join(lines)
