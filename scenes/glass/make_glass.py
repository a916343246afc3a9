#!/usr/bin/env python3
"""Turns a profile about the y axis into goblet.obj: a wine glass as one closed surface with smooth normals.

    python3 scenes/glass/make_glass.py

The profile runs from the middle of the foot's underside out and up along the outside, over the rim, and down the
inside to the middle of the bowl: left of it is air, right of it is glass. It is a Catmull-Rom spline through the
points below (radius, height in metres), so its tangents, and with them the normals, are continuous; at both ends on
the axis the tangent is horizontal. Faces are counter-clockwise from the air side.
"""
import math
import os

SEGMENTS = 96   # about the axis
STEPS = 4       # spline steps between two points

PROFILE = [
    (0.0000, 0.0000), (0.0120, 0.0000), (0.0240, 0.0000), (0.0300, 0.0002), (0.0322, 0.0014), (0.0310, 0.0028),
    (0.0250, 0.0040), (0.0150, 0.0058), (0.0080, 0.0085), (0.0050, 0.0140), (0.0042, 0.0240), (0.0041, 0.0340),
    (0.0046, 0.0430), (0.0075, 0.0500), (0.0150, 0.0555), (0.0235, 0.0620), (0.0300, 0.0710), (0.0330, 0.0820),
    (0.0330, 0.0930), (0.0311, 0.1040), (0.0288, 0.1130), (0.0272, 0.1186), (0.0264, 0.1200), (0.0255, 0.1188),
    (0.0267, 0.1130), (0.0290, 0.1040), (0.0309, 0.0930), (0.0309, 0.0825), (0.0280, 0.0727), (0.0220, 0.0645),
    (0.0140, 0.0590), (0.0065, 0.0562), (0.0000, 0.0556),
]


def spline(points):
    """Points and unit tangents of the Catmull-Rom spline; mirrored in the axis at both ends."""
    mirror = lambda p: (-p[0], p[1])
    p = [mirror(points[1])] + points + [mirror(points[-2])]
    out = []
    for i in range(1, len(p) - 2):
        for k in range(STEPS):
            t = k / STEPS
            a, b, c, d = p[i - 1:i + 3]
            at = lambda j: 0.5 * (2 * b[j] + (c[j] - a[j]) * t + (2 * a[j] - 5 * b[j] + 4 * c[j] - d[j]) * t * t
                                  + (3 * b[j] - a[j] - 3 * c[j] + d[j]) * t ** 3)
            by = lambda j: 0.5 * ((c[j] - a[j]) + 2 * (2 * a[j] - 5 * b[j] + 4 * c[j] - d[j]) * t
                                  + 3 * (3 * b[j] - a[j] - 3 * c[j] + d[j]) * t * t)
            tangent = (by(0), by(1))
            length = math.hypot(*tangent)
            out.append(((at(0), at(1)), (tangent[0] / length, tangent[1] / length)))
    out.append((points[-1], (-1.0, 0.0)))
    return out


def main():
    rings = spline(PROFILE)
    lines = ["# A wine glass made by make_glass.py; metres, y up, closed.", "o goblet"]
    normals, faces, first = [], [], []
    count = 0
    for i, ((radius, height), (tr, ty)) in enumerate(rings):
        first.append(count + 1)
        # Outward normal of the profile: the tangent turned to the air side.
        nr, ny = ty, -tr
        pole = i in (0, len(rings) - 1)
        for k in range(1 if pole else SEGMENTS):
            s, c = math.sin(2 * math.pi * k / SEGMENTS), math.cos(2 * math.pi * k / SEGMENTS)
            r, n = (0.0, 0.0) if pole else (radius, nr)
            lines.append(f"v {r * c:.6f} {height:.6f} {-r * s:.6f}")
            up = math.copysign(1.0, ny) if pole else ny
            normals.append(f"vn {n * c:.4f} {up:.4f} {-n * s:.4f}")
            count += 1
    for i in range(len(rings) - 1):
        below, above = first[i], first[i + 1]
        for k in range(SEGMENTS):
            j = (k + 1) % SEGMENTS
            if i == 0:
                triangles = [(below, above + j, above + k)]
            elif i == len(rings) - 2:
                triangles = [(below + k, below + j, above)]
            else:
                triangles = [(below + k, below + j, above + j), (below + k, above + j, above + k)]
            faces += ["f " + " ".join(f"{v}//{v}" for v in t) for t in triangles]
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "goblet.obj")
    with open(path, "w", encoding="ascii") as out:
        out.write("\n".join(lines + normals + faces) + "\n")


main()
