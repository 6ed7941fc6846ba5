#!/usr/bin/env python3
"""What the Snakefile's rules run, in the cohort's folder.

cohort.py stage STAGE EXAM [--threads N]   one stage of one exam, told by EXAM/STAGE.json
cohort.py summary EXAM...                  summary.csv, volumes.svg and ejection_fraction.svg

Sources are read from the list that BEATLAS_COHORT_LIST names, a line an exam; nothing that is written
names one.
"""
import argparse
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

MUSCLE_G_PER_ML = 1.05
COLUMNS = ("exam", "state", "stage", "reason", "warnings", "phases", "rr_ms", "lv_edv_ml", "lv_esv_ml",
           "lv_sv_ml", "lv_ef_percent", "rv_edv_ml", "rv_esv_ml", "rv_ef_percent", "lv_mass_g",
           "heart_ed_ml", "package_mb")
STAGES = ("import", "segment", "register", "field", "mesh", "pack", "report")
REJECTED = 4
# Of beatlas; whatever else ends a stage is trouble of the machine.
STATES = {3: "failed", REJECTED: "rejected"}


def source_of(exam):
    lines = pathlib.Path(os.environ["BEATLAS_COHORT_LIST"]).read_text().splitlines()
    sources = [line.strip() for line in lines if line.strip() and not line.startswith("#")]
    return sources[int(exam.removeprefix("exam_")) - 1]


def without_paths(text, exam):
    """What beatlas says, without the source's place: its folder may be named after a patient."""
    source = source_of(exam).rstrip("/")
    for part in (source, os.path.realpath(source), os.path.dirname(source)):
        if len(part) > 1:
            text = text.replace(part, "SOURCE")
    # A name may begin or end with what is no letter.
    return re.sub(rf"(?<!\w){re.escape(os.path.basename(source))}(?!\w)", "SOURCE", text)


def write_json(file, content):
    """Whole or not at all, as Snakemake takes a file that is there for a stage that is done."""
    with tempfile.NamedTemporaryFile("w", dir=file.parent, prefix=".partial-", delete=False) as part:
        json.dump(content, part, indent=2)
        part.write("\n")
    os.replace(part.name, file)


def report_words(folder, threads):
    return [os.environ["BEATLAS_COHORT_PROGRAM"], "report", str(folder / "study"), "-o",
            str(folder / "report.html"), "--threads", str(threads), "--json"]


def run_stage(stage, exam, threads):
    folder = pathlib.Path(exam)
    folder.mkdir(exist_ok=True)
    words = [os.environ["BEATLAS_COHORT_PROGRAM"], stage, "--study", str(folder / "study"),
             "--threads", str(threads), "--json"]
    if stage == "report":
        words = report_words(folder, threads)
    if stage == "pack":
        words += ["-o", str(folder / "heart.beatlas")]
    if stage != "report" and os.environ.get("BEATLAS_COHORT_RECIPE"):
        words += ["--recipe", os.environ["BEATLAS_COHORT_RECIPE"]]
    if stage == "import":  # behind all options: a name may look like one
        words += ["--", source_of(exam)]
    failure = folder / "failure.json"
    done = subprocess.run(words, capture_output=True, text=True)
    events = []
    for line in done.stderr.splitlines():
        try:
            events.append(json.loads(line))
        except ValueError:  # of a library, or a crash
            pass
    told = [without_paths(event["text"], exam) for event in events if event.get("event") == "warning"]
    if done.returncode == 0:
        failure.unlink(missing_ok=True)
        result = {"stage": stage, "warnings": told}
        if stage == "report":
            summary = json.loads(done.stdout)
            result |= {"verdict": summary["verdict"],
                       "reasons": [reason["sentence"] for reason in summary["reasons"]]}
        write_json(folder / f"{stage}.json", result)
        return 0
    ends = [event["text"] for event in events if event.get("event") == "end"]
    reason = without_paths(ends[-1], exam) if ends else f"it ended with status {done.returncode}"
    write_json(failure, {"stage": stage, "exit_code": done.returncode, "reason": reason,
                         "warnings": told})
    if done.returncode == REJECTED:  # the page shows what is wrong; the reason is told without it, too
        subprocess.run(report_words(folder, threads), capture_output=True)
    print(f"cohort: {exam}: {stage}: {reason}", file=sys.stderr)
    return 1


def stroke(volumes):
    most, least = max(volumes), min(volumes)
    return most, least, 100 * (most - least) / most if most > 0 else 0


def row_of(exam):
    """A line of the table, and the package's figures, if it has one."""
    folder = pathlib.Path(exam)
    row = dict.fromkeys(COLUMNS, "") | {"exam": exam}
    records = [folder / f"{stage}.json" for stage in STAGES]
    warnings = sum(len(json.loads(file.read_text())["warnings"]) for file in records if file.exists())
    failure, package = folder / "failure.json", folder / "heart.beatlas"
    if failure.exists():
        told = json.loads(failure.read_text())
        row |= {"state": STATES.get(told["exit_code"], "trouble"), "stage": told["stage"],
                "reason": told["reason"], "warnings": warnings + len(told["warnings"])}
        return row, None
    if not records[-1].exists():
        return row | {"state": "open"}, None
    info = json.loads(subprocess.run(
        [os.environ["BEATLAS_COHORT_PROGRAM"], "info", str(package), "--json"], check=True,
        capture_output=True, text=True).stdout)
    volumes = {entry["name"]: entry["volume_ml"] for entry in info["structures"]}
    report = json.loads(records[-1].read_text())
    row |= {"state": report["verdict"], "reason": "; ".join(report["reasons"]),
            "warnings": warnings, "phases": info["phases"],
            "rr_ms": f"{1000 * info['rr_interval_s']:.0f}",
            "heart_ed_ml": f"{volumes['heart'][info['end_diastole']]:.1f}",
            "package_mb": f"{package.stat().st_size / 1e6:.2f}"}
    if "lv_blood" in volumes:
        most, least, percent = stroke(volumes["lv_blood"])
        row |= {"lv_edv_ml": f"{most:.1f}", "lv_esv_ml": f"{least:.1f}",
                "lv_sv_ml": f"{most - least:.1f}", "lv_ef_percent": f"{percent:.1f}"}
    if "rv_blood" in volumes:
        most, least, percent = stroke(volumes["rv_blood"])
        row |= {"rv_edv_ml": f"{most:.1f}", "rv_esv_ml": f"{least:.1f}",
                "rv_ef_percent": f"{percent:.1f}"}
    if "lv_myocardium" in volumes:
        mass = MUSCLE_G_PER_ML * volumes["lv_myocardium"][info["end_diastole"]]
        row["lv_mass_g"] = f"{mass:.1f}"
    return row, info


def plots(done):
    """volumes.svg: LV blood over the cycle, all exams. ejection_fraction.svg: a dot an exam."""
    os.environ.setdefault("MPLCONFIGDIR", tempfile.gettempdir())
    import matplotlib
    matplotlib.use("svg")
    # Names of parts and the date by which two runs would differ.
    matplotlib.rcParams |= {"svg.hashsalt": "beatlas", "svg.fonttype": "none", "font.size": 9}
    import matplotlib.pyplot as pyplot
    figure, axes = pyplot.subplots(figsize=(6, 4))
    for row, info in done:
        curve = next((e["volume_ml"] for e in info["structures"] if e["name"] == "lv_blood"), None)
        if curve:
            share = [100 * p / len(curve) for p in range(len(curve) + 1)]
            axes.plot(share, [*curve, curve[0]], label=row["exam"], linewidth=1.2)
    axes.set_xlabel("share of the R-R interval [%]")
    axes.set_ylabel("LV blood [ml]")
    axes.set_ylim(bottom=0)
    if 0 < len(axes.lines) <= 12:
        axes.legend(frameon=False)
    figure.tight_layout()
    figure.savefig("volumes.svg", metadata={"Date": None})
    figure, axes = pyplot.subplots(figsize=(6, 4))
    dots = [(row["exam"], float(row["lv_edv_ml"]), float(row["lv_ef_percent"])) for row, _ in done
            if row["lv_ef_percent"]]
    axes.scatter([edv for _, edv, _ in dots], [percent for *_, percent in dots], s=24)
    for exam, edv, percent in dots:
        axes.annotate(exam, (edv, percent), textcoords="offset points", xytext=(5, 4))
    axes.set_xlabel("LV end-diastolic volume [ml]")
    axes.set_ylabel("LV ejection fraction [%]")
    axes.set_ylim(0, 100)
    axes.set_xlim(0, 1.2 * max((edv for _, edv, _ in dots), default=100))
    figure.tight_layout()
    figure.savefig("ejection_fraction.svg", metadata={"Date": None})


def summarize(exams):
    rows = [row_of(exam) for exam in exams]
    with tempfile.NamedTemporaryFile("w", dir=".", prefix=".partial-", delete=False,
                                     newline="") as part:
        table = csv.DictWriter(part, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(row for row, _ in rows)
    os.replace(part.name, "summary.csv")
    plots([(row, info) for row, info in rows if info])
    bad = [row for row, info in rows if not info]
    print(f"cohort: {len(rows) - len(bad)} of {len(rows)} exams have an atlas; see summary.csv",
          file=sys.stderr)
    for row in bad:
        print(f"cohort: {row['exam']}: {row['state']} {row['stage']} {row['reason']}".rstrip(),
              file=sys.stderr)
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    stage = verbs.add_parser("stage")
    stage.add_argument("stage", choices=STAGES)
    stage.add_argument("exam")
    stage.add_argument("--threads", type=int, default=0)
    summary = verbs.add_parser("summary")
    summary.add_argument("exams", nargs="+")
    words = parser.parse_args()
    if words.verb == "stage":
        return run_stage(words.stage, words.exam, words.threads)
    return summarize(words.exams)


if __name__ == "__main__":
    sys.exit(main())
