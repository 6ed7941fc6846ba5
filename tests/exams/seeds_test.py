"""Real exams found from a dozen balls of a person, without a prior, held to what was reached.

usage: seeds_test.py SOURCE_ROOT BEATLAS EXAM

The balls of tests/exams/seeds_EXAM.json were placed by looking at the images, not at an expert's outline: one of
LV, RV, muscle and background in each of three slices of one phase. Each is also moved by 4 mm, in a direction
drawn from a seed. Skipped (77) where the exams are not on the machine.
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

ROOT, BEATLAS, EXAM = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
sys.path.insert(0, str(ROOT / "scripts" / "exams"))
sys.dont_write_bytecode = True
import measures  # noqa: E402
from real_exam import real_exam  # noqa: E402

MOVED_MM = 4
# What is aimed at is .88, .88 and .70; what is held is what was reached, less .02, as placed and moved.
HELD = {"sunnybrook/SCD0000101": {"placed": (0.88, 0.87, 0.67), "moved": (0.87, 0.84, 0.64)},
        "sunnybrook/SCD0000401": {"placed": (0.89, 0.80, 0.675), "moved": (0.87, 0.79, 0.655)},
        "two-phase-ge": {"placed": (0.92, 0.685, None), "moved": (0.925, 0.66, None)}}


def moved(seeds, draw):
    """Each in the plane of the first three marks, which lie in one slice."""
    if draw is None:
        return seeds
    chance = random.Random(draw)
    a, b, c = ([float(x) for x in seed["lps_mm"]] for seed in seeds[:3])
    u = [q - p for p, q in zip(a, b)]
    w = [q - p for p, q in zip(a, c)]
    u = [x / math.hypot(*u) for x in u]
    along = sum(p * q for p, q in zip(u, w))
    w = [q - along * p for p, q in zip(u, w)]
    w = [x / math.hypot(*w) for x in w]
    out = []
    for seed in seeds:
        angle = chance.uniform(0, 2 * math.pi)
        place = [x + MOVED_MM * (math.cos(angle) * p + math.sin(angle) * q)
                 for x, p, q in zip(seed["lps_mm"], u, w)]
        out.append({**seed, "lps_mm": place})
    return out


def main():
    data, exam = real_exam(ROOT, EXAM)
    placed = json.loads((ROOT / "tests" / "exams" / f"seeds_{EXAM.split('/')[-1]}.json").read_text())
    failed = []
    with tempfile.TemporaryDirectory(prefix="beatlas-seeds-") as folder:
        study = pathlib.Path(folder) / "exam.study"
        subprocess.run([BEATLAS, "import", str(data / exam["source"]), "--study", str(study)], check=True,
                       capture_output=True)
        for draw in (None, 1, 2):
            marks = pathlib.Path(folder) / "seeds.json"
            marks.write_text(json.dumps({**placed, "seeds": moved(placed["seeds"], draw)}))
            subprocess.run([BEATLAS, "segment", "--study", str(study), "--prior", "none", "--seeds", str(marks)],
                           check=True, capture_output=True)
            row = measures.score(study, exam, data)
            got = (row["ed"]["lv_blood"]["dice"], row["es"]["lv_blood"]["dice"],
                   row["ed"].get("lv_myocardium", {}).get("dice"))
            name = "placed" if draw is None else "moved"
            print(f"{EXAM} {name} {draw or ''}: Dice LV ED {got[0]:.3f}, ES {got[1]:.3f}, muscle ED {got[2]}")
            for least, value in zip(HELD[EXAM][name], got):
                if least is not None and value < least:
                    failed.append(f"{EXAM}, {name} {draw or ''}: Dice {value:.3f} is below {least}")
    print("\n".join(failed))
    return 1 if failed else 0


sys.exit(main())
