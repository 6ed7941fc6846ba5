"""Pictures of a patient's heart, built from a real exam that may be shown: surfaces and blood, never its images."""
import shutil

from measuring import ROOT, Missing

EXAM = "sunnybrook/SCD0000101"
SIZE = "640x480"
PICTURES = {"patient_ed.png": ("--phase", "ed"), "patient_es.png": ("--phase", "es"),
            "patient_volume.png": ("--phase", "ed", "--volume", "blood"),
            "patient_cut.png": ("--phase", "ed", "--cut", "four-chamber", "--view", "four-chamber", "--no-image")}


def measure(tools):
    exam = (tools.data or ROOT.parent / "shared" / "data") / EXAM
    if not exam.is_dir():
        raise Missing(f"there is no {exam}")
    tools.run("beatlas", "build", exam, "-o", "patient.beatlas", told=False)
    tools.note("beatlas build SCD0000101 -o patient.beatlas")
    for name, words in PICTURES.items():
        tools.run("beatlas-play", "patient.beatlas", "--screenshot", name, *words, "--size", SIZE)
        shutil.copyfile(tools.folder / name, tools.pictures / name)
    return {name: " ".join(words) for name, words in PICTURES.items()}


def text(values):
    return ("A failing heart at end-diastole and end-systole, and its blood as a volume and a cut, built from the exam SCD0000101 of the "
            "Sunnybrook Cardiac Data (CC0) with no option: `beatlas-play PACKAGE --screenshot FILE` with "
            + ", ".join(f"`{words}`" for words in values.values()) + ".")
