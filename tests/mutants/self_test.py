"""mutants.py tells a change that is noticed from one that is not, and one that has lost its line or its test."""
import pathlib
import tempfile
import unittest

import mutants

MUTANT = mutants.Mutant("runtime/base", "ball.cpp", "r * r", "r + r", "ball_test", "Ball.HasItsArea")
SAYS = {"passes": ("[       OK ] Ball.HasItsArea", 0), "fails": ("[  FAILED  ] Ball.HasItsArea", 1)}


class House(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("runtime/base/ball.cpp", "return pi *\n r * r;\n")
        self.write("tests/ball_test.cpp", "TEST(Ball, HasItsArea) {\n")
        self.write("tests/CMakeLists.txt", "beatlas_test(ball_test SOURCES ball_test.cpp)\n")

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def problems(self):
        rooms = [MUTANT._replace(room=f"room{n}") for n in range(mutants.FEWEST_ROOMS - 1)]
        for other in rooms:
            self.write(mutants.where(other), "r * r")
        return mutants.check(self.root, [MUTANT, *rooms])

    def test_changes_with_line_and_test_are_in_order(self):
        self.assertEqual(self.problems(), [])

    def test_too_few_rooms_are_told(self):
        self.assertIn("1 rooms", mutants.check(self.root, [MUTANT])[0])

    def test_a_line_that_is_gone_or_stands_twice_is_told(self):
        for text in ("return 1;", "r * r; r * r;"):
            self.write("runtime/base/ball.cpp", text)
            found = self.problems()
            self.assertEqual(len(found), 1, found)
            self.assertIn("runtime/base/ball.cpp", found[0])

    def test_a_test_that_is_gone_is_told(self):
        self.write("tests/ball_test.cpp", "TEST(Ball, IsRound) {\n")
        self.assertIn("there is no test Ball.HasItsArea", self.problems()[0])
        self.write("tests/CMakeLists.txt", "beatlas_test(cube_test SOURCES cube_test.cpp)\n")
        self.assertIn("no program of tests ball_test", self.problems()[1])

    def test_only_a_verdict_counts(self):
        for words, code, verdict in ((*SAYS["passes"], True), (*SAYS["fails"], False), ("", 0, None), ("", 139, None),
                                     ("[  PASSED  ] 0 tests.", 0, None), (SAYS["passes"][0], 1, None)):
            program = self.write("build/release/bin/ball_test", f"#!/bin/sh\necho '{words}'\nexit {code}\n")
            program.chmod(0o755)
            if verdict is None:
                self.assertRaises(RuntimeError, mutants.passes, self.root, MUTANT)
            else:
                self.assertEqual(mutants.passes(self.root, MUTANT), verdict)

    def test_a_change_that_no_test_notices_is_told_and_the_line_is_as_before(self):
        file = self.root / "runtime/base/ball.cpp"
        before = file.read_text()
        for says, problem in (("passes", "was not noticed"), ("fails", "")):
            words, code = SAYS[says]
            # Building is making a program that tells whether it saw the change.
            self.write("scripts/build_jobs", f"""grep -q 'r + r' runtime/base/ball.cpp || exit 1
mkdir -p build/release/bin
printf '#!/bin/sh\\necho "{words}"\\nexit {code}\\n' > build/release/bin/ball_test
chmod +x build/release/bin/ball_test\n""")
            said = mutants.told(MUTANT, self.root)
            self.assertIn(problem, said)
            self.assertEqual(bool(said), bool(problem))
            self.assertEqual(file.read_text(), before)
        self.write("scripts/build_jobs", "exit 1\n")
        self.assertIn("does not compile", mutants.told(MUTANT, self.root))
        self.assertEqual(file.read_text(), before)

    def test_a_copy_follows_the_sources_and_keeps_what_it_built(self):
        self.write("build/release/old", "")
        work = self.root / "build" / "work"
        copy = mutants.copied(self.root, work)
        self.assertFalse((copy / "build").exists())
        built = copy / "build" / "made"
        built.parent.mkdir()
        built.touch()
        time = (copy / "tests/CMakeLists.txt").stat().st_mtime_ns
        self.write("runtime/base/ball.cpp", "new")
        (self.root / "tests/ball_test.cpp").unlink()
        mutants.copied(self.root, work)
        self.assertEqual((copy / "runtime/base/ball.cpp").read_text(), "new")
        self.assertFalse((copy / "tests/ball_test.cpp").exists())
        self.assertEqual((copy / "tests/CMakeLists.txt").stat().st_mtime_ns, time)
        self.assertTrue(built.exists())


if __name__ == "__main__":
    unittest.main()
