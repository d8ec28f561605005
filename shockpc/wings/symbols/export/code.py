"""The files of a program in C and in JavaScript, each with a test of its own."""

import itertools
import json
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.symbols.c_and_javascript import JAVASCRIPT, C, StatementPieces, digits, pieces
from shockpc.wings.symbols.programs import Program


class Samples(NamedTuple):
    """Samples with which the test of a code compares its results.

    Attributes:
        inputs: (n, i) of the program, one row a posture.
        exact: (n, m) the numbers that `shock_profile` proves there, without condition and pivot.
        size: (m,) their medians: errors are relative to the number and this.
    """

    inputs: Array
    exact: Array
    size: Array

    def error(self, numbers: Array) -> float:
        """The maximum error of numbers (n, m)."""
        return float(np.max(np.abs(numbers - self.exact) / (np.abs(self.exact) + self.size)))


C_HEADER = """/*
{about} */
#ifndef LANDING_H
#define LANDING_H

/* Places in out. */
{names}#define LANDING_OUTPUTS {count}

/* Where the condition is above this, the posture is singular or nearly so:
   the numbers are not to be trusted. */
#define LANDING_MOST_CONDITION {most!r}

#ifdef __cplusplus
extern "C"
#endif
void landing({arrays}, double out[LANDING_OUTPUTS]);

#endif
"""

C_SOURCE = """/*
{about} */
#include "landing.h"
#include <math.h>

{functions}
void landing({arrays}, double out[LANDING_OUTPUTS])
{{
double w[{slots}];
{calls}}}
"""

C_TEST = """/* Compares landing.c with {n} exact landings, and prints the maximum error. */
#include "landing.h"
#include <math.h>
#include <stdio.h>

#define N {n}
#define M (LANDING_OUTPUTS - 2)

static const double given[N][{inputs}] = {{
{given}}};
static const double exact[N][M] = {{
{exact}}};
static const double size[M] = {{{size}}};

int main(void)
{{
    double worst = 0.0, out[LANDING_OUTPUTS];
    for (int k = 0; k < N; k++) {{
        landing({arguments}, out);
        for (int i = 0; i < M; i++) {{
            const double error = fabs(out[i] - exact[k][i]) / (fabs(exact[k][i]) + size[i]);
            if (worst == worst && !(error <= worst))
                worst = error; /* NaN stays. */
        }}
    }}
    printf("%.3g\\n", worst);
    return !(worst < {error!r});
}}
"""

MAKEFILE = """test: landing_test
\t./landing_test

landing_test: landing.c landing_test.c landing.h
\t$(CC) -std=c99 -O1 -o $@ landing.c landing_test.c -lm
"""

JS_SOURCE = """/*
{about} */

/** Where the condition is above this, the posture is singular or nearly so:
 *  the numbers are not to be trusted. */
export const mostCondition = {most!r};

/** Names of the numbers in out. */
export const names = {names};

const w = new Float64Array({slots});

{functions}
/** Writes the numbers of a landing into out, and returns it. */
export function landing({arrays}, out = new Float64Array({count})) {{
{calls}return out;
}}
"""

JS_TEST = """// Compares landing.mjs with {n} exact landings, and prints the maximum error.
import {{ landing }} from "./landing.mjs";

const given = [
{given}];
const exact = [
{exact}];
const size = [{size}];

let worst = 0;
given.forEach((x, k) => {{
    const out = landing({arguments});
    exact[k].forEach((value, i) => {{
        const error = Math.abs(out[i] - value) / (Math.abs(value) + size[i]);
        worst = Math.max(worst, error);
    }});
}});
process.stdout.write(worst + "\\n"); // console.log may colour it.
process.exitCode = worst < {error!r} ? 0 : 1;
"""

C_FILES = {
    "landing.h": C_HEADER,
    "landing.c": C_SOURCE,
    "landing_test.c": C_TEST,
    "Makefile": MAKEFILE,
}
JAVASCRIPT_FILES = {"landing.mjs": JS_SOURCE, "landing_test.mjs": JS_TEST}
"""Templates by file name."""

MOST_ERROR = 1e-9
"""Error of a number, relative to its size, above which the test of a code fails."""


def code_files(
    lang: Literal["c", "js"],
    program: Program,
    inputs: Mapping[str, int],
    outputs: Sequence[str],
    about: Sequence[str],
    most: float,
    samples: Samples,
) -> dict[str, str]:
    """A program in C99, or in JavaScript as a module, with a test of its own, by file name.

    Args:
        lang: the language.
        program: the program.
        inputs: sizes of its arrays by name.
        outputs: names of its outputs, one of each number.
        about: lines that say what it is of.
        most: condition up to which the numbers are to be trusted.
        samples: what the test compares with.
    """
    starts = [0, *itertools.accumulate(inputs.values())]
    parts: dict[str, object] = {
        "about": "".join(f" * {_in_comment(line)}".rstrip() + "\n" for line in about),
        "count": len(outputs),
        "most": most,
        "n": len(samples.inputs),
        "inputs": starts[-1],
        "error": MOST_ERROR,
    }
    if lang == "c":
        parts |= _parts_of_c(program, inputs, outputs, starts, samples)
        files = C_FILES
    else:
        parts |= _parts_of_javascript(program, inputs, outputs, starts, samples)
        files = JAVASCRIPT_FILES
    return {name: template.format(**parts) for name, template in files.items()}


def _parts_of_c(
    program: Program,
    inputs: Mapping[str, int],
    outputs: Sequence[str],
    starts: Sequence[int],
    samples: Samples,
) -> dict[str, object]:
    """Texts that replace the names in braces in files in C.

    Args: starts, of inputs in one array.
    """
    arguments = [*inputs, "w", "out"]
    types = [f"const double *{name}" for name in inputs] + ["double *w", "double *out"]
    # Not every piece reads all of its arguments.
    unused = "".join(f"(void){name};" for name in arguments)
    head = "static void piece{}(" + ", ".join(types) + ") {{\n" + unused + "\n"
    names = [f"#define LANDING_{name.upper()} {k}\n" for k, name in enumerate(outputs)]
    return {
        "arrays": ", ".join(f"const double {name}[{n}]" for name, n in inputs.items()),
        "names": "".join(names),
        "arguments": ", ".join(f"given[k] + {start}" for start in starts[:-1]),
        **_functions(pieces(program, inputs, C, "const double", 300), head, arguments),
        **_samples(samples, "{{{}}}", C),
    }


def _parts_of_javascript(
    program: Program,
    inputs: Mapping[str, int],
    outputs: Sequence[str],
    starts: Sequence[int],
    samples: Samples,
) -> dict[str, object]:
    """Texts that replace the names in braces in files in JavaScript.

    Args: as for `_parts_of_c`.
    """
    arguments = [*inputs, "w", "out"]
    head = "function piece{}(" + ", ".join(arguments) + ") {{\n"
    slices = [f"x.slice({a}, {b})" for a, b in itertools.pairwise(starts)]
    return {
        "arrays": ", ".join(inputs),
        "names": json.dumps(list(outputs)),
        "arguments": ", ".join(slices),
        **_functions(pieces(program, inputs, JAVASCRIPT, "const", 700), head, arguments),
        **_samples(samples, "[{}]", JAVASCRIPT),
    }


def _functions(parts: StatementPieces, head: str, arguments: Sequence[str]) -> dict[str, object]:
    """The functions of a program, and their calls.

    Args:
        parts: of the program.
        head: beginning of a function, with {} for its number.
        arguments: of each.
    """
    names = ", ".join(arguments)
    functions = [head.format(k) + body + "\n}\n" for k, body in enumerate(parts.bodies)]
    calls = [f"piece{k}({names});\n" for k in range(len(parts.bodies))]
    return {
        "functions": "".join(functions),
        "calls": "".join(calls),
        "slots": max(parts.slots, 1),
    }


def _samples(samples: Samples, row: str, words: Mapping[str, str]) -> dict[str, object]:
    """The numbers of a test. Args: row, form of a row; words, as for `pieces`."""
    return {
        "given": _rows(samples.inputs, row, words),
        "exact": _rows(samples.exact, row, words),
        "size": ", ".join(digits(x, words) for x in samples.size.tolist()),
    }


def _rows(table: Array, row: str, words: Mapping[str, str]) -> str:
    lines = []
    for values in table.tolist():
        numbers = ", ".join(digits(x, words) for x in values)
        lines.append(row.format(numbers) + ",\n")
    return "".join(lines)


def _in_comment(line: str) -> str:
    """A line that ends no comment, and no script of a page in which the code stands."""
    for end in ("*/", "</", "<!--"):
        line = line.replace(end, f"{end[0]} {end[1:]}")
    return line
