# SPDX-License-Identifier: Apache-2.0
"""Plan a survey of a region file, and print who flies where and when he is back.

python examples/plan_field.py field.geojson 3
"""

import sys

from rocsafe_planner.region_plan import plan_region


def main(region: str, drones: int = 3) -> None:
    """Plan and print; no vehicle and no ROS is needed."""
    plan = plan_region(region, drones=drones)
    for route in plan.routes:
        print(
            f'{route.vehicle.name}: {len(route.viewpoints)} photographs, {route.duration_s:.0f} s'
        )
    print(f'all are back after {plan.makespan_s:.0f} s; no plan takes less than '
          f'{plan.lower_bound_s:.0f} s')  # fmt: skip


if __name__ == '__main__':
    main(sys.argv[1], int(sys.argv[2]))
