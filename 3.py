import meniscus

with meniscus.Simulation("lab") as simulation:
    simulation.load("dambreak2d", {"resolution": 20})
    simulation.run_until(0.5)
    simulation.time, simulation.state                                # 0.5, "PAUSED"
    cfl = simulation.parameters.scheme.cfl                           # or parameters["scheme.cfl"]
    float(cfl), cfl.unit, cfl.bounds, cfl.meaning                    # 0.1 in cfl.bounds
    simulation.parameters.gravity = [0, -2]                          # RefusedError if it is out of bounds
    simulation.parameters.update({"end_time": 3, "scheme.cfl": 0.2}) # at one step, or not at all
    simulation.probes["front"], simulation.probes.units["front"]     # a float; nan: nothing to measure
    simulation.probes.now("front", "h1")                             # a record, all of one step
    simulation.particles(["position"])["position"]                   # numpy, in the memory it was received in
