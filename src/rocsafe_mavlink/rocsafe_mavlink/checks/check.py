# SPDX-License-Identifier: Apache-2.0
"""One check before a flight: its subject, the value found, the value required."""

from dataclasses import dataclass
from enum import Enum

# Value of a setting that was asked for and may still be answered.
NOT_READ = 'not read yet'
# Checks that may pass a while after a vehicle was switched on or first heard.
_PASSING_SOON = frozenset({'contact', 'fix', 'satellites', 'self-test', 'home', 'settings'})


class CheckVerdict(Enum):
    """Result of a check."""

    PASS = 'pass'  # noqa: S105 - the opposite of fail
    WARN = 'warn'
    FAIL = 'fail'


@dataclass(frozen=True, slots=True)
class Check:
    """One check: what it is about, what was found, and what it must be."""

    name: str
    verdict: CheckVerdict
    value: str
    limit: str

    @property
    def may_pass_soon(self) -> bool:
        """Whether waiting can help, as after a vehicle was switched on."""
        is_untold = self.value == NOT_READ or 'not known' in self.value
        return is_untold or self.name in _PASSING_SOON


def failures(checks: tuple[Check, ...]) -> str:
    """Return what failed, in one line; empty if nothing did."""
    failed = (check for check in checks if check.verdict is CheckVerdict.FAIL)
    return '; '.join(f'{check.name} is {check.value}: must be {check.limit}' for check in failed)


def is_failed_for_good(checks: tuple[Check, ...]) -> bool:
    """Whether a check failed that cannot pass by waiting."""
    return any(check.verdict is CheckVerdict.FAIL and not check.may_pass_soon for check in checks)


def check_that(name: str, is_good: bool, value: str, limit: str) -> Check:
    """Return a check that passes or fails."""
    return Check(name, CheckVerdict.PASS if is_good else CheckVerdict.FAIL, value, limit)
