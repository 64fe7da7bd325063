# SPDX-License-Identifier: Apache-2.0
"""Procedures of responders, ranked by what was observed and what was probably released."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_dispersion.identification.evidence import Evidence
from rocsafe_dispersion.identification.posterior import Identification, identify
from rocsafe_dispersion.identification.signatures import NO_AGENT, SOMETHING_ELSE
from rocsafe_geo.storage.named_file import require_file

SHIPPED = Path(__file__).with_name('procedures')
# A hypothesis below this probability adds no words to the question.
LEAST_PROBABILITY = 0.05
# Nor does one that evidence has not made so many times as probable as before.
RAISED = 1.5
# Below this probability of every agent the word `UNKNOWN` is looked for as well.
NAMED, UNKNOWN = 0.5, 'unknown'
MOST_BYTES = 1_000_000
_HEADING = re.compile(r'^#{1,6}\s+(.+?)\s*#*$', re.MULTILINE)
_WORD = re.compile(r'[a-z0-9]+')


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A part of a procedure below one heading: name of its file, heading, text."""

    file: str
    heading: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedSection:
    """A section that fits, its score of BM25, and the words because of which it was found."""

    section: Section
    score: float
    because_of: tuple[str, ...]


def read_sections(folder: Path) -> tuple[Section, ...]:
    """Return the sections of all Markdown files of a folder, in the order of their names.

    Raises
    ------
    ValueError
        If it is no folder, has no Markdown file, or one that is too large or not UTF-8.
    """
    if not folder.is_dir():
        raise ValueError(f'{folder}: must be a folder with procedures as Markdown files')
    found: list[Section] = []
    for path in sorted(folder.glob('*.md')):
        try:
            require_file(path)
            if path.stat().st_size > MOST_BYTES:
                raise ValueError(f'{path}: must be at most {MOST_BYTES} bytes')
            found += _sections(path.name, path.read_text(encoding='utf-8-sig'))
        except OSError as error:
            raise ValueError(f'{path}: {error.strerror}') from error
        except UnicodeDecodeError as error:
            raise ValueError(f'{path}: must be text in UTF-8') from error
    if not found:
        raise ValueError(f'{folder}: has no Markdown file (*.md) with text')
    return tuple(found)


def question(evidence: Evidence, found: Identification) -> dict[str, float]:
    """Return the words to look for, with their weights between 0 and 1.

    What was observed counts fully. Agents and their categories count by their probabilities, if
    the evidence made them more probable. If something was observed that names no agent, `UNKNOWN`
    counts fully, too.
    """
    weights: dict[str, float] = {}
    for report in evidence.reports:
        if report.is_true:
            _, _, words = report.observation.partition('_')
            weights |= dict.fromkeys(_words(words), 1.0)
    if evidence.un_number is not None:
        weights[str(evidence.un_number)] = 1.0
    before = identify(Evidence())
    least = {
        name: max(LEAST_PROBABILITY, RAISED * probability)
        for name, probability in (*before.probabilities, *before.categories.items())
    }
    for name, probability in (*found.probabilities, *found.categories.items()):
        if probability < least[name] or name in (NO_AGENT, SOMETHING_ELSE):
            continue
        for word in _words(name):
            weights[word] = max(weights.get(word, 0.0), probability)
    names = {name: share for name, share in found.probabilities if name != SOMETHING_ELSE}
    if evidence.is_positive and max(names.values()) < NAMED:
        weights[UNKNOWN] = 1.0
    return weights


def rank_sections(
    sections: Sequence[Section], words: dict[str, float], count: int = 5
) -> tuple[RankedSection, ...]:
    """Return the sections that have any of the words, the best first.

    The score is the sum of the BM25 scores of the words times their weights.
    """
    import bm25s

    if not words or not sections:
        return ()
    tokens = [_words(f'{one.heading} {one.text}') for one in sections]
    corpus = sorted({word for own in tokens for word in own})
    known = {word: weight for word, weight in words.items() if word in set(corpus)}
    if not known:
        return ()
    index = bm25s.BM25()
    index.index(tokens, show_progress=False)
    scores = sum(weight * index.get_scores([word]) for word, weight in known.items())
    order = np.argsort(-np.asarray(scores), kind='stable')[:count]
    return tuple(
        RankedSection(
            section=sections[at],
            score=float(scores[at]),
            because_of=tuple(sorted(set(tokens[at]) & set(known), key=lambda w: (-known[w], w))),
        )
        for at in order.tolist()
        if scores[at] > 0.0
    )


def _sections(file: str, text: str) -> list[Section]:
    """Return the parts below each heading; the text before the first has the name of the file."""
    parts = _HEADING.split(text)
    pairs = zip([file, *parts[1::2]], parts[0::2], strict=True)
    return [
        Section(file=file, heading=heading, text=body.strip())
        for heading, body in pairs
        if body.strip()
    ]


def _words(text: str) -> list[str]:
    return _WORD.findall(text.lower())
