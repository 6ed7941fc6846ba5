"""Real exams beside what experts drew, by scripts/score_exams."""
import json

from measures import ENDS
from measuring import Missing

CALLED = {"sunnybrook/SCD0000101": "Sunnybrook SCD0000101", "sunnybrook/SCD0000401": "Sunnybrook SCD0000401",
          "two-phase-ge": "two phases, four slices", "cine-exam": "slices 17.7 mm apart"}
_SKIPPED = 77


def measure(tools):
    words = ["scripts/score_exams", *([tools.data] if tools.data else []), "--beatlas", tools.programs / "beatlas",
             "--stop-after", "segment", "--skip-absent", "--json", tools.folder / "exams.json"]
    said = tools.run(*words, ends=(0, _SKIPPED), told=False)
    if said.startswith("skipped"):
        raise Missing(said.strip())
    tools.note("scripts/score_exams --stop-after segment")
    values = {}
    for name, row in json.loads((tools.folder / "exams.json").read_text()).items():
        made = {"lost": not row.get("found")}
        for end in ENDS:
            made[end] = {structure: {key: got[key] for key in ("dice", "ml", "expert_ml")}
                         for structure, got in row.get(end, {}).items()}
        for key in ("ef", "ef_same_slices", "expert_ef", "largest_ml", "smallest_ml", "reference_ml"):
            if row.get(key) is not None:
                made[key] = row[key]
        values[name] = made
    return values


def _dice(made, structure, ends):
    said = [f"{made[end][structure]['dice']:.2f}" for end in ends if structure in made[end]]
    return " / ".join(said)


def _volumes(made):
    if made["ed"]:
        ours, theirs = ([made[end]["lv_blood"][key] for end in ENDS if "lv_blood" in made[end]]
                        for key in ("ml", "expert_ml"))
    else:
        ours = [made["largest_ml"]["lv_blood"], made["smallest_ml"]["lv_blood"]]
        theirs = made.get("reference_ml", {}).get("lv_blood")
    said = ", ".join(f"{ml:.0f}" for ml in ours)
    return f"{said} for {', '.join(f'{ml:.0f}' for ml in theirs)}" if theirs else said


def _ejection(made):
    if "expert_ef" in made:
        return f"{made['ef_same_slices']:.0f} for {made['expert_ef']:.0f}"
    reference = made.get("reference_ml", {}).get("lv_blood")
    said = f"{made['ef']:.0f}"
    return f"{said} for {100 * (1 - reference[1] / reference[0]):.0f}" if reference else said


def text(values):
    lines = ["| exam | LV blood, Dice ED / ES | LV muscle, Dice ED | LV ml ED, ES, for the experts' | EF % |",
             "|---|---|---|---|---|"]
    for name, made in values.items():
        called = CALLED.get(name, name)
        if made["lost"]:
            lines.append(f"| {called} | lost | | | |")
            continue
        note = " (an independent fit)" if not made["ed"] and "reference_ml" in made else ""
        lines.append(f"| {called} | {_dice(made, 'lv_blood', ENDS)} | {_dice(made, 'lv_myocardium', ('ed',))} | "
                     f"{_volumes(made)}{note} | {_ejection(made)} |")
    return "\n".join(lines)
