"""scripts/train on slices of discs: train_test.py SOURCE_FOLDER parts|run|refuses

parts    the loss, the average, the variations and the ring against what they should give
run      20 steps in two goes, a new plan from them, ONNX that OpenCV reads
refuses  bad input: one sentence, exit 3, nothing written
"""
import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

SOURCE, NAME = pathlib.Path(sys.argv[1]), sys.argv[2]
SCRIPTS = SOURCE / "scripts" / "train"
DISCS = SOURCE / "tests" / "train" / "circles.py"
SKIPPED = 77
try:
    import cv2
    import numpy
    import torch
except ImportError as error:
    print(f"skipped: no Python module {error.name}; scripts/setup --train installs it")
    sys.exit(SKIPPED)
sys.path.insert(0, str(SCRIPTS))
import checkpoint  # noqa: E402
import draws  # noqa: E402
import losses  # noqa: E402
import model  # noqa: E402
import train  # noqa: E402
import weights  # noqa: E402

torch.set_num_threads(1)
UNKNOWN = 255


def run(script: str, *words) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-B", str(SCRIPTS / script), *map(str, words)],
                          capture_output=True, text=True)


def trained(out: pathlib.Path, steps: int, *words) -> str:
    done = run("train.py", "--draws", DISCS, "--out", out, "--steps", steps, "--batch", 4, "--pool", 32,
               "--held-out", 4, *words)
    assert done.returncode == 0, done.stderr
    return done.stdout


def loss_is_that_of_known_pixels() -> None:
    random = numpy.random.default_rng(1)
    logits = random.normal(0, 2, (2, 8, 5, 6))
    labels = random.integers(0, 8, (2, 5, 6))
    labels[0, :2] = UNKNOWN
    chance = numpy.exp(logits) / numpy.exp(logits).sum(1, keepdims=True)
    entropy = weight = 0.0
    both, sizes = numpy.zeros(8), numpy.zeros(8)
    for n, row, column in numpy.ndindex(labels.shape):
        name = labels[n, row, column]
        if name != UNKNOWN:
            entropy -= losses.CLASS_WEIGHTS[name] * numpy.log(chance[n, name, row, column])
            weight += losses.CLASS_WEIGHTS[name]
            both[name] += chance[n, name, row, column]
            sizes += chance[n, :, row, column]
            sizes[name] += 1
    dice = ((2 * both + losses.DICE_PIXELS) / (sizes + losses.DICE_PIXELS))[1:].mean()
    found = losses.loss(torch.tensor(logits), torch.tensor(labels))
    assert abs(float(found) - (entropy / weight + 0.7 * (1 - dice))) < 1e-5

    nothing = losses.loss(torch.tensor(logits, requires_grad=True), torch.full((2, 5, 6), UNKNOWN))
    assert float(nothing) == 0

    right = torch.nn.functional.one_hot(torch.tensor(labels % 8), 8).permute(0, 3, 1, 2).float()
    count = losses.DiceCount()
    count.add(right, torch.tensor(labels))
    assert set(count.dice().values()) == {1.0}


def average_holds_the_statistics_of_batch_norm() -> None:
    network = model.HeartNet()
    average = train.Average(network.state_dict())
    names = ("down.0.1.running_mean", "down.0.0.weight")
    wanted = {name: network.state_dict()[name].clone() for name in names}
    for step in range(1, 4):
        network.train()(torch.rand(2, 5, 32, 32))
        for weights in network.parameters():
            weights.data += 0.1
        average.add(network.state_dict(), step)
        for name in names:
            share = max(1 / train.AVERAGE_STEPS, 9 / (10 + step))
            wanted[name] += share * (network.state_dict()[name] - wanted[name])
    for name in names:
        assert torch.allclose(average.state[name], wanted[name], atol=1e-6), name
    assert int(average.state["down.0.1.num_batches_tracked"]) == 3


def rate_rises_and_falls() -> None:
    rates = [train.rate(n / 1000) for n in range(1001)]
    assert max(rates) == 1 and rates.index(1.0) == round(1000 * train.WARM_UP)
    assert abs(rates[-1] - train.LAST_RATE) < 1e-9 and train.rate(1.5) <= rates[-1] + 1e-9
    assert all(later < earlier for earlier, later in zip(rates[20:], rates[21:]))


def variations_leave_the_label_true() -> None:
    records = draws.read_all(DISCS, 0, 24)
    kept = records.copy()
    images, labels = draws.vary(records, numpy.random.default_rng(3))
    again, _ = draws.vary(records, numpy.random.default_rng(3))
    assert torch.equal(images, again) and (records == kept).all()
    assert images.shape == (24, 5, draws.CROP, draws.CROP) and 0 <= images.min() and images.max() <= draws.LARGEST
    parts, compared = set(), 0
    for image, label, record in zip(images, labels, records):
        turned = [turn for upright in (record[draws.LABEL], record[draws.LABEL][:, ::-1])
                  for turn in (numpy.rot90(upright, n) for n in range(4))]
        found = [(n, row, column) for n, whole in enumerate(turned)
                 for row in range(0, draws.SIZE - draws.CROP + 1)
                 for column in range(0, draws.SIZE - draws.CROP + 1)
                 if whole[row, column] == label[0, 0] and numpy.array_equal(
                     whole[row:row + draws.CROP, column:column + draws.CROP], label)]
        assert found, "the label is a part of the record's, turned"
        parts.add(found[0])
        # Blood is brighter than muscle at the places where the label now has them.
        if (label == 3).any() and (label == 2).any():
            compared += 1
            assert image[draws.FRAME][label == 3].mean() > image[draws.FRAME][label == 2].mean() + 0.1
    assert len(parts) > 12 and compared > 12

    many = numpy.concatenate([records] * 40)
    many[:, draws.BELOW] = many[:, draws.ABOVE] = 100
    many[::2, draws.BELOW] = 0
    images, _ = draws.vary(many, numpy.random.default_rng(4))
    unknown = images.amax((2, 3)) == 0
    half = (unknown[::2, draws.BELOW] | unknown[::2, draws.ABOVE]).float().mean()
    assert half == 1, "a neighbour that is not known stays so on the side to which it went"
    shares = unknown[1::2].float().mean(0)
    assert shares[draws.FRAME] == 0 and abs(shares[draws.BELOW] - 0.145) < 0.06
    assert abs(unknown[:, draws.DEVIATION].float().mean() - 0.20) < 0.06


def ring_waits_for_the_trainer() -> None:
    ring = draws.Ring(DISCS, 100, capacity=8, reuse=2)
    try:
        ring.wait(8)
        random = numpy.random.default_rng(1)
        seen = {record.tobytes() for record in ring.take(64, random)}
        wanted = draws.read_all(DISCS, 100, 60)
        assert seen <= {record.tobytes() for record in wanted}
        for _ in range(200):
            ring.take(1, random)
            assert ring.written <= 8 + ring.used / 2 + 1
        ring.wait(1)
        assert ring.next_seed() == 100 + ring.written
    finally:
        ring.close()


def learns() -> None:
    args = argparse.Namespace(seed=1, first=0, resume=None, lr=2e-3, steps=1000, minutes=None)
    records = draws.read_all(DISCS, 0, 2)
    runs = [train.Run(args, records) for _ in range(2)]
    assert model.parameters(runs[0].model) <= model.MAX_PARAMETERS
    values = [runs[0].train(records, False) for _ in range(18)]
    assert values[-1] < 0.9 * values[0], values
    assert runs[1].train(records, False) == values[0], "the seed decides"


def parts(_: pathlib.Path) -> None:
    loss_is_that_of_known_pixels()
    average_holds_the_statistics_of_batch_norm()
    rate_rises_and_falls()
    variations_leave_the_label_true()
    ring_waits_for_the_trainer()
    learns()


def optimiser_steps(run_: dict) -> int:
    return int(run_["optimiser"][0]["step"])


def goes_on_and_exports(folder: pathlib.Path) -> None:
    out = folder / "run"
    file = out / "checkpoint.pt"
    trained(out, 12)
    first = checkpoint.load(file)
    assert first["step"] == 12 and first["samples"] == 48 and first["next_seed"] >= 32
    # The plan of 12 steps made longer goes on as one plan; without the optimiser a new one begins.
    trained(out, 20, "--resume", file, "--same-optimiser")
    second = checkpoint.load(file)
    assert second["step"] == second["plan_step"] == optimiser_steps(second) == 20
    assert second["next_seed"] > first["next_seed"]
    said = trained(folder / "new", 2, "--resume", file)
    third = checkpoint.load(folder / "new" / "checkpoint.pt")
    assert third["step"] == 22 and optimiser_steps(third) == third["plan_step"] == 2
    assert "from step 20" in said and "held-out Dice: background" in said
    assert said.splitlines()[-1] in (folder / "new" / "log.txt").read_text()
    assert not list(folder.glob("**/.partial-*"))

    onnx = folder / "heart.onnx"
    done = run("export.py", file, "-o", onnx)
    assert done.returncode == 0, done.stderr
    content = onnx.read_bytes()
    told = json.loads(onnx.with_suffix(".json").read_text())
    assert len(content) <= 3_000_000 and told["sha256"] == hashlib.sha256(content).hexdigest()
    assert told["sha256"] in done.stdout
    assert told["format"] == 1 and told["multiple"] == 16 and told["card"]["samples"] == 80
    assert told["channels"] == ["frame", "below", "above", "mean", "deviation"]
    assert told["outputs"][1:4] == ["rv_blood", "lv_myocardium", "lv_blood"] and len(told["outputs"]) == 8
    network = checkpoint.network(second, "average").eval()
    net = cv2.dnn.readNetFromONNX(str(onnx))
    for size in ((112, 160), (208, 96), (112, 160)):
        slices = numpy.random.default_rng(5).uniform(0, 1.2, (1, 5, *size)).astype(numpy.float32)
        net.setInput(slices)
        with torch.no_grad():
            wanted = network(torch.from_numpy(slices)).numpy()
        assert abs(net.forward() - wanted).max() < 1e-4 * max(1, abs(wanted).max())
    goes_on_from_onnx(folder, onnx)


def goes_on_from_onnx(folder: pathlib.Path, onnx: pathlib.Path) -> None:
    """Evaluated it is the network that was exported; it learns, and its samples are counted on."""
    slices = draws.planes(draws.read_all(DISCS, 7, 4))[0]
    network = weights.exported(onnx, slices).eval()
    net = cv2.dnn.readNetFromONNX(str(onnx))
    net.setInput(slices.numpy())
    wanted = net.forward()
    with torch.no_grad():
        assert abs(network(slices).numpy() - wanted).max() < 1e-4 * max(1, abs(wanted).max())
    trained(folder / "from_onnx", 3, "--resume", onnx)
    gone_on = checkpoint.load(folder / "from_onnx" / "checkpoint.pt")
    assert gone_on["plan_step"] == optimiser_steps(gone_on) == 3 and gone_on["samples"] == 80 + 12


def refused(done: subprocess.CompletedProcess, words: str) -> None:
    assert done.returncode == 3, (done.returncode, done.stderr)
    assert words in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


def refuses(folder: pathlib.Path) -> None:
    out = folder / "out"
    plan = ("--out", out, "--steps", 1, "--batch", 1, "--pool", 4, "--held-out", 1)
    refused(run("train.py", "--draws", folder / "none", *plan), "is not there")
    short = folder / "short.sh"
    short.write_text("#!/bin/sh\nhead -c 1000 /dev/zero\n")
    short.chmod(0o755)
    refused(run("train.py", "--draws", short, *plan), "wrote 0 of 1 records")
    cut = folder / "cut.pt"
    torch.save({"weights": torch.rand(100)}, cut)
    whole = cut.read_bytes()
    for content in (whole, whole[:200], b"no checkpoint"):
        cut.write_bytes(content)
        refused(run("train.py", "--draws", DISCS, "--resume", cut, *plan), "is no checkpoint")
    onnx = folder / "cut.onnx"
    for content in (b"no network", (SOURCE / "tests/unit/prior/models/unet.onnx").read_bytes()):
        onnx.write_bytes(content)
        refused(run("train.py", "--draws", DISCS, "--resume", onnx, *plan),
                "is no ONNX" if content == b"no network" else "other layers")
    refused(run("train.py", "--draws", DISCS, "--resume", folder / "none.onnx", *plan), "is not there")
    refused(run("export.py", cut, "-o", folder / "heart.onnx"), "is no checkpoint")
    assert not (out / "checkpoint.pt").exists() and not list(folder.glob("heart.*"))
    out.mkdir(exist_ok=True)
    (out / "checkpoint.pt").write_bytes(b"of another run")
    refused(run("train.py", "--draws", DISCS, *plan), "of another run")
    assert (out / "checkpoint.pt").read_bytes() == b"of another run"


with tempfile.TemporaryDirectory(prefix="beatlas-train-") as work:
    {"parts": parts, "run": goes_on_and_exports, "refuses": refuses}[NAME](pathlib.Path(work))
