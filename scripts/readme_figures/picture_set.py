"""The pictures of the heart at the head of README.md: of the phantom small, whole, as its images were read."""
import shutil

SIZE = "640x480"
PICTURES = {"heart_surfaces.png": ("--phase", "es"), "heart_volume.png": ("--phase", "es", "--volume", "blood"),
            "heart_cut.png": ("--phase", "es", "--volume", "muscle", "--cut", "short-axis", "--view", "short-axis"),
            "heart_pressed.png": ("--press-mm", "8", "--plots", "--size", "960x600"),
            "heart_segments.png": ("--phase", "es", "--colour", "segments")}


def measure(tools):
    _, _, package = tools.phantom("small", False)
    for name, words in PICTURES.items():
        size = () if "--size" in words else ("--size", SIZE)
        tools.run("beatlas-play", package.name, "--screenshot", name, *words, *size)
        shutil.copyfile(tools.folder / name, tools.pictures / name)
    return {name: " ".join(words) for name, words in PICTURES.items()}


def text(values):
    return ("The phantom `small` with all its parts, built from its images, in `beatlas-play heart.beatlas --screenshot "
            "FILE`:\n" + "; ".join(f"`{words}`" for words in values.values()) + ".")
