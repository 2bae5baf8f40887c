"""Peter Corke's Robotics Toolbox for Python: its recursive Newton-Euler in C."""

import roboticstoolbox

from .engine import Engine


def engines(arm) -> list:
    """Return rne of a DHRobot."""
    p = arm.parameters
    links = [roboticstoolbox.RevoluteDH(
        d=p.d[i], a=p.a[i], alpha=p.alpha[i], offset=p.theta_offset[i], m=p.mass[i],
        r=p.center_of_mass[i], I=p.inertia[i]) for i in range(len(p.mass))]
    robot = roboticstoolbox.DHRobot(links, gravity=arm.gravity_vector)
    return [Engine(name='Robotics Toolbox', tau=robot.rne, batch=robot.rne,
                   notes={'tau': 'rne of a DHRobot, in C', 'batch': 'rne of a trajectory'})]
