# SPDX-License-Identifier: Apache-2.0
"""Three roles, and the table of what each may do."""

from enum import Enum

from rocsafe_console.errors import RefusedError


class Role(Enum):
    """A viewer looks, an operator commands vehicles, a commander also decides what flies."""

    VIEWER = 'viewer'
    OPERATOR = 'operator'
    COMMANDER = 'commander'


class Action(Enum):
    """What somebody can ask of the console; values are the words of requests and of the log."""

    SEE = 'see'
    ACKNOWLEDGE = 'acknowledge'
    MARK = 'mark'
    HOLD = 'hold'
    RESUME = 'resume'
    RETURN = 'return'
    LAND = 'land'
    TAKE = 'take'
    RELEASE = 'release'
    GO_TO = 'go_to'
    SEND = 'send'
    REPLAN = 'replan'
    DRAFT = 'draft'
    LAUNCH = 'launch'
    END = 'end'
    RESUME_RUN = 'resume_run'
    REMAKE = 'remake'
    ASSIGN = 'assign'
    CLEAR = 'clear'
    SEAL = 'seal'
    REVOKE = 'revoke'


# Orders that vehicles fly or drive by; all else is to the console.
VERBS = frozenset(
    {
        Action.HOLD, Action.RESUME, Action.RETURN, Action.LAND, Action.TAKE, Action.RELEASE,
        Action.GO_TO, Action.SEND, Action.REPLAN,
    }
)  # fmt: skip
_OPERATOR = (VERBS - {Action.REPLAN}) | {
    Action.SEE, Action.ACKNOWLEDGE, Action.MARK, Action.DRAFT, Action.REMAKE,
}  # fmt: skip
MAY = {
    Role.VIEWER: frozenset({Action.SEE}),
    Role.OPERATOR: _OPERATOR,
    Role.COMMANDER: frozenset(Action),
}


def require(role: Role, action: Action) -> None:
    """Refuse an action that a role may not do; raises `RefusedError`."""
    if action not in MAY[role]:
        raise RefusedError(f'the role {role.value} may not {action.value.replace("_", " ")}')
