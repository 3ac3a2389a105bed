# SPDX-License-Identifier: BSD-3-Clause
"""A plot of probes that grows in place in a notebook. matplotlib and IPython are imported when it is drawn, not before."""

from __future__ import annotations

import io
import time
from typing import Any, Dict, List, Optional, Sequence, Tuple

from .client import Client
from .errors import MeniscusError, RefusedError
from .values import Telemetry

FLUSHED = 2.0  # [s] after which a series that is followed is on the disk
STILL = ("EMPTY", "READY", "PAUSED", "DONE", "FAULT", "STOPPING")


class LivePlot:
    """Probes over time, one set of axes for each unit.

        simulation.start()
        simulation.plot("front", "h1").follow()     # until the run stands still; interrupting the cell stops watching, not the run

    It needs neither %matplotlib nor ipympl: it is a picture that is put in the place of the last one. Outside of notebooks
    `figure` has what was drawn, as in plot.figure.savefig("front.png").
    """

    def __init__(self, client: Client, probes: Sequence[str], interval: float = 0.2) -> None:
        """interval: least time between two pictures [s]. RefusedError if there is nothing to plot."""
        if not probes:
            raise RefusedError("INVALID_ARGUMENT", "this case has no probes; add some to the case, and load it again", "probes")
        from matplotlib.figure import Figure

        values = client.query(*probes)
        self._client = client
        self._interval = interval
        self._points: Dict[str, Tuple[List[float], List[float]]] = {name: ([], []) for name in probes}
        units = list(dict.fromkeys(values[name].unit for name in probes))
        self.figure = Figure(figsize=(7, 1 + 2 * len(units)), layout="constrained")
        axes = self.figure.subplots(len(units), 1, sharex=True, squeeze=False)[:, 0]
        self._axes = dict(zip(units, axes))
        self._lines = {name: self._axes[values[name].unit].plot([], [], label=name)[0] for name in probes}
        for unit, ax in self._axes.items():
            ax.set_ylabel(f"[{unit}]" if unit else "")
            ax.legend(loc="upper left", frameon=False)
        axes[-1].set_xlabel("time [s]")
        self._shown: Any = None

    def add(self, sample: Telemetry) -> None:
        """One more sample of the topic "probe". One that goes back in time begins anew: the run was reset or restored."""
        for name in self._points:
            if name in sample.values:
                value = sample.values[name].value
                self._put(name, sample.time, float(value) if isinstance(value, (int, float)) else float("nan"))

    def _put(self, name: str, when: float, value: float) -> None:
        times, values = self._points[name]
        while times and times[-1] >= when:
            times.pop()
            values.pop()
        times.append(when)
        values.append(value)

    def _complete(self) -> None:
        """What came before we listened, and what was not read in time, is in the series, to the last sample that we have."""
        last = max((times[-1] for times, _ in self._points.values() if times), default=0.0)
        before, self._points = self._points, {name: ([], []) for name in self._points}
        with self._client.stream("series", *self._points, timeout=FLUSHED) as stream:
            for item in stream:
                for name in self._points:
                    for when, value in zip(item["time"], item[name]):
                        self._put(name, float(when), float(value))
                if float(item["time"][-1]) >= last:
                    break
        if not any(times for times, _ in self._points.values()):
            self._points = before

    def draw(self) -> None:
        """Bring the picture up to date, in the place of the last one."""
        for name, line in self._lines.items():
            line.set_data(*self._points[name])
        for ax in self._axes.values():
            ax.relim()
            ax.autoscale_view()
        self._show()

    def follow(self, timeout: Optional[float] = None) -> None:
        """Draw samples as they come until the run stands still, or timeout [s] pass without any message."""
        drawn = 0.0
        messages = self._client.subscribe("probe", "event", "progress", timeout=timeout)
        try:
            for message in messages:
                if message.topic == "probe":
                    self.add(message)
                if time.monotonic() > drawn + self._interval:
                    self.draw()
                    drawn = time.monotonic()
                if message.topic == "event" and message.state in STILL and self._client.status().state in STILL:
                    break  # the first may be the last one from before the start
        except KeyboardInterrupt:
            pass
        finally:
            messages.close()  # type: ignore[attr-defined]
        try:
            self._complete()
        except MeniscusError:
            pass  # the run is gone, or it has no series; what we have seen we have
        self.draw()

    def _show(self) -> None:
        try:
            from IPython import get_ipython
            from IPython.display import display
        except ImportError:
            return
        if get_ipython() is None:
            return
        if self._shown is None:
            self._shown = display(self, display_id=True)
        else:
            self._shown.update(self)

    def _repr_png_(self) -> Optional[bytes]:
        picture = io.BytesIO()
        self.figure.savefig(picture, format="png", dpi=90)
        return picture.getvalue()
