"""The files of a program in C and in JavaScript, each with a test of its own."""

import itertools
import json
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from shockpc.core.spatial import Array
from shockpc.wings.symbols.c_and_javascript import JAVASCRIPT, C, digits, pieces
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

    def error(self, found: Array) -> float:
        """The maximum error of numbers (n, m)."""
        return float(np.max(np.abs(found - self.exact) / (np.abs(self.exact) + self.size)))


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
    in_c = lang == "c"
    words, size = (C, 300) if in_c else (JAVASCRIPT, 700)
    bodies, slots = pieces(program, inputs, words, "const double" if in_c else "const", size)
    given = ", ".join([*inputs, "w", "out"])
    taken = (
        ", ".join([*(f"const double *{name}" for name in inputs), "double *w", "double *out"])
        if in_c
        else given
    )
    # Not every piece reads all of its arguments.
    unused = "".join(f"(void){name};" for name in (*inputs, "w", "out")) + "\n" if in_c else ""
    begin = "static void" if in_c else "function"
    starts = [0, *itertools.accumulate(inputs.values())]
    rows = "{{{}}}" if in_c else "[{}]"
    parts = {
        "about": "".join(f" * {_in_comment(line)}".rstrip() + "\n" for line in about),
        "arrays": ", ".join(
            f"const double {name}[{n}]" if in_c else name for name, n in inputs.items()
        ),
        "names": "".join(f"#define LANDING_{name.upper()} {k}\n" for k, name in enumerate(outputs))
        if in_c
        else json.dumps(list(outputs)),
        "count": len(outputs),
        "most": most,
        "functions": "".join(
            f"{begin} piece{k}({taken}) {{\n{unused}{body}\n}}\n" for k, body in enumerate(bodies)
        ),
        "calls": "".join(f"piece{k}({given});\n" for k in range(len(bodies))),
        "slots": max(slots, 1),
        "n": len(samples.inputs),
        "inputs": starts[-1],
        "arguments": ", ".join(
            f"given[k] + {a}" if in_c else f"x.slice({a}, {b})"
            for a, b in itertools.pairwise(starts)
        ),
        "given": _rows(samples.inputs, rows, words),
        "exact": _rows(samples.exact, rows, words),
        "size": ", ".join(digits(x, words) for x in samples.size.tolist()),
        "error": MOST_ERROR,
    }
    files = {
        "landing.h": C_HEADER,
        "landing.c": C_SOURCE,
        "landing_test.c": C_TEST,
        "Makefile": MAKEFILE,
    }
    files = files if in_c else {"landing.mjs": JS_SOURCE, "landing_test.mjs": JS_TEST}
    return {name: template.format(**parts) for name, template in files.items()}


def _rows(table: Array, row: str, words: Mapping[str, str]) -> str:
    return "".join(
        row.format(", ".join(digits(x, words) for x in one)) + ",\n" for one in table.tolist()
    )


def _in_comment(line: str) -> str:
    """A line that ends no comment, and no script of a page in which the code stands."""
    for end in ("*/", "</", "<!--"):
        line = line.replace(end, f"{end[0]} {end[1:]}")
    return line
