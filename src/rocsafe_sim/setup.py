# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_sim'

setup(
    name=NAME,
    version='0.2.0',
    description='Simulated world and vehicles of ROCSAFE.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed', 'sensors/*.COF']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'world = rocsafe_sim.world_node:main',
            'rav = rocsafe_sim.rav_node:main',
            'fleet = rocsafe_sim.fleet_node:main',
            'rgv = rocsafe_sim.rgv_node:main',
            'viewer = rocsafe_sim.viewer_node:main',
        ],
    },
)
