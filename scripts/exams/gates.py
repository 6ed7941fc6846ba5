"""What each exam must reach, gates.json, and what of that is reached and held by every test run, held.json."""
import json
import pathlib

FOLDER = pathlib.Path(__file__).parent
TABLES = ("gates", "held")
ENDS = {"ed": ("largest_ml", 0), "es": ("smallest_ml", 1)}


def read_gates(table="gates"):
    return json.loads((FOLDER / f"{table}.json").read_text())


def failures(name, row, gates):
    """A sentence for each gate that the exam's row does not pass. An exam that the table does not name
    must be built and have a left ventricle, no more."""
    if row.get("exit", 0) != 0:
        return [f"{name}: beatlas ended with exit code {row['exit']}: {row.get('verdict', '')}"]
    if not row.get("found"):
        return [f"{name}: no left ventricle was found"]
    out = []
    gate = gates.get(name, {})
    for end, structures in gate.get("dice", {}).items():
        for structure, least in structures.items():
            got = row.get(end, {}).get(structure)
            if got is None:
                out.append(f"{name}: {structure} at {end.upper()} was not compared; the gate is {least:.2f}")
            elif got["dice"] < least:
                out.append(f"{name}: {structure} at {end.upper()} has a Dice of {got['dice']:.3f}, "
                           f"the gate is {least:.2f}")
    if "ef_points" in gate:
        ours, expert = row.get("ef_same_slices"), row.get("expert_ef")
        if ours is None or expert is None:
            out.append(f"{name}: the ejection fraction was not compared")
        elif abs(ours - expert) > gate["ef_points"]:
            out.append(f"{name}: the ejection fraction is {ours:.1f} % for the experts' {expert:.1f} %, "
                       f"the gate is {gate['ef_points']:g} points")
    for end, most in gate.get("reference_percent", {}).items():
        key, at = ENDS[end]
        for structure, reference in row.get("reference_ml", {}).items():
            ours, wanted = row[key][structure], reference[at]
            off = 100 * abs(ours / wanted - 1)
            if off > most:
                out.append(f"{name}: {structure} has {ours:.0f} ml at {end.upper()} for {wanted:g} ml, "
                           f"{off:.0f} % off; the gate is {most:g} %")
        if not row.get("reference_ml"):
            out.append(f"{name}: its volumes were not compared")
    return out
