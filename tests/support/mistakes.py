# SPDX-License-Identifier: BSD-3-Clause
"""What the types of the Python client have to refuse. It is never run: lint.sh has mypy read it, which complains of each line that it would let pass."""

from typing import List

import meniscus
import numpy as np

client = meniscus.Client()
client.stream("fields", "pressure", max_herz=10)  # type: ignore[call-arg]
client.stream("fields", "pressure", max_hz="10")  # type: ignore[arg-type]
client.stream("fields", "pressure", box=[0, 0, 1, 1])  # type: ignore[arg-type]
client.stream("fields", ["position", "pressure"])  # type: ignore[arg-type]
client.set({"end_time": 3}, at_stepp=5)  # type: ignore[call-arg]
client.points("pressure", object())  # type: ignore[arg-type]
client.wait(states=3)  # type: ignore[arg-type]
meniscus.AsyncClient().stream("fields", "pressure", max_herz=10)  # type: ignore[call-arg]

simulation = meniscus.Simulation()
simulation.parameters.update({"end_time": 3}, {"gravity": [0, -1]})  # type: ignore[call-arg]
simulation.parameters.update(3)  # type: ignore[arg-type]
simulation.probes.now("front").front  # type: ignore[attr-defined]
meniscus.Snapshots("runs")["pressure"]  # type: ignore[call-overload]
meniscus.Snapshots("runs")[-1].pressure  # type: ignore[attr-defined]

# And what they have to let pass.
client.stream("fields", "position", first=True, exact={"position": "f32"}, box=((0, 0), (1, 1)), sphere=(np.zeros(2), 0.1), phases=[0], timeout=5)
client.set({"end_time": 3, "gravity": np.array([0, -1.0])})
client.points("pressure", [[0.5, 0.5]])
client.wait("DONE")
simulation.parameters.update({"end_time": 3, "scheme.cfl": 0.2})
simulation.parameters.update(end_time=3)
pressures: List[float] = [snapshot["pressure"][:].max() for snapshot in meniscus.Snapshots("runs")[-3:]]
