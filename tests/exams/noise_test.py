"""Frames of noise, flat and Rician, hold no heart: import takes them, segment refuses them with exit code 3."""
import pathlib
import subprocess
import sys
import tempfile

import nibabel
import numpy


def main(beatlas):
    random = numpy.random.default_rng(5)
    shape = (96, 96, 8, 6)
    normal = random.normal(size=(2, *shape))
    kinds = {"uniform": random.integers(0, 1000, shape), "rician": 300 * numpy.hypot(*normal),
             "still": numpy.repeat(300 * numpy.hypot(*normal)[..., :1], shape[3], axis=3)}
    wrong = []
    for kind, values in kinds.items():
        with tempfile.TemporaryDirectory() as folder:
            file, study = pathlib.Path(folder, "noise.nii.gz"), pathlib.Path(folder, "study")
            image = nibabel.Nifti1Image(values.astype(numpy.int16), numpy.diag([1.8, 1.8, 8, 1]))
            image.header.set_xyzt_units("mm", "sec")
            image.header["pixdim"][4] = 0.12
            image.to_filename(file)
            for words in (["import", str(file), "--study", str(study)], ["segment", "--study", str(study)]):
                done = subprocess.run([beatlas, *words], capture_output=True, text=True, check=False)
                if done.returncode:
                    break
            told = (done.stderr.strip().splitlines() or [""])[-1]
            print(f"{kind}: exit {done.returncode}: {told}")
            if done.returncode != 3 or "no heart found" not in told or (study / "segment" / "labels.nii.gz").exists():
                wrong.append(kind)
    return f"noise_test: not refused as no heart: {', '.join(wrong)}" if wrong else 0


sys.exit(main(sys.argv[1]))
