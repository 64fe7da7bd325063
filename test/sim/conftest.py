# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of the simulation; who uses none of the nodes' needs no ROS."""

from collections.abc import Iterator
from typing import Any

import pytest


@pytest.fixture
def operator(ros: Any) -> Iterator[Any]:
    """Return an operator in the test's own ROS context."""
    from test.sim.node_stand import Operator

    made = Operator(ros)
    yield made
    made.node.destroy_node()


@pytest.fixture
def world(ros: Any) -> Iterator[Any]:
    """Return a function that starts a world for the named participants."""
    from test.sim.node_stand import START_S, parameters

    from rocsafe_sim.world_node import WorldNode

    started = []

    def start(*participants: str, **values: Any) -> WorldNode:
        node = WorldNode(
            context=ros.context,
            parameter_overrides=parameters(
                participants=list(participants), start_time_s=START_S, **values
            ),
        )
        ros.executor.add_node(node)
        started.append(node)
        return node

    yield start
    for node in started:
        node.destroy_node()


@pytest.fixture
def rav(ros: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Return a function that starts a vehicle."""
    from test.sim.node_stand import FRAME, HOME_ENU, common, parameters

    from rocsafe_sim.rav_node import RavNode

    started = []

    def start(
        name: str = 'rav1', cameras: tuple[dict[str, Any], ...] = (), **values: Any
    ) -> RavNode:
        home = FRAME.position_of(HOME_ENU)
        node = RavNode(
            context=ros.context,
            namespace=f'/{name}',
            parameter_overrides=parameters(
                **{
                    'home_latitude_deg': home.latitude_deg,
                    'home_longitude_deg': home.longitude_deg,
                    **common(tmp_path_factory.mktemp('files'), *cameras),
                    **values,
                }
            ),
        )
        ros.executor.add_node(node)
        started.append(node)
        return node

    def stop(node: RavNode) -> None:
        ros.executor.remove_node(node)
        node.destroy_node()
        started.remove(node)

    start.stop = stop  # type: ignore[attr-defined]
    yield start
    for node in started:
        node.destroy_node()
