#!/usr/bin/env pvpython
# SPDX-License-Identifier: BSD-3-Clause
"""Draw snapshots with ParaView, or have it write them in another format: pvpython with_paraview.py SNAPSHOTS OUTPUT [FIELD]

SNAPSHOTS: snapshot-STEP.hdf, or snapshots.hdf.series, of which the last is taken. OUTPUT: .png for a picture of FIELD (pressure);
.csv, .vtu, .vtk or whatever else ParaView writes for the particles with all fields. Where there is no display: xvfb-run -a pvpython ...
"""

import sys

from paraview.simple import ColorBy, GetActiveViewOrCreate, OpenDataFile, SaveData, SaveScreenshot, Show

snapshots, output, field = [*sys.argv[1:3], *(sys.argv[3:] or ["pressure"])]
source = OpenDataFile(snapshots)
times = source.TimestepValues
last = times[-1] if hasattr(times, "__getitem__") and len(times) else (times or 0.0)
if output.endswith(".png"):
    view = GetActiveViewOrCreate("RenderView")
    view.ViewSize, view.ViewTime, view.OrientationAxesVisibility = [1200, 800], last, 0
    shown = Show(source, view)
    shown.Representation, shown.PointSize = "Points", 5
    ColorBy(shown, ("POINTS", field))
    shown.RescaleTransferFunctionToDataRange(True)
    shown.SetScalarBarVisibility(view, True)
    view.ResetCamera()
    SaveScreenshot(output, view)
else:
    source.UpdatePipeline(last)
    SaveData(output, source)
