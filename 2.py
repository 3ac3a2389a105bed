import asyncio, meniscus

async def main():
    async with meniscus.AsyncClient() as client:
        await client.load("dambreak2d", {"resolution": 20})
        samples = client.samples()                     # listens from here on; also events(), subscribe(TOPIC...)
        async with client.lease(60):                   # nobody else changes the run
            await client.start()
            async for sample in samples:
                if sample.values["front"].value > 3:
                    break
            await client.set({"gravity": [0, -2]})
        done, status = await asyncio.gather(client.wait(), client.status())

asyncio.run(main())
