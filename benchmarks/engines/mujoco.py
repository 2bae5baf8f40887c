"""MuJoCo's inverse dynamics."""

import mujoco

from .engine import Engine
from .urdf import arm_urdf

_OPTIONS = ('<mujoco><compiler fusestatic="false" balanceinertia="false" boundmass="0" '
            'boundinertia="0"/><option gravity="{} {} {}"><flag contact="disable" '
            'constraint="disable"/></option></mujoco>')


def engines(arm) -> list:
    """Return mj_inverse and mj_forward; they read the state where it is written."""
    options = _OPTIONS.format(*map(float, arm.gravity_vector))
    model = mujoco.MjModel.from_xml_string(arm_urdf(arm.parameters, options))
    data = mujoco.MjData(model)
    # Views: looking the attributes up again costs a microsecond.
    position, velocity, acceleration = data.qpos, data.qvel, data.qacc
    applied, inverse = data.qfrc_applied, data.qfrc_inverse

    def tau(q, qd, qdd):
        position[:], velocity[:], acceleration[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        return inverse

    def forward(q, qd, tau):
        position[:], velocity[:], applied[:] = q, qd, tau
        mujoco.mj_forward(model, data)
        return acceleration

    return [Engine(name='MuJoCo', tau=tau, forward=forward,
                   notes={'tau': 'mj_inverse', 'forward': 'mj_forward'})]
