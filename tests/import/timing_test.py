"""Times of frames as scanners record them, bend them or leave them out: timing_test.py BEATLAS NAME"""
import numpy as np

from dicom_writers import classic_exam, decimal, save_all, set_number
from exam_object import BeatingObject, expect_object
from harness import case, imported, main, one_sentence, refused, run

# A periodic cubic through 25 frames misses a second harmonic of this object by less.
BLEND = 8.0


def truth25(**how):
    return BeatingObject(size=(24, 20, 5), phases=25, **how)


def written(folder, truth, **how):
    save_all(folder / "dicom", classic_exam(truth, **how), names="random")
    return folder / "dicom"


def read(folder, *options):
    return imported(folder / "study", folder / "dicom", *options)


def without(*names):
    def change(k, p, d):
        for name in names:
            if name in d:
                delattr(d, name)
    return change


@case
def each_slice_has_its_own_r_r(folder):
    truth = truth25()
    rr = [702, 864, 931, 779, 818]

    def own(k, p, d):
        d.NominalInterval, d.TriggerTime = rr[k], decimal(p * rr[k] / 25)
    written(folder, truth, change=own)
    exam = read(folder)
    expect_object(exam, truth, times=False, rr_error_s=1)
    assert abs(exam.stack.rr_s - np.mean(rr) / 1e3) < 1e-3, exam.stack.rr_s


@case
def slices_start_at_different_times(folder):
    truth = truth25()
    start = [0, 0.31, 0.77, 1.4, 0.5]  # in frames
    written(folder, truth, frames=lambda k: [((p + start[k]) / 25) % 1 for p in range(25)])
    expect_object(read(folder), truth, error=BLEND, times=False)


@case
def slices_have_different_numbers_of_frames(folder):
    truth = truth25()
    count = [25, 24, 26, 25, 23]
    written(folder, truth, frames=lambda k: [p / count[k] for p in range(count[k])])
    exam = read(folder)
    expect_object(exam, truth, error=BLEND, times=False)


@case
def prospective_gating_does_not_reach_the_end(folder):
    """22 frames over 85 % of the beat: exact within, and said."""
    truth = BeatingObject(size=(24, 20, 5), phases=22)
    written(folder, truth, frames=lambda k: [0.85 * p / 22 for p in range(22)])
    exam = read(folder)
    assert exam.stack.phases == 22
    assert abs(exam.stack.rr_s - 0.8437) < 0.6e-3, exam.stack.rr_s
    places = exam.stack.places()
    for p in range(18):
        off = np.abs(exam.stack.values[..., p] - truth.value(places, p / 22)).max()
        assert off < BLEND, (p, off)
    exam.expect_told(r"(8[0-9]|1[4-9]|2[0-1])(\.\d+)? ?%|prospective|do(es)? not reach")


@case
def frames_sent_twice(folder):
    """Every phase twice under a UID of its own: one of each is kept, and said."""
    truth = BeatingObject()
    images = classic_exam(truth) + classic_exam(truth)
    for n, d in enumerate(images):
        set_number(d, n + 1)
        d.InstanceNumber = n + 1
    save_all(folder / "dicom", images, names="random")
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_told(r"twice|copies|share|doubled|repeat|equal|same trigger")


@case
def trigger_times_in_seconds(folder):
    truth = BeatingObject()

    def seconds(k, p, d):
        d.TriggerTime = decimal(p * truth.rr_ms / truth.phases / 1e3)
    written(folder, truth, change=seconds)
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("trigger time")


@case
def trigger_times_in_microseconds(folder):
    truth = BeatingObject()

    def micro(k, p, d):
        d.TriggerTime = decimal(p * truth.rr_ms / truth.phases * 1e3)
    written(folder, truth, change=micro)
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("trigger time")


@case
def trigger_times_all_alike(folder):
    truth = BeatingObject()
    written(folder, truth, change=lambda k, p, d: setattr(d, "TriggerTime", "512"))
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("trigger times")


@case
def trigger_times_that_hold_scan_time(folder):
    truth = BeatingObject()

    def scan(k, p, d):
        d.TriggerTime = decimal(12345 + 9000 * k + 843.7 * p)
    written(folder, truth, change=scan)
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("trigger times")


@case
def trigger_times_missing(folder):
    truth = BeatingObject()
    written(folder, truth, change=without("TriggerTime"))
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("trigger time")


@case
def trigger_time_missing_in_one_image(folder):
    truth = BeatingObject()

    def one(k, p, d):
        if (k, p) == (2, 6):
            del d.TriggerTime
    written(folder, truth, change=one)
    expect_object(read(folder), truth)


@case
def nominal_interval_missing(folder):
    """Frames x step; the slices agree on it."""
    truth = BeatingObject()
    written(folder, truth, change=without("NominalInterval"))
    exam = read(folder)
    expect_object(exam, truth, rr_error_s=1e-4)
    exam.expect_told("R-R")


@case
def nominal_interval_without_sense(folder):
    for name, value in (("zero", 0), ("scan", 65535)):
        truth = BeatingObject()
        images = classic_exam(truth, change=lambda k, p, d: setattr(d, "NominalInterval", value))
        save_all(folder / name, images)
        expect_object(imported(folder / f"study-{name}", folder / name), truth)


@case
def heart_rate_tells_the_interval(folder):
    truth = BeatingObject(rr_ms=60000 / 71)

    def rate(k, p, d):
        del d.NominalInterval, d.TriggerTime
        d.HeartRate = 71
    written(folder, truth, change=rate)
    expect_object(read(folder), truth)


@case
def frame_time_tells_the_interval(folder):
    truth = BeatingObject()

    def step(k, p, d):
        del d.NominalInterval, d.TriggerTime
        d.FrameTime = "84.37"
    written(folder, truth, change=step)
    expect_object(read(folder), truth)


@case
def trigger_time_is_trusted_first(folder):
    """Temporal positions and instance numbers that contradict it lose."""
    truth = BeatingObject()

    def lie(k, p, d):
        d.TemporalPositionIdentifier, d.InstanceNumber = (3 * p) % 10 + 1, (7 * p) % 10 + 1
    written(folder, truth, change=lie)
    expect_object(read(folder), truth)


@case
def temporal_position_is_trusted_before_instance_number(folder):
    truth = BeatingObject()

    def lie(k, p, d):
        d.TriggerTime = "0"
        d.TemporalPositionIdentifier, d.InstanceNumber = p + 1, (7 * p) % 10 + 1
    written(folder, truth, change=lie)
    exam = read(folder)
    expect_object(exam, truth)
    exam.expect_warning("temporal ?position")


@case
def no_time_at_all_asks_for_the_interval(folder):
    truth = BeatingObject()
    written(folder, truth, change=without("TriggerTime", "NominalInterval", "CardiacNumberOfImages"))
    refused(folder, folder / "dicom", "R-R", "--rr")
    exam = read(folder, "--rr", "0.8437")
    expect_object(exam, truth, rr_error_s=1e-6)
    exam.expect_told("R-R interval was given|given.*R-R|--rr")


@case
def rr_replaces_what_is_recorded(folder):
    truth = BeatingObject()
    written(folder, truth, change=lambda k, p, d: setattr(d, "NominalInterval", 1500))
    exam = read(folder, "--rr", "0.8437")
    expect_object(exam, truth, rr_error_s=1e-3)
    exam.expect_told("given")
    # Frames that fill the cycle are shares of it, whatever its length.
    other = folder / "other"
    save_all(other, classic_exam(truth), names="random")
    for rr in (1.25, 0.5):
        exam = imported(folder / f"study{rr}", other, "--rr", rr)
        assert abs(exam.stack.rr_s - rr) < 1e-9
        truth.rr_ms = 1e3 * rr
        expect_object(exam, truth, rr_error_s=1e-3)


@case
def times_replace_what_is_recorded(folder):
    """Numbers or a file; bogus trigger times are of no account then."""
    truth = BeatingObject()
    written(folder, truth, change=lambda k, p, d: setattr(d, "TriggerTime", "512"))
    times = [f"{t:.6f}" for t in truth.times_s()]
    exam = imported(folder / "a", folder / "dicom", "--times", ",".join(times), "--rr", "0.8437")
    expect_object(exam, truth, rr_error_s=1e-6)
    exam.expect_told("times.*given|given.*times|--times")
    (folder / "times.txt").write_text("\n".join(times) + "\n")
    exam = imported(folder / "b", folder / "dicom", "--times", folder / "times.txt", "--rr", "0.8437")
    expect_object(exam, truth, rr_error_s=1e-6)


@case
def times_that_do_not_fit_are_refused(folder):
    truth = BeatingObject()
    written(folder, truth)
    refused(folder, folder / "dicom", r"\b3\b", r"\b10\b", options=("--times", "0,0.1,0.2"))
    ten = "0,0.1,0.05,0.3,0.4,0.5,0.6,0.7,0.75,0.8"
    for words in (("--times", ten), ("--times", "0,zero"), ("--times", folder / "none.txt"),
                  ("--rr", "0.01"), ("--rr", "30"), ("--rr", "soon")):
        done = run("import", folder / "dicom", "--study", folder / "s", *words)
        assert done.returncode in (2, 3) and done.err.strip(), (words, done.returncode, done.err)
        if done.returncode == 3:
            one_sentence(done)
        assert not (folder / "s" / "exam").exists()


@case
def phases_are_resampled_on_demand(folder):
    truth = truth25()
    written(folder, truth)
    for count in (20, 30):
        exam = imported(folder / f"study{count}", folder / "dicom", "--phases", count)
        expect_object(exam, truth, error=BLEND, times=False, phases=count)


@case
def two_phases_are_not_blended(folder):
    """End-diastole and end-systole only: each is one phase, as it is."""
    truth = BeatingObject(phases=2)
    written(folder, truth)
    expect_object(read(folder), truth, times=False)


if __name__ == "__main__":
    main()
