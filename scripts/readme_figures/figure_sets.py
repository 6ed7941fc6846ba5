"""The sets of figures, the cheapest first: how each is measured and how a page states it."""
from dataclasses import dataclass
from typing import Callable

import bench_set
import draw_set
import exam_set
import palpation_set
import patient_set
import phantom_sets
import picture_set


@dataclass(frozen=True)
class Set:
    what: str
    cost: str  # on two idle cores
    measure: Callable  # Tools -> values
    text: Callable  # values -> the lines of a page, without a newline at the end


SETS = {
    "palpation": Set("paper B's press: what a finger takes from the output", "a second",
                     palpation_set.measure, palpation_set.text),
    "bench": Set("ours beside paper A's method on the phantom small", "two minutes", bench_set.measure, bench_set.text),
    "phantoms": Set("Dice of the phantoms small and clinical", "three minutes", phantom_sets.measure_smaller,
                    phantom_sets.smaller_text),
    "pictures": Set("the heart's pictures", "seconds after phantoms", picture_set.measure,
                    picture_set.text),
    "patient": Set("pictures of a patient's heart; needs a real exam", "two minutes", patient_set.measure,
                   patient_set.text),
    "given": Set("mm of small from the truth's labels and coverage", "three minutes", phantom_sets.measure_given,
                 phantom_sets.given_text),
    "exams": Set("real exams beside experts; needs them", "five minutes", exam_set.measure, exam_set.text),
    "draws": Set("drawn hearts", "six minutes", draw_set.measure, draw_set.text),
    "adult": Set("Dice and mm of the phantom adult", "ten minutes", phantom_sets.measure_adult,
                 phantom_sets.adult_text),
}

# What the pages state beside these, and the commands that would make it.
LEFT = (
    "surfaces from the truth's labels and coverage, and adult's fields from them (beatlas phantom --coverage)",
    "docs/report.png, the report of the phantom hard, which is of an earlier tree (a browser)",
    "the force of a finger on the LV, still and at 2 Hz, and docs/force_traces.svg (force_trace_bench)",
    "growth of time and memory with phases and voxels (beatlas bench --scaling)",
    "bytes, knobs and docs/bench_small.svg of the whole sweep (beatlas bench)",
    "how far apart two readers are, and the outlines of SCD0000401 moved by a pixel",
)
