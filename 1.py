import meniscus

client = meniscus.Client()
with client.stream("fields", "position", "pressure", max_hz=10, exact={"pressure": 0.5}, pack="lz4", box=([0, 0], [0.5, 0.2])) as stream:
    for item in stream:                                # the newest; those skipped meanwhile are counted
        print(item.time, item.skipped, item["pressure"].mean(), item.units["pressure"])
cursor = None                                          # from the beginning
with client.stream("series", since=cursor) as stream:  # every row of the probes' series, once, over restarts of either side
    for item in stream:
        print(item["time"], item["front"])
        cursor = stream.cursor                         # to be kept with what was taken
