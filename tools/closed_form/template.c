#include "_closed_form.h"

#include <math.h>

/* Joints, and states computed at a time in a batch: whole vectors of any processor. */
enum { JOINTS = 7, BLOCK = 16 };

/* Inlined whatever its size: with a known stride, a loop over the states is vectorised. */
#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define INLINE static __forceinline
#else
#define INLINE static inline
#endif

/*
 * Sines and cosines of n angles to 1e-15. The first loop has no branch, so that compilers
 * vectorise it: Taylor series of half the angle, less whole turns, and the double-angle formulas.
 * Whole turns are exact below 1e8 rad; the C library computes larger angles.
 */
INLINE void sines_and_cosines(size_t n, const double *restrict x, double *restrict sines,
    double *restrict cosines)
{
    for (size_t i = 0; i < n; i++) {
        const double turns = rint(x[i] * 0.15915494309189535);
        const double y = 0.5 * (x[i] - turns * 6.283185243606567 - turns * 6.357301909411278e-08);
        const double z = y * y;
$series
        s = y + y * z * s;
        c = 1.0 + z * c;
        sines[i] = 2.0 * s * c;
        cosines[i] = (c - s) * (c + s);
    }
    for (size_t i = 0; i < n; i++)
        if (fabs(x[i]) > 1e8) {
            sines[i] = sin(x[i]);
            cosines[i] = cos(x[i]);
        }
}

/* Copies vectors of m states, one after the other, to the columns of a block; then zeros. */
INLINE void to_block(size_t m, const double *restrict states, double *restrict block)
{
    for (size_t j = 0; j < m; j++)
        for (size_t i = 0; i < JOINTS; i++)
            block[i * BLOCK + j] = states[i + JOINTS * j];
    for (size_t j = m; j < BLOCK; j++)
        for (size_t i = 0; i < JOINTS; i++)
            block[i * BLOCK + j] = 0.0;
}

/* Copies the first m columns of a block, one after the other. */
INLINE void from_block(size_t m, size_t size, const double *restrict block,
    double *restrict results)
{
    for (size_t j = 0; j < m; j++)
        for (size_t i = 0; i < size; i++)
            results[i + size * j] = block[i * BLOCK + j];
}

$kernels

#ifndef BAXTER_DYNAMICS_BATCHES_ONLY

$functions

#endif

$batches
