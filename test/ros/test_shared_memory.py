# SPDX-License-Identifier: Apache-2.0
"""Segments of ports that a killed process left without a size."""

from pathlib import Path

from rocsafe_ros.domain import shared_memory
from rocsafe_ros.domain.shared_memory import remove_torn_ports


def test_a_port_without_a_size_is_removed_and_all_else_stays(tmp_path: Path) -> None:
    """Only the segment of a port can keep participants waiting."""
    (tmp_path / 'fastrtps_port7000').touch()
    kept = ['fastrtps_port7411_el', 'fastrtps_0a1b', 'other_port7000']
    for name in kept:
        (tmp_path / name).touch()
    (tmp_path / 'fastrtps_port7411').write_bytes(b'x')
    remove_torn_ports(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*kept, 'fastrtps_port7411'])


def test_a_port_that_is_being_made_is_left(tmp_path: Path, monkeypatch) -> None:
    """Its maker gives it a size while it is looked at."""
    port = tmp_path / 'fastrtps_port7000'
    port.touch()
    monkeypatch.setattr(shared_memory.time, 'sleep', lambda _: port.write_bytes(b'x'))
    remove_torn_ports(tmp_path)
    assert port.exists()


def test_a_port_that_another_process_removes_is_no_error(tmp_path: Path, monkeypatch) -> None:
    """Two processes that start may find the same one."""
    port = tmp_path / 'fastrtps_port7000'
    port.touch()
    monkeypatch.setattr(shared_memory.time, 'sleep', lambda _: port.unlink())
    remove_torn_ports(tmp_path)
    assert not port.exists()


def test_nothing_is_awaited_without_an_empty_port(tmp_path: Path, monkeypatch) -> None:
    """A start costs nothing where all is well."""
    waits: list[float] = []
    monkeypatch.setattr(shared_memory.time, 'sleep', waits.append)
    remove_torn_ports(tmp_path)
    remove_torn_ports(tmp_path / 'absent')
    assert not waits
