# SPDX-License-Identifier: Apache-2.0
"""Write the texts of a mission that the console shows: of vehicles, agents, estimators, checks.

They reach the page as sentences in English. The catalogue has their templates as they stand in
the code, with {0}, {1} for the values, and keeps what somebody has translated; a test keeps it
equal to the code.

    python tools/console_texts.py
"""

import ast
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / 'src'
CATALOGUE = SOURCE / 'rocsafe_console/rocsafe_console/static/mission_texts.js'
HEAD = """\
// SPDX-License-Identifier: Apache-2.0
// Written by tools/console_texts.py: what vehicles, agents, estimators, checks of scenarios say.
// A translation writes beside each what it is to be; '' leaves it as it is.
export const MISSION_TEXTS = {
"""
# Who speaks on the page, and the rooms of their code; '': all of it.
SPEAKERS = {
    'rocsafe_sim': ('driving', 'flight', 'messages', 'vehicle', 'vehicle_interface'),
    'rocsafe_mavlink': (
        'drone', 'flight', 'knowledge', 'plan', 'protocols', 'vehicle_interface', 'wire',
    ),
    'rocsafe_ros': ('lease', 'parameters.py', 'vehicle_health.py'),
    'rocsafe_fleet': ('',),
    'rocsafe_ground': ('',),
    'rocsafe_planner': ('',),
    'rocsafe_radiation': ('decision', 'localization', 'readings/row_checks.py'),
    'rocsafe_dispersion': ('estimation', 'mission_gas'),
    'rocsafe_scenario': ('',),
    'rocsafe_geo': ('argument.py', 'limits.py', 'mission_file.py', 'option.py', 'regions'),
    'rocsafe_orchestrator': (
        'conversions.py', 'fleet_verbs_node.py', 'mission', 'mission_commands', 'mission_state',
        'parameters/drive_goal.py', 'process_table/values.py', 'processes/interrupt.py',
        'processes/supervisor.py', 'requests', 'watches',
    ),
}  # fmt: skip
# Programs for a terminal, and settings of nodes, which only a terminal sees.
UNSEEN = re.compile(r'command_line/|_command\.py$|options\.py$|figure\.py$')
# Calls whose texts people see, names of their texts, and parameters.
TELLING = re.compile(r'refused|_all|_?note|note_all|finish|_?alarm|HTTP\w+')
TEXTS = frozenset({'text', 'told', 'words', 'why', 'silent', 'refusal'})
# Calls whose texts no page shows: of settings, logs and terminals.
UNTOLD = re.compile(
    r'option|\w*[Ff]ield|ConfigDict|add_argument|add_parser|debug|info|warning|exception|print|write'
)
# Methods that put their first argument into a sentence.
INSIDE = frozenset({'_require_mode', '_flight_for'})
# The name of whom a sentence is of, or another sentence.
BEGINNING = re.compile(r'\{0\}[:;,] ')
SENTENCE = re.compile(r'[a-z]{3,} ')
WORD = re.compile(r'[a-z][a-z ]+')


def templates_of(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of a module that reach the page, with numbers in place of values."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None:
            yield from _strings(node.exc)
        elif isinstance(node, ast.Call):
            yield from _of_call(node)
        elif isinstance(node, ast.Return | ast.Assign) and node.value is not None:
            names = {getattr(target, 'id', '') for target in getattr(node, 'targets', ())}
            if isinstance(node, ast.Return) or names & TEXTS:
                yield from _strings(node.value)


def _of_call(node: ast.Call) -> Iterator[str]:
    name = getattr(node.func, 'attr', getattr(node.func, 'id', ''))
    if TELLING.fullmatch(name):
        yield from (text for part in node.args for text in _strings(part))
    for keyword in node.keywords:
        if keyword.arg in TEXTS | {'reason'}:
            yield from _strings(keyword.value)


def sentences_of(tree: ast.AST) -> Iterator[str]:
    """Yield all sentences of a module but those of docstrings, settings and logs."""
    for node in ast.iter_child_nodes(tree):
        called = getattr(node, 'func', None)
        name = getattr(called, 'attr', getattr(called, 'id', ''))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.Call) and UNTOLD.fullmatch(name):
            continue
        if isinstance(node, ast.Constant | ast.JoinedStr):
            yield from _strings(node)
        else:
            yield from sentences_of(node)


def words_of(tree: ast.AST) -> Iterator[str]:
    """Yield the words that a module puts into sentences: names of states, and verbs."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and any('Enum' in ast.unparse(b) for b in node.bases):
            values = [part.value for part in node.body if isinstance(part, ast.Assign)]
        elif isinstance(node, ast.Call) and getattr(node.func, 'attr', '') in INSIDE:
            values = node.args[:1]
        else:
            continue
        for value in values:
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                yield value.value


def _strings(node: ast.AST) -> Iterator[str]:
    """Yield strings and f-strings in an expression that have words in them."""
    if isinstance(node, ast.JoinedStr):
        count, text = 0, ''
        for part in node.values:
            if isinstance(part, ast.Constant):
                text += str(part.value)
            else:
                text += f'{{{count}}}'
                count += 1
        words: list[object] = [text]
    elif isinstance(node, ast.Constant):
        words = [node.value]
    else:
        for child in ast.iter_child_nodes(node):
            yield from _strings(child)
        return
    for one in words:
        if isinstance(one, str) and SENTENCE.search(one) and not one.startswith('<'):
            yield one


def mission_texts() -> list[str]:
    """Return the templates of all speakers, in order."""
    found: set[str] = set()
    for package, rooms in SPEAKERS.items():
        folder = SOURCE / package / package
        for path in sorted(folder.rglob('*.py')):
            name = path.relative_to(folder).as_posix()
            if UNSEEN.search(name) or not any(_is_in(name, room) for room in rooms):
                continue
            tree = ast.parse(path.read_text(encoding='utf-8'))
            found.update(_alone(text) for text in sentences_of(tree))
            found.update(word for word in words_of(tree) if WORD.fullmatch(word))
    return sorted(found)


def _alone(template: str) -> str:
    """Return a template without what it begins with: the page parts both."""
    while (found := BEGINNING.match(template)) and SENTENCE.search(template[found.end() :]):
        rest = template[found.end() :]
        template = re.sub(r'\{(\d)\}', lambda number: f'{{{int(number[1]) - 1}}}', rest)
    return template.strip(' ,;')


def _is_in(name: str, room: str) -> bool:
    return not room or name == room or name.startswith(f'{room}/')


def translated(catalogue: str) -> dict[str, str]:
    """Return the entries of a catalogue."""
    inside = catalogue.partition('= {\n')[2].rpartition('};')[0].rstrip().removesuffix(',')
    entries: dict[str, str] = json.loads(f'{{{inside}}}')
    return entries


def written(before: dict[str, str]) -> str:
    """Return the catalogue of today with the translations of `before`."""
    lines = (
        f'  {json.dumps(text, ensure_ascii=False)}: '
        f'{json.dumps(before.get(text, ""), ensure_ascii=False)},\n'
        for text in mission_texts()
    )
    return f'{HEAD}{"".join(lines)}}};\n'


def main() -> int:
    """Write the catalogue."""
    before = translated(CATALOGUE.read_text(encoding='utf-8')) if CATALOGUE.is_file() else {}
    CATALOGUE.write_text(written(before), encoding='utf-8')
    sys.stdout.write(f'{CATALOGUE} written\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
