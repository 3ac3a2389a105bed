#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The Python client against a real daemon, and against none."""

import contextlib
import ctypes
import inspect
import os
import pwd
import re
import signal
import subprocess
import sys
import threading
import time
import unittest
from pathlib import Path
from socket import gethostname
from typing import Callable
from unittest import mock

import numpy as np
import xxhash
import zmq

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import BUILD, ROOT, DaemonTest  # noqa: E402

sys.path.insert(0, str(BUILD / "python"))
import meniscus  # noqa: E402
from meniscus import case, dialogue, endpoint, errors, meniscus_pb2, values  # noqa: E402

SMALL = {"resolution": 20}


class WithDaemon(DaemonTest):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = self.environment["MENISCUS_CASES"]
        self.endpoint = f"ipc://{self.home}/run/meniscus/default/control.ipc"
        self.client = meniscus.Client(self.endpoint, timeout=50)
        self.addCleanup(self.client.close)

    def load(self, **more: object) -> meniscus.Reply:
        return self.client.load("dambreak2d", SMALL | more)

    def test_a_run_goes_from_load_to_done_and_is_listened_to(self) -> None:
        self.load(end_time=0.2)
        messages = self.client.subscribe("event", "probe", "progress", timeout=20)
        time.sleep(0.2)  # subscriptions take a moment to reach the daemon
        self.client.start()
        heard = []
        for message in messages:
            heard.append(message)
            if message.state == "DONE":
                break
        self.assertEqual(heard[-1].state, "DONE")
        probes = [message for message in heard if message.topic == "probe"]
        self.assertIn("P05", probes[-1].values)
        self.assertEqual({message.lost for message in heard}, {0})
        self.assertEqual(self.client.wait(["DONE"], timeout=20).state, "DONE")

    def test_a_place_that_is_closed_to_us_is_passed_over_and_named(self) -> None:
        place = self.home / "meniscus"
        place.mkdir(mode=0)
        self.home.chmod(0o755)
        us = os.geteuid()
        if us == 0:
            os.seteuid(65534)  # root may enter it
        try:
            with mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.home)), self.assertRaisesRegex(meniscus.UnavailableError, f"{place} is closed to this user; `sudo -u meniscus`"):
                meniscus.Client("nobody")
        finally:
            os.seteuid(us)

    def test_a_socket_where_others_may_write_is_not_asked(self) -> None:
        place = self.home / "theirs" / "meniscus" / "tank"
        place.mkdir(mode=0o700, parents=True)
        (place / "control.ipc").touch()
        with mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.home / "theirs")):
            self.assertEqual(endpoint.control_endpoint("tank"), f"ipc://{place}/control.ipc")
            for directory in (place, place.parent):
                directory.chmod(0o777)
                with self.assertRaisesRegex(meniscus.UnavailableError, "not asked, as others may write"):
                    endpoint.control_endpoint("tank")
                directory.chmod(0o755)
            place.rename(self.home / "moved")
            place.symlink_to(self.home / "moved")
            with self.assertRaises(meniscus.UnavailableError):
                endpoint.control_endpoint("tank")
            if os.getuid() == 0:
                place.unlink()
                (self.home / "moved").rename(place)
                os.chown(place, 65534, 65534)
                with self.assertRaises(meniscus.UnavailableError):
                    endpoint.control_endpoint("tank")

    def test_the_run_directory_is_the_path_of_a_load(self) -> None:
        loaded = self.client.load("dambreak2d", SMALL, start=True)
        self.assertEqual((loaded.state, loaded.path), ("RUNNING", self.client.status().run_directory))
        self.client.pause()
        self.assertEqual(self.client.stop().path, loaded.path)

    def test_what_went_wrong_under_a_lease_is_seen_though_the_daemon_is_gone(self) -> None:
        self.load()
        try:
            with self.assertRaisesRegex(ValueError, "the cause"), self.client.lease(60) as epoch:
                self.daemon.kill()
                self.daemon.wait()
                raise ValueError("the cause")
        finally:
            self.start_daemon()
        self.client.wait(["READY"], timeout=20)
        self.ask("lease", "release", "--lease", str(epoch))  # it came back with the daemon

    def test_a_daemon_may_have_been_gone_for_long(self) -> None:
        """A connection to the new one takes the request, and we have not heard of it yet: how long the old one is lost is nothing to it."""
        talk = dialogue.Dialogue(self.endpoint)
        talk._lost_since -= 60
        steps = talk.call(meniscus_pb2.Request(status=meniscus_pb2.GetStatus()))
        self.assertIsInstance(next(steps), dialogue.Wait)
        self.assertIsInstance(steps.send(True), dialogue.Send)
        self.assertIsInstance(steps.send(True), dialogue.Wait)

    def test_a_client_that_was_closed_says_so(self) -> None:
        client = meniscus.Client(self.endpoint, timeout=50)
        client.close()
        client.close()
        with self.assertRaisesRegex(meniscus.UnavailableError, "the client is closed"):
            client.status()

    def test_numbers_may_be_numpys_in_overrides_and_in_set(self) -> None:
        self.load(end_time=np.float64(1.5), gravity=np.array([0, -2]), resolution=np.int64(20))
        self.assertEqual(self.client.get("end_time")["end_time"].value, 1.5)
        self.client.set({"end_time": np.float32(2.5), "gravity": np.array([0.0, -3.0])})
        self.assertIn("-3", str(self.client.get("gravity")["gravity"]))

    def test_a_resumed_run_keeps_what_was_set_but_for_overrides(self) -> None:
        self.load()
        self.client.set({"end_time": 3, "gravity": [0, -2]})
        self.client.step(2)
        self.client.checkpoint()
        self.assertEqual(self.client.load("dambreak2d", SMALL | {"end_time": 5}, resume=True).step, 2)
        self.assertEqual(self.client.get("end_time")["end_time"].value, 5)
        self.assertIn("-2", str(self.client.get("gravity")["gravity"]))

    def test_pause_step_and_run_until_return_after_their_effect(self) -> None:
        self.load()
        self.assertEqual(self.client.start().state, "RUNNING")
        paused = self.client.pause()
        self.assertEqual(paused.state, "PAUSED")
        self.assertEqual(self.client.step(3).step, paused.step + 3)
        self.assertEqual(self.client.run_until(paused.time + 0.05).time, paused.time + 0.05)
        self.assertEqual(self.client.resume().state, "RUNNING")

    def test_entries_are_set_and_read(self) -> None:
        self.load()
        self.client.set({"end_time": 3, "gravity": [0, -1.5]})
        self.assertEqual(self.client.get("end_time")["end_time"], meniscus.Value(3.0, "s"))
        with self.assertRaises(meniscus.RefusedError) as caught:
            self.client.set({"scheme.cfl": 99})
        self.assertEqual(caught.exception.path, "scheme.cfl")

    def test_changes_are_taken_back(self) -> None:
        self.load()
        self.assertEqual(self.client.set({"end_time": 3}).case_version, 2)
        with self.assertRaises(meniscus.StateError) as caught:
            self.client.set({"end_time": 4}, if_version=1)
        self.assertEqual(caught.exception.path, "if_version")
        self.assertEqual(self.client.rollback(1, if_version=2).case_version, 3)
        self.assertEqual(self.client.status().case_version, 3)

    def test_one_at_a_time_changes_the_run(self) -> None:
        self.load()
        with meniscus.Client(self.endpoint) as other:
            with self.client.lease(60, "anna") as epoch:
                self.client.set({"end_time": 3})
                with self.assertRaises(meniscus.LeaseError) as caught:
                    other.set({"end_time": 4})
                self.assertEqual((caught.exception.status, caught.exception.path), ("held", "lease_epoch"))
                with self.assertRaisesRegex(meniscus.LeaseError, "^anna holds the lease") as caught:
                    other.load("dambreak2d", SMALL)
                self.assertNotIn("--lease", str(caught.exception), "which is for a command line")
                self.assertEqual((caught.exception.status, caught.exception.path), ("held", "lease_epoch"))
                self.assertEqual(other.status().lease_holder, "anna")
                other.pause()
                self.client.renew(30)
                self.assertLessEqual(self.client.status().lease_s, 30)
            other.set({"end_time": 4})
            with other.lease(0.1) as later:
                self.assertGreater(later, epoch)
                time.sleep(0.2)
                with self.assertRaises(meniscus.LeaseError) as caught:
                    other.set({"end_time": 5})
                self.assertEqual(caught.exception.status, "expired")
            other.set({"end_time": 5})

    def test_who_holds_a_lease_has_the_name_of_the_user_without_the_variable_too(self) -> None:
        self.load()
        for words, name in (({"USER": "anna"}, "anna"), ({"LOGNAME": "of a cron job"}, pwd.getpwuid(os.geteuid()).pw_name)):
            with mock.patch.dict(os.environ, words, clear=True), self.client.lease(60):
                self.assertEqual(self.client.status().lease_holder, f"{name}@{gethostname()[:30]}")
        with mock.patch.dict(os.environ, clear=True), mock.patch("pwd.getpwuid", side_effect=KeyError), self.client.lease(60):
            self.assertEqual(self.client.status().lease_holder, f"{os.geteuid()}@{gethostname()[:30]}")

    def test_fields_come_as_arrays(self) -> None:
        self.load()
        self.client.step(3)
        box = self.client.particles(["position", "pressure"], min=[0, 0], max=[0.2, 0.1])
        self.assertEqual(box["position"].shape, (len(box["pressure"]), 2))
        self.assertTrue((box["position"] <= [0.2, 0.1]).all() and (box["position"] >= 0).all())
        pressure = self.client.points("pressure", [[0.5, 0.5], [-9, 9]])
        self.assertTrue(np.isfinite(pressure[0]) and np.isnan(pressure[1]))
        with self.assertRaises(meniscus.MeniscusError) as caught:
            self.client.particles(limit=5)
        self.assertEqual(caught.exception.code, "RESOURCE_EXHAUSTED")
        words = meniscus.Client.particles.__doc__ or ""
        self.assertIn(f'{type(caught.exception).__name__}, whose status is "{caught.exception.status}"', words)
        first, second, last = self.client.particles()
        self.assertIn(f"none: {first}, {second} and {last}\n", words)

    def test_one_particle_in_so_many_is_always_the_same(self) -> None:
        self.client.load("dambreak2d", {"resolution": 10})
        self.assertEqual(set(self.client.particles("id")), {"id"}, "a name alone is a list of one")
        some = self.client.particles(["id"], every=4)["id"]
        self.assertTrue(180 < len(some) < 360, len(some))
        self.client.step(3)
        self.assertEqual(set(some), set(self.client.particles(["id"], every=4)["id"]))

    def test_a_checkpoint_is_restored_to_the_bit(self) -> None:
        self.load()
        self.client.step(4)
        before = self.client.status().state_hash
        file = self.client.checkpoint()
        self.assertTrue(Path(file.path).is_file())
        self.client.step(4)
        self.assertNotEqual(self.client.status().state_hash, before)
        self.assertEqual(self.client.restore(Path(file.path).name).step, 4)
        self.assertEqual(self.client.status().state_hash, before)

    def test_a_snapshot_says_where_it_is(self) -> None:
        self.load()
        self.assertTrue(Path(self.client.snapshot(["velocity"]).path).is_file())

    def test_wait_gives_up_in_time(self) -> None:
        self.load()
        with self.assertRaises(meniscus.TimedOutError):
            self.client.wait(["DONE"], timeout=0.2)

    def test_a_state_alone_is_a_list_of_one_and_one_there_is_not_is_refused(self) -> None:
        self.load()
        self.assertEqual(self.client.wait("READY", timeout=5).state, "READY")
        with self.assertRaisesRegex(meniscus.RefusedError, 'no state "REDY"; there are EMPTY, .*RECOVERING$') as caught:
            self.client.wait(["REDY"])
        self.assertEqual(caught.exception.path, "states")

    def test_a_wrong_state_is_an_exception_of_its_own(self) -> None:
        with self.assertRaises(meniscus.StateError) as caught:
            self.client.pause()
        self.assertEqual(caught.exception.status, "wrong state")
        self.assertEqual(set(caught.exception.allowed), {"RUNNING", "READY", "PAUSED"})
        self.assertIn("EMPTY", caught.exception.message)

    def test_a_diverged_run_is_an_exception_of_its_own(self) -> None:
        self.load(**{"limits.density_max": 1.0000001})
        with self.assertRaises(meniscus.DivergedError) as caught:
            self.client.step(100)
        self.assertEqual(caught.exception.status, "diverged")
        self.assertIn("restore()", caught.exception.hint)
        self.assertEqual(self.client.status().fault_reason, caught.exception.status)
        self.assertIn("diverged", self.client.status().fault or "")

    def test_a_breakpoint_pauses_the_run(self) -> None:
        self.load()
        self.client.breakpoint("b", step=6)
        self.client.start()
        self.assertEqual(self.client.wait(["PAUSED"], timeout=20).step, 6)
        self.client.breakpoint("c", condition="P05 > 1e9")
        known = {b.name: b for b in self.client.status().breakpoints}
        self.assertEqual(known["c"].condition, "P05 > 1e9")
        self.assertIn("density", [timer.name for timer in self.client.status().timers])
        for name in known:
            self.client.breakpoint(name)
        self.assertEqual(self.client.status().breakpoints, ())

    def test_a_refused_case_names_file_and_line(self) -> None:
        text = (ROOT / "server/cases/dambreak2d.yaml").read_text().splitlines()
        at = next(k for k, line in enumerate(text) if "density: 0.001" in line)
        text[at] = text[at].replace("0.001", "-1")
        file = self.home / "bad.yaml"
        file.write_text("\n".join(text))
        with self.assertRaises(meniscus.CaseError) as caught:
            self.client.load(file)
        self.assertTrue(caught.exception.message.startswith(f"{file}:{at + 1}:"), caught.exception.message)
        self.assertEqual(caught.exception.path, "fluids[1].density")

    def test_the_command_line_and_python_send_the_same_case(self) -> None:
        self.load()
        ours = self.client.status().state_hash
        self.meniscus("load", "dambreak2d", "--set", "resolution=20")
        self.assertEqual(self.client.status().state_hash, ours)

    def test_a_condition_on_the_step_is_kept(self) -> None:
        self.load()
        self.client.step(2)
        for command in (
            lambda step: self.client.start(if_step=step),
            lambda step: self.client.pause(if_step=step),
            lambda step: self.client.resume(if_step=step),
            lambda step: self.client.step(3, if_step=step),
            lambda step: self.client.run_until(1, if_step=step),
            lambda step: self.client.stop(if_step=step),
            lambda step: self.client.set({"end_time": 3}, if_step=step),
        ):
            with self.assertRaises(meniscus.StateError) as caught:
                command(1)
            self.assertEqual(caught.exception.path, "if_step")
        self.assertEqual(self.client.set({"end_time": 3}, if_step=2).effect_step, 2)
        self.assertEqual(self.client.step(1, if_step=2).step, 3)

    def test_capabilities_name_what_can_be_set(self) -> None:
        self.assertIn("end_time", [parameter.path for parameter in self.client.capabilities().parameters])

    def test_a_command_of_every_kind_has_a_method(self) -> None:
        methods = set(dir(self.client))
        missing = {field.name for field in meniscus_pb2.Request.DESCRIPTOR.oneofs_by_name["command"].fields} - methods
        self.assertEqual(missing, set())

    def test_codes_of_the_protocol_are_not_explained_as_if_they_were_exceptions(self) -> None:
        for name, command in inspect.getmembers(meniscus.Client, inspect.isfunction):
            named = set(re.findall(r"[A-Z_]+", command.__doc__ or "")) & set(meniscus_pb2.Code.keys()) - {"OK"}
            self.assertEqual(named, set(), name)

    def test_a_daemon_that_is_about_to_listen_is_waited_for(self) -> None:
        self.listen_late()
        with meniscus.Client(self.endpoint) as other:
            self.assertEqual(other.status().state, "EMPTY")
        self.listen_late()
        with mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.home / "run")), meniscus.Client("default") as other:
            self.assertEqual(other.status().state, "EMPTY")

    def test_a_daemon_that_hangs_is_not_said_to_be_gone(self) -> None:
        self.daemon.send_signal(signal.SIGSTOP)
        try:
            with self.assertRaises(meniscus.UnavailableError) as caught:
                meniscus.Client(self.endpoint)
        finally:
            self.daemon.send_signal(signal.SIGCONT)
        self.assertIn("no answer from", caught.exception.message)

    def test_cancel_ends_a_pending_wait(self) -> None:
        self.load()
        request = bytes(range(16))
        other = meniscus.Client(f"ipc://{self.home}/run/meniscus/default/control.ipc")
        self.addCleanup(other.close)

        def cancel() -> None:
            for _ in range(600):  # refused until there is such a command
                with contextlib.suppress(meniscus.MeniscusError):
                    other.cancel(request)
                    return
                time.sleep(0.1)

        canceller = threading.Thread(target=cancel)
        canceller.start()
        with self.assertRaises(meniscus.CancelledError):
            self.client.wait(["DONE"], timeout=60, request_id=request)
        canceller.join()

    def test_a_daemon_that_is_there_is_named_to_who_asks_for_another(self) -> None:
        there = 'no daemon "other"[^;]*; there is "default", as in MENISCUS_DAEMON=default; start one with `meniscusd --name other`'
        with mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.home / "run")), self.assertRaisesRegex(meniscus.UnavailableError, there):
            meniscus.Client("other")
        self.assertRegex(self.meniscus("-d", "other", "status", code=69).stderr, there)


class WithoutDaemon(unittest.TestCase):
    def setUp(self) -> None:
        os.environ["MENISCUS_CASES"] = str(ROOT / "server" / "cases")

    def test_an_unreachable_daemon_is_said_quickly(self) -> None:
        for daemon in ("nobody-of-that-name", "tcp://127.0.0.1:1", "ipc:///nonexistent/control.ipc"):
            with self.assertRaises(meniscus.UnavailableError) as caught:
                meniscus.Client(daemon)
            self.assertNotIn("no answer", str(caught.exception))  # which is said only after all of the patience

    def test_characters_that_are_not_seen_are_escaped_in_messages(self) -> None:
        odd = "x\u202ey\x1b[31m\u200b"
        asks: "tuple[Callable[[], object], ...]" = (
            lambda: meniscus.Snapshot(f"{odd}.hdf"),
            lambda: meniscus.ProbeSeries(odd),
            lambda: meniscus.commands.cancel(odd),
            lambda: meniscus.Client(odd),
            lambda: case.find(odd),
            lambda: meniscus.commands.wait([odd]),
        )
        for k, ask in enumerate(asks):
            with self.subTest(k), self.assertRaises((meniscus.MeniscusError, ValueError, OSError)) as caught:
                ask()
            for text in (str(caught.exception), getattr(caught.exception, "message", "")):
                self.assertFalse(set("\u202e\x1b\u200b") & set(text), ascii(text))
        self.assertIn("x\\u202ey\\x1b[31m", str(caught.exception))

    def test_every_failure_has_a_status_and_a_hint_whatever_its_source(self) -> None:
        for code in meniscus_pb2.Code.keys():
            if code in ("OK", "INTERNAL"):
                continue
            error = errors.error_for(code, "because")
            self.assertNotEqual(error.status, "internal error", code)
            self.assertTrue(error.hint, code)
        self.assertEqual(errors.error_for("RESOURCE_EXHAUSTED", "full", reason="no space").status, "no space")
        with self.assertRaises(meniscus.UnavailableError) as caught:
            meniscus.Client("nobody-of-that-name")
        self.assertEqual(caught.exception.status, "unavailable")
        self.assertIn("meniscusd", caught.exception.hint)

    def test_statuses_are_the_words_of_the_command_line(self) -> None:
        library = ctypes.CDLL(str(BUILD / "libmeniscus-client.so"))
        library.mns_status_name.restype = ctypes.c_char_p
        words = {library.mns_status_name(k).decode() for k in range(1, 64)} - {"unknown"}
        self.assertEqual(set(errors._HINTS), words)
        self.assertLessEqual(set(errors._STATUS.values()), words)

    def test_other_hosts_take_a_key(self) -> None:
        for daemon in ("tcp://10.0.0.1:80", "tcp://host.example:5555", "tcp://[2001:db8::7]:5555"):
            with self.assertRaises(meniscus.DeniedError):
                meniscus.Client(daemon)

    def test_what_is_no_endpoint_is_refused(self) -> None:
        for daemon in ("tcp://0.0.0.0:80", "tcp://127.0.0.1:65534", "../x", "udp://127.0.0.1:3"):
            with self.assertRaises(meniscus.RefusedError):
                meniscus.Client(daemon)

    def test_a_damaged_array_is_refused(self) -> None:
        frame = np.array([1.0, 2.0]).tobytes()
        array = meniscus_pb2.Array(name="p", type="<f8", shape=[2], xxh64=xxhash.xxh64_intdigest(frame))
        dialogue.check(meniscus_pb2.Reply(arrays=[array]), [frame])
        with self.assertRaises(meniscus.CorruptError):
            dialogue.check(meniscus_pb2.Reply(arrays=[array]), [frame[:-1] + b"\x01"])
        with self.assertRaises(meniscus.CorruptError):
            dialogue.check(meniscus_pb2.Reply(arrays=[array]), [])
        array.shape[0] = 3
        with self.assertRaises(meniscus.CorruptError):
            values.read_array(array, frame)

    def repeat(self, request: meniscus_pb2.Request, deaths: int) -> int:
        """Speak with daemons that end when they get the request, so many of them: how often it was sent."""
        spoken = dialogue.Dialogue("ipc:///tmp/nobody")
        spoken.note(zmq.EVENT_HANDSHAKE_SUCCEEDED)
        spoken.epoch = 1
        self.sent = 0
        steps = spoken.call(request)
        step = next(steps)
        while isinstance(step, (dialogue.Send, dialogue.Wait)):
            if isinstance(step, dialogue.Send):
                asked = meniscus_pb2.Request.FromString(step.frame)
                self.sent += not asked.HasField("status")
                if asked.HasField("status") or self.sent > deaths:
                    reply = meniscus_pb2.Reply(id=asked.id, code="OK", daemon_epoch=1 + self.sent)
                    spoken.deliver([reply.SerializeToString()])
                else:
                    spoken.note(zmq.EVENT_DISCONNECTED)
            try:
                step = steps.send(True)
            except StopIteration:
                return self.sent
            if self.sent and not spoken._connected:
                spoken.note(zmq.EVENT_HANDSHAKE_SUCCEEDED)
        raise AssertionError(step)

    def test_a_command_that_ends_every_daemon_is_not_given_to_each(self) -> None:
        step = meniscus_pb2.Request(step=meniscus_pb2.Step(count=1))
        self.assertEqual(self.repeat(step, 1), 2)
        with self.assertRaisesRegex(meniscus.UnavailableError, "ended 2 times"):
            self.repeat(step, 9)
        self.assertEqual(self.sent, 2)
        self.assertEqual(self.repeat(meniscus_pb2.Request(wait=meniscus_pb2.Wait()), 5), 6)

    def test_overrides_reach_into_lists_and_new_entries(self) -> None:
        text = case.CaseText("dambreak2d")
        text.set("fluids[1].viscosity", 0.5)
        text.set("output.checkpoint_interval", 1e-5)
        text.set("gravity", [0, -2])
        text.set("limits.density_max", "7")
        message = text.message()
        self.assertEqual(message.fluids[1].viscosity, 0.5)
        self.assertEqual(message.output.checkpoint_interval, 1e-5)
        self.assertEqual(list(message.gravity), ["0", "-2"])
        self.assertEqual(message.limits.density_max, 7)
        with self.assertRaises(meniscus.CaseError):
            text.set("fluids[9].density", 1)

    def test_values_of_a_case_may_be_those_of_numpy(self) -> None:
        text = case.CaseText({"dimensions": np.int64(2), "gravity": np.array([0.0, -9.81]), "constants": [{"name": "a, b: #c", "value": np.float64(3)}]})
        text.set("resolution", np.float32(40))
        text.set("end_time", np.array(2.5))
        text.set("output", {"probe_interval": np.float64(1e-5)})
        text.set("threads", np.uint8(3))
        message = text.message()
        self.assertEqual((message.resolution, message.end_time, message.output.probe_interval), (40, 2.5, 1e-5))
        self.assertEqual((message.threads, list(message.gravity)), (3, ["0.0", "-9.81"]))
        self.assertEqual(message.constants[0].name, "a, b: #c")
        for value, yaml in (
            (np.True_, "true"), ([np.float64(1e-5), 2], "[1e-05, 2]"), ("[0, 1]", "[0, 1]"), (["-2*t", "1", "min(1, t)"], '["-2*t", 1, "min(1, t)"]'),
            ({"at": np.zeros((2, 1))}, "{at: [[0.0], [0.0]]}"),
        ):
            self.assertEqual(case.as_yaml(value), yaml)
        with self.assertRaisesRegex(meniscus.CaseError, "^None is no value of a case"):
            text.set("end_time", None)

    def test_every_shipped_case_is_read(self) -> None:
        files = sorted((ROOT / "server/cases").glob("*.yaml"))
        self.assertGreater(len(files), 3)
        for file in files:
            self.assertGreater(case.CaseText(file).message().resolution, 0)

    def test_a_wrong_entry_is_named_with_its_place(self) -> None:
        for wrong, hint in ({"dimension": 2}, "dimensions"), ({"dimensions": "two"}, "whole number"), (
            {"fluids": {"name": "x"}}, "list"), ({"scheme": {"kernel": "gauss"}}, "wendland-c2"):
            with self.assertRaises(meniscus.CaseError) as caught:
                case.CaseText(wrong).message()
            self.assertRegex(caught.exception.message, r"^case:\d+:\d+: ")
            self.assertIn(hint, caught.exception.message)

    def test_a_case_that_is_not_there_is_guessed_at(self) -> None:
        for wrong, hint in ("dambrek2d", 'did you mean "dambreak2d"?'), ("xyz", "there are bubble-in-water2d, bubble2d-hysing1, "):
            with self.assertRaises(meniscus.CaseError) as caught:
                case.find(wrong)
            self.assertIn(hint, caught.exception.message)

    def test_a_wrong_override_is_its_own_place_and_is_guessed_at(self) -> None:
        for path, hint in (("resolutio", "resolution"), ("fluids[0].densty", "density"), ("outputs.walls", "output")):
            text = case.CaseText("dambreak2d")
            with self.assertRaises(meniscus.CaseError) as caught:
                text.set(path, 1)
            self.assertRegex(caught.exception.message, rf"^override {re.escape(path)}: ")
            self.assertIn(f'did you mean "{hint}"?', caught.exception.message)

    def test_the_package_can_be_built_as_pip_would(self) -> None:
        import tempfile

        with tempfile.TemporaryDirectory(prefix="mns-") as scratch:
            subprocess.run(
                ["/usr/bin/python3", "setup.py", "-q", "egg_info", "-e", scratch, "build", "-b", f"{scratch}/b",
                 "--build-lib", f"{scratch}/lib"], cwd=ROOT / "client/python", check=True, capture_output=True)
            done = subprocess.run(
                ["/usr/bin/python3", "-c", "import meniscus; print(meniscus.__version__, meniscus.case.find('dambreak2d'))"],
                capture_output=True, text=True, env=os.environ | {"PYTHONPATH": f"{scratch}/lib", "MENISCUS_CASES": ""}, cwd=scratch)
            self.assertEqual(done.stdout.split(), [meniscus.__version__, f"{scratch}/lib/meniscus/cases/dambreak2d.yaml"], done.stderr)


if __name__ == "__main__":
    unittest.main()
