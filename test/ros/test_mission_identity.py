# SPDX-License-Identifier: Apache-2.0
"""Processes of a mission are told from all others by the enclave of their process."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from rocsafe_ros.domain.mission_identity import MissionIdentity, identity_of, new_identity
from rocsafe_ros.interfaces import calls, topics

NAMES = st.from_regex('[A-Za-z0-9][A-Za-z0-9_-]{0,63}', fullmatch=True)
TOKENS = st.from_regex('[0-9a-f]{1,32}', fullmatch=True)


@pytest.mark.slow
@given(mission=NAMES, token=TOKENS)
def test_identity_is_read_from_the_enclave(mission: str, token: str) -> None:
    """Whatever the scenario is called, also with hyphens, which ROS forbids in names."""
    identity = MissionIdentity(mission=mission, token=token)
    assert identity_of(identity.enclave) == identity


@pytest.mark.parametrize('enclave', ['', '/', '/rocsafe', '/rocsafe/x', '/rocsafe/x/y', '/a/tf'])
def test_other_enclaves_are_of_no_mission(enclave: str) -> None:
    """Enclaves of somebody else's programs, and the default."""
    assert identity_of(enclave) is None


@pytest.mark.parametrize(('mission', 'token'), [('a b', '1'), ('', '1'), ('a', 'x'), ('a', '')])
def test_what_is_no_name_is_refused(mission: str, token: str) -> None:
    """One line that names the value."""
    with pytest.raises(ValueError, match='must be'):
        MissionIdentity(mission=mission, token=token)


def test_tokens_differ() -> None:
    """Two missions of one name are told apart, by 128 bits."""
    tokens = {new_identity('a').token for _ in range(50)}
    assert len(tokens) == 50
    assert all(len(token) == 32 for token in tokens)


def test_time_of_a_mission_has_names_of_its_own(ros_domain_id: int) -> None:
    """Clock, reports of steps and the switch of time; and others see the enclave."""
    identity = new_identity('small-20261123-020000')
    context = Context()
    rclpy.init(
        args=['--ros-args', *identity.ros_arguments], context=context, domain_id=ros_domain_id
    )
    node = Node('one', context=context)
    try:
        hidden = f'/_rocsafe_t{identity.token}'
        for spec in (topics.CLOCK, topics.STEP_DONE):
            name = topics.create_publisher(node, spec).topic_name
            assert name == f'{hidden}/{spec.name.lstrip("/")}'
        service = node.create_client(calls.WORLD_RUN.call_type, calls.WORLD_RUN.name)
        assert service.service_name == f'{hidden}/world/run'
        assert topics.create_publisher(node, topics.PLAN).topic_name == '/plan'
        enclaves = node.get_node_names_and_namespaces_with_enclaves()
        assert ('one', '/', identity.enclave) in enclaves
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
