"""Derivation of programs: the formulation on CasADi symbols, without structural zeros and ones."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import casadi

from .frames import N, Scalar, Scalars
from .program import Program, Value
from .quantities import Arm, ONLY_TILTED, PARAMETERS, Quantity


@cache
def program_of(quantity: Quantity, tilted: bool) -> Program:
    """
    Derive the program of a quantity.

    Unless tilted, gravity is along the axis of joint 1, which saves a few operations.
    """
    vectors = {name: [casadi.SX.sym(f'{name}[{i}]') for i in range(N)]
               for name in ('sin_q', 'cos_q', 'qd', 'qdd', 'tau')}
    parameters = {name: 0 if name in ONLY_TILTED and not tilted else casadi.SX.sym(name)
                  for name in PARAMETERS}
    arm = Arm(vectors['sin_q'], vectors['cos_q'], parameters)
    values = quantity.compute(arm, *(vectors[name] for name in quantity.inputs))
    symbols = [symbol for vector in vectors.values() for symbol in vector]
    symbols += [value for value in parameters.values() if isinstance(value, casadi.SX)]
    return trace(symbols, _flat(values))


def trace(inputs: Sequence[Any], outputs: Sequence[Any]) -> Program:
    """Turn expressions in scalar casadi.SX symbols, which name the inputs, into a program."""
    function = casadi.Function('f', [casadi.vertcat(*inputs)],
                               [casadi.densify(casadi.vertcat(*outputs))])
    program = Program()
    work: dict[int, Value] = {}
    results: dict[int, Value] = {}
    for k in range(function.n_instructions()):
        operator = function.instruction_id(k)
        read = function.instruction_input(k)
        write = function.instruction_output(k)
        if operator == casadi.OP_INPUT:
            work[write[0]] = program.input(inputs[read[1]].name())
        elif operator == casadi.OP_CONST:
            work[write[0]] = program.number(function.instruction_constant(k))
        elif operator == casadi.OP_OUTPUT:
            results[write[1]] = work[read[0]]
        elif operator in _RULES:
            work[write[0]] = _RULES[operator](program, *(work[i] for i in read))
        else:
            raise BaxterDynamicsError(f'no rule for the CasADi operation {operator}')
    program.outputs = [results[i] for i in range(len(outputs))]
    return program


_RULES: dict[int, Callable[..., Value]] = {
    casadi.OP_ADD: Program.sum,
    casadi.OP_SUB: Program.difference,
    casadi.OP_MUL: Program.product,
    casadi.OP_DIV: Program.quotient,
    casadi.OP_NEG: Program.negative,
    casadi.OP_SQ: lambda program, x: program.product(x, x),
    casadi.OP_TWICE: lambda program, x: program.sum(x, x),
    casadi.OP_INV: lambda program, x: program.quotient(program.number(1.0), x),
}


def _flat(values: Scalars) -> list[Scalar]:
    if isinstance(values, (list, tuple)):
        return [scalar for value in values for scalar in _flat(value)]
    return [values]
