# SPDX-License-Identifier: Apache-2.0
"""Write the tables of `docs/interfaces.md` from the code: topics, services and actions.

Run by ``make docs``, in the environment of the built workspace. A table stands between the lines
``<!-- NAME: made by make docs -->`` and ``<!-- end of NAME -->``.
"""

import sys
from collections.abc import Iterable
from pathlib import Path

from rocsafe_ros.interfaces.calls import CALLS
from rocsafe_ros.interfaces.interface_spec import CallSpec, Scope, TopicSpec
from rocsafe_ros.interfaces.topics import TOPICS

DOCUMENT = Path(__file__).resolve().parents[1] / 'docs/interfaces.md'


def with_tables(text: str) -> str:
    """Return `text` with every table made anew.

    Raises
    ------
    ValueError
        If a table has no place in the text.
    """
    for name, table in tables().items():
        head, end = f'<!-- {name}: made by make docs -->\n', f'<!-- end of {name} -->'
        if text.count(head) != 1 or text.count(end) != 1:
            raise ValueError(f'{DOCUMENT.name} must have one place for table {name!r}')
        before, rest = text.split(head)
        text = before + head + table + end + rest.split(end)[1]
    return text


def tables() -> dict[str, str]:
    """Return every table by the name of its place."""
    return {
        'vehicle topics': _topic_table(Scope.VEHICLE),
        'fleet topics': _topic_table(Scope.FLEET),
        'calls': _call_table(),
    }


def _topic_table(scope: Scope) -> str:
    rows = [
        (f'`{spec.name}`', f'`{_type_name(spec.message_type)}`', _qos(spec), spec.rate, spec.note)
        for spec in TOPICS
        if spec.scope is scope
    ]
    return _table(('topic', 'type', 'QoS', 'rate', 'meaning'), rows)


def _call_table() -> str:
    rows = [
        (f'`{_call_name(spec)}`', spec.kind, f'`{_type_name(spec.call_type)}`', spec.note)
        for spec in CALLS
    ]
    return _table(('name', 'kind', 'type', 'meaning'), rows)


def _call_name(spec: CallSpec) -> str:
    return f'ravN/{spec.name}' if spec.scope is Scope.VEHICLE else spec.name


def _type_name(message_type: type) -> str:
    package, kind = message_type.__module__.split('.')[:2]
    return f'{package}/{kind}/{message_type.__name__}'


def _qos(spec: TopicSpec) -> str:
    if spec.qos.durability.name != 'TRANSIENT_LOCAL':
        return f'reliable, {spec.qos.depth} deep'
    kept = f'last {spec.qos.depth} kept for late subscribers'
    return 'reliable, latched' if spec.qos.depth == 1 else f'reliable, {kept}'


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, tuple('---' for _ in head), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


def main() -> int:
    """Rewrite the document."""
    DOCUMENT.write_text(with_tables(DOCUMENT.read_text()))
    return 0


if __name__ == '__main__':
    sys.exit(main())
