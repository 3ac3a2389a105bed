#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python client for asyncio against a real daemon: what it does beyond the other one, with which it shares the rest."""

import asyncio
import inspect
import os
import sys
import unittest
from pathlib import Path
from unittest import mock
from typing import Any, Awaitable, Callable

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, DaemonTest, control_socket  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import meniscus_pb2  # noqa: E402

SMALL = {"resolution": 20}


def with_client(test: Callable[[Any, meniscus.AsyncClient], Awaitable[None]]) -> Callable[[Any], None]:
    """A test that is given a client, in a loop of its own."""

    def run(self: Any) -> None:
        async def main() -> None:
            async with meniscus.AsyncClient(self.endpoint, timeout=50) as client:
                await test(self, client)

        asyncio.run(asyncio.wait_for(main(), 60))

    return run


class WithDaemon(DaemonTest):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/control.ipc"

    @with_client
    async def test_a_run_is_listened_to_while_it_is_waited_for(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL | {"end_time": 0.2})

        async def until_done() -> list:
            heard = []
            async with client.events(timeout=20) as events:
                async for event in events:
                    heard.append(event.state)
                    if event.state == "DONE":
                        return heard
            return heard

        samples = client.samples(timeout=20)
        states = asyncio.ensure_future(until_done())
        await asyncio.sleep(0.2)  # subscriptions take a moment to reach the daemon
        done, started, first = await asyncio.gather(client.wait(["DONE"]), client.start(), samples.__anext__())
        self.assertEqual((done.state, started.state), ("DONE", "RUNNING"))
        self.assertIn("P05", first.values)
        self.assertEqual((await states)[-1], "DONE")
        await samples.aclose()
        self.assertEqual([sample async for sample in samples], [])

    @with_client
    async def test_commands_are_under_way_side_by_side(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL | {"end_time": 50})
        until = asyncio.ensure_future(client.run_until(40))
        while (await client.status()).state != "RUNNING":
            await asyncio.sleep(0.01)
        values, particles = await asyncio.gather(client.query("P05"), client.particles(["id"]))
        self.assertEqual(values["P05"].unit, "Pa")
        self.assertTrue(particles["id"].flags.writeable)
        self.assertFalse(until.done())
        await client.pause()
        with self.assertRaises(meniscus.CancelledError):
            await until

    @with_client
    async def test_the_daemon_ends_what_is_cancelled(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL | {"end_time": 50})
        for command in (lambda: client.run_until(40), lambda: client.step(10**6)):
            under_way = asyncio.ensure_future(command())
            await client.wait(["RUNNING"], timeout=60)
            under_way.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await under_way
            self.assertEqual((await client.wait(["PAUSED"], timeout=60)).state, "PAUSED")

    def test_a_cancel_is_sent_before_the_client_goes(self) -> None:
        async def main() -> None:
            async with meniscus.AsyncClient(self.endpoint) as client:
                await client.load("dambreak2d", SMALL | {"end_time": 50})
                under_way = asyncio.ensure_future(client.run_until(40))
                await client.wait(["RUNNING"], timeout=60)
                under_way.cancel()
                await under_way

        with self.assertRaises(asyncio.CancelledError):
            asyncio.run(main())
        with meniscus.Client(self.endpoint) as client:
            self.assertEqual(client.wait(["PAUSED"], timeout=10).state, "PAUSED")

    def test_a_daemon_that_was_started_in_the_line_before_is_waited_for_while_others_go_on(self) -> None:
        here = control_socket(self.home)
        away = here.with_name("away")

        async def others() -> None:
            for _ in range(10):
                await asyncio.sleep(0.01)
            if away.exists():
                away.rename(here)  # only if this task runs while the client waits

        async def main(daemon: str) -> None:
            task = asyncio.ensure_future(others())
            async with meniscus.AsyncClient(daemon) as client:
                self.assertEqual((await client.status()).state, "EMPTY")
            await task

        with mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.home / "run")):
            for daemon in (self.endpoint, "default"):
                here.rename(away)
                asyncio.run(main(daemon))
            with self.assertRaises(meniscus.UnavailableError):
                asyncio.run(main("nobody"))

    @with_client
    async def test_one_at_a_time_changes_the_run(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL)
        async with meniscus.AsyncClient(self.endpoint) as other:
            async with client.lease(60, "anna") as epoch:
                await client.set({"end_time": 3})
                with self.assertRaises(meniscus.LeaseError):
                    await other.set({"end_time": 4})
                with self.assertRaisesRegex(meniscus.LeaseError, "^anna holds the lease"):
                    await other.load("dambreak2d", SMALL)
                await client.renew(30)
                self.assertGreater(epoch, 0)
            self.assertEqual((await other.set({"end_time": 4})).case_version, 3)

    @with_client
    async def test_what_went_wrong_under_a_lease_is_seen_though_the_daemon_is_gone(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL)
        try:
            with self.assertRaisesRegex(ValueError, "the cause"):
                async with client.lease(60):
                    self.daemon.kill()
                    self.daemon.wait()
                    raise ValueError("the cause")
        finally:
            self.start_daemon()
        await client.wait(["READY"], timeout=20)

    @with_client
    async def test_what_a_crash_cut_off_is_done_once(self, client: meniscus.AsyncClient) -> None:
        await client.load("dambreak2d", SMALL | {"end_time": 3})
        until = asyncio.ensure_future(client.run_until(0.8))
        await asyncio.sleep(0.3)
        self.assertFalse(until.done())
        await asyncio.to_thread(self.kill_daemon)
        reply = await until
        self.assertEqual((reply.state, reply.time), ("PAUSED", 0.8))

    def test_who_listens_is_told_when_the_client_is_closed(self) -> None:
        async def main() -> list:
            async with meniscus.AsyncClient(self.endpoint) as client:
                listener = asyncio.ensure_future(listen(client.samples()))
                await asyncio.sleep(0.1)
            return await asyncio.wait_for(listener, 5)

        async def listen(samples: Any) -> list:
            return [sample async for sample in samples]

        self.assertLessEqual(len(asyncio.run(main())), 1)  # the last of the run before is heard again

    @with_client
    async def test_a_refused_case_names_file_and_line(self, client: meniscus.AsyncClient) -> None:
        with self.assertRaises(meniscus.CaseError) as caught:
            await client.load("dambreak2d", SMALL | {"fluids[1].density": -1})
        self.assertEqual(caught.exception.path, "fluids[1].density")
        with self.assertRaises(meniscus.StateError):
            await client.pause()


class WithoutDaemon(unittest.TestCase):
    def test_an_unreachable_daemon_is_said_quickly(self) -> None:
        for daemon in ("nobody-of-that-name", "tcp://127.0.0.1:1", "ipc:///nonexistent/control.ipc"):
            with self.assertRaises(meniscus.UnavailableError) as caught:
                asyncio.run(meniscus.AsyncClient(daemon).connect())
            self.assertNotIn("no answer", str(caught.exception))  # which is said only after all of the patience

    def test_both_clients_have_the_same_methods_with_the_same_arguments(self) -> None:
        def methods(kind: type) -> dict:
            return {name: list(inspect.signature(what).parameters)
                    for name, what in vars(kind).items() if not name.startswith("_")}

        ours = methods(meniscus.AsyncClient)
        self.assertEqual(ours.pop("connect"), ["self"])
        self.assertEqual(ours, methods(meniscus.Client))
        commands = {field.name for field in meniscus_pb2.Request.DESCRIPTOR.oneofs_by_name["command"].fields}
        self.assertLessEqual(commands, set(ours))

    def test_a_method_explains_itself(self) -> None:
        self.assertIn("Run until a simulated time", meniscus.AsyncClient.run_until.__doc__ or "")
        self.assertEqual(str(inspect.signature(meniscus.Client.start)), "(self, if_step: 'Optional[int]' = None) -> 'Reply'")


if __name__ == "__main__":
    unittest.main()
