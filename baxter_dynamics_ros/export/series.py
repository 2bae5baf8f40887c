"""Sines and cosines without a branch or a call, which compilers vectorise: their numbers."""

from math import factorial

# Taylor's series of half the angle, less whole turns, give the sine and cosine of the angle by
# the formulas of the double angle, to 1e-15. From there up to LARGEST whole turns are exact.
PER_TURN = 0.15915494309189535
# 2 pi in two parts: the first has 25 bits, so that its product with a count of turns is exact.
TURN = 6.283185243606567, 6.357301909411278e-08
LARGEST = 1e8  # [rad]
_ORDER = 21  # of the last term


def steps() -> list[tuple[float, float, int, int]]:
    """
    Return the series' coefficients for Horner's scheme in the square of the angle.

    Returns
    -------
    list of tuple
        (coefficient of the sine, of the cosine, n, m) from the last term to the first: 1/n! and
        1/m! with their signs. What they end in, s and c, gives ``sin y = y + y z s`` and
        ``cos y = 1 + z c``, where z = y y.

    """
    return [((-1) ** (n // 2) / factorial(n), (-1) ** ((n - 1) // 2) / factorial(n - 1), n, n - 1)
            for n in range(_ORDER, 1, -2)]
