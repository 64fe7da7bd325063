# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_fleet'

setup(
    name=NAME,
    version='0.2.0',
    description='Agents that share the work of a ROCSAFE mission without a central planner.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest'], 'zenoh': ['eclipse-zenoh']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'agent = rocsafe_fleet.agent_node:main',
        ],
    },
)
