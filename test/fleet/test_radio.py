# SPDX-License-Identifier: Apache-2.0
"""The simulated radio: known rates of loss, delay, bandwidth, cuts."""

import numpy as np
import pytest

from rocsafe_fleet.trial.radio import RadioOptions, SimulatedRadio

PACKETS = 4000


def arrived(**options: object) -> list[bool]:
    """Return which of many packets from station 0 came to station 1."""
    radio = SimulatedRadio(2, RadioOptions(jitter_s=0.0, **options), np.random.default_rng(1))
    came = []
    for number in range(PACKETS):
        radio.send(0, b'packet', float(number))
        came.append(bool(radio.due(number + 0.5)))
    return came


def test_independent_losses():
    """As many as asked for, within five standard deviations."""
    rate = 1.0 - np.mean(arrived(loss=0.3))
    assert rate == pytest.approx(0.3, abs=5 * (0.3 * 0.7 / PACKETS) ** 0.5)


def test_bursts_of_loss():
    """Gilbert and Elliott: p/(p+r) are lost, in bursts of 1/r on average."""
    came = arrived(burst=(0.05, 0.3))
    text = ''.join('.' if one else 'x' for one in came)
    bursts = [len(part) for part in text.split('.') if part]
    assert 1.0 - np.mean(came) == pytest.approx(0.05 / 0.35, abs=0.03)
    assert np.mean(bursts) == pytest.approx(1.0 / 0.3, abs=0.4)


def test_bandwidth_delays_and_then_drops():
    """9600 bit/s carry 1200 bytes a second; more waits, and for 5 s at most."""
    options = RadioOptions(bits_per_s=9600.0, header_bytes=0, delay_s=0.0, jitter_s=0.0)
    radio = SimulatedRadio(2, options, np.random.default_rng(0))
    for _ in range(20):
        radio.send(0, bytes(1200), 0.0)
    assert not radio.due(0.99)
    assert len(radio.due(1.0)) == 1
    assert len(radio.due(100.0)) == 5


def test_cuts():
    """Only those of one group hear each other."""
    radio = SimulatedRadio(4, RadioOptions(), np.random.default_rng(0))
    radio.cut([[0, 1], [2]])
    radio.send(0, b'a', 0.0)
    assert [receiver for receiver, _ in radio.due(1.0)] == [1]
    radio.send(3, b'a', 1.0)
    assert not radio.due(2.0)
    radio.heal()
    radio.send(3, b'a', 2.0)
    assert sorted(receiver for receiver, _ in radio.due(3.0)) == [0, 1, 2]


def test_the_same_seed_loses_the_same():
    """Trials can be repeated."""
    assert arrived(loss=0.5) == arrived(loss=0.5)


def test_impossible_radios_are_refused():
    """The text names the value and its limits."""
    with pytest.raises(ValueError, match=r'loss is 1\.5'):
        RadioOptions(loss=1.5)
