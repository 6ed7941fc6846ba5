"""Paper B's press on its ventricle, at both readings of its 74 %."""
import json

PRESETS = {"": "S_c = 14.1 cm²", "by_74_percent": "S_c = 41.3 cm²"}


def measure(tools):
    values = {}
    for preset in PRESETS:
        words = ["beatlas-play", "--headless", "--scene", "palpation", "--press", f"press_{preset}", "--json"]
        told = json.loads(tools.run(*words, *(["--preset", preset] if preset else [])))
        values[preset or "default"] = {"natural": _beat(told["natural"]), "pressed": _beat(told["pressed"])}
    return values


def _beat(beat):
    return {key: beat[key] for key in ("edv_ml", "esv_ml", "output_l_per_min", "aortic_mean_mmhg")}


def _row(name, beat, natural):
    share = 100 * beat["output_l_per_min"] / natural["output_l_per_min"]
    return (f"| {name} | {beat['edv_ml']:.1f} | {beat['esv_ml']:.1f} | {beat['output_l_per_min']:.2f} | {share:.0f} | "
            f"{beat['aortic_mean_mmhg']:.0f} |")


def text(values):
    default, other = values["default"], values["by_74_percent"]
    natural = default["natural"]
    return "\n".join([
        "| paper B's ventricle | EDV ml | ESV ml | output l/min | of natural % | mean aortic mmHg |", "|---|---|---|---|---|---|",
        _row("natural", natural, natural),
        _row(f"pressed 8 mm, {PRESETS['']}", default["pressed"], natural),
        _row(f"pressed 8 mm, {PRESETS['by_74_percent']}", other["pressed"], natural)])
