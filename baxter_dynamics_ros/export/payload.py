"""A body in the hand: what it adds to which of the arm's numbers, as every file says it."""

from ..model.arm import BaxterArm

# What is added to which parameter by a body of mass m whose centre is at (x, y, z) and whose
# second moments are Sxx and so on, all in body frame 7.
ADDED = {
    'xx7': 'Sxx', 'yy7': 'Syy', 'xy7': 'Sxy', 'xz7': 'Sxz', 'yz7': 'Syz', 'hx7': 'm*x',
    'hy7': 'm*y', 'yy6': 'Szz', 'hy6': '-m*z',
    'xx5': 'm*a5*a5', 'xz5': 'm*a5*d5', 'hx5': 'm*a5', 'yy4': 'm*d5*d5', 'hy4': '-m*d5',
    'xx3': 'm*a3*a3', 'xz3': 'm*a3*d3', 'hx3': 'm*a3', 'yy2': 'm*d3*d3', 'hy2': '-m*d3',
    'izz1': 'm*a1*a1',
}
_ADDED_TILTED = {'hx1': 'm*a1'}


def added(arm: BaxterArm) -> dict[str, str]:
    """Return which parameters of an arm a body in the hand changes: name -> what is added."""
    return {**ADDED, **({} if arm.dynamics.upright else _ADDED_TILTED)}


def rule(arm: BaxterArm) -> str:
    """Return how a file is changed to another payload."""
    anew = 'export again with --params and copy the numbers'
    p = arm.parameters
    if p.a[-1] or p.alpha[-1]:  # the hand is turned or moved aside, which is not that simple
        return f'For another payload {anew}.'
    sums = ', '.join(f'{name} += {text}' for name, text in added(arm).items())
    return (
        f'Another payload changes {len(added(arm))} parameters. A body of mass m [kg] with its '
        'centre at (x, y, z) [m] and second moments Sxx = int x x dm, Sxy = int x y dm, ... '
        f'[kg m^2], all in body frame 7 and from its origin, adds: {sums}. Body frame 7 has the '
        f'axes of the hand frame: x = x_hand, y = y_hand, z = z_hand + {p.d[-1]:.10g} m (d7). '
        'From inertia I about the centre, along these axes: Sxx = (Iyy + Izz - Ixx)/2 + m x x, '
        f'Sxy = m x y - Ixy, and so on. Or {anew}.')
