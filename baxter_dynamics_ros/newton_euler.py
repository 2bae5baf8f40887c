"""
The recursive Newton-Euler method on the same parameters, computed by Pinocchio.

The paper compares its closed form with this method. It shares no dynamics code with
:mod:`baxter_dynamics_ros.model`, only the parameters. No other module imports Pinocchio.
"""

import numpy as np
import pinocchio as pin

from .model import ArmParameters, Array, BaxterArm, JOINTS, N_JOINTS, Payload


def build_model(parameters: ArmParameters, payload: Payload, gravity: Array,
                mount: Array) -> pin.Model:
    """
    Build the Pinocchio model of one arm, with a frame named ``hand``.

    ``gravity`` (3,) [m/s^2] and ``mount`` (4, 4), the pose of frame {0}, are in the base frame.
    """
    model = pin.Model()
    model.gravity.linear = np.array(gravity)
    joint = 0
    placement = pin.SE3(np.array(mount))  # of the joint frame at q = 0
    for i, name in enumerate(JOINTS):
        placement = placement * pin.SE3(pin.utils.rotate('z', parameters.theta_offset[i]),
                                        np.zeros(3))
        joint = model.addJoint(joint, pin.JointModelRZ(), placement, name)
        # From the rotating frame to the paper's link frame: the rest of eq. (2).
        placement = pin.SE3(pin.utils.rotate('x', parameters.alpha[i]),
                            np.array([parameters.a[i], 0.0, parameters.d[i]]))
        body = pin.Inertia(parameters.mass[i], parameters.center_of_mass[i], parameters.inertia[i])
        model.appendBodyToJoint(joint, body, placement)
    load = pin.Inertia(payload.mass, np.array(payload.center_of_mass), payload.inertia_tensor)
    model.appendBodyToJoint(joint, load, placement)
    model.addFrame(pin.Frame('hand', joint, 0, placement, pin.FrameType.OP_FRAME))
    return model


class NewtonEuler:
    """Recursive Newton-Euler inverse dynamics with the parameters of a ``BaxterArm``."""

    def __init__(self, arm: BaxterArm) -> None:
        self.model = build_model(arm.parameters, arm.payload, arm.gravity_vector, arm.mount)
        self.data = self.model.createData()
        # Batches need a Pinocchio built with OpenMP.
        self._pool = pin.ModelPool(self.model, 1) if hasattr(pin, 'rneaInParallel') else None

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return tau (..., 7) [N m] for states q, qd, qdd (..., 7), already validated."""
        if q.ndim == 1:
            return pin.rnea(self.model, self.data, q, qd, qdd).copy()
        states = [x.reshape(-1, N_JOINTS) for x in (q, qd, qdd)]
        if self._pool is None:
            tau = np.array([self.inverse_dynamics(*state) for state in zip(*states)])
        else:
            tau = np.empty(states[0].shape)
            pin.rneaInParallel(1, self._pool, *(x.T for x in states), tau.T)
        return tau.reshape(q.shape)
