"""scripts/figures: README.md and docs/figures.json cannot differ unnoticed, and a set that is measured anew changes
both and nothing else: figures_test.py SOURCE_FOLDER PROGRAMS_FOLDER"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.readme, self.file = self.folder / "README.md", self.folder / "figures.json"
        shutil.copy(SOURCE / "README.md", self.readme)
        shutil.copy(SOURCE / "docs" / "figures.json", self.file)

    def call(self, *words):
        return subprocess.run([sys.executable, "-B", SOURCE / "scripts" / "figures", *words, "--readme", self.readme,
                               "--file", self.file, "--bin", PROGRAMS], capture_output=True, text=True)

    def assert_noticed(self, *said):
        done = self.call("--check")
        self.assertEqual(done.returncode, 1)
        for words in said:
            self.assertIn(words, done.stderr)

    def change(self, file, before, after):
        text = file.read_text()
        self.assertIn(before, text)
        file.write_text(text.replace(before, after, 1))

    def test_readme_and_file_agree(self):
        self.assertEqual(self.call("--check").returncode, 0)

    def test_a_figure_changed_by_hand_is_noticed(self):
        self.change(self.readme, "| natural | 49.8 |", "| natural | 52.0 |")
        self.assert_noticed("palpation", "52.0", "49.8")

    def test_a_line_that_is_missing_or_too_much_is_noticed(self):
        self.change(self.readme, "| natural | 49.8 |", "| natural, no line |\n| natural | 49.8 |")
        self.assert_noticed("palpation", "no line")
        shutil.copy(SOURCE / "README.md", self.readme)
        text = self.readme.read_text()
        at = text.index("| natural | 49.8 |")
        self.readme.write_text(text[:at] + text[text.index("\n", at) + 1:])
        self.assert_noticed("palpation", "natural")

    def test_a_value_that_changed_in_the_file_is_noticed(self):
        kept = json.loads(self.file.read_text())
        kept["palpation"]["values"]["default"]["pressed"]["output_l_per_min"] *= 1.1
        self.file.write_text(json.dumps(kept))
        self.assert_noticed("palpation")

    def test_parts_and_sets_are_the_same(self):
        self.change(self.readme, "<!-- figures: palpation -->", "<!-- figures: palpitation -->")
        self.assert_noticed("no part for the set palpation", "palpitation that no set makes")
        self.change(self.readme, "<!-- figures: end -->", "")
        self.assert_noticed("not in pairs")

    def test_a_set_measured_anew_mends_its_part_and_leaves_the_rest(self):
        whole, kept = self.readme.read_text(), json.loads(self.file.read_text())
        self.change(self.readme, "| natural | 49.8 |", "| natural | 52.0 |")
        kept["palpation"]["values"]["default"]["pressed"]["edv_ml"] = 1
        self.file.write_text(json.dumps(kept))
        done = self.call("--only", "palpation")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.readme.read_text(), whole)
        self.assertEqual(self.call("--check").returncode, 0)

    def test_what_is_not_made_yet_is_told(self):
        told = self.call("--help").stdout
        self.assertIn("does not make yet", told)
        self.assertIn("force_trace_bench", told)
        self.assertEqual(self.call("--only", "palpitation").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
