"""Functions of CasADi: their derivatives by the tangent of a configuration, steps and texts."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi
import numpy as np

from shockpc.core.spatial import Array
from shockpc.robot.robot import Robot
from shockpc.wings.symbols.expressions import SYMBOLS
from shockpc.wings.symbols.programs import OPERATIONS, Program


def tangent(robot: Robot, q: casadi.SX) -> casadi.SX:
    """The derivatives (nq, nv) of a configuration by its tangent, Pinocchio's layout.

    Args: q (nq,).
    """
    T = casadi.SX(robot.model.nq, robot.model.nv)
    for joint in robot.single_joints:
        at, v = q[joint.q], joint.v
        if joint.kind in ("revolute", "prismatic"):
            T[joint.q.start, v.start] = 1.0
            continue
        if joint.kind == "continuous":
            T[joint.q, v] = casadi.vertcat(-at[1], at[0])
            continue
        if joint.kind == "planar":
            x, y = at[2], at[3]
            T[joint.q, v] = casadi.blockcat([[x, -y, 0], [y, x, 0], [0, 0, -y], [0, 0, x]])
            continue
        x, y, z, w = casadi.vertsplit(at[-4:])
        turns = slice(v.stop - 3, v.stop)
        T[joint.q.stop - 4 : joint.q.stop, turns] = (
            casadi.blockcat([[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]]) / 2
        )
        if joint.kind == "free":
            T[joint.q.start : joint.q.start + 3, v.start : v.start + 3] = SYMBOLS.rotation(
                [x, y, z, w]
            ).m
    return T


def with_slopes(y: casadi.SX, q: casadi.SX, before: casadi.SX, robot: Robot) -> casadi.SX:
    """Numbers (m,), then their derivatives (m, nv + before), row after row.

    They are by the tangent of q and by the motion before the impact.
    """
    slopes = casadi.horzcat(casadi.jacobian(y, q) @ tangent(robot, q), casadi.jacobian(y, before))
    return casadi.densify(casadi.vertcat(y, casadi.vec(slopes.T)))


NAMES = {
    casadi.OP_ADD: "add",
    casadi.OP_SUB: "subtract",
    casadi.OP_MUL: "multiply",
    casadi.OP_DIV: "divide",
    casadi.OP_FMAX: "maximum",
    casadi.OP_FMIN: "minimum",
    casadi.OP_LT: "less",
    casadi.OP_LE: "less_equal",
    casadi.OP_NEG: "negative",
    casadi.OP_INV: "reciprocal",
    casadi.OP_SQRT: "sqrt",
    casadi.OP_SIN: "sin",
    casadi.OP_COS: "cos",
    casadi.OP_FABS: "absolute",
    casadi.OP_SIGN: "sign",
    casadi.OP_NOT: "not",
    casadi.OP_SQ: "multiply",
    casadi.OP_TWICE: "add",  # of a value with itself
}
"""Operations of a program by CasADi's numbers."""


def compiled_program(inputs: Sequence[casadi.SX], outputs: casadi.SX) -> tuple[Program, str]:
    """The steps from vectors of inputs to one of outputs, and the text of their function.

    The inputs follow one another, and each expression is computed once.
    """
    function = casadi.Function("landing", [casadi.vertcat(*inputs)], [outputs], {"cse": True})
    return program_of(function), function.serialize()


def program_of(function: casadi.Function) -> Program:
    """The steps of a function of one vector."""
    n = function.numel_in(0)
    # Constants are told apart by their digits, because NaN is not equal to itself.
    digits: dict[int, str] = {}
    for k in range(function.n_instructions()):
        if function.instruction_id(k) == casadi.OP_CONST:
            digits[k] = float(function.instruction_constant(k)).hex()
    constants: dict[str, int] = {}
    for text in digits.values():
        constants.setdefault(text, n + len(constants))

    # CasADi uses a register for several values; in a program each value has a number of its own:
    # inputs first, then constants, then results of operations.
    names = list(OPERATIONS)
    register: dict[int, int] = {}
    operations: list[int] = []
    operands: list[tuple[int, int]] = []
    results = [0] * function.numel_out(0)
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        to = function.instruction_output(k)
        of = function.instruction_input(k)
        if operation == casadi.OP_CONST:
            register[to[0]] = constants[digits[k]]
        elif operation == casadi.OP_INPUT:
            register[to[0]] = of[1]
        elif operation == casadi.OP_OUTPUT:
            results[to[1]] = register[of[0]]
        else:
            operands.append((register[of[0]], register[of[-1]]))
            register[to[0]] = n + len(constants) + len(operations)
            operations.append(names.index(NAMES[operation]))
    return Program(
        inputs=n,
        constants=np.array([float.fromhex(text) for text in constants], dtype=float),
        operation=np.array(operations, dtype=np.uint8),
        operands=np.array(operands, dtype=np.int32).reshape(-1, 2),
        outputs=np.array(results, dtype=np.int32),
    )


def function_from(text: str) -> Callable[[Array], Any]:
    """The function of which this is the text, of arrays (n, N) with N columns."""
    function = casadi.Function.deserialize(text)
    return lambda columns: function(columns).full()


def function_of(
    text: str, inputs: Mapping[str, int], outputs: Mapping[str, slice]
) -> casadi.Function:
    """A function by its text.

    Args: inputs, sizes of the vectors that its input is made of; outputs, places among its outputs.
    """
    vectors = [casadi.SX.sym(name, size) for name, size in inputs.items()]
    rows = casadi.Function.deserialize(text)(casadi.vertcat(*vectors))
    return casadi.Function(
        "landing", vectors, [rows[part] for part in outputs.values()], [*inputs], [*outputs]
    )
