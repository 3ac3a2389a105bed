import meniscus

series = meniscus.ProbeSeries("runs/dambreak2d")                     # probes.hdf
series.time, series["front"], series.units["front"]
series.array("front", "P05")                                         # structured: step, time, front, P05
for snapshot in meniscus.Snapshots("runs/dambreak2d"):
    water = snapshot.select("water")                                 # a mask
    print(snapshot.time, snapshot["pressure"][:][water].max(), snapshot.units["pressure"])
    snapshot.array("position", "pressure")                           # structured
