import meniscus

with meniscus.Client("tcp://192.0.2.7:5555", key="NAME.key") as client:   # or $MENISCUS_DAEMON and $MENISCUS_KEY
    print(client.status())
