"""A study whose builds wait for each other, are killed, or find the disk full:
study_stops_test.py BEATLAS WORK_FOLDER NAME [KILLS]

WORK_FOLDER is that of stage_test.py; the exam and package are those of study_test.py's `prepare`.
"""
import fcntl
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

import nibabel

from stage_test import PROGRAM, WORK, beatlas, digest, expect_same, new_folder
from study_test import EXAM, PACKAGE, RECIPE


def waits():
    """Two builds in one study: the second says that it waits, and both end well."""
    folder, package = new_folder("waits"), WORK / "waits.beatlas"
    words = [PROGRAM, "build", str(EXAM), "-o", str(package), "--study", str(folder),
             "--recipe", str(RECIPE)]
    first = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60
    while not (folder / "study.json").exists() and time.monotonic() < until:
        time.sleep(0.02)
    second = subprocess.run(words, capture_output=True, text=True)
    _, said = first.communicate()
    assert first.returncode == 0, said
    assert second.returncode == 0, second.stderr
    assert "waiting for its end" in second.stderr, second.stderr
    assert "nothing has changed" in second.stderr, second.stderr
    expect_same(PACKAGE, package)
    # One that waits is stopped by the interrupt key.
    held = os.open(folder, os.O_RDONLY)
    fcntl.flock(held, fcntl.LOCK_EX)
    third = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    assert "waiting" in third.stderr.readline()
    assert json.loads(beatlas("status", folder, "--json").stdout)["in_use"]
    third.send_signal(signal.SIGINT)
    assert third.wait(timeout=10) == 5
    os.close(held)


def no_half_files(folder, package, removed="none"):
    """What has a final name is whole: hashes of finished stages agree with their files.

    `removed` is a stage whose files were taken away. Gives the stages that have all of theirs."""
    if package.exists():
        expect_same(PACKAGE, package)
    index = folder / "study.json"
    if not index.exists():
        return set()
    stages = json.loads(index.read_text())["stages"]
    for name, record in stages.items():
        assert record["outputs"], f"{name} is done and left nothing"
        for file, wanted in record["outputs"].items():
            if not (folder / file).exists() and name == removed:
                continue
            assert digest(folder / file) == wanted, f"{name}: {file}"
    for file in folder.rglob("*.nii.gz"):
        if not file.name.startswith(".partial"):
            nibabel.load(file).get_fdata()
    return {name for name, record in stages.items()
            if all((folder / file).exists() for file in record["outputs"])}


def kill(rounds):
    """Killed at random moments, each resume ends in the bytes of an undisturbed run."""
    chance = random.Random(20261121)
    folder, package = WORK / "kill", WORK / "kill.beatlas"
    words = [PROGRAM, "build", str(EXAM), "-o", str(package), "--study", str(folder),
             "--recipe", str(RECIPE)]
    new_folder("kill")
    begin = time.monotonic()
    beatlas(*words[1:])
    whole_s = time.monotonic() - begin
    done, finished, removed = 0, set(), "none"
    shutil.rmtree(folder)
    package.unlink()
    killed_in = {}
    while done < rounds:
        process = subprocess.Popen(words, stderr=subprocess.DEVNULL)
        try:
            # Short runs too, so that the first stages and the resume itself are hit.
            process.wait(timeout=chance.uniform(0, whole_s * chance.choice((0.05, 0.3, 1))))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            done += 1
        stages = no_half_files(folder, package, removed)
        lost = finished - stages
        # The one that was being written anew has no record; none that was finished is lost.
        assert not lost, f"finished before and gone now: {lost}"
        key = len(stages - {"pictures"})
        killed_in[key] = killed_in.get(key, 0) + 1
        finished = stages
        if process.returncode == 0:
            assert package.exists()
            expect_same(PACKAGE, package)
            if chance.random() < 0.5:
                shutil.rmtree(folder)
                package.unlink()
                removed = "none"
            else:  # a stage in the middle runs again
                removed = chance.choice(("segment", "register", "field", "mesh"))
                shutil.rmtree(folder / removed)
            finished = set()
    beatlas(*words[1:])
    expect_same(PACKAGE, package)
    no_half_files(folder, package)
    assert not list(folder.rglob(".partial*")), "left by a kill and not cleared"
    print(f"{done} kills; finished stages at the time: {dict(sorted(killed_in.items()))}")


def full_disk():
    """A disk that ends at any size of file: exit 5, one sentence, nothing damaged, then resumed."""
    folder, package = new_folder("full_disk"), WORK / "full_disk.beatlas"
    package.write_bytes(PACKAGE.read_bytes())
    words = [PROGRAM, "build", str(EXAM), "-o", str(package), "--study", str(folder),
             "--recipe", str(RECIPE)]
    stopped = 0
    largest = 40 << 20
    size = 1 << 10
    while True:
        def limit(size=size):
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        done = subprocess.run(words, capture_output=True, text=True, preexec_fn=limit)
        if done.returncode == 0:
            break
        assert done.returncode == 5, (size, done.returncode, done.stderr)
        last = done.stderr.strip().splitlines()[-1]
        assert last.startswith("beatlas: ") and "cannot be written" in last, done.stderr
        no_half_files(folder, package)
        assert not list(folder.rglob(".partial*")), "a failed write cleans up"
        stopped += 1
        size *= 4
        assert size < 64 * largest
    assert stopped >= 3, stopped
    expect_same(PACKAGE, package)
    no_half_files(folder, package)


if __name__ == "__main__":
    if sys.argv[3] == "kill":
        kill(int(sys.argv[4]))
    else:
        globals()[sys.argv[3]]()
