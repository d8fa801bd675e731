#!/usr/bin/python3
"""identify written in the usual way in Python, with rosbag and numpy. Prints the estimates.

    identify_in_python.py RUN.bag F0 Q
"""

import sys

import numpy as np
import rosbag

PERIOD = 100  # blocks


def pairs(path):
    """Elements and gains of each locked block."""
    waiting = {}
    with rosbag.Bag(path) as bag:
        topics = [topic for topic in bag.get_type_and_topic_info().topics
                  if topic.endswith(("orbital_elements", "control_gains"))]
        for topic, message, _ in bag.read_messages(topics=topics):
            other = waiting.pop(message.sequence, None)
            if other is None:
                waiting[message.sequence] = (topic, message)
                continue
            elements, gains = (message, other[1]) if "elements" in topic else (other[1], message)
            status = elements.status
            if status.amplitude_locked and status.quadrature_locked and status.phase_locked:
                yield elements, gains


def main():
    path, f0, quality = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
    w0 = 2 * np.pi * f0
    decay = w0 / (2 * quality)
    # a, b, gamma1, gamma2, mu1, mu2, ks, and the sums of a and b over the period.
    x = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    p = None
    measured = np.zeros(2)
    count = 0
    before = None
    for elements, gains in pairs(path):
        if before is None:
            before = elements
            continue
        h = 1e-9 * elements.duration
        w = gains.reference_frequency
        theta = 0.5 * (before.theta + elements.theta)
        phi = 0.5 * (before.phi + elements.phi)
        drive = np.array([complex(gains.drive.x_real, gains.drive.x_imag),
                          complex(gains.drive.y_real, gains.drive.y_imag)])
        turned = np.exp(-1j * phi) * np.array([[np.cos(theta), np.sin(theta)],
                                               [-np.sin(theta), np.cos(theta)]]) @ drive
        force = np.array([turned[0].imag, turned[1].real]) / (2 * w)
        if p is None:
            x[0], x[1] = elements.a, elements.b
            x[6] = decay / force[0]
            p = np.diag([1e-2, 1e-2, 0.1, 0.1, 1e-4, 1e-4, 0.5 * x[6], 0.0, 0.0]) ** 2
        s, c = np.sin(2 * theta), np.cos(2 * theta)
        g = x[2] * c + x[3] * s
        k2 = w0 * w0 / (2 * w)
        m = k2 * (x[4] * s - x[5] * c)
        f = np.eye(9)
        f[0, :7] += h * np.array([-decay * (1 + g), -m, -x[0] * decay * c, -x[0] * decay * s,
                                  -x[1] * k2 * s, x[1] * k2 * c, force[0]])
        f[1, :7] += h * np.array([m, -decay * (1 - g), x[1] * decay * c, x[1] * decay * s,
                                  x[0] * k2 * s, -x[0] * k2 * c, force[1]])
        x[:2] += h * np.array([-x[0] * decay * (1 + g) - x[1] * m + x[6] * force[0],
                               -x[1] * decay * (1 - g) + x[0] * m + x[6] * force[1]])
        x[7:] += x[:2]
        f[7:] += f[:2]
        p = f @ p @ f.T
        p[:2, :2] += h * 4e-12 * np.eye(2)
        measured += (elements.a, elements.b)
        before = elements
        count += 1
        if count % PERIOD:
            continue
        observation = np.zeros((2, 9))
        observation[0, 7] = observation[1, 8] = 1.0 / PERIOD
        noise = 25e-12 / h / PERIOD * np.eye(2)
        gain = p @ observation.T @ np.linalg.inv(observation @ p @ observation.T + noise)
        x += gain @ (measured / PERIOD - observation @ x)
        rest = np.eye(9) - gain @ observation
        p = rest @ p @ rest.T + gain @ noise @ gain.T
        x[7:] = 0.0
        p[7:, :] = 0.0
        p[:, 7:] = 0.0
        measured[:] = 0.0
    print("blocks", count, "gamma", x[2], x[3], "mu", x[4], x[5], "ks", x[6])


if __name__ == "__main__":
    main()
