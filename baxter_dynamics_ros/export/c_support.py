"""What the functions of an exported C source stand on: sines and cosines, blocks of states."""

from .series import LARGEST, PER_TURN, steps, TURN
from ..model.joints import N_JOINTS

# States computed at a time in a batch: whole vectors of any processor, all in its first cache.
BLOCK = 16

_HEAD = f"""#include <math.h>

/* Joints, and states computed at a time in a batch. */
enum {{ JOINTS = {N_JOINTS}, BLOCK = {BLOCK} }};

/* Inlined whatever its size: with a known stride, a loop over the states is vectorised. */
#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define INLINE static __forceinline
#else
#define INLINE static inline
#endif"""

_SIN_COS = f"""/*
 * Sine and cosine to 1e-15 for |x| < {LARGEST:g} rad, without a branch, so that the compiler
 * vectorises a loop: Taylor's series for half the angle, less whole turns, and the formulas of
 * the double angle.
 */
INLINE void sin_cos(double x, double *sine, double *cosine)
{{
    const double turns = rint(x * {PER_TURN!r});
    const double y = 0.5 * (x - turns * {TURN[0]!r} - turns * {TURN[1]!r});
    const double z = y * y;
%s
    s = y + y * z * s;
    c = 1.0 + z * c;
    *sine = 2.0 * s * c;
    *cosine = (c - s) * (c + s);
}}"""

_BLOCKS = """/* Vectors of m states, one after the other, as columns of a block; then zeros. */
INLINE void to_block(size_t m, const double *restrict states, double *restrict block)
{
    for (size_t i = 0; i < JOINTS; i++) {
        for (size_t j = 0; j < m; j++)
            block[i * BLOCK + j] = states[i + JOINTS * j];
        for (size_t j = m; j < BLOCK; j++)
            block[i * BLOCK + j] = 0.0;
    }
}

/* The first m columns of a block, one after the other. */
INLINE void from_block(size_t m, size_t size, const double *restrict block,
    double *restrict results)
{
    for (size_t j = 0; j < m; j++)
        for (size_t i = 0; i < size; i++)
            results[i + size * j] = block[i * BLOCK + j];
}"""


def support() -> str:
    """Return the text that goes before the functions."""
    lines: list[str] = []
    for sine, cosine, n, m in steps():
        for name, value, order in (('s', sine, n), ('c', cosine, m)):
            start = f'{name} = {name} * z +' if lines[1:] else f'double {name} ='
            text = f'{start} {value!r};'.replace('+ -', '- ')
            lines.append(f'    {text:<42} /* 1 / {order}! */')
    return '\n\n'.join((_HEAD, _SIN_COS % '\n'.join(lines), _BLOCKS))
