# SPDX-License-Identifier: Apache-2.0
"""A campaign: a scenario, keys that vary or are drawn, seeds; and the runs that follow."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any
from zlib import crc32

import numpy as np
from pydantic import Field, ValidationError
from shapely.geometry import Polygon

from rocsafe_campaign.design.distributions import Distribution
from rocsafe_campaign.design.key_path import parts_of, with_value
from rocsafe_campaign.errors import CampaignError
from rocsafe_geo.storage.yaml_source import YamlError, read_yaml
from rocsafe_scenario.blocks.block import Block
from rocsafe_scenario.limits import LARGEST_SEED
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario, scenario_of
from rocsafe_scenario.validation_text import error_lines

MOST_RUNS = 1_000_000
LONGEST_PATH = 256
Single = float | int | bool | str
Seed = Annotated[int, Field(ge=0, le=LARGEST_SEED)]


class CampaignBlock(Block):
    """The content of a campaign file.

    Every combination of the values of `vary` is flown `repeats` times with each seed. Values of
    `draw` depend on key, seed and repeat only, so that combinations are compared on equal terms.
    """

    name: Annotated[str, Field(pattern=r'^[A-Za-z0-9][A-Za-z0-9_-]*$', max_length=64)]
    description: str = ''
    scenario: str
    seeds: Annotated[int, Field(ge=1, le=MOST_RUNS)] | tuple[Seed, ...] = 1
    repeats: int = Field(default=1, ge=1, le=MOST_RUNS)
    vary: dict[str, tuple[Single | tuple[Single, ...], ...]] = Field(default={})
    draw: dict[str, Distribution] = Field(default={})
    result: str = 'error_m'
    limit_s: float = Field(default=600.0, gt=0.0, le=86_400.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One run of a campaign.

    Attributes
    ----------
    number
        Its place in the campaign, from 0.
    inputs
        The values of the keys that vary or are drawn.
    """

    number: int
    seed: int
    repeat: int
    inputs: Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """A campaign whose first run has been checked.

    Attributes
    ----------
    block
        The file's content.
    scenario_path
        The scenario that it varies.
    content
        The content of that file.
    region
        Its region, longitudes and latitudes.
    """

    block: CampaignBlock
    scenario_path: Path
    content: Mapping[str, Any]
    region: Polygon

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the runs; a number means so many from 0."""
        seeds = self.block.seeds
        return tuple(range(seeds)) if isinstance(seeds, int) else seeds

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that vary or are drawn."""
        return (*self.block.vary, *self.block.draw)

    def runs(self) -> tuple[Run, ...]:
        """Return all runs, in an order that depends on the file only."""
        vary, draws = self.block.vary, {}
        combinations = [dict(zip(vary, values, strict=True)) for values in product(*vary.values())]
        for seed, repeat in product(self.seeds, range(self.block.repeats)):
            draws[seed, repeat] = self._drawn(seed, repeat)
        inputs = [
            (seed, repeat, {**fixed, **draws[seed, repeat]})
            for fixed in combinations
            for seed, repeat in draws
        ]
        return tuple(
            Run(number=number, seed=seed, repeat=repeat, inputs=values)
            for number, (seed, repeat, values) in enumerate(inputs)
        )

    def _drawn(self, seed: int, repeat: int) -> dict[str, Any]:
        return {
            key: each.drawn(_generator(seed, repeat, key), self.region)
            for key, each in self.block.draw.items()
        }

    def content_of(self, run: Run) -> dict[str, Any]:
        """Return the content of the scenario file of a run."""
        content: Any = self.content
        for key, value in run.inputs.items():
            content = with_value(content, key, value)
        return {**content, 'seed': run.seed}

    def scenario_of(self, run: Run) -> Scenario:
        """Return the scenario of a run.

        Raises
        ------
        ScenarioError
            One line for each mistake.
        """
        return scenario_of(self.content_of(run), self.scenario_path)

    def key_of(self, run: Run) -> str:
        """Return the hash of what a run depends on: the scenario, its files and its seed."""
        scenario = self.content_of(run)
        files = sorted(set(_texts(scenario)))
        digests = {text: _digest(self.scenario_path.parent / text) for text in files}
        content = [scenario, {k: v for k, v in digests.items() if v}, run.repeat]
        text = json.dumps(content, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:20]


def _texts(content: Any) -> Iterator[str]:
    """Yield every text of a scenario that may be the path of a file."""
    if isinstance(content, str):
        if content and len(content) < LONGEST_PATH:
            yield content
    elif isinstance(content, Mapping):
        for value in content.values():
            yield from _texts(value)
    elif isinstance(content, (tuple, list)):
        for value in content:
            yield from _texts(value)


@lru_cache(maxsize=256)
def _digest(path: Path) -> str:
    """Return the hash of the content of a file, empty if it is none."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ''


def _generator(seed: int, repeat: int, key: str) -> np.random.Generator:
    return np.random.default_rng([seed, repeat, crc32(key.encode())])


def read_campaign(path: Path) -> Campaign:
    """Read and check a campaign file and the scenario of its first run.

    Raises
    ------
    CampaignError
        In a line for each mistake.
    ScenarioError
        If the scenario, or that of the first run, is not valid.
    """
    block = _block(path)
    scenario_path = (path.parent / block.scenario).resolve()
    base = read_scenario(scenario_path)
    ring = [(place[1], place[0]) for place in base.region.polygon or ()]
    campaign = Campaign(
        block=block,
        scenario_path=scenario_path,
        content=read_yaml(scenario_path),
        region=Polygon(ring, [[(b, a) for a, b in hole] for hole in base.region.holes]),
    )
    if campaign.runs():
        campaign.scenario_of(campaign.runs()[0])
    return campaign


def _block(path: Path) -> CampaignBlock:
    try:
        block = CampaignBlock.model_validate(read_yaml(path))
    except YamlError as error:
        raise CampaignError(str(error)) from error
    except ValidationError as error:
        lines = error_lines(path.name, error, CampaignBlock)
        raise CampaignError('\n'.join(lines)) from error
    for key in (*block.vary, *block.draw):
        parts_of(key)
        if key == 'seed' or (key in block.vary and key in block.draw):
            raise CampaignError(f'{path.name}: {key}: must be said once, seeds by the key seeds')
    for key, values in block.vary.items():
        if not values:
            raise CampaignError(f'{path.name}: vary.{key}: must have a value or more')
    count = math.prod(map(len, block.vary.values())) * block.repeats
    count *= block.seeds if isinstance(block.seeds, int) else len(block.seeds)
    if not 1 <= count <= MOST_RUNS:
        raise CampaignError(f'{path.name}: {count} runs: must be 1 to {MOST_RUNS}')
    return block
