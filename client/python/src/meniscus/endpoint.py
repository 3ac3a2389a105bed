# SPDX-License-Identifier: BSD-3-Clause
"""Where daemons listen: the rule is the one of <meniscus/client.h>."""

from __future__ import annotations

import asyncio
import ipaddress
import os
import re
import socket
import stat
import time
from pathlib import Path
from typing import List, Optional

from .errors import RefusedError, UnavailableError
from .texts import check_word

STARTING_S = 0.3
LOOK_S = 0.02
SYSTEM = Path("/run/meniscus")
_LOCALHOST = {"localhost": "127.0.0.1", "localhost.": "127.0.0.1", "ip6-localhost": "[::1]", "ip6-loopback": "[::1]"}


def _directories() -> List[Path]:
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    first = [Path(runtime) / "meniscus"] if runtime.startswith("/") else []  # as places_variable() of common/host/places.c
    return first + [SYSTEM, Path(f"/tmp/meniscus-{os.getuid()}")]


def _is_safe(base: Path, name: str) -> bool:
    """True if only this user can have put a socket there. In systemd's directories root decides that. As places_is_safe() of common/host/places.c."""
    for directory in (base, base / name):
        info = directory.lstat()
        if not stat.S_ISDIR(info.st_mode) or info.st_mode & 0o022 or (base != SYSTEM and info.st_uid != os.geteuid()):
            return False
    return True


def near_number(host: str) -> Optional[str]:
    """A number that only this machine reaches, in digits: all of 127.0.0.0/8, also in fewer parts or within IPv6, and [::1]. As
    address_of_near_number() of common/wire/address.c."""
    try:
        if not host.startswith("["):
            number = socket.inet_ntoa(socket.inet_aton(host))
            return number if number.startswith("127.") else None
        six = ipaddress.IPv6Address(host[1:-1])
    except (ValueError, OSError):
        return None
    if six.ipv4_mapped:
        return str(six.ipv4_mapped) if six.ipv4_mapped.is_loopback else None
    return "[::1]" if six.is_loopback else None


def near_host(host: str) -> Optional[str]:
    """This machine by any of its names: its address in digits. None: it is another one. As address_of_near() of common/wire/address.c; the name is not resolved
    again when the socket connects, so plain text goes nowhere else."""
    local = _LOCALHOST.get(host.lower()) or near_number(host)
    if local or host.lower() != socket.gethostname().lower():
        return local
    try:
        found = socket.getaddrinfo(host, None, socket.AF_INET, socket.SOCK_STREAM)
    except OSError:
        return None
    # Where --tcp of a daemon is, whatever /etc/hosts says of the name.
    return "127.0.0.1" if found and all(str(one[4][0]).startswith("127.") for one in found) else None


def _is_all(host: str) -> bool:
    """Does it stand for all addresses of a machine, as the star and 0.0.0.0 do in each of their spellings? As address_is_all() of common/wire/address.c."""
    try:
        if not host.startswith("["):
            return host == "*" or not any(socket.inet_aton(host))
        six = ipaddress.IPv6Address(host[1:-1])
    except (ValueError, OSError):
        return False
    return not int(six.ipv4_mapped if six.ipv4_mapped is not None else six)


def _tcp_endpoint(chosen: str) -> str:
    tcp = re.fullmatch(r"tcp://([a-zA-Z0-9.-]{1,100}|\[[0-9a-fA-F:.]+\]|\*):0*([1-9][0-9]{0,4})", chosen)
    if not tcp or int(tcp[2]) > 65533:
        raise RefusedError("INVALID_ARGUMENT", f'"{chosen}" is not an endpoint; allowed is tcp://HOST:PORT with 1 <= PORT <= 65533')
    if _is_all(tcp[1]):
        text = (f'"{chosen}" stands for all addresses of a machine, where a daemon may listen; a client connects to one of them: write '
                f"tcp://127.0.0.1:{int(tcp[2])} for this machine, or the name or address of another")
        raise RefusedError("INVALID_ARGUMENT", text)
    return f"tcp://{near_host(tcp[1]) or tcp[1]}:{int(tcp[2])}"


def control_endpoint(daemon: Optional[str] = None) -> str:
    """Endpoint of a daemon given by name, as ipc://PATH or as tcp://HOST:PORT.

    None means $MENISCUS_DAEMON, or "default". UnavailableError if no daemon of that name has a socket.
    """
    chosen = daemon or os.environ.get("MENISCUS_DAEMON") or "default"
    check_word("daemon", chosen)
    if chosen.startswith("ipc://") and len(chosen) > len("ipc://"):
        return chosen
    if chosen.startswith("tcp://"):
        return _tcp_endpoint(chosen)
    if "/" in chosen or ":" in chosen or chosen.startswith("."):
        raise RefusedError("INVALID_ARGUMENT", f'"{chosen}" is neither a name nor ipc://PATH nor tcp://HOST:PORT')
    but = ""
    for directory in _directories():
        file = directory / chosen / "control.ipc"
        try:
            file.stat()
            if _is_safe(directory, chosen):
                return f"ipc://{file}"
            but = but or f" ({directory} has one that is not asked, as others may write there)"
        except PermissionError:
            but = but or f" ({directory} is closed to this user; `sudo -u meniscus` reaches daemons that systemd started)"
        except OSError:
            pass  # it is elsewhere
    looked = ", ".join(str(directory) for directory in _directories())
    there = sorted(file.parent.name for directory in _directories() for file in directory.glob("*/control.ipc"))
    but += f'; there is "{there[0]}", as in MENISCUS_DAEMON={there[0]}' if there else ""
    raise UnavailableError(
        "UNAVAILABLE", f'no daemon "{chosen}" in {looked}{but}; start one with `meniscusd --name {chosen}`'
    )


def _look(daemon: Optional[str], deadline: float) -> Optional[str]:
    """Its endpoint; None if it is not there yet, UnavailableError if it is late."""
    try:
        return control_endpoint(daemon)
    except UnavailableError:
        if time.monotonic() > deadline:
            raise
        return None


def await_endpoint(daemon: Optional[str] = None) -> str:
    """The same of a daemon that may have been started in the line before, and has no socket yet."""
    deadline = time.monotonic() + STARTING_S
    while not (found := _look(daemon, deadline)):
        time.sleep(LOOK_S)
    return found


async def async_await_endpoint(daemon: Optional[str] = None) -> str:
    """The same while others go on."""
    deadline = time.monotonic() + STARTING_S
    while not (found := _look(daemon, deadline)):
        await asyncio.sleep(LOOK_S)
    return found


def telemetry_endpoint(control: str) -> str:
    """The telemetry socket that belongs to a control endpoint: telemetry.ipc beside it, or the next port."""
    return _beside(control, "telemetry.ipc", 1)


def data_endpoint(control: str) -> str:
    """The socket of streams: data.ipc beside it, or the port after the next."""
    return _beside(control, "data.ipc", 2)


def _beside(control: str, file: str, ports: int) -> str:
    if control.startswith("tcp://"):
        host, port = control.rsplit(":", 1)
        return f"{host}:{int(port) + ports}"
    return f"ipc://{Path(control[len('ipc://'):]).parent / file}"
