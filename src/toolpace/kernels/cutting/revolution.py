"""A convex solid of revolution, and the part of a ray that is within it.

Pieces (n, 6) from the tip upwards: z0, z1, a, b, arc, widest. Between the heights z0 and z1 the radius is a + b z
where arc is zero; else it is that of an arc of radius `arc` about the centre at radius a and height b, on the side
away from the axis. `widest` is the largest radius of the piece.
"""

from __future__ import annotations

import math

from toolpace.kernels.arrays import Floats
from toolpace.kernels.jit import jit

Z0, Z1, A, B, ARC, WIDEST = 0, 1, 2, 3, 4, 5
PARALLEL = 1e-12
"""Below this, a ray counts as along what it is compared with."""
ITERATIONS = 60


@jit()
def radius_at(pieces: Floats, z: float) -> tuple[float, float, float]:
    """Radius at a height, and the outward normal there: across the axis, and along it."""
    k = 0
    while k < len(pieces) - 1 and z >= pieces[k, Z1]:
        k += 1
    a, b, arc = pieces[k, A], pieces[k, B], pieces[k, ARC]
    if arc == 0.0:
        size = math.sqrt(1.0 + b * b)
        return max(a + b * z, 0.0), 1.0 / size, -b / size
    along = min(max((z - b) / arc, -1.0), 1.0)
    across = math.sqrt(1.0 - along * along)
    return max(a + arc * across, 0.0), across, along


@jit()
def nearest_normal(pieces: Floats, rho: float, z: float) -> tuple[float, float]:
    """The outward normal of the surface that is nearest to a point within: across the axis, and along it."""
    nearest, across, along = z - pieces[0, Z0], 0.0, -1.0
    for k in range(len(pieces)):
        if pieces[k, Z0] <= z <= pieces[k, Z1]:
            a, b, arc = pieces[k, A], pieces[k, B], pieces[k, ARC]
            if arc == 0.0:
                size = math.sqrt(1.0 + b * b)
                distance = (a + b * z - rho) / size
                if distance < nearest:
                    nearest, across, along = distance, 1.0 / size, -b / size
            else:
                out = math.sqrt((rho - a) ** 2 + (z - b) ** 2)
                if rho > a and arc - out < nearest and out > 0.0:
                    nearest, across, along = arc - out, (rho - a) / out, (z - b) / out
    return across, along


@jit()
def below_zero(a: float, b: float, c: float, low: float, high: float) -> tuple[float, float]:
    """The part between low and high with a t^2 + 2 b t + c <= 0; where that is two parts, the longer one."""
    if abs(a) < PARALLEL:
        if abs(b) > PARALLEL:
            if b > 0.0:
                return low, min(high, -0.5 * c / b)
            return max(low, -0.5 * c / b), high
        return (low, high) if c <= 0.0 else (1.0, 0.0)
    root = b * b - a * c
    if root <= 0.0:
        return (1.0, 0.0) if a > 0.0 else (low, high)
    q = -b - math.copysign(math.sqrt(root), b)
    first, second = q / a, c / q
    first, second = min(first, second), max(first, second)
    if a > 0.0:
        return max(low, first), min(high, second)
    if min(high, first) - low >= high - max(low, second):
        return low, min(high, first)
    return max(low, second), high


@jit()
def over_arc(pieces: Floats, k: int, t: float, off: float, base: float, lean: float) -> tuple[float, float]:
    """By how much a place of the ray is outside of an arc's torus, and the derivative along the ray."""
    z = base + t * lean
    rho = math.sqrt(max(off + t * t - z * z, 0.0))
    out = rho - pieces[k, A]
    rise = (t - z * lean) / rho if rho > 0.0 else 0.0
    if out < 0.0:
        out, rise = 0.0, 0.0
    up = z - pieces[k, B]
    size = math.sqrt(out * out + up * up)
    if size == 0.0:
        return -pieces[k, ARC], 0.0
    return size - pieces[k, ARC], (out * rise + up * lean) / size


@jit()
def within_arc(
    pieces: Floats, k: int, off: float, base: float, lean: float, low: float, high: float
) -> tuple[float, float]:
    """The part of a ray within a torus: distance is convex along it, so that Newton from outside finds both ends."""
    close = 1e-12 * pieces[k, WIDEST]
    for side in range(2):
        t = low if side == 0 else high
        sign = 1.0 if side == 0 else -1.0
        for _ in range(ITERATIONS):
            value, slope = over_arc(pieces, k, t, off, base, lean)
            if value <= close:
                break
            if sign * slope >= 0.0:
                return 1.0, 0.0
            t -= value / slope
            if t > high or t < low:
                return 1.0, 0.0
        if side == 0:
            low = t
        else:
            high = t
    return low, high


@jit()
def chord(pieces: Floats, off: float, base: float, lean: float) -> tuple[float, float]:
    """The part of a ray within the solid, as two places t; the first is above the second where there is none.

    At t the ray is at height base + lean t, and the square of its distance from the tip is off + t^2.
    """
    begin, end = math.inf, -math.inf
    across = 1.0 - lean * lean
    for k in range(len(pieces)):
        z0, z1, a, b, arc = pieces[k, Z0], pieces[k, Z1], pieces[k, A], pieces[k, B], pieces[k, ARC]
        low, high = -1e9, 1e9
        if abs(lean) < PARALLEL:
            if base < z0 or base > z1:
                continue
        else:
            low, high = (z0 - base) / lean, (z1 - base) / lean
            if low > high:
                low, high = high, low
        if arc == 0.0:
            c = a + b * base
            low, high = below_zero(
                across - lean * lean * b * b, -lean * (base + b * c), off - base * base - c * c, low, high
            )
        elif a == 0.0:
            low, high = below_zero(1.0, -b * lean, off - 2.0 * b * base + b * b - arc * arc, low, high)
        else:
            widest = pieces[k, WIDEST]
            low, high = below_zero(across, -lean * base, off - base * base - widest * widest, low, high)
            if low < high:
                low, high = within_arc(pieces, k, off, base, lean, low, high)
        if low < high:
            begin, end = min(begin, low), max(end, high)
    return begin, end
