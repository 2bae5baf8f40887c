"""Solution of a symmetric system of equations, on scalars of any type."""

from .frames import Rows, Scalar, Scalars


def solve(m: Rows, right: Scalars) -> list[Scalar]:
    """Return m^-1 right for a symmetric positive definite m, which is overwritten."""
    x = list(right)
    inverse = [0] * len(x)
    for k in range(len(x)):  # m becomes L below its diagonal; L x = right
        inverse[k] = 1 / m[k][k]
        for i in range(k + 1, len(x)):
            factor = m[i][k] * inverse[k]
            for j in range(k + 1, i + 1):
                m[i][j] = m[i][j] - factor * m[j][k]
            x[i] = x[i] - factor * x[k]
    for k in range(len(x) - 1, -1, -1):
        x[k] = x[k] * inverse[k]
        for i in range(k + 1, len(x)):
            x[k] = x[k] - m[i][k] * inverse[k] * x[i]
    return x
