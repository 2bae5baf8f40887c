#ifndef BAXTER_DYNAMICS_H
#define BAXTER_DYNAMICS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The parameters of an arm. */
typedef struct baxter_dynamics_parameters {
$fields
} baxter_dynamics_parameters;

/* The parameters of the exported arm; copy and change them for another arm. */
extern const baxter_dynamics_parameters baxter_dynamics_default;

/*
 * Each function takes one state, and with the suffix _batch n states, one after the other: joint k
 * of state i is q[7 * i + k], and its results begin at i times the size of one result.
 * Matrices are stored row by row. Results must not overlap arguments. All functions are reentrant.
 */

$declarations

/* X(function, vectors that it takes, results that it writes) for each function. */
#define BAXTER_DYNAMICS_FUNCTIONS(X) \
$table

#ifdef __cplusplus
}
#endif

#endif /* BAXTER_DYNAMICS_H */
