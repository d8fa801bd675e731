#!/usr/bin/python3
"""Prints a TCP port for a ROS master: free now, and none that the system hands out by itself to whoever
asks for any, so that nobody takes it before the master does."""

import random
import socket
from pathlib import Path

FIRST, LAST = 11312, 65535  # above the port that a master has unless told


def free_ports():
    """One port after the other, none twice."""
    low, high = map(int, Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split())
    ports = [port for port in range(FIRST, LAST + 1) if not low <= port <= high]
    random.SystemRandom().shuffle(ports)
    for port in ports:
        with socket.socket() as listener:
            try:
                listener.bind(("", port))
            except OSError:
                continue
        yield port


if __name__ == "__main__":
    print(next(free_ports()))
