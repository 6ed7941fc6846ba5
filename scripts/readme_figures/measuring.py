"""Runs the programs that measure, once each: what several sets need is made for the first and taken up by the next."""
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Missing(Exception):
    """What a set needs is not on this machine, or a program ended badly."""


class Tools:
    def __init__(self, programs, folder, data, pictures):
        """@param pictures where those of README.md lie"""
        self.programs, self.folder = pathlib.Path(programs).resolve(), pathlib.Path(folder).resolve()
        self.data, self.pictures = data, pathlib.Path(pictures)
        self._told = []

    def told(self):
        """The commands since this was asked last, as a reader would type them."""
        told, self._told = self._told, []
        return told

    def note(self, command):
        """A command as a reader would type it, where it was run with words of this machine."""
        self._told.append(command)

    def run(self, *words, ends=(0,), told=True):
        """stdout. The first word is a program of the build or a script of this tree."""
        words = [str(word) for word in words]
        if told:
            self._told.append(shlex.join(words))
        program = ROOT / words[0] if words[0].startswith("scripts/") else self.programs / words[0]
        if not program.exists():
            raise Missing(f"there is no {program}; build it first")
        environment = {**os.environ, "PATH": f"{self.programs}{os.pathsep}{os.environ.get('PATH', '')}"}
        done = subprocess.run([str(program), *words[1:]], capture_output=True, text=True, errors="replace",
                              cwd=self.folder, env=environment)
        if done.returncode not in ends:
            last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
            raise Missing(f"'{shlex.join(words)}' ended with {done.returncode}: {last}")
        return done.stdout

    def _kept(self, name, *commands):
        """Runs commands unless an earlier set did; the commands are told either way."""
        done = self.folder / f"{name}.done"
        for words in commands:
            if done.exists():
                self._told.append(shlex.join(map(str, words)))
            else:
                print(f"figures:   {shlex.join(map(str, words))}", file=sys.stderr, flush=True)
                self.run(*words)
        done.touch()

    def phantom(self, preset, alone):
        """(folder of the phantom, study, package), their names within `folder`. @param alone without atria,
        aortic root, papillary muscles and fat"""
        name = f"{preset}_alone" if alone else preset
        self._kept(name, ["beatlas", "phantom", "-o", name, "--preset", preset] + (["--without", "all"] * alone),
                   ["beatlas", "build", f"{name}/dicom", "-o", f"{name}.beatlas", "--study", f"{name}.study"])
        return self.folder / name, self.folder / f"{name}.study", self.folder / f"{name}.beatlas"

    def validated(self, preset, alone):
        """What `beatlas validate` tells of such a phantom; 4 is 'measured, and not good enough'."""
        phantom, _, package = self.phantom(preset, alone)
        return json.loads(self.run("beatlas", "validate", package.name, "--truth", phantom.name, "--json",
                                   ends=(0, 4)))

    def given(self, coverage):
        """What `beatlas validate` tells of the phantom small, ventricles alone, built from the truth's labels.
        @param coverage and from the shares of voxels"""
        name = "given_coverage" if coverage else "given_labels"
        self._kept("given", ["beatlas", "phantom", "-o", "given", "--preset", "small", "--without", "all", "--coverage"])
        self._kept(name, ["beatlas", "build", "given/dicom", "-o", f"{name}.beatlas", "--labels",
                          "given/truth_labels.nii.gz"] + ["--coverage", "given/truth_coverage"] * coverage)
        return json.loads(self.run("beatlas", "validate", f"{name}.beatlas", "--truth", "given", "--json", ends=(0, 4)))
