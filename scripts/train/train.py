#!/usr/bin/env python3
"""Trains the network on slices that a program draws while it learns; README.md has the commands.

DIR/checkpoint.pt is replaced every few minutes and at the end, on Ctrl-C too; DIR/log.txt is what is
printed. Exit 0 done, 2 usage, 3 bad input or a program that ended.
"""
import argparse
import math
import pathlib
import signal
import sys
import time

import numpy
import torch

import checkpoint
from draws import HELD_OUT_FIRST, DrawsEnded, Ring, planes, read_all, vary
from losses import DiceCount, loss
from model import MAX_PARAMETERS, HeartNet, parameters
from weights import exported, trained_before

WARM_UP = 0.02           # of the planned duration
LAST_RATE = 0.01         # of the rate, at the end
WEIGHT_DECAY = 0.01
LARGEST_GRADIENT = 5.0   # norm over all weights
AVERAGE_STEPS = 1000     # of the moving average of the weights
LOG_SECONDS = 30
MEASURED = 128           # records on which the batch norms of an exported network are measured


class Average:
    """Moving average of the weights and of batch norm's running statistics, which belong to them."""

    def __init__(self, state: dict[str, torch.Tensor]) -> None:
        self.state = {name: value.detach().clone() for name, value in state.items()}

    def add(self, state: dict[str, torch.Tensor], step: int) -> None:
        """Short at first, so that what was there before training is soon forgotten."""
        share = max(1 / AVERAGE_STEPS, 9 / (10 + step))
        for name, value in state.items():
            if value.is_floating_point():
                self.state[name].lerp_(value.detach(), share)
            else:
                self.state[name].copy_(value)  # how many batches were counted


def rate(progress: float) -> float:
    """Share of --lr: a line up, then a cosine down over the planned duration (progress 0..1)."""
    if progress < WARM_UP:
        return max(LAST_RATE, progress / WARM_UP)
    turn = math.cos(math.pi * min(1.0, (progress - WARM_UP) / (1 - WARM_UP)))
    return LAST_RATE + (1 - LAST_RATE) * 0.5 * (1 + turn)


def has_bfloat16() -> bool:
    """Whether this processor multiplies bfloat16; where it does not, plain floats are faster."""
    info = pathlib.Path("/proc/cpuinfo")
    return info.exists() and any(flag in info.read_text() for flag in ("avx512_bf16", "amx_bf16"))


def judge(state: dict[str, torch.Tensor], widths: tuple[int, ...], held_out: numpy.ndarray, short: bool,
          batch: int = 32) -> dict[str, float]:
    """Dice by structure over the held-out records, as they were drawn."""
    model = HeartNet(widths)
    model.load_state_dict(state)
    model = model.eval().to(memory_format=torch.channels_last)
    count = DiceCount()
    with torch.no_grad(), torch.autocast("cpu", torch.bfloat16, enabled=short):
        for first in range(0, len(held_out), batch):
            images, labels = planes(held_out[first:first + batch])
            count.add(model(images.contiguous(memory_format=torch.channels_last)).float(), labels)
    return count.dice()


class Run:
    """A run in progress: what a checkpoint holds, and how far the plan has come."""

    def __init__(self, args: argparse.Namespace, held_out: numpy.ndarray) -> None:
        self.args = args
        torch.manual_seed(args.seed)
        self.random = numpy.random.default_rng(args.seed)
        self.model = HeartNet()
        self.step = self.samples = 0        # since the first of all runs
        self.minutes = 0.0
        self.plan_step, self.plan_minutes = 0, 0.0  # since the schedule began
        self.first = args.first
        self.dice: dict[str, float] = {}
        before = None
        if args.resume and args.resume.suffix == ".onnx":
            self.model = exported(args.resume, planes(held_out[:MEASURED])[0])
            self.samples, self.minutes = trained_before(args.resume)
        elif args.resume:
            before = checkpoint.load(args.resume)
            self.model = checkpoint.network(before, "weights")
        self.model = self.model.train().to(memory_format=torch.channels_last)
        self.average = Average(before["average"] if before else self.model.state_dict())
        self.optimiser = torch.optim.AdamW(self.model.parameters(), args.lr, weight_decay=WEIGHT_DECAY)
        if before:
            self.step, self.samples, self.minutes = before["step"], before["samples"], before["minutes"]
            self.first = max(args.first, before["next_seed"])
            if args.same_optimiser:
                self.plan_step, self.plan_minutes = before["plan_step"], before["plan_minutes"]
                groups = self.optimiser.state_dict()["param_groups"]
                self.optimiser.load_state_dict({"state": before["optimiser"], "param_groups": groups})
                torch.set_rng_state(before["torch_random"])
                self.random.bit_generator.state = before["numpy_random"]

    def progress(self) -> float:
        """Of the planned duration, 0 to 1 and more."""
        if self.args.steps is not None:
            return self.plan_step / self.args.steps if self.args.steps else 1.0
        return self.plan_minutes / self.args.minutes

    def train(self, records: numpy.ndarray, short: bool) -> float:
        """One step; returns the loss."""
        images, labels = vary(records, self.random)
        for group in self.optimiser.param_groups:
            group["lr"] = self.args.lr * rate(self.progress())
        with torch.autocast("cpu", torch.bfloat16, enabled=short):
            logits = self.model(images.contiguous(memory_format=torch.channels_last))
        value = loss(logits, labels)
        self.optimiser.zero_grad(set_to_none=True)
        value.backward()
        # A batch of which a gradient is not finite would spoil every weight; it is left out.
        if math.isfinite(float(torch.nn.utils.clip_grad_norm_(self.model.parameters(), LARGEST_GRADIENT))):
            self.optimiser.step()
        self.step += 1
        self.plan_step += 1
        self.samples += len(records)
        self.average.add(self.model.state_dict(), self.step)
        return float(value.detach())

    def save(self, next_seed: int) -> None:
        tensors = {"weights": self.model.state_dict(), "average": self.average.state,
                   "optimiser": self.optimiser.state_dict()["state"], "torch_random": torch.get_rng_state()}
        checkpoint.save(self.args.out / "checkpoint.pt", tensors, {
            "widths": self.model.widths, "step": self.step, "samples": self.samples,
            "minutes": self.minutes, "plan_step": self.plan_step, "plan_minutes": self.plan_minutes,
            "next_seed": next_seed, "numpy_random": self.random.bit_generator.state, "dice": self.dice,
            "seed": self.args.seed, "batch": self.args.batch, "rate": self.args.lr,
            "date": time.strftime("%Y-%m-%d"),
        })


def words_of(dice: dict[str, float]) -> str:
    return " ".join(f"{name} {value:.3f}" for name, value in dice.items())


def follow(run: Run, ring: Ring, held_out: numpy.ndarray, say) -> None:
    """The loop; ends when the plan is done or a signal asks for it."""
    args, short = run.args, not args_float(run.args)
    stop: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: stop.append(number))
    ring.wait(min(args.pool, 20 * args.batch))
    start = kept = logged = time.monotonic()
    minutes, plan_minutes = run.minutes, run.plan_minutes
    losses: list[float] = []
    while run.progress() < 1 and not stop:
        losses.append(run.train(ring.take(args.batch, run.random), short))
        now = time.monotonic()
        run.minutes = minutes + (now - start) / 60
        run.plan_minutes = plan_minutes + (now - start) / 60
        if now - logged >= LOG_SECONDS:
            say(f"step {run.step}, {run.minutes:.1f} min, {len(losses) * args.batch / (now - logged):.1f} "
                f"samples/s, loss {sum(losses) / len(losses):.4f}, "
                f"rate {args.lr * rate(run.progress()):.2e}, "
                f"{ring.written} drawn, each used {ring.reused:.1f} times")
            logged, losses = now, []
        if now - kept >= 60 * args.keep_minutes:
            run.dice = judge(run.average.state, run.model.widths, held_out, short)
            say(f"step {run.step}, held-out Dice: {words_of(run.dice)}")
            run.save(ring.next_seed())
            kept = time.monotonic()
    if losses:
        say(f"step {run.step}, loss {sum(losses) / len(losses):.4f}")
    run.dice = judge(run.average.state, run.model.widths, held_out, short)
    say(f"step {run.step}, held-out Dice: {words_of(run.dice)}")
    run.save(ring.next_seed())
    say(f"{'stopped' if stop else 'done'} after {run.samples} samples: {args.out / 'checkpoint.pt'}")


def args_float(args: argparse.Namespace) -> bool:
    return args.float or not has_bfloat16()


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Trains the network that tells where the heart is.")
    parser.add_argument("--draws", type=pathlib.Path, required=True, help="the program heart_draws")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder of checkpoint.pt and log.txt")
    plan = parser.add_mutually_exclusive_group()
    plan.add_argument("--minutes", type=float, default=90, help="planned duration (90)")
    plan.add_argument("--steps", type=int, help="planned duration in steps")
    parser.add_argument("--resume", type=pathlib.Path,
                        help="go on from this checkpoint, or the ONNX file of one, as a new plan")
    parser.add_argument("--same-optimiser", action="store_true",
                        help="with --resume: go on with the plan that was stopped")
    parser.add_argument("--seed", type=int, default=1, help="of weights and variations (1)")
    parser.add_argument("--first", type=int, default=0, help="first seed that is drawn (0)")
    parser.add_argument("--batch", type=int, default=24)
    parser.add_argument("--lr", type=float, default=2e-3, help="largest learning rate (0.002)")
    parser.add_argument("--pool", type=int, default=24000, help="records kept, 98 kB each (24000)")
    parser.add_argument("--reuse", type=float, default=3, help="times that a record is used (3)")
    parser.add_argument("--held-out", type=int, default=512, help="records to judge by (512)")
    parser.add_argument("--keep-minutes", type=float, default=5, help="between checkpoints (5)")
    parser.add_argument("--float", action="store_true", help="plain floats, where bfloat16 would be used")
    args = parser.parse_args()
    if min(args.batch, args.pool, args.held_out) < 1 or args.reuse <= 0 or args.lr <= 0 or args.minutes <= 0 \
            or (args.steps is not None and args.steps < 1) or not 0 <= args.first < HELD_OUT_FIRST:
        parser.error("numbers must be positive, --first less than the first held-out seed, "
                     f"{HELD_OUT_FIRST}")
    if args.same_optimiser and (not args.resume or args.resume.suffix == ".onnx"):
        parser.error("--same-optimiser goes with --resume CHECKPOINT")
    return args


def main() -> int:
    args = parsed()
    torch.set_num_threads(1)  # two were slower than one, and the program that draws wants the other core
    if not args.draws.is_file():
        print(f"train: {args.draws} is not there; build it with cmake --build --preset release --target "
              "heart_draws", file=sys.stderr)
        return 3
    ours = args.out / "checkpoint.pt"
    if ours.exists() and (not args.resume or args.resume.resolve() != ours.resolve()):
        print(f"train: {ours} is of another run; add --resume {ours}, or give another --out",
              file=sys.stderr)
        return 3
    ring = None
    try:
        held_out = read_all(args.draws, HELD_OUT_FIRST, args.held_out)
        run = Run(args, held_out)
        args.out.mkdir(parents=True, exist_ok=True)
        assert parameters(run.model) <= MAX_PARAMETERS
        ring = Ring(args.draws, run.first, args.pool, args.reuse)
        with open(args.out / "log.txt", "a") as log:
            def say(line: str) -> None:
                print(line, flush=True)
                print(time.strftime("%H:%M:%S"), line, file=log, flush=True)
            say(f"{parameters(run.model)} parameters, {'float' if args_float(args) else 'bfloat16'}, "
                f"batch {args.batch}, from step {run.step}, seeds from {run.first}")
            follow(run, ring, held_out, say)
    except (checkpoint.BadCheckpoint, DrawsEnded, OSError) as error:
        print(f"train: {error}", file=sys.stderr)
        return 3
    finally:
        if ring:
            ring.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
