"""scripts/figures: pages and docs/figures.json cannot differ unnoticed, and a set that is measured anew changes
both and nothing else: figures_test.py SOURCE_FOLDER PROGRAMS_FOLDER"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE, PROGRAMS = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
PAGES = ("README.md", "docs/accuracy.md", "docs/trainer.md")


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "figures.json"
        self.readme, self.page, self.trainer = (pathlib.Path(shutil.copy(SOURCE / page, self.folder)) for page in PAGES)
        shutil.copy(SOURCE / "docs" / "figures.json", self.file)

    def call(self, *words):
        pages = [word for page in (self.readme, self.page, self.trainer) for word in ("--page", page)]
        return subprocess.run([sys.executable, "-B", SOURCE / "scripts" / "figures", *words, *pages,
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

    def test_pages_and_file_agree(self):
        self.assertEqual(self.call("--check").returncode, 0)

    def test_a_figure_changed_by_hand_is_noticed(self):
        self.change(self.page, "| natural | 49.8 |", "| natural | 52.0 |")
        self.assert_noticed("palpation", "52.0", "49.8")

    def test_a_set_that_stands_on_two_pages_is_held_on_both(self):
        self.change(self.readme, "<!-- figures: exams -->\n| exam |", "<!-- figures: exams -->\n| study |")
        self.assert_noticed("README.md states of exams", "study")

    def test_a_line_that_is_missing_or_too_much_is_noticed(self):
        self.change(self.page, "| natural | 49.8 |", "| natural, no line |\n| natural | 49.8 |")
        self.assert_noticed("palpation", "no line")
        shutil.copy(SOURCE / "docs" / "accuracy.md", self.page)
        text = self.page.read_text()
        at = text.index("| natural | 49.8 |")
        self.page.write_text(text[:at] + text[text.index("\n", at) + 1:])
        self.assert_noticed("palpation", "natural")

    def test_a_value_that_changed_in_the_file_is_noticed(self):
        kept = json.loads(self.file.read_text())
        kept["palpation"]["values"]["default"]["pressed"]["output_l_per_min"] *= 1.1
        self.file.write_text(json.dumps(kept))
        self.assert_noticed("palpation")

    def test_parts_and_sets_are_the_same(self):
        self.change(self.page, "<!-- figures: palpation -->", "<!-- figures: palpitation -->")
        self.assert_noticed("no page has a part for the set palpation", "palpitation that no set makes")
        self.change(self.page, "<!-- figures: end -->", "")
        self.assert_noticed("not in pairs")

    def test_a_set_measured_anew_mends_its_part_and_leaves_the_rest(self):
        whole, kept = self.page.read_text(), json.loads(self.file.read_text())
        self.change(self.page, "| natural | 49.8 |", "| natural | 52.0 |")
        kept["palpation"]["values"]["default"]["pressed"]["edv_ml"] = 1
        self.file.write_text(json.dumps(kept))
        done = self.call("--only", "palpation")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.page.read_text(), whole)
        self.assertEqual(self.call("--check").returncode, 0)

    def test_what_is_not_made_yet_is_told(self):
        told = self.call("--help").stdout
        self.assertIn("does not make yet", told)
        self.assertIn("force_trace_bench", told)
        self.assertEqual(self.call("--only", "palpitation").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
