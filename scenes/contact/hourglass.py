#!/usr/bin/env python3
"""Writes scenes/hourglass.obj: a profile of radii turned about y.   usage: hourglass.py >hourglass.obj"""

import math

SEGMENTS = 32
PROFILE = [(0.00, 0.25), (0.15, 0.25), (0.47, 0.05), (0.53, 0.05), (0.85, 0.25), (1.00, 0.25)]  # height, radius

print("""\
# An hourglass, closed at both ends: a surface of revolution about y in 32 segments, from y = 0 to y = 1, facing outwards.
# Radius 0.25 up to y = 0.15, a cone down to 0.05 at y = 0.47, the neck up to y = 0.53, and the same upside down. m
# Written by hourglass.py.""")
for height, radius in PROFILE:
    for i in range(SEGMENTS):
        angle = 2 * math.pi * i / SEGMENTS
        # Twelve digits keep the quadrilaterals flat; adding zero turns -0 into 0.
        x = round(radius * math.cos(angle), 12) + 0.0
        z = round(radius * math.sin(angle), 12) + 0.0
        print(f"v {x:.12g} {height:g} {z:.12g}")
bottom = len(PROFILE) * SEGMENTS + 1
print(f"v 0 {PROFILE[0][0]:g} 0\nv 0 {PROFILE[-1][0]:g} 0")


def vertex(ring, i):
    return ring * SEGMENTS + i % SEGMENTS + 1


for ring in range(len(PROFILE) - 1):
    for i in range(SEGMENTS):
        print("f", vertex(ring, i), vertex(ring + 1, i), vertex(ring + 1, i + 1), vertex(ring, i + 1))
last = len(PROFILE) - 1
for i in range(SEGMENTS):
    print("f", bottom, vertex(0, i), vertex(0, i + 1))
    print("f", bottom + 1, vertex(last, i + 1), vertex(last, i))
