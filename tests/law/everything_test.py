"""`scripts/test --everything` runs every preset, the nightly and the soak tests, ITK and the Debian package, and
sums up: on a stand-in for `scripts/test`. everything_test.py ROOT"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop(1))
# Says what it was called with, and what it is told to say and to end with of that preset.
STAND_IN = """#!/usr/bin/env bash
echo "called: $*"
while read -r name skipped passed failed status; do
  if [[ " $* " == *" $name "* ]]; then
    ((skipped == 0)) || echo "$skipped skipped (listed above), counted neither way"
    ((passed < 0)) || echo "$passed passed, $failed failed"
    exit "$status"
  fi
done < outcomes.txt
echo "5 passed, 0 failed"
"""


class Everything(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "scripts").mkdir()
        shutil.copy(ROOT / "scripts" / "test_everything", self.root / "scripts")
        (self.root / "scripts" / "test").write_text(STAND_IN)
        (self.root / "scripts" / "setup").write_text("echo setup \"$@\" > setup.txt\n")

    def run_it(self, outcomes, *words):
        (self.root / "outcomes.txt").write_text("".join(f"{line}\n" for line in outcomes))
        return subprocess.run(["bash", "scripts/test_everything", *words], cwd=self.root, capture_output=True,
                              text=True)

    def test_every_preset_and_the_rest_are_parts(self):
        done = subprocess.run(["bash", ROOT / "scripts" / "test", "--everything", "--list"], capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = dict(line.split(None, 1) for line in done.stdout.splitlines())
        presets = json.loads((ROOT / "CMakePresets.json").read_text())["testPresets"]
        self.assertGreaterEqual(len(presets), 6)
        for preset in presets:
            self.assertIn(f"--preset {preset['name']}", lines[preset["name"]])
        self.assertTrue({"itk", "package"} <= set(lines), lines)
        # The names that parts choose are those of tests.
        lists = "".join(file.read_text() for file in (ROOT / "tests").rglob("CMakeLists.txt"))
        for part, test in (("itk", "correct.editors_itk"), ("package", "install.debian_package")):
            self.assertIn(f"^{test}$".replace(".", r"\."), lines[part])
            self.assertIn(test.split(".")[1], lists)

    def test_all_parts_run_and_are_summed_up(self):
        done = self.run_it(["dev 2 7 0 0"])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual((self.root / "setup.txt").read_text(), "setup --everything\n")
        self.assertEqual(done.stdout.count("called: --no-setup"), 9)
        self.assertTrue(done.stdout.endswith("2 skipped, counted neither way\n47 passed, 0 failed\n"), done.stdout)
        self.assertIn("called", (self.root / "build/everything/asan.txt").read_text())

    def test_a_part_that_fails_is_counted_and_stops_no_other(self):
        done = self.run_it(["asan 0 4 3 1"])
        self.assertEqual(done.returncode, 1)
        self.assertIn("called: --no-setup --preset tsan", done.stdout)
        self.assertTrue(done.stdout.endswith("44 passed, 3 failed\n"), done.stdout)

    def test_a_part_in_which_nothing_passed_or_that_broke_has_failed(self):
        for outcome, passed in (("tsan 6 0 0 0", 40), ("tsan 0 5 0 2", 45), ("tsan 0 -1 0 1", 40)):
            done = self.run_it([outcome])
            self.assertEqual(done.returncode, 1, outcome)
            self.assertTrue(done.stdout.endswith(f"{passed} passed, 1 failed\n"), done.stdout)

    def test_parts_are_chosen_by_name(self):
        done = self.run_it([], "--no-setup", "--only", "tsan", "--only", "itk")
        self.assertFalse((self.root / "setup.txt").exists())
        self.assertEqual(done.stdout.count("called:"), 2)
        self.assertTrue(done.stdout.endswith("10 passed, 0 failed\n"), done.stdout)
        done = self.run_it([], "--only", "msan")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("release nightly runtime-only", done.stderr)


if __name__ == "__main__":
    unittest.main()
