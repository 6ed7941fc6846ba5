"""The laws can be broken: each is fed a house that keeps it and one that breaks it."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import built
import counts
import documents
import rules
import sources

KEEPS = {
    "runtime/base/README.md": "What every room speaks: errors, frames of reference, units, hashes.",
    "runtime/base/error.h": "#pragma once\n#include <string>\n",
    "runtime/base/error.cpp": '#include "runtime/base/error.h"\n\n#include <Eigen/Core>\n',
    "runtime/atlas/README.md": "The package: its format, what the manifest says, and its reader.",
    "runtime/atlas/reader.h": '#pragma once\n/// Never #include <vtkImageData.h> or CGAL::X.\n'
                              '#include "runtime/base/error.h"\n',
    "runtime/atlas/reader.cpp": '#include "runtime/atlas/reader.h"\n#include <draco/mesh/mesh.h>\n',
    "pipeline/mesh/README.md": "Distance and motion to surfaces of the cycle, by CGAL, OpenMesh.",
    "pipeline/mesh/remesh.h": "#pragma once\n#include <CGAL/Surface_mesh.h>\n",
    "pipeline/mesh/remesh.cpp": '#include "pipeline/mesh/remesh.h"\n'
                                '#include "runtime/atlas/reader.h"\n',
}


class House(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name).resolve() / "house"
        self.system = self.root.parent / "usr" / "include"

    def write(self, path, text, root=None):
        file = (root or self.root) / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def broken(self, law):
        return list(law(self.root))

    def assert_breaks(self, law, path, text, *words):
        self.assertEqual(self.broken(law), [], "the house kept the law before")
        self.write(path, text)
        found = self.broken(law)
        self.assertEqual(len(found), 1, found)
        for word in (path, *words):
            self.assertIn(word, found[0])


class TextLaws(House):
    def setUp(self):
        super().setUp()
        for path, text in KEEPS.items():
            self.write(path, text)

    def test_a_house_that_keeps_the_law_is_not_accused(self):
        for law in (sources.check_arrows, sources.check_libraries, sources.check_public_headers,
                    sources.check_order, documents.check_documents, sources.check_scratch):
            self.assertEqual(self.broken(law), [])

    def test_runtime_that_includes_pipeline_is_found(self):
        self.assert_breaks(sources.check_arrows, "runtime/atlas/writer.cpp",
                           'int a;\n  #  include "pipeline/mesh/mesh.h"\n', ":2", "pipeline/mesh")

    def test_angle_brackets_hide_no_arrow(self):
        self.write("runtime/base/x.cpp", "#include <runtime/atlas/reader.h>\n")
        self.assertIn("may not include", self.broken(sources.check_arrows)[0])

    def test_a_room_that_reaches_up_is_found(self):
        self.assert_breaks(sources.check_arrows, "runtime/base/x.cpp",
                           '#include "runtime/atlas/reader.h"\n', "runtime/atlas")

    def test_an_include_not_from_the_root_is_found(self):
        self.assert_breaks(sources.check_arrows, "runtime/atlas/x.cpp",
                           '#include "reader.h"\n', "root")

    def test_a_room_without_an_entry_is_found(self):
        self.write("pipeline/cellar/x.cpp", "int x;\n")
        self.assertIn("pipeline/cellar", self.broken(sources.check_arrows)[0])

    def test_each_library_outside_its_room_is_found(self):
        examples = {"VTK": "vtkImageData.h", "OpenCV": "opencv2/core.hpp",
                    "OpenVDB": "openvdb/openvdb.h", "CGAL": "CGAL/Surface_mesh.h",
                    "OpenMesh": "OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh",
                    "Draco": "draco/mesh/mesh.h", "niftilib": "nifti/nifti1_io.h",
                    "GDCM": "gdcmTrace.h", "Qt": "QWidget", "OpenCV dnn": "opencv2/dnn.hpp"}
        self.assertEqual(set(examples), set(rules.LIBRARIES))
        for name, header in examples.items():
            with self.subTest(name):
                self.write("runtime/base/x.cpp", f"#include <{header}>\n")
                found = self.broken(sources.check_libraries)
                self.assertEqual(len(found), 1, found)
                self.assertIn(f"{name} ({header})", found[0])

    def use_mesh_from_outside(self):
        self.write("pipeline/mesh/mesh.h", "#pragma once\n")
        self.write("pipeline/cli/main.cpp", '#include "pipeline/mesh/mesh.h"\n')

    def test_a_public_header_that_includes_a_library_is_found(self):
        self.use_mesh_from_outside()
        self.assert_breaks(sources.check_public_headers, "pipeline/mesh/mesh.h",
                           "#pragma once\n#include <CGAL/Surface_mesh.h>\n", "CGAL")

    def test_a_public_header_that_reads_a_private_one_with_a_library_is_found(self):
        self.use_mesh_from_outside()
        self.write("pipeline/mesh/mesh.h", '#include "pipeline/mesh/remesh.h"\n')
        self.assertIn("pipeline/mesh/remesh.h", self.broken(sources.check_public_headers)[0])

    def test_a_public_header_that_only_names_a_librarys_type_is_found(self):
        self.use_mesh_from_outside()
        self.assert_breaks(sources.check_public_headers, "pipeline/mesh/mesh.h",
                           "#pragma once\nclass vtkPolyData;\n", ":2", "vtkPolyData")

    def test_every_header_of_the_runtime_is_public(self):
        self.assert_breaks(sources.check_public_headers, "runtime/atlas/mesh_decoder.h",
                           "#pragma once\n#include <draco/mesh/mesh.h>\n", "Draco")

    def test_a_comment_is_no_finding(self):
        self.write("runtime/base/x.h", "/*\n#include <CGAL/x.h>\n*/ // cv::Mat\n/// vtkX\n")
        self.assertEqual(self.broken(sources.check_public_headers), [])

    def test_a_slash_or_quote_in_a_literal_hides_nothing_after_it(self):
        self.write("runtime/base/x.h",
                   """const char* u = "http://x"; char c = '"'; char d = '/'; cv::Mat m;\n""")
        self.assertEqual(len(self.broken(sources.check_public_headers)), 1)

    def test_a_room_without_a_readme_is_found(self):
        (self.root / "runtime/atlas/README.md").unlink()
        self.assertIn("runtime/atlas", self.broken(sources.check_order)[0])

    def test_a_document_that_names_what_there_is_not_is_found(self):
        self.write("tests/unit/x_test.cpp", "TEST(Ball, IsRound) {}\n")
        self.write("docs/kept.md", "`Ball.IsRound` in `runtime/base/error.h`, `1.5 mm`, `Ball`\n")
        self.assert_breaks(documents.check_documents, "docs/page.md",
                           "\n`runtime/base/gone.h`\n", ":2", "gone.h")
        self.write("docs/page.md", "`Ball.IsSquare`\n")
        self.assertIn("Ball.IsSquare", self.broken(documents.check_documents)[0])
        self.write("docs/page.md", "`Cube.IsRound`\n")
        self.assertIn("Cube.IsRound", self.broken(documents.check_documents)[0])

    def test_readmes_are_held_as_well_as_pages(self):
        self.write("runtime/base/README.md", KEEPS["runtime/base/README.md"] + " `error.h`\n")
        self.write("schemas/CHANGES.md", "`runtime/base/of_before.h` went\n")
        self.assert_breaks(documents.check_documents, "runtime/base/README.md",
                           "`error.h` and\n`old_error.h`\n", ":2", "old_error.h")
        self.write("runtime/base/README.md", KEEPS["runtime/base/README.md"])
        self.write("README.md", "![A heart](docs/heart.png)\n")
        self.assertIn("docs/heart.png", self.broken(documents.check_documents)[0])

    def test_a_command_that_there_is_not_is_found(self):
        self.write("pipeline/cli/README.md", "The words and the console of the one program there is.")
        self.write("pipeline/cli/main.cpp",
                   'app.add_subcommand("build", "Build it with --force");\n'
                   'app.add_option("-o,--output", file);  // "--gone"\n')
        self.write("scripts/score", "#!/bin/sh\n# --only NAME\n")
        self.write("docs/kept.md", "`beatlas build --output` or `--output`, `scripts/score --only x`\n"
                                   "```sh\nbeatlas build exam -o x  # --anything\nother --thing | beatlas build\n```\n")
        for text, said in (("`beatlas bild exam`\n", "no command bild"),
                           ("`beatlas build --gone`\n", "no option --gone"),
                           ("`--force`\n", "no program of ours has an option --force"),
                           ("`scripts/score --all`\n", "no option --all"),
                           ("```sh\nbeatlas build exam \\\n  --gone\n```\n", ":2: beatlas has no option --gone"),
                           ("```sh\nother && beatlas build --gone\n```\n", "--gone"),
                           ("```sh\nscripts/score\n```\n", "not executable"),
                           ("```sh\nscripts/gone\n```\n", "there is no scripts/gone")):
            with self.subTest(text):
                self.write("docs/page.md", "nothing\n")
                self.assert_breaks(documents.check_documents, "docs/page.md", text, said)

    def test_what_a_search_for_a_mistake_left_is_found(self):
        self.write("runtime/app/main.cpp", 'std::fprintf(stderr, "x");  // getenv\n')
        self.write("pipeline/mesh/says.cpp", 'throw Error("no printf");  // in "/tmp/x"\n')
        self.assert_breaks(sources.check_scratch, "pipeline/mesh/remesh.cpp",
                           'int x;\nif (getenv("X")) y();\n', ":2", "getenv")
        self.write("pipeline/mesh/remesh.cpp", 'open("/tmp/x");\n')
        self.assertIn("/tmp/", self.broken(sources.check_scratch)[0])

    def test_a_room_with_too_much_in_it_is_found(self):
        inner = "  if (x) {\n    y({1, 2});\n  }\n"
        self.write("pipeline/mesh/long.cpp", "namespace beatlas {\n\n/// {\nvoid f(int x,\n       int y) {\n" +
                   inner * 40 + "}\n\nstruct S {\n  int x = {};\n  int g() const { return x; }\n};\n\n}\n")
        lengths = dict(counts.functions((self.root / "pipeline/mesh/long.cpp").read_text()))
        self.assertEqual(lengths, {4: 123, 130: 1})
        self.assertIn("longest function: 123", self.broken(counts.check_counts)[0])
        self.assertEqual(list(counts.functions("template <class T, class... Ts>\nvoid f(T x = {}) {\n  x();\n}\n")),
                         [(1, 4)])
        self.write("pipeline/mesh/long.cpp", "constexpr double kA = 1;\nconstexpr int kB{2};\n" * 100)
        self.assertIn("constants: 200", self.broken(counts.check_counts)[0])
        self.write("pipeline/mesh/long.cpp", "int x;\n")
        for here, there in ("ab", "bc", "cd", "da"):
            self.write(f"pipeline/mesh/{here}.h", f'#include "pipeline/mesh/{there}.h"\n')
        self.assertIn("knot: 4", self.broken(counts.check_counts)[0])

    def test_a_test_that_is_named_otherwise_is_found(self):
        self.write("tests/unit/x_test.cpp", "TEST(Ball, IsRound) {}\n")
        self.assert_breaks(sources.check_test_names, "tests/unit/y_test.cpp", "\nTEST(Ball, is_round) {}\n", ":2",
                           "is_round")

    def test_a_file_that_is_too_long_is_found(self):
        self.assert_breaks(sources.check_order, "tests/unit/long_test.cpp",
                           "int x;\n" * (rules.MAX_LINES + 1), str(rules.MAX_LINES + 1))


class BuiltLaws(House):
    """On real objects and libraries: the laws read what this compiler and loader report."""

    def compile(self):
        commands, ninja = [], [
            "rule cc", f"  command = c++ -MD -MF $out.d -I{self.root} -I{self.system} "
                       "-c $in -o $out", "  deps = gcc", "  depfile = $out.d"]
        build = self.root / "build"
        build.mkdir(exist_ok=True)
        for source in sorted(self.root.rglob("*.cpp")):
            output = f"{source.stem}.o"
            ninja.append(f"build {output}: cc {source}")
            commands.append({"directory": str(build), "file": str(source),
                             "command": f"c++ -o {output} -c {source}"})
        (build / "build.ninja").write_text("\n".join(ninja) + "\n", encoding="utf-8")
        (build / "compile_commands.json").write_text(json.dumps(commands), encoding="utf-8")
        subprocess.run(["ninja", "-C", build], check=True, capture_output=True)
        return build

    def test_a_header_read_through_others_is_found(self):
        for header, name in (("CGAL/version.h", "CGAL"), ("vtk-9.1/vtkObject.h", "VTK"),
                             ("opencv4/core.hpp", "OpenCV"), ("openvdb/tree.h", "OpenVDB"),
                             ("opencv4/opencv2/dnn/dnn.hpp", "OpenCV dnn"),
                             ("OpenMesh/mesh.hh", "OpenMesh"), ("string_view.h", None)):
            with self.subTest(header):
                self.write(header, "", self.system)
                self.write("harmless.h", f"#include <{header}>\n", self.system)
                self.write("runtime/base/error.cpp", "#include <harmless.h>\n")
                build = self.compile()
                found = list(built.check_compiled(self.root, build))
                self.assertEqual(len(found), 0 if name is None else 1, found)
                if name:
                    self.assertIn("runtime/base/error.cpp: the compiler read", found[0])
                    self.assertIn(f"of {name}", found[0])

    def test_a_pipeline_header_read_through_others_is_found(self):
        self.write("pipeline/core/grid.h", "")
        self.write("runtime/atlas/reader.h", '#include "pipeline/core/grid.h"\n')
        self.write("runtime/field/query.cpp", '#include "runtime/atlas/reader.h"\n')
        found = list(built.check_compiled(self.root, self.compile()))
        self.assertEqual(len(found), 1, found)
        self.assertIn("runtime/field cannot reach pipeline/core", found[0])

    def test_an_object_that_was_not_compiled_is_found(self):
        self.write("runtime/base/error.cpp", "int x;\n")
        build = self.compile()
        (build / ".ninja_deps").unlink()
        self.assertIn("build everything first", next(built.check_compiled(self.root, build)))

    def test_a_build_without_runtime_is_no_proof(self):
        self.assertIn("nothing could be checked", next(built.check_seen({}, {}, self.root)))

    def test_a_library_loaded_through_another_is_found(self):
        def link(name, *arguments):
            target = self.root / name
            subprocess.run(["c++", "-x", "c++", "-o", target, self.root / "empty.cpp",
                            "-Wl,--no-as-needed", f"-Wl,-rpath,{self.root}", f"-L{self.root}",
                            *arguments], check=True)
            return str(target)

        self.write("empty.cpp", "int main() {}\n")
        link("libCGAL.so.13", "-shared", "-fPIC")
        link("libbetween.so", "-shared", "-fPIC", "-l:libCGAL.so.13")
        guilty = link("guilty", "-lbetween")
        innocent = link("innocent")
        self.assertEqual(list(built.check_programs([innocent])), [])
        found = list(built.check_programs([innocent, guilty]))
        self.assertEqual(found, [f"{guilty}: loads libCGAL.so.13 of CGAL"])
        (self.root / "libCGAL.so.13").unlink()
        self.assertIn("not installed", "".join(built.check_programs([guilty])))

    def test_a_program_that_cannot_be_read_is_found(self):
        self.assertEqual(len(list(built.check_programs([str(self.root / "gone")]))), 1)


if __name__ == "__main__":
    unittest.main()
