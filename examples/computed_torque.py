"""
Computed-torque control with M, C and G, compared with PD control plus gravity compensation.

Each controller is a function of state and reference. Both follow trajectory 3(b) of the paper, a
fast switch of the hand, with the same gains. The plant is the fake Baxter's: MuJoCo with the
manufacturer's robot description, independent of the model.

Run: python examples/computed_torque.py
"""

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.simulation.plant import default_truth, Plant, TIMESTEP
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory
import numpy as np

DURATION = 6.0  # [s]
KP, KD = 400.0, 40.0  # [1/s^2, 1/s]: critically damped, exp(-20 t)

ARM = BaxterArm(mount=mount('right'))
NOMINAL = np.diag(ARM.mass_matrix(HandTrajectory('right', 'switch').q))  # at the start [kg m^2]
RIGID, FRICTION = EffortModel.rigid(), default_truth(spring=False)


def computed_torque(q, qd, q_r, qd_r, qdd_r):
    """Return tau = M(q) (qdd_r + Kd ed + Kp e) + C(q, qd) qd + G(q)."""
    mass, coriolis, gravity = ARM.torque_terms(q, qd)
    return mass @ (qdd_r + KD * (qd_r - qd) + KP * (q_r - q)) + coriolis + gravity


def pd_with_gravity(q, qd, q_r, qd_r, qdd_r):
    """Return tau = M_0 (Kd ed + Kp e) + G(q), M_0 the diagonal of M(q) at the start."""
    return NOMINAL * (KD * (qd_r - qd) + KP * (q_r - q)) + ARM.gravity(q)


def switch():
    """Return the joint references q, qd, qdd, each (n, 7), one row per time step of the plant."""
    reference = HandTrajectory('right', 'switch')
    q = [reference.q]
    for _ in range(round(DURATION / TIMESTEP)):
        reference.advance(TIMESTEP)
        q.append(reference.q)
    qd = np.gradient(q, TIMESTEP, axis=0)
    return np.array(q), qd, np.gradient(qd, TIMESTEP, axis=0)


def follow(reference, controller, truth, compensated):
    """Return the RMS error (7,) [rad] on an arm with true and compensated friction."""
    plant = Plant('right', truth=truth)
    plant.place(reference[0][0])
    errors = []
    for q_r, qd_r, qdd_r in zip(*reference):
        errors.append(q_r - plant.q)
        plant.step(controller(plant.q, plant.qd, q_r, qd_r, qdd_r)
                   + compensated.friction(qd_r))
    return np.sqrt(np.mean(np.square(errors), axis=0))


def main():
    """Follow with both controllers on each arm, and print the errors."""
    reference = switch()
    columns = [1e3 * follow(reference, controller, truth, compensated)
               for truth, compensated in ((RIGID, RIGID), (FRICTION, RIGID), (FRICTION, FRICTION))
               for controller in (pd_with_gravity, computed_torque)]
    print(f'RMS of e = q_r - q [mrad] over {DURATION:g} s of trajectory 3(b); '
          f'Kp = {KP:g} 1/s^2, Kd = {KD:g} 1/s')
    print(f'{"":5} {"rigid arm":^24} {"friction":^24} {"friction compensated":^24}')
    print('joint' + 3 * f' {"PD+G":>8} {"computed torque":>15}')
    for joint, *errors in zip(JOINTS, *columns):
        print(f'{joint:5}' + (3 * ' {:8.3f} {:15.3f}').format(*errors))


if __name__ == '__main__':
    main()
