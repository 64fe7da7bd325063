# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_orchestrator'

setup(
    name=NAME,
    version='0.2.0',
    description='Processes, mission phases, recording and report of ROCSAFE.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed'], NAME + '.report': ['templates/*.html']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'orchestrator = rocsafe_orchestrator.cli:orchestrator',
            'fleet_verbs = rocsafe_orchestrator.fleet_verbs_node:main',
            'recorder = rocsafe_orchestrator.recorder_node:main',
            'rocsafe = rocsafe_orchestrator.cli:main',
        ],
    },
)
