#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python client beside multiprocessing: exceptions and values go to other processes, connections do not, and a forked process hears so."""

import asyncio
import copy
import inspect
import pickle
import sys
import unittest
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402

POOL = """
import multiprocessing, meniscus
def work(case):
    with meniscus.Client() as client:
        return client.load(case)
with multiprocessing.get_context("fork").Pool(1) as pool:
    for case in "no-such-case", {"dimensions": 2, "xyzzy": 1}:
        try:
            pool.apply_async(work, [case]).get(20)
        except meniscus.CaseError as error:
            print(error.code, error.status, bool(error.hint), error.message[:20], len(getattr(error, "__notes__", [0])))
"""
FORKED = """
import multiprocessing, os, sys, meniscus
client = meniscus.Client()
client.load("dambreak2d", {"resolution": 10})
heard = client.events(timeout=10)
stream = client.stream("probes")
def child(use):
    try:
        use()
    except meniscus.UnavailableError as error:
        print("child:", error.message[:8], "hint:", error.hint)
        sys.stdout.flush()
    client.close()
uses = client.status, lambda: client.load("dambreak2d"), lambda: next(heard), client.subscribe, lambda: next(iter(stream))
for use in uses:
    process = multiprocessing.get_context("fork").Process(target=child, args=[use])
    process.start()
    process.join(20)
    print("ended with", process.exitcode)
    process.kill()
if not os.fork():
    sys.exit()  # with everything taken down
print("ended with", os.wait()[1])
print("parent:", client.status().state, client.step(1).state)
print("parent heard:", next(heard).topic)
"""
ASYNC_FORKED = """
import asyncio, os, sys, meniscus
async def parent():
    client = await meniscus.AsyncClient(timeout=20).connect()
    sys.stdout.flush()
    if not os.fork():
        try:
            await client.status()
        except meniscus.UnavailableError as error:
            print("child:", error.hint, flush=True)
        await client.close()
        os._exit(0)
    os.wait()
    print("parent:", (await client.status()).state)
    await client.close()
asyncio.run(parent())
"""


def filled(kind: Any) -> Any:
    """A value of a data class whose members are all there; of what type they are does not matter to pickle."""
    return kind(**{name: f"its {name}" for name in kind.__dataclass_fields__})


class Processes(DaemonTest):
    def setUp(self) -> None:
        self.client = meniscus.Simulation(f"ipc://{self.home}/run/meniscus/default/control.ipc", timeout=50)
        self.addCleanup(self.client.close)

    def back(self, value: Any) -> Any:
        return pickle.loads(pickle.dumps(value))

    def test_exceptions_come_back_from_a_pool_of_processes(self) -> None:
        lines = self.run_python(POOL, self.home).splitlines()
        self.assertEqual(lines, ['NOT_FOUND not found True there is no file "no 1', "INVALID_ARGUMENT invalid True case:1:17: unknown e 1"])

    def test_a_forked_process_is_refused_and_its_parent_goes_on(self) -> None:
        lines = self.run_python(FORKED, self.home).splitlines()
        told = "child: process  hint: make a client in this process; that of the parent goes on"
        self.assertEqual(lines, [told, "ended with 0"] * 5 + ["ended with 0", "parent: READY PAUSED", "parent heard: event"])

    def test_a_forked_process_is_refused_with_asyncio_too(self) -> None:
        lines = self.run_python(ASYNC_FORKED, self.home).splitlines()
        self.assertEqual(lines, ["child: make a client in this process; that of the parent goes on", "parent: EMPTY"])

    def test_every_public_exception_pickles(self) -> None:
        kinds = [kind for kind in vars(meniscus).values() if inspect.isclass(kind) and issubclass(kind, Exception)]
        self.assertGreater(len(kinds), 8)

        class Own(meniscus.StateError):
            def __init__(self) -> None:
                super().__init__("FAILED_PRECONDITION", "not now")

        globals()["Own"] = Own
        Own.__qualname__ = "Own"
        for error in [kind("NOT_FOUND", "a sentence", "a.path", "diverged", ("READY", "PAUSED")) for kind in kinds] + [Own()]:
            for again in [copy.copy(error), copy.deepcopy(error)] + [
                    pickle.loads(pickle.dumps(error, protocol)) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)]:
                with self.subTest(type(error)):
                    self.assertIs(type(again), type(error))
                    self.assertEqual((str(again), again.args, vars(again)), (str(error), error.args, vars(error)))

    def test_every_public_value_pickles(self) -> None:
        kinds = [kind for kind in vars(meniscus).values() if hasattr(kind, "__dataclass_fields__")]
        self.assertGreater(len(kinds), 10)
        values = [filled(kind) for kind in kinds if kind is not meniscus.StreamItem]
        self.client.load("dambreak2d", {"resolution": 20, "end_time": 0.02, "output.probe_interval": 0.01})
        with self.client.stream("probes", first=True) as stream, self.client.stream("snapshots") as files:
            self.client.start()
            self.client.wait()
            items = [stream.next(20), files.next(20)]
        values += [*items, self.client.status(), self.client.query(), self.client.capabilities(), self.client.get()]
        for value in values:
            with self.subTest(type(value)):
                self.assertEqual(repr(self.back(value)).replace(" at 0x", ""), repr(self.plain(value)).replace(" at 0x", ""))
        self.assertEqual(bytes(items[1].data), self.back(items[1]).data)

    @staticmethod
    def plain(value: Any) -> Any:
        """An item with its piece of a file as bytes, which is what becomes of a memoryview."""
        return copy.copy(value) if isinstance(value, meniscus.StreamItem) else value

    def test_files_pickle_as_their_paths(self) -> None:
        self.client.load("dambreak2d", {"resolution": 20, "end_time": 0.02, "output.probe_interval": 0.01}, start=True)
        self.client.wait()
        self.client.snapshot()
        series, snapshots = self.client.series, self.client.snapshots
        np.testing.assert_array_equal(self.back(series)["front"], series["front"])
        self.assertEqual(self.back(snapshots).paths, snapshots.paths)
        again, field = self.back(snapshots[-1]), self.back(snapshots[-1]["velocity"])
        self.assertEqual((again.step, again.path), (snapshots[-1].step, snapshots[-1].path))
        np.testing.assert_array_equal(field[:], snapshots[-1]["velocity"][:])

    def test_connections_do_not_and_say_what_to_do(self) -> None:
        self.client.load("dambreak2d", {"resolution": 10})
        with self.client.stream("probes") as stream:
            for one in (self.client, self.client.parameters, self.client.probes, stream):
                with self.subTest(type(one)), self.assertRaisesRegex(TypeError, "cannot be pickled: make a client in each process"):
                    pickle.dumps(one)

        async def asynchronous() -> None:
            async with meniscus.AsyncClient(self.client._connection.endpoint) as client:
                with self.assertRaisesRegex(TypeError, "cannot be pickled: make a client in each process"):
                    pickle.dumps(client)

        asyncio.run(asynchronous())


if __name__ == "__main__":
    unittest.main()
