# SPDX-License-Identifier: Apache-2.0
"""Quality of service of `topic echo` and `topic pub`: chosen by the user, or by the publishers."""

from argparse import ArgumentParser, Namespace
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSLivelinessPolicy,
    QoSPresetProfiles,
    QoSProfile,
    QoSReliabilityPolicy,
)

POLICIES = {
    'history': QoSHistoryPolicy,
    'reliability': QoSReliabilityPolicy,
    'durability': QoSDurabilityPolicy,
    'liveliness': QoSLivelinessPolicy,
}


def add_qos_arguments(parser: ArgumentParser, default_profile: str) -> None:
    """Add `--qos-*`; what is not given keeps the value of the profile."""
    parser.add_argument(
        '--qos-profile',
        choices=QoSPresetProfiles.short_keys(),
        default=default_profile,
        help='Quality of service preset profile (default: %(default)s)',
    )
    parser.add_argument('--qos-depth', metavar='N', type=int, help='Queue size')
    for name, policy in POLICIES.items():
        parser.add_argument(f'--qos-{name}', choices=policy.short_keys(), help=f'The {name}')
    parser.add_argument(
        '--qos-liveliness-lease-duration-seconds', type=float, help='Lease of the liveliness'
    )


def chosen_qos(options: Namespace) -> QoSProfile:
    """Return the profile with what the user overrides."""
    profile = QoSPresetProfiles.get_from_short_key(options.qos_profile)
    for name, policy in POLICIES.items():
        if chosen := getattr(options, f'qos_{name}'):
            setattr(profile, name, policy.get_from_short_key(chosen))
    if (lease_s := options.qos_liveliness_lease_duration_seconds) and lease_s >= 0:
        profile.liveliness_lease_duration = Duration(seconds=lease_s)
    if options.qos_depth and options.qos_depth >= 0:
        profile.depth = options.qos_depth
    elif profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL and profile.depth == 0:
        profile.depth = 1
    return profile


def is_qos_chosen(options: Namespace) -> bool:
    """Return whether the user overrides any part of the profile."""
    lease_s = options.qos_liveliness_lease_duration_seconds
    values = [getattr(options, f'qos_{name}') for name in (*POLICIES, 'depth')]
    return any(value is not None for value in (*values, lease_s))


def matched_qos(profile: QoSProfile, publishers: list[Any]) -> QoSProfile:
    """Return the profile made to hear all the publishers: as strict as the least strict one."""
    if publishers:
        offered = [publisher.qos_profile for publisher in publishers]
        profile.reliability = _common(
            [offer.reliability for offer in offered],
            QoSReliabilityPolicy.RELIABLE,
            QoSReliabilityPolicy.BEST_EFFORT,
        )
        profile.durability = _common(
            [offer.durability for offer in offered],
            QoSDurabilityPolicy.TRANSIENT_LOCAL,
            QoSDurabilityPolicy.VOLATILE,
        )
    return profile


def _common(offers: list[Any], strict: Any, lenient: Any) -> Any:
    """Return `strict` if all offer it, else `lenient`; say so if only some do."""
    if all(offer == strict for offer in offers):
        return strict
    if strict in offers:
        print(
            f'Some, but not all, publishers are offering {type(strict).__name__}.{strict.name}. '
            f'Falling back to {type(lenient).__name__}.{lenient.name} '
            'as it will connect to all publishers'
        )
    return lenient
