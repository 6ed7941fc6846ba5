"""What the tests of import share: running the program, reading an exam back, refusals, named cases.

A test file is called with BEATLAS NAME and runs the function of that name that @case marks; CMake
finds the names by the same mark.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import nibabel
import numpy as np

SKIPPED = 77  # the exit code that ctest takes for "skipped"
LPS_FROM_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])
CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def main():
    """Runs one case in a new folder. The program is argv[1], the case's name argv[2]."""
    if len(sys.argv) != 3 or sys.argv[2] not in CASES:
        sys.exit(f"usage: {sys.argv[0]} BEATLAS NAME, one of: {', '.join(CASES)}")
    with tempfile.TemporaryDirectory(prefix="beatlas-import-") as folder:
        CASES[sys.argv[2]](pathlib.Path(folder))


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def shared_data(name):
    """A folder of real exams that is no part of the repository."""
    root = os.environ.get("BEATLAS_SHARED_DATA") or str(
        pathlib.Path(__file__).resolve().parents[3] / "shared" / "data")
    if not (pathlib.Path(root) / "exams.json").exists():
        skip(f"the real exams of {root} are not on this machine (set BEATLAS_SHARED_DATA to their folder)")
    folder = pathlib.Path(root) / name
    assert folder.is_dir(), f"the real exam {name} is missing beside the others in {root}"
    return folder


def run(*words, cwd=None):
    words = [sys.argv[1], *map(str, words)]
    done = subprocess.run(words, capture_output=True, cwd=cwd)
    done.out = done.stdout.decode("utf-8", "replace")
    done.err = done.stderr.decode("utf-8", "replace")
    done.command = " ".join(["beatlas", *words[1:]])
    return done


def beatlas(*words, code=0, cwd=None):
    done = run(*words, cwd=cwd)
    assert done.returncode == code, (
        f"$ {done.command}\nexit code {done.returncode}, expected {code}\n{done.err}")
    return done


class Cine:
    """One cine of a study: the grid in LPS, values[i, j, k, phase], times."""

    def __init__(self, folder, entry):
        image = nibabel.load(folder / entry["file"])
        self.values = image.get_fdata(dtype=np.float64)
        self.size = self.values.shape[:3]
        self.phases = self.values.shape[3]
        self.rr_s, self.times_s = entry["rr_interval_s"], entry["frame_times_s"]
        self.lps = np.array(entry["grid"]["mm_from_index"], float).reshape(-1, 4)
        self.lps = np.vstack([self.lps, [0, 0, 0, 1]])[:4]
        assert tuple(entry["grid"]["size"]) == self.size, (entry["grid"]["size"], self.size)
        assert entry["phases"] == self.phases, (entry["phases"], self.phases)
        in_file = LPS_FROM_RAS @ image.affine
        far = np.abs(self.corners(in_file) - self.corners(self.lps)).max()
        assert far < 0.01, f"exam.json and {entry['file']} lie {far:.4f} mm apart"

    def corners(self, affine):
        top = np.array(self.size) - 1
        at = np.array([[a, b, c] for a in (0, top[0]) for b in (0, top[1]) for c in (0, top[2])])
        return at @ affine[:3, :3].T + affine[:3, 3]

    def places(self):
        """LPS [mm] of every voxel centre, shape (i, j, k, 3)."""
        index = np.stack(np.meshgrid(*map(np.arange, self.size), indexing="ij"), axis=-1)
        return index @ self.lps[:3, :3].T + self.lps[:3, 3]

    def spacing(self):
        return np.linalg.norm(self.lps[:3, :3], axis=0)


class Exam:
    def __init__(self, study, said=""):
        folder = pathlib.Path(study) / "exam"
        content = json.loads((folder / "exam.json").read_text())
        self.stack = Cine(folder, content["stack"])
        self.views = [Cine(folder, view) for view in content["views"]]
        self.decisions = content["decisions"]
        self.format = content["source_format"]
        self.said = said

    def told(self, pattern):
        return any(re.search(pattern, text, re.IGNORECASE) for text in self.decisions)

    def expect_told(self, *patterns):
        """Every decision is kept in the exam and printed."""
        for pattern in patterns:
            assert self.told(pattern), f"no decision says /{pattern}/:\n" + "\n".join(self.decisions)
            assert re.search(pattern, self.said, re.IGNORECASE), (
                f"/{pattern}/ was kept but not printed:\n{self.said}")

    def expect_warning(self, *patterns):
        for pattern in patterns:
            warnings = [d for d in self.decisions if re.search("warning", d, re.IGNORECASE)]
            assert any(re.search(pattern, w, re.IGNORECASE) for w in warnings), (
                f"no warning says /{pattern}/:\n" + "\n".join(self.decisions))
            assert any("warning" in line.lower() and re.search(pattern, line, re.IGNORECASE)
                       for line in self.said.splitlines()), f"not printed:\n{self.said}"


def imported(study, sources, *options):
    """Imports into a new study and reads the exam with a library of its own."""
    if not isinstance(sources, (list, tuple)):
        sources = [sources]
    done = beatlas("import", *sources, "--study", study, *options)
    assert done.out == "", f"import prints no data: {done.out}"
    return Exam(study, done.err)


def exam_bytes(study):
    """What must not change when files are only renamed or shuffled."""
    folder = pathlib.Path(study) / "exam"
    return {file.name: file.read_bytes() for file in sorted(folder.iterdir())}


def expect_same_exam(study, other):
    a, b = exam_bytes(study), exam_bytes(other)
    assert sorted(a) == sorted(b), (sorted(a), sorted(b))
    different = [name for name in a if a[name] != b[name]]
    told = "\n".join(line for line in (a["exam.json"].decode().splitlines() +
                                       b["exam.json"].decode().splitlines())
                     if (line in a["exam.json"].decode()) != (line in b["exam.json"].decode()))
    assert not different, f"{different} differ\n{told}"


def nothing_left(folder, before):
    """No package, no half-written file, nothing in a study under a final name."""
    for file in sorted(set(pathlib.Path(folder).rglob("*")) - before):
        if file.is_dir():
            continue
        # A study that was begun may say so; it records no stage and holds no image.
        if file.name == "study.json":
            assert not json.loads(file.read_text()).get("stages"), f"{file} records a stage"
            continue
        lock = file.name.startswith(".") and "partial" not in file.name and not file.stat().st_size
        assert lock, f"left behind: {file}"


def one_sentence(done, *patterns, code=3):
    where = f"$ {done.command}\n--- stderr\n{done.err}"
    assert done.returncode == code, f"exit code {done.returncode}, expected {code}\n{where}"
    assert done.out == "", f"data was printed\n{where}"
    lines = done.err.splitlines()
    assert len(lines) == 1, f"{len(lines)} lines, one sentence was expected\n{where}"
    assert lines[0].startswith("beatlas: ") and "unexpected trouble" not in lines[0], where
    assert len(lines[0]) < 700, f"a sentence of {len(lines[0])} characters\n{where}"
    for pattern in patterns:
        assert re.search(pattern, lines[0], re.IGNORECASE), f"lacks /{pattern}/\n{where}"
    return lines[0]


def refused(folder, sources, *patterns, options=(), never=()):
    """Import, and the first time build too, says one sentence with every pattern in it, exits with
    3 and leaves nothing."""
    commands = ("import",) if refused.built else ("import", "build")
    refused.built = True
    if not isinstance(sources, (list, tuple)):
        sources = [sources]
    before = set(pathlib.Path(folder).rglob("*"))
    for command in commands:
        words = [command, *sources, "--study", pathlib.Path(folder) / f"study-{command}", *options]
        if command == "build":
            words += ["-o", pathlib.Path(folder) / "heart.beatlas"]
        done = run(*words)
        said = one_sentence(done, *patterns)
        for word in never:
            assert word not in said, f"{word} was told: {said}"
        nothing_left(folder, before)
    return said


refused.built = False
