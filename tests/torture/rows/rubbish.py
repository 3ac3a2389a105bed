# SPDX-License-Identifier: BSD-3-Clause
"""Frames, texts and parameters that nobody in their right mind would send."""

from __future__ import annotations

import math
import os
import random
import re
import sys
import time
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any, Iterator

import numpy as np
import zmq
from daemon import BUILD

from .latency import Line
from .live import Daemon, meniscus, test_program
from .metrics import Metric, Size, all_of, none_of

from meniscus import meniscus_pb2 as pb  # isort: skip

FRAMES = 10**8  # malformed ones, in the promise
BATCH = 500  # sets under way at once
STEPS = 3  # after each batch


def fuzz(inputs: int) -> "tuple[int, int, dict[str, int]]":
    """So many, to each target its share: how many broke nothing, how many something, and the inputs of each."""
    limit = 120 + inputs // 1000
    passed, failed, said = test_program(["tests/support/fuzz.sh", str(limit), str(inputs)], 3 * limit, BUILD=str(BUILD / "asan"))
    if failed:
        sys.stderr.write(said[-3000:])
    return passed, failed, {name: int(n) for name, n in re.findall(r"^ok - (\w+): (\d+) inputs", said, re.MULTILINE)}


def frames(size: Size) -> Iterator[Metric]:
    """libFuzzer's targets with address and undefined-behaviour sanitizers, and the handlers behind them without, in the process of the test."""
    inputs: "dict[str, int]" = {}
    failed, began = 0, time.monotonic()
    while not failed and sum(inputs.values()) < size.inputs:
        passed, failed, more = fuzz(min(size.fuzz_inputs, size.inputs))
        inputs |= {name: inputs.get(name, 0) + n for name, n in more.items()}
        if not more:
            break
    rate = sum(inputs.values()) / (time.monotonic() - began)
    yield all_of("fuzz targets that no input breaks", passed, passed + failed, ", ".join(f"{name} {n}" for name, n in sorted(inputs.items())))
    yield Metric("inputs under sanitizers", sum(inputs.values()), low=size.inputs, note=f"{rate:.0f}/s: {FRAMES:.0e} take {FRAMES / max(1, rate) / 3600:.1f} h")
    began = time.monotonic()
    passed, failed, said = test_program([BUILD / "tests/protocol/test_daemon_fuzz"], 120 + size.frames / 2000, FRAMES=str(size.frames))
    if failed:
        sys.stderr.write(said[-3000:])
    yield all_of("tests of frames before the handlers that passed", passed, passed + failed,
                 f"{size.frames} of each kind in {time.monotonic() - began:.0f} s")


SEQUENCES = 10**5  # in the promise
SEQUENCES_OF_RUN = 1000
DAEMONS = 2 * len(os.sched_getaffinity(0))  # at once: each waits for its client, and that for it


def sequences(seed: int, count: int) -> "tuple[int, int, int]":
    """Of one daemon: how many there were, with how many commands, and how many tests failed."""
    _, failed, said = test_program([sys.executable, "tests/system/test_model.py"], 120 + count, MENISCUS_SEQUENCES=str(count), MENISCUS_SEED=str(seed))
    found = re.search(r"^(\d+) sequences, (\d+) commands", said, re.MULTILINE)
    if failed or not found:
        sys.stderr.write(said[-3000:])
        return 0, 0, max(1, failed)
    return int(found[1]), int(found[2]), 0


def model(size: Size) -> Iterator[Metric]:
    """Random sequences of commands to daemons and to the reference model, in runs of other seeds each; none is begun after one that failed."""
    done = commands = failed = begun = runs = 0
    began = time.monotonic()
    with ThreadPoolExecutor(DAEMONS) as pool:
        under_way: "set[Future[tuple[int, int, int]]]" = set()
        while under_way or (not failed and begun < size.sequences):
            while len(under_way) < DAEMONS and not failed and begun < size.sequences:
                count = min(SEQUENCES_OF_RUN, math.ceil(size.sequences / DAEMONS), size.sequences - begun)
                under_way.add(pool.submit(sequences, 20261125 + runs, count))
                begun, runs = begun + count, runs + 1
            ended, under_way = wait(under_way, return_when=FIRST_COMPLETED)
            for more in (future.result() for future in ended):
                done, commands, failed = done + more[0], commands + more[1], failed + more[2]
    rate = done / (time.monotonic() - began)
    yield none_of("runs in which a reply was not that of the model", failed)
    yield Metric("random sequences of commands", done, low=size.sequences,
                 note=f"{commands} commands; {rate:.1f}/s: {SEQUENCES:.0e} take {SEQUENCES / max(0.01, rate) / 3600:.1f} h")


WORDS = ["", " ", "0", "-0", "1", "-1", "1e308", "-1e308", "1e-308", "1e999", "nan", ".inf", "-.inf", "true", "no", "null", "~", "[]", "{}",
         "[0, -1]", "[0, 0, 0]", "[1e300, .nan]", "[[1]]", "{a: 1}", "t", "x*y", "sin(1/0)", "while true do end", "\u0000", "\u2603", "'",
         "18446744073709551616", "-9223372036854775809", "0x7f", "1_000", "&a *a", "!!binary x", "? :", "a: b: c", "#", "---", "..."]


def value(chance: random.Random, now: str) -> str:
    """Something near what is there, a number of any size, a word, or bytes."""
    kind = chance.random()
    if kind < 0.5:
        scale = chance.choice([0.5, 0.9, 1, 1.1, 2, -1, 10, 1e6, 1e-6])
        return re.sub(r"-?\d+\.?\d*(e-?\d+)?", lambda found: repr(float(found[0]) * scale), now)
    if kind < 0.7:
        return repr(chance.choice([-1, 1]) * 10 ** chance.uniform(-12, 12))
    if kind < 0.9:
        return chance.choice(WORDS)
    return "".join(chr(chance.randrange(32, 0x2FF)) for _ in range(chance.randrange(80)))


def path(chance: random.Random, known: "list[str]") -> str:
    name = chance.choice(known)
    if chance.random() < 0.1:
        k = chance.randrange(len(name) + 1)
        name = name[:k] + chance.choice(["", ".", "[0]", "[999999]", "[-1]", "\u00e9", "x" * 300]) + name[k + 1:]
    return name


def parameters(size: Size) -> Iterator[Metric]:
    """Random changes of a run, several entries at once at times; after each batch it does some steps with what was accepted."""
    answers: "dict[str, int]" = {}
    sane = batches = faults = 0
    chance = random.Random(1)
    settings = {"resolution": 10, "threads": 1, "end_time": 1e4, "output.checkpoint_interval": 1e3}
    with Daemon() as daemon, daemon.client(timeout=20) as client, zmq.Context() as context:
        client.load("dambreak2d", settings)
        line = Line(context, daemon.endpoint)
        present = {name: str(entry.value) for name, entry in client.get().items()}
        known = [p.path for p in client.capabilities().parameters if "[]" not in p.path] + list(present)
        sent = 0
        while sent < size.parameters:
            for _ in range(min(BATCH, size.parameters - sent)):
                names = [path(chance, known) for _ in range(1 if chance.random() < 0.8 else chance.randrange(9))]
                line.send(set=pb.Set(assignments=[pb.Assignment(path=name, value=value(chance, present.get(name, "1"))) for name in names]))
                sent += 1
            for _ in range(min(BATCH, sent - BATCH * batches)):
                name = pb.Code.Name(line.receive().code)
                answers[name] = answers.get(name, 0) + 1
            batches += 1
            state = _go_on(client)
            faults += state == "FAULT"
            sane += state == "FAULT" or _is_finite(client)
            if state == "FAULT" or batches % 10 == 0:
                client.load("dambreak2d", settings)
        alive = daemon.alive and client.status().state
        line.socket.close()
    note = ", ".join(f"{n} {name}" for name, n in sorted(answers.items()))
    yield all_of("random changes that were answered", sum(answers.values()), size.parameters, note)
    yield none_of("answers that tell of a defect (INTERNAL, DATA_LOSS, UNKNOWN)", sum(answers.get(name, 0) for name in ("INTERNAL", "DATA_LOSS", "UNKNOWN")))
    yield all_of("batches after which the run is finite, or in FAULT", sane, batches, f"{faults} in FAULT")
    yield all_of("the daemon answers at the end", int(bool(alive)), 1)


def _go_on(client: meniscus.Client) -> str:
    """Some steps, in no more than a while: a change may have made them short. The state after that."""
    try:
        client.step(STEPS)
    except meniscus.MeniscusError:
        pass  # the state tells
    return client.status().state


def _is_finite(client: meniscus.Client) -> bool:
    state: "dict[str, Any]" = client.particles(["position", "velocity", "pressure"], limit=10**6)
    return all(bool(np.isfinite(values).all()) for values in state.values()) and math.isfinite(client.status().time or 0)
