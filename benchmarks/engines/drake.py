"""Drake's inverse dynamics."""

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from .engine import Engine
from .urdf import arm_urdf


def engines(arm) -> list:
    """Return CalcInverseDynamics, given gravity as an applied force, as Drake wants it."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(arm_urdf(arm.parameters), 'urdf')
    plant.mutable_gravity_field().set_gravity_vector(arm.gravity_vector)
    plant.Finalize()
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)

    def tau(q, qd, qdd):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        plant.CalcForceElementsContribution(context, forces)
        return plant.CalcInverseDynamics(context, qdd, forces)

    return [Engine(name='Drake', tau=tau, notes={
        'tau': 'CalcInverseDynamics, state and gravity set'})]
