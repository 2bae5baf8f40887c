#include <stdio.h>

#include "baxter_dynamics.h"

int main(void)
{
    <states>
    double tau[7];

    baxter_dynamics_inverse_dynamics(q, qd, qdd, &baxter_dynamics_default, tau);
    for (int i = 0; i < 7; i++)
        printf("%.6f ", tau[i]);
    printf("\n");
    return 0;
}
