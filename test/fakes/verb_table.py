# SPDX-License-Identifier: Apache-2.0
"""Answers to orders by the state of a vehicle: one table for simulated and for real vehicles."""

from enum import Enum


class Answer(Enum):
    """Answer of a vehicle to an order."""

    OBEYED = '+'
    # Accepted: it does already what is asked for.
    NOTHING = '='
    REFUSED = '-'


VERBS = ('hold', 'return_home', 'land', 'resume', 'go_to', 'set_speed', 'fence', 'rally')
# A row a state, a column a verb. Where both differ, the first sign is that of a simulated vehicle:
# the landing of a route or after a failure of its battery is not broken off, a real one's landing
# by order is; while it speaks to nobody, and while its route is being sent, there is none.
TABLE = {
    'disarmed': '= = = - - - + +',
    'waiting': '+ + + =- - - + +',
    'starting': '.+ .+ .+ .- .- .- .- .-',
    'armed': '.+ .+ .+ .- .- .- .- .-',
    'taking off': '+ + + = + + + +',
    'flying': '+ + + = + + + +',
    'holding': '= + + + + + + +',
    'returning': '+ = + - + + + +',
    'landing': '-+ -+ = - -+ -+ + +',
    'landed': '= = = - - - + +',
    'falling': '-. -. -. -. -. -. +. +.',
    'crashed': '=. =. =. -. -. -. +. +.',
    'lost': '.- .- .- .- .- .- .- .-',
}


def answers(*, is_real: bool) -> dict[tuple[str, str], Answer]:
    """Return the answer by state and verb; without those that such a vehicle does not have."""
    found = {}
    for state, row in TABLE.items():
        for verb, signs in zip(VERBS, row.split(), strict=True):
            sign = signs[-1 if is_real else 0]
            if sign != '.':
                found[state, verb] = Answer(sign)
    return found
