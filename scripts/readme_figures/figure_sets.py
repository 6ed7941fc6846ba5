"""The sets of figures, the cheapest first: how each is measured and how README.md states it."""
from dataclasses import dataclass
from typing import Callable

import bench_set
import exam_set
import palpation_set
import phantom_sets


@dataclass(frozen=True)
class Set:
    what: str
    cost: str  # on two idle cores
    measure: Callable  # Tools -> values
    text: Callable  # values -> the lines of README.md, without a newline at the end


SETS = {
    "palpation": Set("paper B's press: what a finger takes from the output", "a second",
                     palpation_set.measure, palpation_set.text),
    "bench": Set("ours beside paper A's method on the phantom small", "two minutes", bench_set.measure, bench_set.text),
    "phantoms": Set("Dice of the phantoms small and clinical", "three minutes", phantom_sets.measure_smaller,
                    phantom_sets.smaller_text),
    "exams": Set("real exams beside experts; needs them", "five minutes", exam_set.measure, exam_set.text),
}

# What README.md states beside these, and the commands that would make it.
LEFT = (
    "Dice and mm of the phantom adult (beatlas build, beatlas validate --truth)",
    "Dice of drawn hearts (scripts/score_draws)",
    "fields and surfaces from the truth's labels and coverage (beatlas phantom --coverage)",
    "the palpation set of the LV's force, still and at 2 Hz (force_trace_bench)",
    "growth of time and memory with phases and voxels (beatlas bench --scaling)",
    "bytes, knobs and docs/bench_small.svg of the whole sweep (beatlas bench)",
    "how far apart two readers are, and the outlines of SCD0000401 moved by a pixel",
)
