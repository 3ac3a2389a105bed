# SPDX-License-Identifier: BSD-3-Clause
"""Steer, watch and question Meniscus simulations.

    import meniscus
    with meniscus.Client() as client:
        client.load("dambreak2d", {"resolution": 20}, start=True)
        for message in client.subscribe("progress", "event"):
            print(message.time, message.state)
            if message.state in ("DONE", "FAULT"):
                break
        print(client.query())
"""

from .asynchronous import AsyncClient
from .client import TOPICS, Client
from .errors import (CancelledError, CaseError, CorruptError, DeniedError, DivergedError, LeaseError, MeniscusError,
                     RefusedError, StateError, TimedOutError, UnavailableError)
from .files import Field, ProbeSeries, Snapshot, Snapshots
from .plot import LivePlot
from .simulation import Bounds, Parameter, Parameters, Probes, Simulation
from .streams import Stream
from .values import Breakpoint, OutputFile, Reply, Scheduled, Status, StreamsNow, Telemetry, Timer, Value
from .wishes import Column, Cursor, StreamItem, StreamStats

__version__ = "0.1.0"
__all__ = ["AsyncClient", "Bounds", "Breakpoint", "CancelledError", "CaseError", "Client", "Column", "CorruptError", "Cursor",
           "DeniedError", "DivergedError", "Field", "LeaseError", "LivePlot", "MeniscusError", "OutputFile",
           "Parameter", "Parameters", "ProbeSeries", "Probes", "RefusedError", "Reply", "Scheduled", "Simulation", "Snapshot",
           "Snapshots", "StateError", "Status", "Stream", "StreamItem", "StreamStats", "StreamsNow", "TOPICS", "Telemetry", "TimedOutError", "Timer", "UnavailableError",
           "Value"]
