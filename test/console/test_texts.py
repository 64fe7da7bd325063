# SPDX-License-Identifier: Apache-2.0
"""All texts that the page shows stand in one catalogue: its own, and those of the server."""

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import rocsafe_console

PACKAGE = Path(rocsafe_console.__file__).parent
CATALOGUE = PACKAGE / 'static' / 'texts.js'
# Commands of a terminal, what they read, and the start of the server: no page shows it.
OF_TERMINALS = (
    'console_command.py', 'users_command.py', 'seal_command.py', 'verify_command.py',
    'serve_node.py', 'people/users.py', 'runs/base_map.py', 'runs/raster_map.py',
    'outward/cursor_on_target.py', 'outward/event_target.py', 'outward/features.py',
    'web/door.py', 'web/event_sender.py', 'web/server.py',
)  # fmt: skip
# Calls whose texts people see, names of their texts, and parameters.
TELLING = re.compile(r'refused|_all|_?note|note_all|finish|_?alarm|HTTP\w+')
TEXTS = frozenset({'text', 'told', 'words', 'why', 'silent', 'refusal'})


def templates_of(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of a module that reach the page, with numbers in place of values."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None:
            yield from _strings(node.exc)
        elif isinstance(node, ast.Call):
            name = getattr(node.func, 'attr', getattr(node.func, 'id', ''))
            if TELLING.fullmatch(name):
                yield from (text for part in node.args for text in _strings(part))
            for keyword in node.keywords:
                if keyword.arg in TEXTS | {'reason'}:
                    yield from _strings(keyword.value)
        elif isinstance(node, ast.Return | ast.Assign) and node.value is not None:
            names = {getattr(target, 'id', '') for target in getattr(node, 'targets', ())}
            if isinstance(node, ast.Return) or names & TEXTS:
                yield from _strings(node.value)


def _strings(node: ast.AST) -> Iterator[str]:
    """Yield strings and f-strings in an expression that have words in them."""
    if isinstance(node, ast.JoinedStr):
        count, text = 0, ''
        for part in node.values:
            if isinstance(part, ast.Constant):
                text += part.value
            else:
                text += f'{{{count}}}'
                count += 1
        words = [text]
    elif isinstance(node, ast.Constant):
        words = [node.value]
    else:
        for child in ast.iter_child_nodes(node):
            yield from _strings(child)
        return
    yield from (one for one in words if isinstance(one, str) and re.search(r'[a-z]{3,} ', one))


def refusals_in_python() -> dict[str, str]:
    """Return the texts of the server that the page shows, with a module of each."""
    found = {}
    for path in sorted(PACKAGE.rglob('*.py')):
        name = path.relative_to(PACKAGE).as_posix()
        if name not in OF_TERMINALS:
            tree = ast.parse(path.read_text(encoding='utf-8'))
            found.update(dict.fromkeys(templates_of(tree), name))
    return found


def catalogue() -> list[str]:
    """Return the texts of the server in the catalogue of the page."""
    text = CATALOGUE.read_text(encoding='utf-8')
    (inside,) = re.findall(r'\nexport const REFUSALS = {\n(.*?)\n};', text, re.DOTALL)
    return [
        next(iter(json.loads(f'{{{line.removesuffix(",")}}}'))) for line in inside.splitlines()
    ]


def test_every_refusal_of_the_server_is_in_the_catalogue():
    """And nothing else is: who translates the catalogue has translated the page."""
    found = refusals_in_python()
    written = catalogue()
    assert len(set(written)) == len(written)
    missing = {text: name for text, name in found.items() if text not in written}
    assert not missing, '\n'.join(json.dumps(text) for text in missing)
    assert not set(written) - found.keys()


SHOWN = re.compile(r"""(?:text|placeholder|title|alt|'aria-label'): (['`])((?:\\.|(?!\1).)*)\1""")


@pytest.mark.parametrize('path', sorted(PACKAGE.glob('static/*.js')), ids=lambda path: path.name)
def test_no_script_has_words_of_its_own(path):
    """What an element shows comes from the catalogue, but for names, numbers and signs."""
    if path == CATALOGUE:
        return
    for _, text in SHOWN.findall(path.read_text(encoding='utf-8')):
        words = re.sub(r'\$\{(?:[^{}]|\{[^{}]*\})*\}?', '', text)
        assert not re.search(r'[A-Za-z]{2,} ?[A-Za-z]', words), text
