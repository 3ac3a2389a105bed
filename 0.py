import meniscus

with meniscus.Client() as client:                      # $MENISCUS_DAEMON, or the daemon named "default"
    client.load("dambreak2d", {"resolution": 20}, start=True)
    client.set({"gravity": [0.2, -1]}, at_step=500, wait=False)  # scheduled: see client.status().scheduled, client.cancel()
    for message in client.subscribe("progress", "event"):
        print(message.time, message.eta_s)
        if message.state in ("DONE", "FAULT"):
            break
    print(client.query("P05")["P05"])                  # Value(value=..., unit='Pa')
    water = client.particles(["position", "velocity"], min=[0, 0], max=[1, 1])["position"]  # numpy, [n][2]
