# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_mavlink'

setup(
    name=NAME,
    version='0.2.0',
    description='Bridge from ROCSAFE to real vehicles with ArduPilot or PX4 by MAVLink.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'bridge = rocsafe_mavlink.bridge_node:main',
            'mavlink_view = rocsafe_mavlink.view_node:main',
            'preflight = rocsafe_mavlink.preflight_command:main',
            'signing = rocsafe_mavlink.signing_command:main',
        ],
    },
)
