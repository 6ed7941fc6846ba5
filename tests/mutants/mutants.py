"""Whether the tests notice: lines of the product are changed one after another in a copy of the sources,
and a fast test of the room has to fail for each.

mutants.py SOURCE list                              the changes, and who has to notice
mutants.py SOURCE check                             each change still has its line and its test; a moment
mutants.py SOURCE run WORK_FOLDER [--only ROOM...]  copies, builds, changes, tests; the first time takes long

A line is changed in a sign, a bound or a unit, as slips change them. A change that does not compile or that no
test notices is a failure, and so is a test that fails before anything was changed.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
from typing import NamedTuple

FEWEST_ROOMS = 10
NO_SOURCE = re.compile(r"build.*|out|\.git|\.cache")  # at the root, as .gitignore has them


class Mutant(NamedTuple):
    room: str
    file: str    # in the room's folder
    before: str  # stands once in the file, within a line
    after: str
    target: str  # program of tests
    test: str    # of that program, which has to fail


MUTANTS = (
    # Whatever begins as a folder does would lie within it.
    Mutant("runtime/base", "within.cpp", ".first == from.end()", ".first != from.begin()",
           "runtime_base_test", "LiesWithin.WhatIsBesideOrBelow"),
    # An entry's size would be believed by one more than there may be.
    Mutant("runtime/atlas", "zip_archive.cpp", "count < 0 || static_cast<std::size_t>(count) > kMaxEntries",
           "count < 0 || static_cast<std::size_t>(count) > 2 * kMaxEntries",
           "package_hostile_test", "HostilePackage.WithEntriesThatMisleadIsRefused"),
    # A surface would move against its own motion.
    Mutant("runtime/field", "field_query.cpp", "? -sample.rate_mm_s / length", "? sample.rate_mm_s / length",
           "runtime_field_test", "FieldQuery.MovesWithABeatingSphere"),
    # The hand would get half as much again as the safety stage allows.
    Mutant("runtime/haptics", "safety.cpp", "if (size > options_.peak_n) {", "if (size > 1.5 * options_.peak_n) {",
           "runtime_haptics_test", "SafetyStage.CapsThePeakWithoutTurningTheForce"),
    # A larger animal's ventricle would be stiffer, not softer.
    Mutant("runtime/palpation", "circulation.cpp", "out.emax /= ratio;", "out.emax *= ratio;",
           "palpation_test", "Circulation.ScalesWithWeight"),
    # Recorded millimetres would be played as centimetres.
    Mutant("runtime/device", "replay.cpp", "1e-3 * Vec3(row[1]", "1e-2 * Vec3(row[1]",
           "runtime_device_test", "Replay.PlaysARecordingLinearlyBetweenItsRows"),
    # Milliseconds of NIfTI would be read as seconds.
    Mutant("pipeline/formats", "nifti_header.cpp", "to_seconds = 1e-3;", "to_seconds = 1;",
           "formats_test", "Nifti.TimeIsInSecondsWhateverTheUnit"),
    # The R-R interval that images print would be taken for ten times as long.
    Mutant("pipeline/ingest", "slice_timing.cpp", "*stamp.rr_ms * 1e-3", "*stamp.rr_ms * 1e-2",
           "ingest_test", "SliceTiming.UnevenTimesStayUneven"),
    # A phantom's truth would be ten times as large as its shape.
    Mutant("pipeline/phantom", "volume.cpp", "return sum * 1e-3;", "return sum * 1e-2;",
           "phantom_test", "PhantomShape.VolumesEqualClosedForms"),
    # A volume that fell in one phase would count as one that rose.
    Mutant("pipeline/alarm", "volume_jumps.cpp", "above > below ? above : -below", "above > below ? above : below",
           "alarm_test", "VolumeJumps.OnePhaseThatLeakedOrLostIsFoundWhereverItIs"),
    # Errors would be told ten times as small as they are felt.
    Mutant("pipeline/assess", "force_error.cpp", "kJndShare = 0.07;", "kJndShare = 0.7;",
           "assess_test", "ForceErrors.FollowFromThePairsOfForces"),
    # The spline between key surfaces would bend with a jump at each.
    Mutant("pipeline/keyframes", "periodic_spline.cpp", "+= 2 * (1 / left", "+= 3 * (1 / left",
           "keyframes_test", "PeriodicSpline.BendsWithoutAJump"),
)


def where(mutant):
    return f"{mutant.room}/{mutant.file}"


def changed(mutant, text):
    """The text of the file with the change. @raises ValueError if the line is not there once."""
    if text.count(mutant.before) != 1 or "\n" in mutant.before or mutant.before == mutant.after:
        raise ValueError(f"{where(mutant)}: '{mutant.before}' stands there {text.count(mutant.before)} times, not "
                         "once; choose another line for the room in tests/mutants/mutants.py")
    return text.replace(mutant.before, mutant.after)


def check(source, mutants):
    """A sentence for each change that has lost its line or its test."""
    problems = []
    rooms = {mutant.room for mutant in mutants}
    if len(rooms) < FEWEST_ROOMS:
        problems.append(f"{len(rooms)} rooms are changed, {FEWEST_ROOMS} at least are wanted")
    tests = "".join(file.read_text() for file in sorted((source / "tests").rglob("*.cpp")))
    lists = "".join(file.read_text() for file in sorted((source / "tests").rglob("CMakeLists.txt")))
    for mutant in mutants:
        try:
            changed(mutant, (source / where(mutant)).read_text())
        except (OSError, ValueError) as trouble:
            problems.append(str(trouble))
        suite, name = mutant.test.split(".")
        if not re.search(rf"^TEST(_F)?\({suite}, {name}\)", tests, re.MULTILINE):
            problems.append(f"{where(mutant)}: there is no test {mutant.test}")
        # Some programs of tests are named in a loop: package_${name}_test.
        if f"beatlas_test({mutant.target}" not in lists and not mutant.target.startswith("package_"):
            problems.append(f"{where(mutant)}: there is no program of tests {mutant.target}")
    return problems


def copied(source, work):
    """A copy of the sources without what was built. One that is there is brought up to date, so that its build is
    used again; files that did not change keep their time."""
    copy = work / "source"
    tops = [top for top in source.iterdir() if not NO_SOURCE.fullmatch(top.name)]
    wanted = {path.relative_to(source) for top in tops for path in [top, *top.rglob("*")]
              if path.is_file() and path.parent.name != "__pycache__"}
    for path in wanted:
        target = copy / path
        if target.exists() and target.read_bytes() == (source / path).read_bytes():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source / path, target)
        os.utime(target)
    for path in copy.rglob("*"):
        inside = path.relative_to(copy)
        if path.is_file() and inside.parts[0] != "build" and inside not in wanted:
            path.unlink()
    return copy


def built(copy, targets):
    """Whether the programs were built; what was said if not."""
    done = subprocess.run(["bash", "scripts/build_jobs", "cmake", "--build", "build/release", "--target", *targets],
                          cwd=copy, capture_output=True, text=True)
    return done.returncode == 0, (done.stdout + done.stderr)[-4000:]


def passes(copy, mutant):
    """Whether the test passes; a test that is not there, or ends without a verdict, is an error."""
    done = subprocess.run([copy / "build" / "release" / "bin" / mutant.target, f"--gtest_filter={mutant.test}"],
                          cwd=copy, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    if f"[       OK ] {mutant.test}" in said and done.returncode == 0:
        return True
    if f"[  FAILED  ] {mutant.test}" in said and done.returncode != 0:
        return False
    raise RuntimeError(f"{mutant.target} gave no verdict on {mutant.test}:\n{said[-2000:]}")


def told(mutant, copy):
    """What became of one change: empty if it was noticed."""
    file = copy / where(mutant)
    sound = file.read_text()
    file.write_text(changed(mutant, sound))
    try:
        good, said = built(copy, [mutant.target])
        if not good:
            return f"does not compile:\n{said}"
        return f"was not noticed by {mutant.test}" if passes(copy, mutant) else ""
    finally:
        file.write_text(sound)


def run(source, work, mutants):
    copy = copied(source, work.resolve())
    for words in (["cmake", "--preset", "release"],):
        done = subprocess.run(words, cwd=copy, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"mutants: {' '.join(words)} failed\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    good, said = built(copy, sorted({mutant.target for mutant in mutants}))
    if not good:
        sys.exit(f"mutants: the copy of the sources does not build\n{said}")
    for mutant in mutants:
        if not passes(copy, mutant):
            sys.exit(f"mutants: {mutant.test} fails before anything was changed")
    lost = 0
    for mutant in mutants:
        problem = told(mutant, copy)
        lost += bool(problem)
        print(f"{where(mutant)}: '{mutant.before}' -> '{mutant.after}': {problem or 'noticed by ' + mutant.test}",
              flush=True)
    print(f"{len(mutants) - lost} of {len(mutants)} changes were noticed")
    return 1 if lost else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("what", choices=["list", "check", "run"])
    parser.add_argument("work", type=pathlib.Path, nargs="?", help="where the copy and its build lie and stay")
    parser.add_argument("--only", action="append", choices=sorted({mutant.room for mutant in MUTANTS}))
    words = parser.parse_args()
    mutants = [mutant for mutant in MUTANTS if not words.only or mutant.room in words.only]
    if words.what == "list":
        for mutant in mutants:
            print(f"{where(mutant)}: '{mutant.before}' -> '{mutant.after}'; {mutant.target} {mutant.test}")
        return 0
    problems = check(words.source.resolve(), MUTANTS)
    if problems:
        sys.exit("\n".join(problems))
    if words.what == "check":
        return 0
    if words.work is None:
        parser.error("run needs a folder to work in")
    return run(words.source.resolve(), words.work, mutants)


if __name__ == "__main__":
    sys.exit(main())
