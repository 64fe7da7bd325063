# SPDX-License-Identifier: Apache-2.0
"""Sessions of users, and the limit of attempts to log in. Time is an argument, seconds."""

import hashlib
import secrets
from collections import deque
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from rocsafe_console.people.roles import Role

LONGEST_S = 12 * 3600.0
MOST_SESSIONS = 200
# A user has at most so many sessions, and so many links, so that he ends no session of others.
MOST_OF_USER = 20
ATTEMPTS, ATTEMPTS_S = 5, 60.0
_MOST_KEYS = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Session:
    """Somebody who is logged in, or a link that somebody has made.

    Attributes
    ----------
    public_id
        Names the session to others; its secret cannot be learned from it.
    is_link
        Whether it opens only what other programs read.
    """

    public_id: str
    user: str
    role: Role
    began_s: float
    address: str
    is_link: bool = False


class Sessions:
    """The sessions, known by a secret of 256 bits of which only the hash is kept."""

    def __init__(self) -> None:
        self._sessions: dict[str, Session] = {}

    def begin(
        self, user: str, role: Role, address: str, now_s: float, *, is_link: bool = False
    ) -> tuple[str, Session]:
        """Begin a session; return its secret and itself.

        The user's oldest ends if he has too many, and the oldest of all if there are too many.
        """
        secret = secrets.token_urlsafe(32)
        key = _key(secret)
        session = Session(
            public_id=key[:12],
            user=user,
            role=role,
            began_s=now_s,
            address=address,
            is_link=is_link,
        )
        self._sessions[key] = session
        own = [k for k, s in self._sessions.items() if (s.user, s.is_link) == (user, is_link)]
        for one in own[:-MOST_OF_USER]:
            del self._sessions[one]
        while len(self._sessions) > MOST_SESSIONS:
            del self._sessions[next(iter(self._sessions))]
        return secret, session

    def of_secret(self, secret: str, now_s: float) -> Session | None:
        """Return the session of a secret, None if there is none or it is over."""
        session = self._sessions.get(_key(secret))
        if session is None or now_s - session.began_s > LONGEST_S:
            return None
        return session

    def is_alive(self, session: Session, now_s: float) -> bool:
        """Return whether a session has neither been ended nor is over."""
        there = any(one.public_id == session.public_id for one in self._sessions.values())
        return there and now_s - session.began_s <= LONGEST_S

    def end(self, public_id: str) -> bool:
        """End a session; return whether there was one."""
        keys = [key for key, one in self._sessions.items() if one.public_id == public_id]
        for key in keys:
            del self._sessions[key]
        return bool(keys)

    def to_plain(self) -> dict[str, Any]:
        """Return the sessions by the hashes of their secrets, fit for JSON."""
        return {
            key: {**asdict(one), 'role': one.role.value} for key, one in self._sessions.items()
        }

    def restore(self, plain: Mapping[str, Any], roles: Mapping[str, Role]) -> None:
        """Take over sessions of an earlier process, of users who still have their role.

        Raises
        ------
        ValueError, KeyError, TypeError
            If `plain` is not what `to_plain` has returned.
        """
        for key, one in plain.items():
            session = Session(**{**one, 'role': Role(one['role'])})
            if roles.get(session.user) is session.role:
                self._sessions[key] = session

    def all(self, now_s: float) -> list[Session]:
        """Return the sessions that are not over."""
        return [s for s in self._sessions.values() if now_s - s.began_s <= LONGEST_S]


class AttemptLimit:
    """Limits what may be tried under a key, such as a user or an address, in some time."""

    def __init__(self, most: int = ATTEMPTS, within_s: float = ATTEMPTS_S) -> None:
        self._most = most
        self._within_s = within_s
        self._tried: dict[str, deque[float]] = {}

    def wait_s(self, key: str, now_s: float) -> float:
        """Return how long to wait until the next attempt, seconds; 0: none."""
        times = self._tried.get(key)
        if times is None or len(times) < self._most:
            return 0.0
        return max(times[0] + self._within_s - now_s, 0.0)

    def note(self, key: str, now_s: float) -> None:
        """Note an attempt."""
        if key not in self._tried and len(self._tried) >= _MOST_KEYS:
            del self._tried[next(iter(self._tried))]
        self._tried.setdefault(key, deque(maxlen=self._most)).append(now_s)

    def forgive(self, key: str) -> None:
        """Forget the attempts of a key: one has succeeded."""
        self._tried.pop(key, None)


class RefusalCount:
    """Counts what users were refused, and says which of it is worth a line of a log.

    Parameters
    ----------
    most, within_s
        Lines of one user in some seconds.
    """

    def __init__(self, most: int, within_s: float) -> None:
        self._limit = AttemptLimit(most, within_s)
        self._left_out: dict[str, int] = {}

    def note(self, user: str, now_s: float) -> int | None:
        """Note a refusal; return how many before it have no line, None: it has none, either."""
        if self._limit.wait_s(user, now_s):
            self._left_out[user] = self._left_out.get(user, 0) + 1
            return None
        self._limit.note(user, now_s)
        return self._left_out.pop(user, 0)


def _key(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()
