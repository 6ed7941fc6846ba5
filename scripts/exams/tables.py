"""The scoreboard as a table: for a terminal, or as Markdown."""
from measures import ENDS, LABELS

SHORT = {"lv_blood": "LV", "lv_myocardium": "muscle", "rv_blood": "RV"}
HEAD = ("exam", "found", "Dice ED", "Dice ES", "ml ED, ours / expert", "ml ES", "EF %", "seconds", "exit",
        "verdict")
LONGEST_VERDICT = 60


def _by_structure(row, end, say):
    got = row.get(end, {})
    return ", ".join(f"{SHORT[name]} {say(got[name])}" for name in LABELS if name in got)


def _volumes(row, end):
    """Those of the slices that were compared, or of the whole beside a reference."""
    said = _by_structure(row, end, lambda g: f"{g['ml']:.0f} / {g['expert_ml']:.0f}")
    if said or "largest_ml" not in row:
        return said
    own = row["largest_ml" if end == "ed" else "smallest_ml"]
    reference = row.get("reference_ml", {})
    beside = {n: f" / {reference[n][ENDS.index(end)]:g}" if n in reference else "" for n in LABELS}
    return ", ".join(f"{SHORT[n]} {own[n]:.0f}{beside[n]}" for n in LABELS)


def _ejection(row):
    if row.get("expert_ef") is not None:
        ours = row.get("ef_same_slices")
        return f"{'-' if ours is None else format(ours, '.0f')} / {row['expert_ef']:.0f}"
    reference = row.get("reference_ml", {}).get("lv_blood")
    said = f"{row['ef']:.0f}" if row.get("ef") is not None else "-"
    return said + (f" / {100 * (1 - reference[1] / reference[0]):.0f}" if reference else "")


def cells(name, row):
    verdict = row.get("lost") or row.get("verdict", "")
    if len(verdict) > LONGEST_VERDICT:
        verdict = verdict[:LONGEST_VERDICT - 3] + "..."
    seconds = row.get("seconds")
    return [name, "yes" if row.get("found") else "LOST",
            _by_structure(row, "ed", lambda g: f"{g['dice']:.3f}") or "-",
            _by_structure(row, "es", lambda g: f"{g['dice']:.3f}") or "-",
            _volumes(row, "ed") or "-", _volumes(row, "es") or "-",
            _ejection(row), "-" if seconds is None else f"{seconds:.0f}", str(row.get("exit", "-")),
            verdict.replace("|", "/") or "-"]


def markdown(rows):
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    lines += ["| " + " | ".join(cells(name, row)) + " |" for name, row in rows.items()]
    return "\n".join(lines)


def plain(rows):
    """Columns of even width; the verdict, which is long, comes below each exam."""
    table = [list(HEAD[:-1])] + [cells(name, row)[:-1] for name, row in rows.items()]
    widths = [max(len(line[n]) for line in table) for n in range(len(HEAD) - 1)]
    out = []
    for line, row in zip(table, [None, *rows.values()]):
        out.append("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())
        if row is None:
            continue
        if row.get("lost") or row.get("verdict"):
            out.append("    " + (row.get("lost") or row["verdict"]))
        for end in ENDS:
            for name, got in row.get(end, {}).items():
                each = " ".join(f"{k}:{value:.2f}" for k, value in got["slices"].items())
                out.append(f"    {end.upper()} {SHORT[name]:6s} Dice by slice {each}")
    return "\n".join(out)
