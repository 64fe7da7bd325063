# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_radiation'

setup(
    name=NAME,
    version='0.2.0',
    description='Gamma dose-rate field and detectors of ROCSAFE.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed', 'tables/*.json', 'tables/*.yaml']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'field = rocsafe_radiation.field_node:main',
            'detector = rocsafe_radiation.detector_node:main',
            'localizer = rocsafe_radiation.localizer_node:main',
            'localize = rocsafe_radiation.command_line.localize_command:main',
        ],
    },
)
