#!/usr/bin/env pvpython
# SPDX-License-Identifier: BSD-3-Clause
"""A state for ParaView: the particles of a run by pressure, with a scale and the time, of the last snapshot; the arrow plays the others.

    cd DIR && paraview --state=PATH/paraview_state.py

DIR is the run directory; or $MENISCUS_RUN names it, also where the state is chosen with File, Load State.
"""

import os

from paraview.simple import (AnnotateTimeFilter, ColorBy, GetActiveViewOrCreate, GetAnimationScene, GetColorTransferFunction,
                             GetScalarBar, OpenDataFile, RenameSource, Show)  # fmt: skip

run = OpenDataFile(os.path.join(os.environ.get("MENISCUS_RUN", "."), "snapshots.hdf.series"))
RenameSource("run", run)
view = GetActiveViewOrCreate("RenderView")
view.ViewSize, view.OrientationAxesVisibility = [1200, 800], 0
particles = Show(run, view)
particles.Representation, particles.PointSize = "Points", 5
ColorBy(particles, ("POINTS", "pressure"))
time = AnnotateTimeFilter(run, Format="t = {time:.4g} s")
RenameSource("time", time)
Show(time, view)

scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()
particles.RescaleTransferFunctionToDataRange(False)
particles.SetScalarBarVisibility(view, True)
GetScalarBar(GetColorTransferFunction("pressure"), view).Title = "pressure [Pa]"
view.ResetCamera()
