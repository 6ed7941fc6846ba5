"""The Debian package that cpack makes holds what is installed, in place, and its programs run from there:
package_test.py CPACK BUILD_FOLDER WORK_FOLDER PACKAGE

Skipped where dpkg-dev is not: it finds the libraries that the package depends on."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

CPACK, BUILD, WORK, PACKAGE = sys.argv[1], *map(pathlib.Path, sys.argv[2:5])
SKIPPED = 77  # the exit code that ctest takes for "skipped"
if not shutil.which("dpkg-shlibdeps"):
    print("skipped: there is no dpkg-shlibdeps; scripts/setup --everything installs it")
    sys.exit(SKIPPED)


def run(*words, **how):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **how)
    assert done.returncode == 0, f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


shutil.rmtree(WORK, ignore_errors=True)
WORK.mkdir(parents=True)
run(CPACK, "--config", BUILD / "CPackConfig.cmake", "-B", WORK / "made", cwd=BUILD)
made = list((WORK / "made").glob("*.deb"))
assert len(made) == 1 and re.fullmatch(r"beatlas_\d+\.\d+\.\d+_amd64\.deb", made[0].name), made

# What it depends on is what its programs load: libraries of the pipeline, and none of the build's own.
told = dict(re.findall(r"^ (\S+): (.*)$", run("dpkg-deb", "--info", made[0]), re.MULTILINE))
assert told["Package"] == "beatlas" and told["Architecture"] == "amd64", told
needed = {word.split()[0] for word in told["Depends"].split(", ")}
for library in ("libc6", "libzip", "libzstd", "libdraco", "libvtk9", "libopenvdb", "libopencv-core"):
    assert any(name.startswith(library) for name in needed), (library, needed)

run("dpkg-deb", "--extract", made[0], WORK / "root")
usr = WORK / "root" / "usr"
assert not [path for path in (WORK / "root").iterdir() if path.name != "usr"], "all is below /usr"
for file in ("share/beatlas/heart_prior.onnx", "share/beatlas/schemas/recipe.schema.json",
             "share/beatlas/samples/recipe.json", "share/beatlas/cohort/Snakefile", "share/doc/beatlas/LICENSE.md",
             "include/beatlas/runtime/c/beatlas.h"):
    assert (usr / file).is_file(), file
libraries = next(usr.glob("lib/**/libbeatlas.so")).parent
assert (libraries / "cmake" / "beatlas_runtime" / "beatlas_runtime-config.cmake").is_file()

environment = {**os.environ, "LD_LIBRARY_PATH": str(libraries)}
version = made[0].name.split("_")[1]
assert run(usr / "bin" / "beatlas", "--version", env=environment) == f"beatlas {version}\n"
assert "heart" in run(usr / "bin" / "beatlas", "info", PACKAGE, env=environment)
run(usr / "bin" / "beatlas-play", PACKAGE, "--headless", "--seconds", "0.1", env=environment)
