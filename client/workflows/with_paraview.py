#!/usr/bin/env pvpython
# SPDX-License-Identifier: BSD-3-Clause
"""Draw snapshots with ParaView, or have it write them in another format: pvpython with_paraview.py SNAPSHOTS OUTPUT [FIELD]

SNAPSHOTS: snapshot-STEP.hdf, or snapshots.hdf.series, of which the last is taken. OUTPUT: .png for a picture of FIELD (pressure);
.csv, .vtu, .vtk or whatever else ParaView writes for the particles with all fields. Where there is no display, a picture takes xvfb-run,
which is started by itself; without it: a ParaView built for EGL or OSMesa, which draws without one.
"""

import os
import shutil
import subprocess
import sys

from paraview.simple import ColorBy, GetActiveViewOrCreate, OpenDataFile, SaveData, SaveScreenshot, Show
from vtkmodules.vtkRenderingCore import vtkRenderWindow


def begin_again_with_display() -> None:
    """ParaView itself would crash at the first picture, and say nothing that helps."""
    xvfb, python = shutil.which("xvfb-run"), shutil.which("pvpython")
    if not xvfb or not python:
        sys.exit("there is no display, and this ParaView cannot draw without one: install xvfb-run (Debian: xvfb), or set DISPLAY")
    # Not in place of this process: xvfb-run takes the end of what MPI has started here for the sign that its display is there. And a display
    # that begins anew when nobody is connected may not be there when ParaView connects for the second time.
    sys.exit(subprocess.call([xvfb, "-a", "-s", "-screen 0 1280x1024x24 -noreset", python, *sys.argv]))


if len(sys.argv) < 3:
    sys.exit("pvpython with_paraview.py SNAPSHOTS OUTPUT [FIELD]: the files to read and to write are missing")
snapshots, output, field = [*sys.argv[1:3], *(sys.argv[3:] or ["pressure"])]
if output.endswith(".png") and not os.environ.get("DISPLAY") and vtkRenderWindow().GetClassName() == "vtkXOpenGLRenderWindow":
    begin_again_with_display()
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
